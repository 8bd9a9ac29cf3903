// Rebuild of the pair lists: skins, cells, search, history carry-over; and the sort epoch that permutes storage.
// Invariants: I1, I2, I3 (a rebuild never changes storage order; sections sorted by (i, j)), I5.
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cstring>
#include <numeric>

#include "core/error.hpp"
#include "scheduler/world.hpp"

namespace talus {

namespace {

template <class T>
void grow(Column<T>& c, std::size_t n) {
  if (c.size() < n) c.resize(n + n / 8 + 64);
}

std::uint64_t spread21(std::uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  x = (x | x << 2) & 0x1249249249249249;
  return x;
}

std::uint64_t spread2(std::uint64_t x) {  // for the two-dimensional Morton rank of pencils
  x &= 0xffffffff;
  x = (x | x << 16) & 0x0000ffff0000ffff;
  x = (x | x << 8) & 0x00ff00ff00ff00ff;
  x = (x | x << 4) & 0x0f0f0f0f0f0f0f0f;
  x = (x | x << 2) & 0x3333333333333333;
  x = (x | x << 1) & 0x5555555555555555;
  return x;
}

/// Runs fn(block) for blocks 0..n-1 in parallel, isolated. Timed as a loop and its blocks.
template <class F>
void parallel(World& w, int n, F fn) {
  const NodeTimer loop(w, Timed::loop, -1);
  const auto timed = [&](int k) {
    const NodeTimer block(w, Timed::block, k);
    fn(k);
  };
  if (n == 1) {
    timed(0);
    return;
  }
  tbb::this_task_arena::isolate([&] { tbb::parallel_for(0, n, timed, tbb::simple_partitioner{}); });
}

/// Stable sort of the alive rows by cell key (least significant digit first, block-parallel counting sort).
void sort_by_cell(World& w, std::uint32_t cells) {
  const auto n = static_cast<std::size_t>(w.alive);
  static constexpr int digit = 11, buckets = 1 << digit;
  const int blocks = std::max(1, std::min(w.threads, static_cast<int>(n / 8192) + 1));
  std::vector<std::int32_t> other(n);
  std::vector<std::uint32_t> hist(static_cast<std::size_t>(blocks) * buckets);
  std::int32_t *from = w.order.data(), *to = other.data();
  for (int shift = 0; (std::uint64_t{cells} - 1) >> shift != 0; shift += digit) {
    std::fill(hist.begin(), hist.end(), 0);
    parallel(w, blocks, [&](int b) {
      std::uint32_t* h = hist.data() + static_cast<std::size_t>(b) * buckets;
      for (std::size_t k = n * b / blocks; k < n * (b + 1) / blocks; ++k)
        ++h[(w.key[from[k]] >> shift) & (buckets - 1)];
    });
    std::uint32_t sum = 0;
    for (int d = 0; d < buckets; ++d)
      for (int b = 0; b < blocks; ++b) {
        std::uint32_t& h = hist[static_cast<std::size_t>(b) * buckets + d];
        const std::uint32_t c = h;
        h = sum;
        sum += c;
      }
    parallel(w, blocks, [&](int b) {
      std::uint32_t* h = hist.data() + static_cast<std::size_t>(b) * buckets;
      for (std::size_t k = n * b / blocks; k < n * (b + 1) / blocks; ++k)
        to[h[(w.key[from[k]] >> shift) & (buckets - 1)]++] = from[k];
    });
    std::swap(from, to);
  }
  if (from != w.order.data()) std::copy(from, from + n, w.order.data());
}

/// Cell grid for the present reaches; ranks pencils (cy, cz) in Morton order, x cells contiguous within a pencil.
void lay_cells(World& w, double edge) {
  std::int32_t cells[3];
  const double limit = 8.0 * w.n + 4096;
  for (double scale = 1;; scale *= 1.26) {  // sparse scenes: coarser cells rather than more cells than particles
    double total = 1;
    for (int k = 0; k < 3; ++k) {
      const double c = w.size[k] / (edge * scale);
      cells[k] = c < 1 ? 1 : (c > 1e6 ? 1000000 : static_cast<std::int32_t>(c));
      total *= cells[k];
    }
    if (total <= limit || (cells[0] == 1 && cells[1] == 1 && cells[2] == 1)) break;
  }
  if (cells[1] != w.cells[1] || cells[2] != w.cells[2] || w.pencil_rank.empty()) {
    const auto pencils = static_cast<std::size_t>(cells[1]) * cells[2];
    std::vector<std::pair<std::uint64_t, std::int32_t>> codes(pencils);
    for (std::int32_t z = 0; z < cells[2]; ++z)
      for (std::int32_t y = 0; y < cells[1]; ++y) {
        const auto q = static_cast<std::size_t>(z) * cells[1] + y;
        codes[q] = {spread2(static_cast<std::uint64_t>(y)) | spread2(static_cast<std::uint64_t>(z)) << 1,
                    static_cast<std::int32_t>(q)};
      }
    std::sort(codes.begin(), codes.end());
    w.pencil_rank.resize(pencils);
    for (std::size_t q = 0; q < pencils; ++q)
      w.pencil_rank[static_cast<std::size_t>(codes[q].second)] = static_cast<std::int32_t>(q);
  }
  for (int k = 0; k < 3; ++k) w.cells[k] = cells[k];
}

std::int32_t cell_of(double x, double inverse, std::int32_t n) {
  const auto c = static_cast<std::int32_t>(x * inverse);
  return c < 0 ? 0 : (c >= n ? n - 1 : c);
}

void search_chunk(World& w, Chunk& c) {
  SearchArgs a{};
  a.x = w.sx.data();
  a.y = w.sy.data();
  a.z = w.sz.data();
  a.r = w.sr.data();
  a.row = w.sorted_row.data();
  a.start = w.cell_start.data();
  a.rank = w.pencil_rank.data();
  for (int k = 0; k < 3; ++k) {
    a.n[k] = w.cells[k];
    a.inverse[k] = w.cells[k] / w.size[k];
    a.period[k] = w.scene.domain.periodic(k) ? static_cast<float>(w.size[k]) : 0.0F;
  }
  a.p = w.p.data();
  a.reach = w.reach.data();
  a.fixed = w.has.fixed ? w.fixed.data() : nullptr;
  a.lo = a.next = c.lo;
  a.hi = c.hi;
  const auto rows = static_cast<std::size_t>(c.hi - c.lo);
  for (int s = 0; s < 6; ++s) grow(c.build[s], rows * (s < 2 || s > 3 ? 2 : 6) + 256);
  grow(c.row_buffer, 1024 + k_pad);
  for (;;) {
    for (int s = 0; s < 3; ++s) {
      a.si[s] = c.build[2 * s].data();
      a.sj[s] = c.build[2 * s + 1].data();
      a.capacity[s] = static_cast<std::int64_t>(std::min(c.build[2 * s].size(), c.build[2 * s + 1].size()));
    }
    a.scratch = c.row_buffer.data();
    a.scratch_capacity = static_cast<std::int32_t>(c.row_buffer.size()) - k_pad;
    const std::int32_t before = a.next;
    w.kernels->search(a);
    if (a.next >= a.hi) break;
    if (a.next == before) c.row_buffer.resize(c.row_buffer.size() * 2);  // either ran out: grow both
    for (int s = 0; s < 3; ++s)
      for (int q = 0; q < 2; ++q) {
        auto& b = c.build[2 * s + q];
        b.resize(b.size() + b.size() / 2 + static_cast<std::size_t>(a.scratch_capacity));
      }
  }
  for (int s = 0; s < 3; ++s) c.pairs[s] = a.count[s];
}

/// Lays the three sections into the flat list and merges the carried contacts into mask and history.
void assemble_chunk(World& w, Chunk& c) {
  std::int64_t total = 0;
  for (int s = 0; s < 3; ++s) total += (c.pairs[s] + 7) / 8 * 8;
  grow(c.pi, static_cast<std::size_t>(total) + k_pad);
  grow(c.pj, static_cast<std::size_t>(total) + k_pad);
  c.mask.resize(static_cast<std::size_t>(total / 8) + k_pad);
  std::memset(c.mask.data(), 0, c.mask.size());
  CarriedContacts& old = c.carried;
  Column<std::int64_t> kept;
  kept.reserve(static_cast<std::size_t>(old.size()));
  std::int64_t slot = 0, k = 0;
  for (int s = 0; s < 3; ++s) {
    const std::int32_t *bi = c.build[2 * s].data(), *bj = c.build[2 * s + 1].data();
    k = s == 0 ? 0 : old.end[s - 1];
    const std::int64_t k_end = old.end[s];
    for (std::int64_t q = 0; q < c.pairs[s]; ++q, ++slot) {
      c.pi[static_cast<std::size_t>(slot)] = bi[q];
      c.pj[static_cast<std::size_t>(slot)] = bj[q];
      while (k < k_end && (old.i[static_cast<std::size_t>(k)] < bi[q] ||
                           (old.i[static_cast<std::size_t>(k)] == bi[q] && old.j[static_cast<std::size_t>(k)] < bj[q])))
        ++k;
      if (k < k_end && old.i[static_cast<std::size_t>(k)] == bi[q] && old.j[static_cast<std::size_t>(k)] == bj[q]) {
        c.mask[static_cast<std::size_t>(slot >> 3)] |= static_cast<std::uint8_t>(1U << (slot & 7));
        kept.push_back(k++);
      }
    }
    for (; (slot & 7) != 0; ++slot) c.pi[static_cast<std::size_t>(slot)] = c.pj[static_cast<std::size_t>(slot)] = w.n;
    c.end[s] = slot;
  }
  for (int h = 0; h < w.has.history_columns; ++h) {
    if (static_cast<std::int64_t>(kept.size()) == old.size()) {
      std::swap(c.h[h], old.h[h]);
      grow(c.h[h], kept.size() + k_pad);
      continue;
    }
    grow(c.h[h], kept.size() + k_pad);
    for (std::size_t q = 0; q < kept.size(); ++q) c.h[h][q] = old.h[h][static_cast<std::size_t>(kept[q])];
  }
}

void wall_candidates(World& w, Chunk& c) {
  c.wall_row.clear();
  c.wall_begin.clear();
  c.wall_element.clear();
  for (Row i = c.lo; i < c.hi; ++i) {
    if (!w.is_alive(i) || (w.has.fixed && w.fixed[i] != 0)) continue;
    const std::size_t before = c.wall_element.size();
    const double skin = __builtin_sqrt(w.x0[4L * i + 3]) / (w.options.seeded_fault == 3 ? 3 : 1);
    // Walls have no images: where the row wraps before the next rebuild it meets the elements at the other end.
    const Vec3 at{w.p[4L * i], w.p[4L * i + 1], w.p[4L * i + 2]};
    Vec3 shift[3];
    int shifts[3] = {1, 1, 1};
    for (int k = 0; k < 3; ++k) {
      if (!w.scene.domain.periodic(k)) continue;
      const double x = w.p[4L * i + k], margin = skin + 1e-12 * w.size[k];
      if (x < margin) shift[shifts[k]++][k] = w.size[k];
      if (x >= w.size[k] - margin) shift[shifts[k]++][k] = -w.size[k];
    }
    for (int a = 0; a < shifts[0]; ++a)
      for (int b = 0; b < shifts[1]; ++b)
        for (int d = 0; d < shifts[2]; ++d)
          w.walls.candidates(at + Vec3{shift[a].x, shift[b].y, shift[d].z}, w.p[4L * i + 3] + skin, c.wall_element);
    if (shifts[0] * shifts[1] * shifts[2] > 1) {
      const auto first = c.wall_element.begin() + static_cast<std::ptrdiff_t>(before);
      std::sort(first, c.wall_element.end());
      c.wall_element.erase(std::unique(first, c.wall_element.end()), c.wall_element.end());
    }
    if (c.wall_element.size() == before) continue;
    c.wall_row.push_back(i);
    c.wall_begin.push_back(static_cast<std::int32_t>(before));
  }
  c.wall_begin.push_back(static_cast<std::int32_t>(c.wall_element.size()));
}

}  // namespace

void for_chunks(World& w, void (*fn)(World&, Chunk&)) {
  parallel(w, static_cast<int>(w.chunks.size()), [&](int k) { fn(w, *w.chunks[static_cast<std::size_t>(k)]); });
}

void carry_from_lists(World& w) {
  for_chunks(w, [](World& world, Chunk& c) {
    CarriedContacts& k = c.carried;
    std::int64_t n = 0;
    grow(k.i, static_cast<std::size_t>(c.contact_end[2]) + k_pad);
    grow(k.j, static_cast<std::size_t>(c.contact_end[2]) + k_pad);
    std::int64_t slot = 0;
    for (int s = 0; s < 3; ++s) {
      for (; slot < c.end[s]; slot += 8)
        for (unsigned m = c.mask[static_cast<std::size_t>(slot >> 3)]; m != 0; m &= m - 1) {
          const auto q = static_cast<std::size_t>(slot + __builtin_ctz(m));
          k.i[static_cast<std::size_t>(n)] = c.pi[q];
          k.j[static_cast<std::size_t>(n++)] = c.pj[q];
        }
      k.end[s] = n;
    }
    for (int h = 0; h < world.has.history_columns; ++h) std::swap(k.h[h], c.h[h]);
  });
}

void sort_epoch(World& w) {
  std::vector<ContactEntry> contacts = collect_contacts(w);
  std::vector<WallState> walls = collect_wall_states(w);
  // The key comes from a grid of the scene alone, never from the list's cells (I3).
  const double inverse = 1.0 / (2.6 * w.r_max);
  std::vector<std::pair<std::uint64_t, Row>> keys;
  keys.reserve(static_cast<std::size_t>(w.alive));
  for (Row i = 0; i < w.n; ++i) {
    if (!w.is_alive(i)) continue;
    const double* x = w.p.data() + 4L * i;
    std::uint64_t k = 0;
    for (int a = 0; a < 3; ++a)
      k |= spread21(static_cast<std::uint64_t>(cell_of(fmin2(x[a], w.size[a]), inverse, 1 << 21))) << a;
    keys.emplace_back(k, i);
  }
  std::sort(keys.begin(), keys.end());  // ties by row: stable
  std::vector<Row> inverse_row(static_cast<std::size_t>(w.n), -1);
  for (std::size_t q = 0; q < keys.size(); ++q)
    inverse_row[static_cast<std::size_t>(keys[q].second)] = static_cast<Row>(q);
  const auto n = static_cast<Row>(keys.size());
  const int stride = w.stride;
  parallel(w, w.threads, [&](int b) {
    for (std::size_t q = keys.size() * b / w.threads; q < keys.size() * (b + 1) / w.threads; ++q) {
      const long o = keys[q].second;
      std::memcpy(w.p2.data() + 4 * q, w.p.data() + 4 * o, 4 * sizeof(double));
      std::memcpy(w.v2.data() + stride * q, w.v.data() + stride * o, static_cast<std::size_t>(stride) * sizeof(double));
    }
  });
  std::swap(w.p, w.p2);
  std::swap(w.v, w.v2);
  const auto permute = [&](auto& column) {
    auto copy = column;
    for (std::size_t q = 0; q < keys.size(); ++q) column[q] = copy[static_cast<std::size_t>(keys[q].second)];
  };
  permute(w.id);
  if (w.has.materials) permute(w.material);
  if (w.has.fixed) permute(w.fixed);
  if (w.has.groups) permute(w.group);
  std::size_t kept = 0;
  for (ContactEntry& e : contacts) {
    e.a = inverse_row[static_cast<std::size_t>(e.a)];
    e.b = inverse_row[static_cast<std::size_t>(e.b)];
    if (e.a >= 0 && e.b >= 0) contacts[kept++] = e;
  }
  contacts.resize(kept);
  kept = 0;
  for (WallState& s : walls) {
    s.row = inverse_row[static_cast<std::size_t>(s.row)];
    if (s.row >= 0) walls[kept++] = s;
  }
  walls.resize(kept);
  set_particle_capacity(w, n);
  w.velocity_at_old_step = false;
  make_chunks(w);
  distribute_contacts(w, contacts, walls);
  ++w.counters.sort_epochs;
}

void rebuild_lists(World& w) {
  const auto rows = static_cast<std::size_t>(w.n) + k_pad;
  w.key.resize(rows);
  w.order.resize(rows);
  for (auto* c : {&w.sx, &w.sy, &w.sz, &w.sr, &w.reach}) grow(*c, rows + k_pad);
  grow(w.sorted_row, rows + k_pad);
  PartClock clock(w.serial);
  // 1. skins and reference positions; a non-finite coordinate ends the run here at the latest (I9)
  std::vector<double> largest(w.chunks.size(), 0.0);
  std::vector<Row> bad(w.chunks.size(), -1);
  parallel(w, static_cast<int>(w.chunks.size()), [&](int q) {
    const Chunk& c = *w.chunks[static_cast<std::size_t>(q)];
    double top = 0;
    for (Row i = c.lo; i < c.hi; ++i) {
      const double* x = w.p.data() + 4L * i;
      double* ref = w.x0.data() + 4L * i;
      if (!w.is_alive(i)) {
        if (!(x[0] >= 1e100)) bad[static_cast<std::size_t>(q)] = i;
        continue;
      }
      const double* v = w.v.data() + static_cast<long>(w.stride) * i;
      const double speed2 = (v[0] * v[0] + v[1] * v[1]) + v[2] * v[2];
      if (!(x[1] < 1e100) || !(x[2] < 1e100) || !(speed2 < 1e200)) bad[static_cast<std::size_t>(q)] = i;
      double a = 0;
      if (w.skin.acceleration_on && w.velocity_at_old_step) {
        const double* u = w.v2.data() + static_cast<long>(w.stride) * i;
        const double d[3] = {v[0] - u[0], v[1] - u[1], v[2] - u[2]};
        a = __builtin_sqrt((d[0] * d[0] + d[1] * d[1]) + d[2] * d[2]) / w.scene.dt;
      }
      const double skin = w.skin(x[3], __builtin_sqrt(speed2), a);
      ref[0] = x[0];
      ref[1] = x[1];
      ref[2] = x[2];
      const double stored =
          w.options.seeded_fault == 3 ? 3 * skin : skin;  // tests only: more than the list was built for
      ref[3] = stored * stored;
      // the check compares squares: the reach covers the rounding of the square root
      const double reach = (x[3] + skin) * (1 + 1e-12);
      w.reach[static_cast<std::size_t>(i)] = static_cast<float>(reach);
      top = fmax2(top, reach);
    }
    largest[static_cast<std::size_t>(q)] = top;
  });
  double top = 0;
  for (std::size_t q = 0; q < largest.size(); ++q) {
    top = fmax2(top, largest[q]);
    if (bad[q] >= 0) fail_non_finite(w, bad[q]);
  }
  if (top == 0) top = w.r_max > 0 ? w.r_max : 1;
  clock.lap(RebuildPart::skin);
  // 2. cells; float32 rounding of coordinates and period is covered by `slack`, of the arithmetic by the factor
  double extent = 0;
  for (int k = 0; k < 3; ++k) extent = fmax2(extent, w.size[k]);
  const double slack = 8 * 5.97e-8 * extent;
  lay_cells(w, 2 * (top * 1.00001 + slack));
  const auto cell_count = static_cast<std::uint32_t>(static_cast<std::uint64_t>(w.cells[0]) * w.cells[1] * w.cells[2]);
  std::size_t alive = 0;
  for (Row i = 0; i < w.n; ++i)
    if (w.is_alive(i)) w.order[alive++] = i;
  parallel(w, static_cast<int>(w.chunks.size()), [&](int q) {
    const Chunk& c = *w.chunks[static_cast<std::size_t>(q)];
    double inverse[3];
    for (int k = 0; k < 3; ++k) inverse[k] = w.cells[k] / w.size[k];
    for (Row i = c.lo; i < c.hi; ++i) {
      const double* x = w.p.data() + 4L * i;
      if (!(x[0] < 1e100)) continue;
      w.reach[static_cast<std::size_t>(i)] =
          static_cast<float>(w.reach[static_cast<std::size_t>(i)] * 1.000001 + slack);
      const std::int32_t cy = cell_of(x[1], inverse[1], w.cells[1]), cz = cell_of(x[2], inverse[2], w.cells[2]);
      w.key[static_cast<std::size_t>(i)] = static_cast<std::uint32_t>(
          static_cast<std::uint64_t>(w.pencil_rank[static_cast<std::size_t>(cz) * w.cells[1] + cy]) * w.cells[0] +
          static_cast<std::uint64_t>(cell_of(x[0], inverse[0], w.cells[0])));
    }
  });
  clock.lap(RebuildPart::keys);
  sort_by_cell(w, cell_count);
  clock.lap(RebuildPart::sort);
  w.cell_start.resize(static_cast<std::size_t>(cell_count) + 1);
  const int blocks = std::max(1, std::min<int>(w.threads, static_cast<int>(alive / 8192) + 1));
  parallel(w, blocks, [&](int b) {
    for (std::size_t k = alive * b / blocks; k < alive * (b + 1) / blocks; ++k) {
      const auto i = static_cast<std::size_t>(w.order[k]);
      w.sx[k] = static_cast<float>(w.p[4 * i]);
      w.sy[k] = static_cast<float>(w.p[4 * i + 1]);
      w.sz[k] = static_cast<float>(w.p[4 * i + 2]);
      w.sr[k] = w.reach[i];
      w.sorted_row[k] = static_cast<std::int32_t>(i);
      const std::uint32_t first = k == 0 ? 0 : w.key[static_cast<std::size_t>(w.order[k - 1])] + 1;
      for (std::uint32_t c = first; c <= w.key[i]; ++c) w.cell_start[c] = static_cast<std::int32_t>(k);
    }
  });
  const std::uint32_t after = alive == 0 ? 0 : w.key[static_cast<std::size_t>(w.order[alive - 1])] + 1;
  for (std::uint32_t c = after; c <= cell_count; ++c) w.cell_start[c] = static_cast<std::int32_t>(alive);
  clock.lap(RebuildPart::fill);
  // 3. lists
  if (w.has.walls)
    w.walls.mark(w.scene.list.verlet_k, w.scene.dt, 0.0,
                 w.scene.list.policy == ListPolicy::always ? 0.0 : 0.5 * w.r_min);
  for_chunks(w, [](World& world, Chunk& c) {
    PartClock parts(c);
    c.expired = 0;
    search_chunk(world, c);
    parts.lap(RebuildPart::search);
    assemble_chunk(world, c);
    parts.lap(RebuildPart::history);
    if (world.has.walls) {
      wall_candidates(world, c);
      parts.lap(RebuildPart::walls);
    }
  });
  w.counters.pairs = 0;
  for (const auto& c : w.chunks) w.counters.pairs += 2 * c->pairs[1] + c->pairs[0] + c->pairs[2];
  w.counters.pairs /= 2;
  ++w.counters.rebuilds;
}

}  // namespace talus
