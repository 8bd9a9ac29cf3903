// List policy outer_inner: lists cut out of longer ones. Who calls it: set_skins and rebuild_lists (outer lists are
// made and cut for the first time), rebuild_tuned (cut again). Why it is exact: skin_check.cpp. Invariants: I1, I2 (the
// skin that is checked is the one that was cut with), I3 (a cut keeps the order of the outer list, which is that of a
// rebuild), I5. Other policies come here for nothing.
#include <algorithm>
#include <cstring>

#include "scheduler/step/world.hpp"
#include "scheduler/team/parallel.hpp"

namespace talus {

namespace {

/// A row that would get less than this of the skin it should have ends the outer list (hopper-20k: 0.5 costs 6 % more).
constexpr double k_least_part = 0.25;

/// Fresh skins within what is left of the outer ones. False: some row has too little left.
bool cut_skins(World& w, const Chunk& c, double& skins) {
  RowSkins wanted(w, c);
  for (Row i = c.lo; i < c.hi; ++i) {
    const double *x = w.p.data() + 4L * i, *ref = w.outer.data() + 4L * i;
    if (x[0] >= 1e100) {
      set_near(w, i, 0);
      continue;
    }
    const double skin = wanted(i), left = ref[3] * (1 - 1e-12) - __builtin_sqrt(distance2(w, x, ref));
    if (!(skin >= 0) || !(left >= k_least_part * skin)) return false;  // what is not finite ends in a rebuild
    const double s = fmin2(skin, left);
    set_reference(w, i, s);
    set_near(w, i, s);
    skins += s / (2 * x[3]);
  }
  return true;
}

}  // namespace

void set_near(World& w, Row i, double skin) {
  const double* x = w.p.data() + 4L * i;
  double* near = w.near.data() + 4L * i;
  for (int k = 0; k < 3; ++k) near[k] = x[k];
  const double extent = fmax2(w.size.x, fmax2(w.size.y, w.size.z));
  // rounding of squares and coordinates is in the reach, as in set_skins
  near[3] = x[0] < 1e100 ? (x[3] + w.skin.range(x[3]) + skin) * (1 + 1e-12) + 4e-16 * extent : 0.0;
}

Sections cut_sections(World& w, Chunk& c, ListScratch& t, const Sections* fresh) {
  if (fresh != nullptr) {
    std::int64_t total = 0;
    for (const std::int64_t n : fresh->n) total += (n + 7) / 8 * 8;
    grow_discarding(c.outer_i, static_cast<std::size_t>(total) + k_pad);
    grow_discarding(c.outer_j, static_cast<std::size_t>(total) + k_pad);
    std::int64_t slot = 0;
    for (int s = 0; s < 3; ++s) {
      const std::int64_t n = fresh->n[s], padded = (n + 7) / 8 * 8;
      std::copy_n(fresh->i[s], n, c.outer_i.data() + slot);
      std::copy_n(fresh->j[s], n, c.outer_j.data() + slot);
      std::fill_n(c.outer_i.data() + slot + n, padded - n, w.n);
      std::fill_n(c.outer_j.data() + slot + n, padded - n, w.n);
      c.outer_end[s] = slot += padded;
    }
  }
  const auto room = static_cast<std::size_t>(c.outer_end[2]) + 2 * k_pad;
  grow_discarding(t.build[0], room);
  grow_discarding(t.build[1], room);
  grow_discarding(t.mask, room);
  NarrowArgs a{};  // pairs within reach are found as contacts are
  a.p = w.near.data();
  a.pi = c.outer_i.data();
  a.pj = c.outer_j.data();
  a.mask = t.mask.data();
  const Box box = w.scene.domain.box();
  for (int k = 0; k < 3; ++k) a.end[k] = c.outer_end[k], a.half[k] = box.half(k), a.period[k] = box.period(k);
  a.periodic = w.has.periodic ? 1 : 0;
  a.ci = t.build[0].data();
  a.cj = t.build[1].data();
  w.kernels->narrow(a);
  Sections inner{};
  std::int64_t from = 0;
  for (int s = 0; s < 3; ++s) {
    inner.i[s] = a.ci + from;
    inner.j[s] = a.cj + from;
    inner.n[s] = a.contact_end[s] - from;
    from = a.contact_end[s];
  }
  return inner;
}

bool cut_lists(World& w) {
  if (!w.skin.cuts() || w.structure || !w.lists_valid || w.frame.rows != w.n) return false;
  if (w.has.moving_walls && w.walls.expired()) return false;
  struct alignas(64) Part {
    double skins = 0;
    bool enough = false;
  };
  std::vector<Part> parts(w.chunks.size());
  parallel(w, static_cast<int>(w.chunks.size()), [&](int q) {
    Part& part = parts[static_cast<std::size_t>(q)];
    part.enough = cut_skins(w, *w.chunks[static_cast<std::size_t>(q)], part.skins);
  });
  double skins = 0;
  for (const Part& p : parts) {
    if (!p.enough) return false;
    skins += p.skins;
  }
  w.any_expired.store(false, std::memory_order_relaxed);
  w.frame.built = w.step;
  w.frame.mean_skin = w.alive > 0 ? skins / static_cast<double>(w.alive) : 0;
  for_chunks(w, [](World& world, Chunk& c) {
    ListScratch* t = world.list_scratch.take();
    replace_list(world, c, *t, cut_sections(world, c, *t, nullptr));
    world.list_scratch.give(t);
  });
  count_pairs(w);
  ++w.counters.cuts;
  return true;
}

}  // namespace talus
