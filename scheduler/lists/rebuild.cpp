// Rebuild of the pair lists: search, history carry-over, wall candidates, chunk by chunk.
// Who calls it: the rebuild node and sort epochs. Invariants: I1, I2, I3 (a rebuild never changes storage order;
// sections sorted by (i, j)), I5.
#include <algorithm>
#include <cstring>

#include "scheduler/step/world.hpp"
#include "scheduler/team/parallel.hpp"

namespace talus {

namespace {

/// Rows that are searched together lie in a box of this many reaches and differ at most by this factor in reach. Dense
/// bed: 4 reaches cost 30 % more, 10 cost 8 % more; radii 1:5 uniform: 244, 188, 158 ns per rebuild with 2, 4, 8.
constexpr float k_group_extent = 6, k_group_ratio = 8;

/// Searches the chunk's rows; the sections stay in the scratch's build columns.
Sections search_chunk(World& w, const Chunk& c, ListScratch& t) {
  SearchArgs a{};
  a.x = w.sx.data();
  a.y = w.sy.data();
  a.z = w.sz.data();
  a.r = w.sr.data();
  a.row = w.sorted_row.data();
  a.start = w.cell_start.data();
  a.level = w.level;
  a.levels = w.levels;
  for (int k = 0; k < 3; ++k) a.period[k] = w.scene.domain.box().period(k);
  a.p = w.p.data();
  a.reach = w.reach.data();
  a.fixed = w.has.fixed ? w.fixed.data() : nullptr;
  a.group_extent = k_group_extent;
  a.group_ratio = k_group_ratio;
  a.lo = a.next = c.lo;
  a.hi = c.hi;
  const auto rows = static_cast<std::size_t>(c.hi - c.lo);
  for (int s = 0; s < 6; ++s) grow_discarding(t.build[s], rows * (s < 2 || s > 3 ? 2 : 6) + 256);
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
    w.kernels->search(a);
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
  return found;
}

/// Touching pairs of the present list as ordered keys (i, j), each section closed by a last key.
void collect_keys(const Chunk& c, ListScratch& t) {
  grow_discarding(t.keys, static_cast<std::size_t>(c.contact_end[2]) + 3);
  std::uint64_t* out = t.keys.data();
  std::int64_t slot = 0;
  for (int s = 0; s < 3; ++s) {
    for (; slot < c.end[s]; slot += 8)
      for (unsigned m = c.mask[static_cast<std::size_t>(slot >> 3)]; m != 0; m &= m - 1) {
        const auto q = static_cast<std::size_t>(slot + __builtin_ctz(m));
        *out++ = pair_key(c.pi[q], c.pj[q]);
      }
    *out++ = ~std::uint64_t{0};
  }
}

/// Lays the three sections into the flat list and merges the old contacts into mask and history. A contact that opened
/// in the last integration may be absent from the new list: its history is dropped (I5).
void assemble_chunk(World& w, Chunk& c, ListScratch& t, const Sections& list, const std::uint64_t* keys) {
  std::int64_t total = 0;
  for (int s = 0; s < 3; ++s) {
    c.pairs[s] = list.n[s];
    total += (list.n[s] + 7) / 8 * 8;
  }
  grow_discarding(c.pi, static_cast<std::size_t>(total) + k_pad);
  grow_discarding(c.pj, static_cast<std::size_t>(total) + k_pad);
  grow_discarding(c.mask, static_cast<std::size_t>(total / 8) + k_pad);
  t.lost.clear();
  std::int64_t slot = 0, k = 0;  // k counts contacts, keys[k + s] is the present one
  for (int s = 0; s < 3; ++s) {
    const std::int32_t *bi = list.i[s], *bj = list.j[s];
    const std::int64_t n = list.n[s], padded = (n + 7) / 8 * 8;
    std::memcpy(c.pi.data() + slot, bi, static_cast<std::size_t>(n) * sizeof(std::int32_t));
    std::memcpy(c.pj.data() + slot, bj, static_cast<std::size_t>(n) * sizeof(std::int32_t));
    for (std::int64_t q = n; q < padded; ++q)
      c.pi[static_cast<std::size_t>(slot + q)] = c.pj[static_cast<std::size_t>(slot + q)] = w.n;
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
      c.mask[static_cast<std::size_t>((slot + q0) >> 3)] = static_cast<std::uint8_t>(bits);
    }
    for (; key[k] != ~std::uint64_t{0}; ++k) t.lost.push_back(k);
    slot += padded;
    c.end[s] = slot;
    c.contact_end[s] = k - static_cast<std::int64_t>(t.lost.size());
  }
  if (t.lost.empty()) return;
  for (int h = 0; h < w.has.history_columns; ++h) {
    std::size_t to = 0, next = 0;
    for (std::int64_t q = 0; q < k; ++q) {
      if (next < t.lost.size() && t.lost[next] == q) {
        ++next;
        continue;
      }
      c.h[h][to++] = c.h[h][static_cast<std::size_t>(q)];
    }
  }
}

void wall_candidates(World& w, Chunk& c) {
  c.wall_row.clear();
  c.wall_begin.clear();
  c.wall_radius.clear();
  c.wall_element.clear();
  c.wall_distance.clear();
  c.wall_nearest.clear();
  for (Row i = c.lo; i < c.hi; ++i) {
    if (!w.is_alive(i) || (w.has.fixed && w.fixed[i] != 0)) continue;
    const std::size_t before = c.wall_element.size();
    const double own =
        w.skin.cuts() ? w.outer[4L * i + 3] : __builtin_sqrt(w.x0[4L * i + 3]) / (w.options.seeded_fault == 3 ? 3 : 1);
    const double skin = w.skin.to_walls(own) + drift_reach(w, i);
    const Vec3 at{w.p[4L * i], w.p[4L * i + 1], w.p[4L * i + 2]};
    const double radius = w.p[4L * i + 3] + 2 * w.skin.range(w.p[4L * i + 3]);
    w.walls.candidates(at, radius + skin, c.wall_element, &c.wall_distance);
    if (c.wall_element.size() == before) continue;
    c.wall_row.push_back(i);
    if (w.has.adhesion) c.wall_radius.push_back(radius);
    c.wall_begin.push_back(static_cast<std::int32_t>(before));
    c.wall_nearest.push_back(
        *std::min_element(c.wall_distance.begin() + static_cast<std::ptrdiff_t>(before), c.wall_distance.end()));
  }
  c.wall_begin.push_back(static_cast<std::int32_t>(c.wall_element.size()));
}

/// K of the walls' skins. Where K is chosen automatically they last half as long again as the lists are meant to: more
/// than the tuner allows for an interval that something cut, so that a short one cannot make the next ones shorter.
double wall_k(const World& w) {
  return w.skin.outer * (w.tuner.on() && w.tuner.wanted() > 0 ? 1.5 * w.tuner.wanted() : w.scene.list.verlet_k);
}

}  // namespace

