// See size_push.hpp.
#include "scheduler/nodes/size_push.hpp"

#include <algorithm>

#include "core/base/det_math.hpp"
#include "core/rules/laws/law.hpp"

namespace talus {
namespace {

/// Cohesion: -c times the area of contact, integrated over the way in.
SizePush cohesion(double c, double ri, double rj, double d) {
  if (rj < 0) {
    const double w = ri, e = w * w * (w - d) - (w * w * w - d * d * d) / 3;
    return {-c * det::k_pi * e, -c * (2 * det::k_pi) * w * (w - d), 0};
  }
  const double w = ri + rj, g = ri - rj, a = -0.25 * det::k_pi * c, gap = w - d;
  const double e = (w * w + g * g) * gap - (w * w * w - d * d * d) / 3 - w * g * g * (w / d - 1);
  const double by_w = 2 * gap * (w - g * g / d), by_g = -2 * g * gap * gap / d;
  return {a * e, a * (by_w + by_g), a * (by_w - by_g)};
}

/// Energy of the rolling and twisting springs of a contact with history columns m [J].
double turned_energy(const Rules& rules, int pair, double reduced, double delta, const double* m) {
  const AddOnParameters& a = rules.law.add_ons[static_cast<std::size_t>(pair)];
  const double kn = rules.law.parameters[static_cast<std::size_t>(pair)].kn;
  // with adhesion: the radius of Hertz; the share of these springs is small
  const double stiffness = law_of(rules.scene).by_modulus ? 1.5 * kn * __builtin_sqrt(reduced * fmax2(delta, 0)) : kn;
  const double unit = 2.25 * stiffness * (reduced * reduced);
  const bool rolls = rules.law.moment_args.rolling == 2;
  double e = 0;
  if (const double k = unit * (a.rolling * a.rolling); rolls && k > 0)
    e += 0.5 * ((m[0] * m[0] + m[1] * m[1]) + m[2] * m[2]) / k;
  const double t = rules.law.moment_args.twisting != 0 ? m[rolls ? 3 : 0] : 0;
  if (const double k = unit * (a.twisting * a.twisting); k > 0) e += 0.5 * (t * t) / k;
  return e;
}

int pair_of(const Rules& rules, const Rows& rows, Row i, Row j) {
  return rules.has.materials ? rules.pair_index(rows.material[i], rows.material[j]) : 0;
}

double distance_of(const Rules& rules, const Rows& rows, Row i, Row j) {
  const double *p = rows.p.data() + 4L * i, *q = rows.p.data() + 4L * j;
  return norm(rules.scene.domain.box().nearest({p[0] - q[0], p[1] - q[1], p[2] - q[2]}));
}

}  // namespace

SizePush size_push(const Rules& rules, int pair, double ri, double rj, double distance, double turned) {
  const bool wall = rj < 0;
  const double delta = wall ? ri - distance : (ri + rj) - distance, reduced = wall ? ri : ri * rj / (ri + rj);
  const StoredEnergy n =
      law_of(rules.scene).stored(rules.law.parameters[static_cast<std::size_t>(pair)], reduced, delta);
  const double by_reduced = n.by_reduced - 2 * turned / reduced;
  const auto share = [&](double r) { return wall ? 1.0 : (reduced / r) * (reduced / r); };
  SizePush p{n.energy, n.by_overlap + by_reduced * share(ri), wall ? 0 : n.by_overlap + by_reduced * share(rj)};
  if (!rules.has.cohesion || !(delta > 0)) return p;
  const SizePush c = cohesion(rules.law.cohesion[static_cast<std::size_t>(pair)], ri, rj, distance);
  return {p.energy + c.energy, p.i + c.i, p.j + c.j};
}

void push_pairs(const Rules& rules, const Rows& rows, Ledger& ledger, const Chunk& c) {
  double* push = ledger.push.data();
  std::fill(push + c.lo, push + c.hi, 0.0);
  const Scratch& s = *c.scratch;
  const auto first = static_cast<std::size_t>(rules.has.law_columns);
  for (std::int64_t k = 0; k < c.contacts.end[2]; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const Row i = s.ci[at], j = s.cj[at];
    const double ri = rows.p[4L * i + 3], rj = rows.p[4L * j + 3], d = distance_of(rules, rows, i, j);
    const int pair = pair_of(rules, rows, i, j);
    double turned = 0;
    if (rules.has.moments) {
      double m[k_max_moment] = {};
      for (int q = 0; q < rules.has.moment_columns; ++q) m[q] = c.contacts.h[first + static_cast<std::size_t>(q)][at];
      turned = turned_energy(rules, pair, ri * rj / (ri + rj), (ri + rj) - d, m);
    }
    const SizePush p = size_push(rules, pair, ri, rj, d, turned);
    push[i] = push[i] + p.i;
    if (k >= c.contacts.end[0] && k < c.contacts.end[1]) push[j] = push[j] + p.j;
  }
}

void push_walls(const Rules& rules, const Rows& rows, const WallSet& walls, Ledger& ledger, const Chunk& c) {
  const auto columns = static_cast<std::size_t>(rules.has.moment_columns);
  for (std::size_t k = 0; k < c.wall.state.size(); ++k) {
    const WallState& t = c.wall.state[k];
    const double r = rows.p[4L * t.row + 3];
    const int pair = rules.has.materials ? rules.pair_index(rows.material[t.row], walls.material(t.contact.wall)) : 0;
    const double turned =
        rules.has.moments ? turned_energy(rules, pair, r, r - t.contact.distance, c.wall.moment.data() + k * columns)
                          : 0;
    double& to = ledger.push[static_cast<std::size_t>(t.row)];
    to = to + size_push(rules, pair, r, -1, t.contact.distance, turned).i;
  }
}

}  // namespace talus
