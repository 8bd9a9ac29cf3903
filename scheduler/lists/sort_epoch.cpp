// Sort epoch: compacts the storage and permutes it into Morton order, every part over blocks or chunks in parallel.
// Who calls it: the rebuild node, at steps fixed by the scene. Invariant: I3 (the order is a function of the
// trajectory: cell key, then the row before). Apart from counters it needs no memory of its own: x0, p2, v2 and the
// columns of the cell grid are free between two steps and are filled again by the rebuild and the step that follow.
#include <array>
#include <bit>
#include <cstring>
#include <utility>

#include "core/base/count.hpp"
#include "scheduler/lists/hand_over.hpp"

namespace talus {

namespace {

std::uint64_t spread21(std::uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  x = (x | x << 2) & 0x1249249249249249;
  return x;
}

constexpr int k_digit = 8;  ///< most bits per pass of the radix sort: counters of all blocks stay in L2

/// Sorts the present rows by cell key, then row. Afterwards sorted_row holds the old row of each new one, cell_of_row
/// the new row of each old one or -1.
void sort_rows(World& w) {
  const auto rows = static_cast<std::size_t>(w.n);
  grow_discarding(w.sorted_row, rows + 2 * k_pad);
  grow_discarding(w.cell_of_row, rows + 2 * k_pad);
  double *from = w.x0.data(), *to = from + 2 * rows;  // items: the bits of a key and a row
  const auto item = [](double* base, std::int64_t q) { return base + 2 * q; };
  const Blocks blocks = counting_blocks(w, w.n, 1 << k_digit);
  // The key comes from a grid of the scene alone, never from the list's cells (I3). Small grains rule it: within a cell
  // of a grain of 20 radii rows stay disordered, and a rebuild, which searches groups of neighbouring rows, took 320
  // instead of 134 ns per particle. Radii 1:5 uniform: no difference.
  const double inverse = 1.0 / (2.6 * fmin2(w.r_max, 2 * w.r_min));
  std::vector<std::uint64_t> used(static_cast<std::size_t>(blocks.count), 0);
  parallel(w, blocks.count, [&](int b) {
    std::uint64_t all = 0;
    for (std::int64_t i = blocks.from(b); i < blocks.to(b); ++i) {
      std::uint64_t k = 0;
      if (w.is_alive(static_cast<Row>(i))) {
        const double* x = w.p.data() + 4 * i;
        for (int a = 0; a < 3; ++a)
          k |= spread21(static_cast<std::uint64_t>(cell_index(fmin2(x[a], w.size[a]) * inverse, 1 << 21))) << a;
        all |= k;
      } else {
        k = ~k;  // behind all others, as soon as one bit more than theirs is looked at
      }
      double* e = item(from, i);
      e[0] = std::bit_cast<double>(k);
      e[1] = std::bit_cast<double>(static_cast<std::uint64_t>(i));
    }
    used[static_cast<std::size_t>(b)] = all;
  });
  std::uint64_t all = 0;
  for (const std::uint64_t u : used) all |= u;
  const int bits = std::max(1, static_cast<int>(std::bit_width(all)) + (w.alive < w.n ? 1 : 0));
  const int passes = (bits + k_digit - 1) / k_digit, digit = (bits + passes - 1) / passes;
  const std::uint64_t mask = (std::uint64_t{1} << digit) - 1;
  std::vector<std::int32_t> place(static_cast<std::size_t>(blocks.count) << digit);
  for (int pass = 0; pass < passes; ++pass) {
    const int shift = pass * digit;
    const auto digit_of = [&](const double* e) { return (std::bit_cast<std::uint64_t>(e[0]) >> shift) & mask; };
    parallel(w, blocks.count, [&](int b) {
      std::int32_t* count = place.data() + (static_cast<std::size_t>(b) << digit);
      std::memset(count, 0, sizeof(std::int32_t) << digit);
      for (std::int64_t q = blocks.from(b); q < blocks.to(b); ++q) ++count[digit_of(item(from, q))];
    });
    std::vector<std::int32_t> first = scan_blocks(place, blocks.count);
    std::int32_t sum = 0;
    for (std::int32_t& f : first) {
      const std::int32_t n = f;
      f = sum;
      sum += n;
    }
    parallel(w, blocks.count, [&](int b) {
      std::int32_t* next = place.data() + (static_cast<std::size_t>(b) << digit);
      for (std::size_t d = 0; d <= mask; ++d) next[d] += first[d];
      for (std::int64_t q = blocks.from(b); q < blocks.to(b); ++q) {
        const double* e = item(from, q);
        const std::int32_t at = next[digit_of(e)]++;
        if (pass + 1 < passes) {
          std::memcpy(item(to, at), e, 2 * sizeof(double));
        } else {
          const auto row = static_cast<std::size_t>(std::bit_cast<std::uint64_t>(e[1]));
          w.sorted_row[static_cast<std::size_t>(at)] = static_cast<Row>(row);
          w.cell_of_row[row] = at < w.alive ? at : -1;
        }
      }
    });
    std::swap(from, to);
  }
}

/// Moves all columns of the rows into the new order.
void permute_rows(World& w) {
  const Blocks blocks = counting_blocks(w, w.alive, 1);
  const Row* old_row = w.sorted_row.data();
  const auto n = static_cast<std::size_t>(w.alive);
  const auto stride = static_cast<std::size_t>(w.stride);
  // the narrow columns pass through x0: 8 + 1 + 1 + 2 + 8 of its 32 bytes per row
  auto* buffer = reinterpret_cast<unsigned char*>(w.x0.data());
  struct Narrow {
    unsigned char *column, *copy;
    std::size_t width;
  };
  std::array<Narrow, 5> narrow;
  std::size_t columns = 0;
  const auto add = [&](auto& column) {
    const std::size_t width = sizeof column[0];
    narrow[columns++] = {reinterpret_cast<unsigned char*>(column.data()), buffer, width};
    buffer += width * n;
  };
  add(w.id);
  if (w.has.materials) add(w.material);
  if (w.has.fixed) add(w.fixed);
  if (w.has.groups) add(w.group);
  if (w.frame.noted) add(w.next_skin);
  parallel(w, blocks.count, [&](int b) {
    const auto lo = static_cast<std::size_t>(blocks.from(b)), hi = static_cast<std::size_t>(blocks.to(b));
    for (std::size_t q = lo; q < hi; ++q) {
      const auto o = static_cast<std::size_t>(old_row[q]);
      std::memcpy(w.p2.data() + 4 * q, w.p.data() + 4 * o, 4 * sizeof(double));
      std::memcpy(w.v2.data() + stride * q, w.v.data() + stride * o, stride * sizeof(double));
    }
    for (std::size_t k = 0; k < columns; ++k) {
      const Narrow c = narrow[k];
      const auto gather = [&](auto width) {
        for (std::size_t q = lo; q < hi; ++q)
          std::memcpy(c.copy + width * q, c.column + width * static_cast<std::size_t>(old_row[q]), width);
      };
      if (c.width == 8) {
        gather(std::integral_constant<std::size_t, 8>{});
      } else if (c.width == 2) {
        gather(std::integral_constant<std::size_t, 2>{});
      } else {
        gather(std::integral_constant<std::size_t, 1>{});
      }
    }
  });
  parallel(w, blocks.count, [&](int b) {
    const auto lo = static_cast<std::size_t>(blocks.from(b)), hi = static_cast<std::size_t>(blocks.to(b));
    for (std::size_t k = 0; k < columns; ++k) {
      const Narrow c = narrow[k];
      std::memcpy(c.column + c.width * lo, c.copy + c.width * lo, c.width * (hi - lo));
    }
  });
  std::swap(w.p, w.p2);
  std::swap(w.v, w.v2);
}

/// Every chunk looks up the wall contacts of its rows under their old row, and takes them in the order they had there.
void take_wall_states(World& w, int chunks, const ChunkMap& old_chunk_of) {
  parallel(w, chunks, [&](int k) {
    Chunk& c = *w.chunks[static_cast<std::size_t>(k)];
    c.wall_next.clear();
    c.wall_moment_next.clear();
    for (Row i = w.chunk_of.lo(k); i < w.chunk_of.hi(k, w.n); ++i) {
      const Row o = w.sorted_row[static_cast<std::size_t>(i)];
      const Chunk& old = *w.chunks[static_cast<std::size_t>(old_chunk_of(o))];
      const std::vector<WallState>& from = old.wall_state;
      if (from.empty() || o < from.front().row || o > from.back().row) continue;
      auto s = std::lower_bound(from.begin(), from.end(), o, [](const WallState& t, Row row) { return t.row < row; });
      for (; s != from.end() && s->row == o; ++s) {
        c.wall_next.push_back(*s);
        c.wall_next.back().row = i;
        const auto m = old.wall_moment.begin() + (s - from.begin()) * w.has.moment_columns;
        c.wall_moment_next.insert(c.wall_moment_next.end(), m, m + w.has.moment_columns);
      }
    }
  });
  for (const auto& c : w.chunks) {
    std::swap(c->wall_state, c->wall_next);
    std::swap(c->wall_moment, c->wall_moment_next);
  }
}

/// Hands the contacts of the old lists over to the chunks of the new rows; those of removed grains end here.
void hand_over_lists(World& w, int chunks) {
  const Row* new_row = w.cell_of_row.data();
  const Blocks blocks = counting_blocks(w, static_cast<std::int64_t>(w.chunks.size()), chunks);
  const auto n = static_cast<std::size_t>(w.n);
  const std::array<std::span<double>, 3> room{std::span(w.v2.data(), static_cast<std::size_t>(w.stride) * n),
                                              std::span(w.p2.data(), 4 * n), std::span(w.x0.data(), 4 * n)};
  hand_over(w, w.n, blocks, room, [&](int b, const auto& emit) {
    for (std::int64_t k = blocks.from(b); k < blocks.to(b); ++k) {
      const Chunk& c = *w.chunks[static_cast<std::size_t>(k)];
      const double* h[k_max_columns];
      for (int q = 0; q < k_max_columns; ++q) h[q] = c.h[q].data();
      // the chunk above owns the pairs with lower chunks just as well
      std::int64_t contact = c.contact_end[0];
      for (std::int64_t slot = c.end[0]; slot < c.end[2]; slot += 8)
        for (unsigned m = c.mask[static_cast<std::size_t>(slot >> 3)]; m != 0; m &= m - 1, ++contact) {
          const auto q = static_cast<std::size_t>(slot + __builtin_ctz(m));
          const Row i = new_row[c.pi[q]], j = new_row[c.pj[q]];
          if (i >= 0 && j >= 0) emit(i, j, h, contact);
        }
    }
  });
}

/// New borders for several threads: chunks of equal cost, so that equal numbers of them are equal shares. A row costs
/// what the rows of its old chunk did; a sample of each group of rows is enough.
ChunkMap equal_cost_chunks(const World& w) {
  const std::vector<double> cost = chunk_costs(w);
  const Row rows = ChunkMap::group_rows(w.chunk_size);
  std::vector<double> group;
  for (Row i = 0; i < w.n; i += rows) {
    const auto old = static_cast<std::size_t>(w.chunk_of(w.sorted_row[static_cast<std::size_t>(i)]));
    group.push_back(cost[old] / std::max(1, w.chunks[old]->hi - w.chunks[old]->lo) * std::min(rows, w.n - i));
  }
  return ChunkMap(w.chunk_size, w.n, group);
}

}  // namespace

void sort_epoch(World& w) {
  sort_rows(w);
  permute_rows(w);
  set_particle_capacity(w, w.alive);  // before x0, p2 and v2 take the contacts: it writes the padding rows
  const ChunkMap old_chunk_of = std::exchange(w.chunk_of, equal_cost_chunks(w));
  const int chunks = w.chunk_of.count(w.n);
  need_chunks(w, chunks);
  hand_over_lists(w, chunks);
  if (w.has.walls) take_wall_states(w, chunks, old_chunk_of);
  w.velocity_at_old_step = false;
  make_chunks(w);
  ++w.counters.sort_epochs;
}

}  // namespace talus
