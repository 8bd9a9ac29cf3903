// See size_push.hpp.
#include "scheduler/nodes/size_push.hpp"

#include <algorithm>
#include <optional>

#include "core/base/det_math.hpp"
#include "core/rules/laws/law.hpp"
#include "scheduler/team/pools.hpp"

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

/// Rows of the grain that row i leads, [i, end).
Row end_of(const Rules& rules, const Rows& rows, Row i) {
  const std::int32_t b = rows.body_of(i);
  return b < 0 ? i + 1 : i + static_cast<Row>(shape_of(rules, rows.bodies, b).spheres.size());
}

/// One side of a contact with the outer normal n: radius for Hertz [m]; way of the surface per growth of what the row's
/// push is by: of a sphere its radius, of a superquadric its bounding radius.
struct Side {
  double radius = 0, rise = 1;
};

Side side_of(const Rules& rules, const Rows& rows, Row i, Vec3 n) {
  const double r = rows.p[4L * i + 3];
  if (superquadric_of(rules, rows, i) == nullptr) return {r, 1};
  const Surface s = surface_of(rules, rows, i);
  const Vec3 m = shapes::to_body(s.turn, n);
  return {hertz_radius_of(s, n), shapes::support(s.form, {m.x, m.y, m.z}, shapes::k_eta).h / r};
}

/// As size_push(), by the bounding radii of rows; `wall`: j is none.
SizePush push_of_surfaces(const Rules& rules, const Rows& rows, int pair, Row i, Row j, double overlap, Vec3 n) {
  const bool wall = j < 0;
  const Side a = side_of(rules, rows, i, n), o = wall ? Side{} : side_of(rules, rows, j, -n);
  const double reduced = wall ? a.radius : a.radius * o.radius / (a.radius + o.radius);
  const StoredEnergy e =
      law_of(rules.scene).stored(rules.law.parameters[static_cast<std::size_t>(pair)], reduced, overlap);
  const auto by = [&](Row row, const Side& s) {
    const double share = wall ? 1.0 : (reduced / s.radius) * (reduced / s.radius);
    return e.by_overlap * s.rise + e.by_reduced * share * (s.radius / rows.p[4L * row + 3]);
  };
  return {e.energy, by(i, a), wall ? 0 : by(j, o)};
}

/// Of contact k of a chunk in a scene of superquadrics; nothing where both are spheres.
std::optional<SizePush> push_of_shaped(const Rules& rules, const Rows& rows, const Chunk& c, std::size_t k, int pair) {
  const double share = c.scratch->depth[k];
  if (!rules.has.superquadrics || share < 0) return {};
  if (share == 0) return SizePush{};
  const Row i = c.scratch->ci[k], j = c.scratch->cj[k];
  const Column<double>* n = c.contacts.h + rules.has.law_columns;
  const double inner = fmin2(surface_of(rules, rows, i).inner, surface_of(rules, rows, j).inner);
  return push_of_surfaces(rules, rows, pair, i, j, share * inner, {n[0][k], n[1][k], n[2][k]});
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
    if (const auto p = rules.has.superquadrics ? push_of_shaped(rules, rows, c, at, pair) : std::nullopt) {
      push[i] = push[i] + p->i;
      if (k >= c.contacts.end[0] && k < c.contacts.end[1]) push[j] = push[j] + p->j;
      continue;
    }
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
    if (superquadric_of(rules, rows, t.row) != nullptr)
      to = to + push_of_surfaces(rules, rows, pair, t.row, -1, r - t.contact.distance, t.contact.normal).i;
    else
      to = to + size_push(rules, pair, r, -1, t.contact.distance, turned).i;
  }
}

void push_bodies(const Rules& rules, const Rows& rows, Ledger& ledger, const Chunk& c) {
  for (Row i = c.lo; i < c.hi; i = end_of(rules, rows, i)) {
    const std::int32_t b = rows.body_of(i);
    if (b < 0 || !rows.is_alive(i)) continue;
    const BodyState s = state_of(rows.bodies, b);
    const shapes::Rotation r = shapes::rotation(s.turn);
    double sum = 0;
    Row k = i;
    for (const shapes::SubSphere& part : shape_of(rules, rows.bodies, b).spheres) {
      const double* f = c.scratch->f.data() + static_cast<std::ptrdiff_t>(rows.stride) * (k - c.lo);
      const Vec3 arm = shapes::to_space(r, part.x);
      sum = sum + (ledger.push[static_cast<std::size_t>(k)] * part.r - dot(arm, Vec3{f[0], f[1], f[2]}));
      ledger.push[static_cast<std::size_t>(k)] = 0;
      ++k;
    }
    ledger.push[static_cast<std::size_t>(i)] = sum;
  }
}

}  // namespace talus
