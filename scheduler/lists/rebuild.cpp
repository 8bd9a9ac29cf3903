// Rebuild of the pair lists: search, history carry-over, wall candidates, chunk by chunk.
// Who calls it: the rebuild node and sort epochs. Invariants: I1, I2, I3 (a rebuild never changes storage order;
// sections sorted by (i, j)), I5.
#include "scheduler/lists/rebuild.hpp"

#include <algorithm>
#include <cstring>

#include "scheduler/team/parallel.hpp"

namespace talus {

namespace {

/// Rows that are searched together lie in a box of this many reaches and differ at most by this factor in reach. Dense
/// bed: 4 reaches cost 30 % more, 10 cost 8 % more; radii 1:5 uniform: 244, 188, 158 ns per rebuild with 2, 4, 8.
constexpr float k_group_extent = 6, k_group_ratio = 8;

/// Spheres of one body are no pair. The order stays.
void drop_own_pairs(const Rows& rows, ListScratch& t, Sections& found) {
  for (int s = 0; s < 3; ++s) {
    std::int32_t *i = t.build[2 * s].data(), *j = t.build[2 * s + 1].data();
    std::int64_t kept = 0;
    for (std::int64_t q = 0; q < found.n[s]; ++q) {
      i[kept] = i[q];
      j[kept] = j[q];
      const std::int32_t b = rows.body[static_cast<std::size_t>(i[q])];
      kept += b >= 0 && b == rows.body[static_cast<std::size_t>(j[q])] ? 0 : 1;
    }
    found.n[s] = kept;
  }
}

/// Searches the chunk's rows; the sections stay in the scratch's build columns.
Sections search_chunk(const Rules& rules, const Rows& rows, const Lists& lists, const Chunk& c, ListScratch& t) {
  SearchArgs a{};
  a.x = lists.grid.sx.data();
  a.y = lists.grid.sy.data();
  a.z = lists.grid.sz.data();
  a.r = lists.grid.sr.data();
  a.row = lists.grid.sorted_row.data();
  a.start = lists.grid.cell_start.data();
  a.level = lists.grid.level;
  a.levels = lists.grid.levels;
  for (int k = 0; k < 3; ++k) a.period[k] = rules.scene.domain.box().period(k);
  a.p = rows.p.data();
  a.reach = lists.grid.reach.data();
  a.fixed = rules.has.fixed ? rows.fixed.data() : nullptr;
  a.group_extent = k_group_extent;
  a.group_ratio = k_group_ratio;
  a.lo = a.next = c.lo;
  a.hi = c.hi;
  const auto own = static_cast<std::size_t>(c.hi - c.lo);
  for (int s = 0; s < 6; ++s) grow_discarding(t.build[s], own * (s < 2 || s > 3 ? 2 : 6) + 256);
  grow_discarding(t.hits, 1024);
  for (;;) {
    for (auto* column : {&t.x, &t.y, &t.z, &t.r}) grow_discarding(*column, t.hits.size());
    grow_discarding(t.tag, t.hits.size());
    for (int s = 0; s < 3; ++s) {
      a.si[s] = t.build[2 * s].data();
      a.sj[s] = t.build[2 * s + 1].data();
      a.capacity[s] = static_cast<std::int64_t>(std::min(t.build[2 * s].size(), t.build[2 * s + 1].size())) - k_pad;
    }
    a.cx = t.x.data();
    a.cy = t.y.data();
    a.cz = t.z.data();
    a.cr = t.r.data();
    a.tag = t.tag.data();
    a.hits = t.hits.data();
    a.candidate_capacity = static_cast<std::int32_t>(t.hits.size()) - k_pad;
    rules.kernels->search(a);
    if (a.next >= a.hi) break;
    // either ran out, which is rare: grow both (sections keep their content)
    t.hits.resize(2 * t.hits.size());
    for (auto& b : t.build) b.resize(b.size() + b.size() / 2 + t.hits.size());
  }
  Sections found{};
  for (int s = 0; s < 3; ++s) {
    found.i[s] = t.build[2 * s].data();
    found.j[s] = t.build[2 * s + 1].data();
    found.n[s] = a.count[s];
  }
  if (rows.bodies.in) drop_own_pairs(rows, t, found);
  return found;
}

/// Touching pairs of the present list as ordered keys (i, j), each section closed by a last key.
void collect_keys(const Chunk& c, ListScratch& t) {
  grow_discarding(t.keys, static_cast<std::size_t>(c.contacts.end[2]) + 3);
  std::uint64_t* out = t.keys.data();
  std::int64_t slot = 0;
  for (int s = 0; s < 3; ++s) {
    for (; slot < c.list.end[s]; slot += 8)
      for (unsigned m = c.list.mask[static_cast<std::size_t>(slot >> 3)]; m != 0; m &= m - 1) {
        const auto q = static_cast<std::size_t>(slot + __builtin_ctz(m));
        *out++ = pair_key(c.list.pi[q], c.list.pj[q]);
      }
    *out++ = ~std::uint64_t{0};
  }
}

/// Lays the three sections into the flat list and merges the old contacts into mask and history. A contact that opened
/// in the last integration may be absent from the new list: its history is dropped (I5).
void assemble_chunk(const Rules& rules, const Rows& rows, Chunk& c, ListScratch& t, const Sections& list,
                    const std::uint64_t* keys) {
  std::int64_t total = 0;
  for (int s = 0; s < 3; ++s) {
    c.list.pairs[s] = list.n[s];
    total += (list.n[s] + 7) / 8 * 8;
  }
  grow_discarding(c.list.pi, static_cast<std::size_t>(total) + k_pad);
  grow_discarding(c.list.pj, static_cast<std::size_t>(total) + k_pad);
  grow_discarding(c.list.mask, static_cast<std::size_t>(total / 8) + k_pad);
  t.lost.clear();
  std::int64_t slot = 0, k = 0;  // k counts contacts, keys[k + s] is the present one
  for (int s = 0; s < 3; ++s) {
    const std::int32_t *bi = list.i[s], *bj = list.j[s];
    const std::int64_t n = list.n[s], padded = (n + 7) / 8 * 8;
    std::memcpy(c.list.pi.data() + slot, bi, static_cast<std::size_t>(n) * sizeof(std::int32_t));
    std::memcpy(c.list.pj.data() + slot, bj, static_cast<std::size_t>(n) * sizeof(std::int32_t));
    for (std::int64_t q = n; q < padded; ++q)
      c.list.pi[static_cast<std::size_t>(slot + q)] = c.list.pj[static_cast<std::size_t>(slot + q)] = rows.n;
    const std::uint64_t* key = keys + s;
    std::uint64_t next = key[k];
    for (std::int64_t q0 = 0; q0 < n; q0 += 8) {
      unsigned bits = 0;
      for (std::int64_t q = q0; q < std::min(n, q0 + 8); ++q) {
        const std::uint64_t present = pair_key(bi[q], bj[q]);
        while (next < present) {
          t.lost.push_back(k);
          next = key[++k];
        }
        const bool same = next == present;
        bits |= (same ? 1U : 0U) << (q - q0);
        k += same ? 1 : 0;
        next = key[k];
      }
      c.list.mask[static_cast<std::size_t>((slot + q0) >> 3)] = static_cast<std::uint8_t>(bits);
    }
    for (; key[k] != ~std::uint64_t{0}; ++k) t.lost.push_back(k);
    slot += padded;
    c.list.end[s] = slot;
    c.contacts.end[s] = k - static_cast<std::int64_t>(t.lost.size());
  }
  if (t.lost.empty()) return;
  for (int h = 0; h < rules.has.history_columns; ++h) {
    std::size_t to = 0, next = 0;
    for (std::int64_t q = 0; q < k; ++q) {
      if (next < t.lost.size() && t.lost[next] == q) {
        ++next;
        continue;
      }
      c.contacts.h[h][to++] = c.contacts.h[h][static_cast<std::size_t>(q)];
    }
  }
}

void wall_candidates(const Rules& rules, const Rows& rows, const Lists& lists, const WallSet& walls, Chunk& c) {
  c.wall.row.clear();
  c.wall.begin.clear();
  c.wall.radius.clear();
  c.wall.element.clear();
  c.wall.distance.clear();
  c.wall.nearest.clear();
  for (Row i = c.lo; i < c.hi; ++i) {
    if (!rows.is_alive(i) || (rules.has.fixed && !rules.has.fixed_at_walls && rows.fixed[i] != 0)) continue;
    const std::size_t before = c.wall.element.size();
    const double own = lists.skin.cuts() ? lists.outer[4L * i + 3]
                                         : __builtin_sqrt(lists.x0[4L * i + 3]) / rules.hooks.skin;
    const double skin = lists.skin.to_walls(own) + drift_reach(lists, i);
    const Vec3 at{rows.p[4L * i], rows.p[4L * i + 1], rows.p[4L * i + 2]};
    const double radius = rows.p[4L * i + 3] + 2 * lists.skin.range(rows.p[4L * i + 3]);
    walls.candidates(at, radius + skin, c.wall.element, &c.wall.distance);
    if (c.wall.element.size() == before) continue;
    c.wall.row.push_back(i);
    if (rules.has.adhesion) c.wall.radius.push_back(radius);
    c.wall.begin.push_back(static_cast<std::int32_t>(before));
    c.wall.nearest.push_back(
        *std::min_element(c.wall.distance.begin() + static_cast<std::ptrdiff_t>(before), c.wall.distance.end()));
  }
  c.wall.begin.push_back(static_cast<std::int32_t>(c.wall.element.size()));
}

/// K of the walls' skins. Where K is chosen automatically they last half as long again as the lists are meant to: more
/// than the tuner allows for an interval that something cut, so that a short one cannot make the next ones shorter.
double wall_k(const Rules& rules, const Lists& lists) {
  return lists.skin.outer *
         (lists.tuner.on() && lists.tuner.wanted() > 0 ? 1.5 * lists.tuner.wanted() : rules.scene.list.verlet_k);
}

}  // namespace

void replace_list(const Rules& rules, const Rows& rows, Chunk& c, ListScratch& t, const Sections& s) {
  if (c.contacts.distributed.empty()) {
    collect_keys(c, t);
    assemble_chunk(rules, rows, c, t, s, t.keys.data());
  } else {
    assemble_chunk(rules, rows, c, t, s, c.contacts.distributed.data());
    c.contacts.distributed.clear();
  }
}

void count_pairs(const Contacts& contacts, Counters& counters) {
  counters.pairs = 0;
  for (const auto& c : contacts.chunks) counters.pairs += 2 * c->list.pairs[1] + c->list.pairs[0] + c->list.pairs[2];
  counters.pairs /= 2;
}

void count_rebuild(const Clock& clock, const Lists& lists, Counters& counters, bool forced) {
  if (forced) {
    ++counters.rebuilds_forced;
  } else {
    ++counters.rebuilds_skin;
    const std::int64_t interval = clock.step - lists.last_rebuild_step;
    if (counters.shortest_interval == 0 || interval < counters.shortest_interval) counters.shortest_interval = interval;
  }
  if (counters.interval_steps.size() < 4096) counters.interval_steps.push_back(clock.step);
}

void rebuild_lists(const Rules& rules, const Clock& clock, const Rows& rows, Contacts& contacts, Lists& lists,
                   Counters& counters, WallSet& walls, Team& team) {
  lists.any_expired.store(false, std::memory_order_relaxed);
  prepare_skins(rules, clock, rows, contacts, lists, team);
  fill_cells(rules, rows, contacts, lists, walls, team);
  if (rules.has.walls)
    walls.mark(wall_k(rules, lists), rules.scene.dt, 0.0,
               lists.skin.policy->skin == Policy::Skin::none ? 0.0 : 0.5 * rules.r_min);
  for_chunks(team, contacts, [&](Chunk& c) {
    PartClock parts(c.rebuild_seconds);
    c.result.travel[0] = c.result.travel[1] = 0;
    ListScratch* t = team.list_scratch.take();
    Sections list = search_chunk(rules, rows, lists, c, *t);
    parts.lap(RebuildPart::search);
    if (lists.skin.cuts()) list = cut_sections(rules, rows, lists, c, *t, &list);
    replace_list(rules, rows, c, *t, list);
    team.list_scratch.give(t);
    parts.lap(RebuildPart::history);
    if (rules.has.walls) {
      wall_candidates(rules, rows, lists, walls, c);
      parts.lap(RebuildPart::walls);
    }
  });
  count_pairs(contacts, counters);
  team.shares.divide(chunk_costs(contacts), team.lane_choice.threads());
  ++counters.rebuilds;
}

}  // namespace talus