ListScratch* ListScratchPool::take() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (free_.empty()) {
    all_.push_back(std::make_unique<ListScratch>());
    return all_.back().get();
  }
  ListScratch* s = free_.back();
  free_.pop_back();
  return s;
}

void ListScratchPool::give(ListScratch* s) {
  const std::lock_guard<std::mutex> lock(mutex_);
  free_.push_back(s);
}

std::size_t ListScratchPool::bytes() const {
  std::size_t b = 0;
  for (const auto& s : all_) {
    for (const auto* c : {&s->x, &s->y, &s->z, &s->r}) b += c->capacity() * sizeof(float);
    for (const auto& c : s->build) b += c.capacity() * sizeof(std::int32_t);
    b += (s->tag.capacity() + s->hits.capacity()) * sizeof(std::int32_t) + s->keys.capacity() * sizeof(std::uint64_t);
  }
  return b;
}

void for_chunks(World& w, void (*fn)(World&, Chunk&)) {
  const int chunks = static_cast<int>(w.chunks.size());
  w.shares.prepare(chunks, w.lane_choice.threads());
  w.shares.begin_round();
  parallel(w, chunks, [&](int) { fn(w, *w.chunks[static_cast<std::size_t>(w.shares.take(thread_slot(w)))]); });
}

void replace_list(World& w, Chunk& c, ListScratch& t, const Sections& s) {
  if (c.distributed.empty()) {
    collect_keys(c, t);
    assemble_chunk(w, c, t, s, t.keys.data());
  } else {
    assemble_chunk(w, c, t, s, c.distributed.data());
    c.distributed.clear();
  }
}

void count_pairs(World& w) {
  w.counters.pairs = 0;
  for (const auto& c : w.chunks) w.counters.pairs += 2 * c->pairs[1] + c->pairs[0] + c->pairs[2];
  w.counters.pairs /= 2;
}

void rebuild_lists(World& w) {
  w.any_expired.store(false, std::memory_order_relaxed);
  prepare_skins(w);
  fill_cells(w);
  if (w.has.walls)
    w.walls.mark(wall_k(w), w.scene.dt, 0.0, w.scene.list.policy == ListPolicy::always ? 0.0 : 0.5 * w.r_min);
  for_chunks(w, [](World& world, Chunk& c) {
    PartClock parts(c);
    c.travel[0] = c.travel[1] = 0;
    ListScratch* t = world.list_scratch.take();
    Sections list = search_chunk(world, c, *t);
    parts.lap(RebuildPart::search);
    if (world.skin.cuts()) list = cut_sections(world, c, *t, &list);
    replace_list(world, c, *t, list);
    world.list_scratch.give(t);
    parts.lap(RebuildPart::history);
    if (world.has.walls) {
      wall_candidates(world, c);
      parts.lap(RebuildPart::walls);
    }
  });
  count_pairs(w);
  divide_chunks(w);
  ++w.counters.rebuilds;
}

}  // namespace talus
