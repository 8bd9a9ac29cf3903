// What contact laws add to the plain step, each only where the scene asks for it: history columns of rolling and
// twisting, necks that hold beyond touch (JKR), cohesion, moments on the grains. Who calls it: nodes of pairs and
// walls, start_of(). Invariants: I3 (moments are summed in the order of the forces), I5, I7 (a chunk writes only its
// own history and scratch); a scene without additions allocates nothing here and takes none of these paths.
#include "scheduler/nodes/add_ons.hpp"

#include <algorithm>
#include <cstring>

#include "core/base/error.hpp"
#include "core/rules/adhesion.hpp"
#include "scheduler/nodes/shaped_contacts.hpp"

namespace talus {

namespace {

/// The moment block that belongs to a block of forces; s and h are set by the caller.
MomentBlock moment_block(const Rules& rules, const Block& b) {
  MomentBlock m{};
  m.n = b.n;
  m.x = b.x;
  m.y = b.y;
  m.z = b.z;
  m.r = b.r;
  m.reff = b.reff;
  m.slid = b.slid;
  m.pair = b.pair;
  m.e = rules.has.energies ? b.e : nullptr;
  return m;
}

CohesionArgs cohesion_args(const Rules& rules) {
  CohesionArgs a{};
  a.one = rules.law.cohesion[0];
  a.table = rules.has.materials ? rules.law.cohesion.data() : nullptr;
  a.energy = rules.has.energies ? 1 : 0;
  return a;
}

}  // namespace

void configure_add_ons(Rules& rules) {
  const Scene& scene = rules.scene;
  Features& h = rules.has;
  h.moments = scene.contact.rolling != Rolling::none || scene.contact.twisting;
  h.cohesion = scene.contact.cohesion != Cohesion::none;
  h.adhesion = law_of(scene).adhesion != nullptr;
  if (h.moments && !h.rotation)
    throw Error(ErrorCode::scene, "rolling and twisting resistance need friction: without it no grain rotates",
                scene.file, "contact.friction > 0");
  h.law_columns = h.history_columns;
  h.moment_columns = h.moments ? moment_columns(scene) : 0;
  h.history_columns = h.law_columns + (h.superquadrics ? k_max_shaped : h.moment_columns);
  h.reff = h.reff || h.moments;
  if (h.moments || h.cohesion) rules.law.add_ons = add_on_parameters(scene);
  if (h.cohesion)
    for (const AddOnParameters& p : rules.law.add_ons) rules.law.cohesion.push_back(p.cohesion);
  if (h.moments) {
    rules.law.moment_args = moment_args(scene);
    rules.law.moment_args.one = rules.law.add_ons[0];
    rules.law.moment_args.table = h.materials ? rules.law.add_ons.data() : nullptr;
    rules.law.moment_flips = moment_flips(scene);
  }
  if (h.superquadrics) rules.law.moment_flips = k_shaped_flips;
  if (h.adhesion) {
    const int n = static_cast<int>(scene.materials.size());
    for (int a = 0; a < n; ++a)
      for (int b = 0; b < n; ++b) {
        const double kappa = adhesion_length(scene, a, b);
        rules.law.adhesive_range.push_back(27 * (kappa * kappa));
      }
  }
  check_attraction(scene, rules.r_min, rules.r_max);
}

void narrow_add_ons(const Rules& rules, const Rows& rows, Chunk& c, NarrowArgs& a, std::size_t room) {
  Scratch& s = *c.scratch;
  const auto bytes = static_cast<std::size_t>(c.list.end[2] / 8);
  grow(s.before, bytes);
  if (bytes > 0) std::memcpy(s.before.data(), c.list.mask.data(), bytes);
  if (rules.has.adhesion)
    rules.kernels->narrow_adhesive(
        a, {rules.has.materials ? rows.material.data() : nullptr, static_cast<int>(rules.scene.materials.size()),
            rules.law.adhesive_range.data()});
  else
    rules.kernels->narrow(a);
  CarryArgs k{};
  k.before = s.before.data();
  k.now = c.list.mask.data();
  k.slots = c.list.end[2];
  const int first =
      rules.has.adhesion ? 0 : rules.has.law_columns;  // the laws find the columns below by the narrow phase's runs
  for (int q = first; q < rules.has.history_columns; ++q) {
    grow(s.h[q], room);
    grow(c.contacts.h[q], k_pad);
    k.from[k.columns] = c.contacts.h[q].data();
    k.to[k.columns++] = s.h[q].data();
  }
  rules.kernels->carry(k);
  for (int q = first; q < rules.has.history_columns; ++q) std::swap(c.contacts.h[q], s.h[q]);
}

void evaluate_add_ons(const Rules& rules, const Rows& rows, const MomentArgs& args, Chunk& c, std::int64_t k0, Block& b,
                      BlockBuffers& buffers) {
  const Scratch& s = *c.scratch;
  if (rules.has.moments) {
    rules.kernels->spin({rows.p.data(), rows.v.data(), s.ci.data() + k0, s.cj.data() + k0, b.n, buffers.s});
    MomentBlock m = moment_block(rules, b);
    m.s = buffers.s;
    for (int q = 0; q < rules.has.moment_columns; ++q) m.h[q] = c.contacts.h[rules.has.law_columns + q].data() + k0;
    rules.kernels->moments(m, args);
  }
  if (rules.has.cohesion) {
    CohesionArgs a = cohesion_args(rules);
    a.p = rows.p.data();
    a.i = s.ci.data() + k0;
    a.j = s.cj.data() + k0;
    rules.kernels->cohesion(b, a);
  }
}

int keep_wall_contacts(const Rules& rules, const Rows& rows, const WallSet& walls, Row i, WallContact* found,
                       std::int32_t* from, int n) {
  const double r = rows.p[4L * i + 3];
  int kept = 0;
  for (int k = 0; k < n; ++k) {
    const double gap = found[k].distance - r;
    const int pair = rules.has.materials ? rules.pair_index(rows.material[i], walls.material(found[k].wall)) : 0;
    const bool holds =
        gap < 0 || (from[k] >= 0 && (gap * gap) * gap <= rules.law.adhesive_range[static_cast<std::size_t>(pair)] * r);
    if (!holds) continue;
    found[kept] = found[k];
    from[kept++] = from[k];
  }
  return kept;
}

void wall_add_ons(const Rules& rules, const Clock& clock, const Rows& rows, const WallSet& walls, Chunk& c,
                  std::size_t k0, Block& b) {
  if (rules.has.moments) {
    alignas(64) double spin[4][k_block + k_pad], history[k_max_moment][k_block + k_pad];
    const auto columns = static_cast<std::size_t>(rules.has.moment_columns);
    const int padded = (b.n + 7) / 8 * 8;
    for (int k = 0; k < padded; ++k) {
      const std::size_t at = k0 + static_cast<std::size_t>(std::min(k, b.n - 1));
      const WallState& t = c.wall.next[at];
      const double* v = rows.v.data() + static_cast<long>(rules.stride) * t.row;
      const double inverse = 1 / rows.p[4L * t.row + 3], mass = v[7] > 0 ? v[7] : 1.0;
      const Vec3 wall = walls.pose(t.contact.wall).omega;
      for (int q = 0; q < 3; ++q) spin[q][k] = v[4 + q] * inverse - wall[q];
      spin[3][k] = (5.0 / 7.0) * (mass * (inverse * inverse));
      for (std::size_t q = 0; q < columns; ++q) history[q][k] = c.wall.moment_next[at * columns + q];
    }
    MomentBlock m = moment_block(rules, b);
    m.s = spin;
    for (std::size_t q = 0; q < columns; ++q) m.h[q] = history[q];
    rules.kernels->moments(m, rules.law.moment_args);
    double* rows = c.scratch->m.data() - 4 * static_cast<std::ptrdiff_t>(c.lo);
    for (int k = 0; k < b.n; ++k) {
      const std::size_t at = k0 + static_cast<std::size_t>(k);
      const WallState& t = c.wall.next[at];
      for (std::size_t q = 0; q < columns; ++q) c.wall.moment_next[at * columns + q] = history[q][k];
      const Vec3 moment{spin[0][k], spin[1][k], spin[2][k]};
      for (int q = 0; q < 3; ++q) rows[4L * t.row + q] = rows[4L * t.row + q] + moment[q];
      c.wall.torque[at] = moment;
    }
  }
  if (rules.has.cohesion) rules.kernels->cohesion(b, cohesion_args(rules));
}

void clear_moments(Chunk& c) {
  const auto size = 4 * static_cast<std::size_t>(c.hi - c.lo);
  grow(c.scratch->m, size);
  std::fill_n(c.scratch->m.data(), size, 0.0);
}

void fold_moments(const Rows& rows, Chunk& c) {
  double* f = c.scratch->f.data();
  const double* m = c.scratch->m.data();
  for (Row i = c.lo; i < c.hi; ++i, f += 8, m += 4) {
    const double r = rows.p[4L * i + 3];
    if (!(r > 0)) continue;  // a removed row
    for (int q = 0; q < 3; ++q) f[4 + q] = f[4 + q] + m[q] / r;
  }
}

}  // namespace talus
