// List policy outer_inner: lists cut out of longer ones. Who calls it: set_skins and rebuild_lists (outer lists are
// made and cut for the first time), rebuild_tuned (cut again). Why it is exact: skin_check.cpp. Invariants: I1, I2 (the
// skin that is checked is the one that was cut with), I3 (a cut keeps the order of the outer list, which is that of a
// rebuild), I5. Other policies come here for nothing.
#include <algorithm>
#include <cstring>

#include "scheduler/lists/rebuild.hpp"
#include "scheduler/team/parallel.hpp"

namespace talus {

namespace {

/// A row that would get less than this of the skin it should have ends the outer list (hopper-20k: 0.5 costs 6 % more).
constexpr double k_least_part = 0.25;

/// Fresh skins within what is left of the outer ones. False: some row has too little left.
bool cut_skins(const Rules& rules, const Rows& rows, Lists& lists, const Chunk& c, double& skins) {
  RowSkins wanted(rules, rows, lists, c);
  for (Row i = c.lo; i < c.hi; ++i) {
    const double *x = rows.p.data() + 4L * i, *ref = lists.outer.data() + 4L * i;
    if (x[0] >= k_far) {
      set_near(rules, rows, lists, i, 0);
      continue;
    }
    const double skin = wanted(i), left = ref[3] * (1 - 1e-12) - __builtin_sqrt(distance2(rules, x, ref));
    if (!(skin >= 0) || !(left >= k_least_part * skin)) return false;  // what is not finite ends in a rebuild
    const double s = fmin2(skin, left);
    set_reference(rules, rows, lists, i, s);
    set_near(rules, rows, lists, i, s);
    skins += s / (2 * x[3]);
  }
  return true;
}

}  // namespace

void set_near(const Rules& rules, const Rows& rows, Lists& lists, Row i, double skin) {
  const double* x = rows.p.data() + 4L * i;
  double* near = lists.near.data() + 4L * i;
  for (int k = 0; k < 3; ++k) near[k] = x[k];
  const double extent = fmax2(rules.size.x, fmax2(rules.size.y, rules.size.z));
  // rounding of squares and coordinates is in the reach, as in set_skins
  near[3] = x[0] < k_far ? (x[3] + lists.skin.range(x[3]) + skin) * (1 + 1e-12) + 4e-16 * extent : 0.0;
}

Sections cut_sections(const Rules& rules, const Rows& rows, const Lists& lists, Chunk& c, ListScratch& t,
                      const Sections* fresh) {
  if (fresh != nullptr) {
    std::int64_t total = 0;
    for (const std::int64_t n : fresh->n) total += (n + 7) / 8 * 8;
    grow_discarding(c.outer.pi, static_cast<std::size_t>(total) + k_pad);
    grow_discarding(c.outer.pj, static_cast<std::size_t>(total) + k_pad);
    std::int64_t slot = 0;
    for (int s = 0; s < 3; ++s) {
      const std::int64_t n = fresh->n[s], padded = (n + 7) / 8 * 8;
      std::copy_n(fresh->i[s], n, c.outer.pi.data() + slot);
      std::copy_n(fresh->j[s], n, c.outer.pj.data() + slot);
      std::fill_n(c.outer.pi.data() + slot + n, padded - n, rows.n);
      std::fill_n(c.outer.pj.data() + slot + n, padded - n, rows.n);
      c.outer.end[s] = slot += padded;
    }
  }
  const auto room = static_cast<std::size_t>(c.outer.end[2]) + 2 * k_pad;
  grow_discarding(t.build[0], room);
  grow_discarding(t.build[1], room);
  grow_discarding(t.mask, room);
  NarrowArgs a{};  // pairs within reach are found as contacts are
  a.p = lists.near.data();
  a.pi = c.outer.pi.data();
  a.pj = c.outer.pj.data();
  a.mask = t.mask.data();
  const Box box = rules.scene.domain.box();
  for (int k = 0; k < 3; ++k) a.end[k] = c.outer.end[k], a.half[k] = box.half(k), a.period[k] = box.period(k);
  a.periodic = rules.has.periodic ? 1 : 0;
  a.ci = t.build[0].data();
  a.cj = t.build[1].data();
  rules.kernels->narrow(a);
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

bool cut_lists(const Rules& rules, const Clock& clock, const Rows& rows, Contacts& contacts, Lists& lists,
               Counters& counters, const WallSet& walls, Team& team) {
  if (!lists.skin.cuts() || clock.structure || !lists.valid || lists.frame.rows != rows.n) return false;
  if (rules.has.moving_walls && walls.expired()) return false;
  struct alignas(64) Part {
    double skins = 0;
    bool enough = false;
  };
  std::vector<Part> parts(contacts.chunks.size());
  parallel(team, static_cast<int>(contacts.chunks.size()), [&](int q) {
    Part& part = parts[static_cast<std::size_t>(q)];
    part.enough = cut_skins(rules, rows, lists, *contacts.chunks[static_cast<std::size_t>(q)], part.skins);
  });
  double skins = 0;
  for (const Part& p : parts) {
    if (!p.enough) return false;
    skins += p.skins;
  }
  lists.any_expired.store(false, std::memory_order_relaxed);
  lists.frame.built = clock.step;
  lists.frame.mean_skin = rows.alive > 0 ? skins / static_cast<double>(rows.alive) : 0;
  for_chunks(team, contacts, [&](Chunk& c) {
    ListScratch* t = team.list_scratch.take();
    replace_list(rules, rows, c, *t, cut_sections(rules, rows, lists, c, *t, nullptr));
    team.list_scratch.give(t);
  });
  count_pairs(contacts, counters);
  ++counters.cuts;
  return true;
}

}  // namespace talus
