// What contact laws add to the plain step, each only where the scene asks for it: history columns of rolling and
// twisting, necks that hold beyond touch (JKR), cohesion, moments on the grains. Who calls it: chunk_work.cpp,
// simulation.cpp. Invariants: I3 (moments are summed in the order of the forces), I5, I7 (a chunk writes only its own
// history and scratch); a scene without additions allocates nothing here and takes none of these paths.
#include <algorithm>
#include <cstring>

#include "core/base/error.hpp"
#include "core/rules/adhesion.hpp"
#include "scheduler/step/world.hpp"

namespace talus {

namespace {

/// The moment block that belongs to a block of forces; s and h are set by the caller.
MomentBlock moment_block(const World& w, const Block& b) {
  MomentBlock m{};
  m.n = b.n;
  m.x = b.x;
  m.y = b.y;
  m.z = b.z;
  m.r = b.r;
  m.reff = b.reff;
  m.slid = b.slid;
  m.pair = b.pair;
  m.e = w.has.energies ? b.e : nullptr;
  return m;
}

CohesionArgs cohesion_args(const World& w) {
  CohesionArgs a{};
  a.one = w.cohesion[0];
  a.table = w.has.materials ? w.cohesion.data() : nullptr;
  a.energy = w.has.energies ? 1 : 0;
  return a;
}

}  // namespace

void configure_add_ons(World& w) {
  const Scene& scene = w.scene;
  Features& h = w.has;
  h.moments = scene.contact.rolling != Rolling::none || scene.contact.twisting;
  h.cohesion = scene.contact.cohesion != Cohesion::none;
  h.adhesion = scene.contact.model == ContactModel::jkr;
  if (h.moments && !h.rotation)
    throw Error(ErrorCode::scene, "rolling and twisting resistance need friction: without it no grain rotates",
                scene.file, "contact.friction > 0");
  h.law_columns = h.history_columns;
  h.moment_columns = h.moments ? moment_columns(scene) : 0;
  h.history_columns = h.law_columns + h.moment_columns;
  h.reff = h.reff || h.moments;
  if (h.moments || h.cohesion) w.add_ons = add_on_parameters(scene);
  if (h.cohesion)
    for (const AddOnParameters& p : w.add_ons) w.cohesion.push_back(p.cohesion);
  if (h.moments) {
    w.moment_args = moment_args(scene);
    w.moment_args.one = w.add_ons[0];
    w.moment_args.table = h.materials ? w.add_ons.data() : nullptr;
    w.moment_flips = moment_flips(scene);
  }
  if (h.adhesion) {
    const int n = static_cast<int>(scene.materials.size());
    for (int a = 0; a < n; ++a)
      for (int b = 0; b < n; ++b) {
        const double kappa = adhesion_length(scene, a, b);
        w.adhesive_range.push_back(27 * (kappa * kappa));
      }
  }
  check_attraction(scene, w.r_min, w.r_max);
}

void narrow_add_ons(World& w, Chunk& c, NarrowArgs& a, std::size_t room) {
  Scratch& s = *c.scratch;
  const auto bytes = static_cast<std::size_t>(c.end[2] / 8);
  grow(s.before, bytes);
  if (bytes > 0) std::memcpy(s.before.data(), c.mask.data(), bytes);
  if (w.has.adhesion)
    w.kernels->narrow_adhesive(a, {w.has.materials ? w.material.data() : nullptr,
                                   static_cast<int>(w.scene.materials.size()), w.adhesive_range.data()});
  else
    w.kernels->narrow(a);
  CarryArgs k{};
  k.before = s.before.data();
  k.now = c.mask.data();
  k.slots = c.end[2];
  const int first =
      w.has.adhesion ? 0 : w.has.law_columns;  // the laws find the columns below by the narrow phase's runs
  for (int q = first; q < w.has.history_columns; ++q) {
    grow(s.h[q], room);
    grow(c.h[q], k_pad);
    k.from[k.columns] = c.h[q].data();
    k.to[k.columns++] = s.h[q].data();
  }
  w.kernels->carry(k);
  for (int q = first; q < w.has.history_columns; ++q) std::swap(c.h[q], s.h[q]);
}

void evaluate_add_ons(const World& w, Chunk& c, std::int64_t k0, Block& b, BlockBuffers& buffers) {
  const Scratch& s = *c.scratch;
  if (w.has.moments) {
    w.kernels->spin({w.p.data(), w.v.data(), s.ci.data() + k0, s.cj.data() + k0, b.n, buffers.s});
    MomentBlock m = moment_block(w, b);
    m.s = buffers.s;
    for (int q = 0; q < w.has.moment_columns; ++q) m.h[q] = c.h[w.has.law_columns + q].data() + k0;
    w.kernels->moments(m, w.moment_args);
  }
  if (w.has.cohesion) {
    CohesionArgs a = cohesion_args(w);
    a.p = w.p.data();
    a.i = s.ci.data() + k0;
    a.j = s.cj.data() + k0;
    w.kernels->cohesion(b, a);
  }
}

int keep_wall_contacts(const World& w, Row i, WallContact* found, std::int32_t* from, int n) {
  const double r = w.p[4L * i + 3];
  int kept = 0;
  for (int k = 0; k < n; ++k) {
    const double gap = found[k].distance - r;
    const int pair = w.has.materials ? w.pair_index(w.material[i], w.walls.material(found[k].wall)) : 0;
    const bool holds =
        gap < 0 || (from[k] >= 0 && (gap * gap) * gap <= w.adhesive_range[static_cast<std::size_t>(pair)] * r);
    if (!holds) continue;
    found[kept] = found[k];
    from[kept++] = from[k];
  }
  return kept;
}

void wall_add_ons(World& w, Chunk& c, std::size_t k0, Block& b) {
  if (w.has.moments) {
    alignas(64) double spin[4][k_block + k_pad], history[k_max_moment][k_block + k_pad];
    const auto columns = static_cast<std::size_t>(w.has.moment_columns);
    const int padded = (b.n + 7) / 8 * 8;
    for (int k = 0; k < padded; ++k) {
      const std::size_t at = k0 + static_cast<std::size_t>(std::min(k, b.n - 1));
      const WallState& t = c.wall_next[at];
      const double* v = w.v.data() + static_cast<long>(w.stride) * t.row;
      const double inverse = 1 / w.p[4L * t.row + 3], mass = v[7] > 0 ? v[7] : 1.0;
      const Vec3 wall = w.walls.pose(t.contact.wall).omega;
      for (int q = 0; q < 3; ++q) spin[q][k] = v[4 + q] * inverse - wall[q];
      spin[3][k] = (5.0 / 7.0) * (mass * (inverse * inverse));
      for (std::size_t q = 0; q < columns; ++q) history[q][k] = c.wall_moment_next[at * columns + q];
    }
    MomentBlock m = moment_block(w, b);
    m.s = spin;
    for (std::size_t q = 0; q < columns; ++q) m.h[q] = history[q];
    w.kernels->moments(m, w.moment_args);
    double* rows = c.scratch->m.data() - 4 * static_cast<std::ptrdiff_t>(c.lo);
    for (int k = 0; k < b.n; ++k) {
      const std::size_t at = k0 + static_cast<std::size_t>(k);
      const WallState& t = c.wall_next[at];
      for (std::size_t q = 0; q < columns; ++q) c.wall_moment_next[at * columns + q] = history[q][k];
      const Vec3 moment{spin[0][k], spin[1][k], spin[2][k]};
      for (int q = 0; q < 3; ++q) rows[4L * t.row + q] = rows[4L * t.row + q] + moment[q];
      c.wall_torque[at] = moment;
    }
  }
  if (w.has.cohesion) w.kernels->cohesion(b, cohesion_args(w));
}

void clear_moments(const World& w, Chunk& c) {
  const auto size = 4 * static_cast<std::size_t>(c.hi - c.lo);
  grow(c.scratch->m, size);
  std::memset(c.scratch->m.data(), 0, size * sizeof(double));
}

void fold_moments(const World& w, Chunk& c) {
  double* f = c.scratch->f.data();
  const double* m = c.scratch->m.data();
  for (Row i = c.lo; i < c.hi; ++i, f += 8, m += 4) {
    const double r = w.p[4L * i + 3];
    if (!(r > 0)) continue;  // a removed row
    for (int q = 0; q < 3; ++q) f[4 + q] = f[4 + q] + m[q] / r;
  }
}

}  // namespace talus
