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
#include "scheduler/lists/rebuild.hpp"

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

/// An item of the sort: the bits of a key, then of a row.
double* item(double* base, std::int64_t q) { return base + 2 * q; }

/// The cell key of a present row: three coordinates, bit by bit in turns. It comes from a grid of the scene alone,
/// never from the list's cells (I3). Small grains rule it: within a cell of a grain of 20 radii rows stay disordered,
/// and a rebuild, which searches groups of neighbouring rows, took 320 instead of 134 ns per particle. Radii 1:5
/// uniform: no difference.
std::uint64_t cell_key(const Rules& rules, const Rows& rows, Row i, double inverse) {
  const double* x = rows.grain_at(i);  // one key for all rows of a body: they stay together
  std::uint64_t k = 0;
  for (int a = 0; a < 3; ++a)
    k |= spread21(static_cast<std::uint64_t>(cell_index(fmin2(x[a], rules.size[a]) * inverse, 1 << 21))) << a;
  return k;
}

/// Writes the items of all rows in their order; the bits that some key has.
std::uint64_t make_items(const Rules& rules, const Rows& rows, double* items, const Blocks& blocks, Team& team) {
  const double inverse = 1.0 / (2.6 * fmin2(rules.r_max, 2 * rules.r_min));
  std::vector<std::uint64_t> used(static_cast<std::size_t>(blocks.count), 0);
  parallel(team, blocks.count, [&](int b) {
    std::uint64_t all = 0;
    for (std::int64_t i = blocks.from(b); i < blocks.to(b); ++i) {
      // removed rows: behind all others, as soon as one bit more than theirs is looked at
      std::uint64_t k = ~std::uint64_t{0};
      if (rows.is_alive(static_cast<Row>(i))) {
        k = cell_key(rules, rows, static_cast<Row>(i), inverse);
        all |= k;
      }
      double* e = item(items, i);
      e[0] = std::bit_cast<double>(k);
      e[1] = std::bit_cast<double>(static_cast<std::uint64_t>(i));
    }
    used[static_cast<std::size_t>(b)] = all;
  });
  std::uint64_t all = 0;
  for (const std::uint64_t u : used) all |= u;
  return all;
}

/// Where each block puts its first item of each digit: place[block][digit] holds how many it has of it on entry.
void start_places(std::vector<std::int32_t>& place, const Blocks& blocks, int digit) {
  std::vector<std::int32_t> first = scan_blocks(place, blocks.count);
  std::int32_t sum = 0;
  for (std::int32_t& f : first) sum += std::exchange(f, sum);
  for (int b = 0; b < blocks.count; ++b)
    for (std::size_t d = 0; d < first.size(); ++d) place[(static_cast<std::size_t>(b) << digit) + d] += first[d];
}

/// Sorts the present rows by cell key, then row. Afterwards sorted_row holds the old row of each new one, cell_of_row
/// the new row of each old one or -1.
void sort_rows(const Rules& rules, const Rows& rows, const Contacts& contacts, Lists& lists, Team& team) {
  const auto count = static_cast<std::size_t>(rows.n);
  grow_discarding(lists.grid.sorted_row, count + 2 * k_pad);
  grow_discarding(lists.grid.cell_of_row, count + 2 * k_pad);
  double *from = lists.x0.data(), *to = from + 2 * count;
  const Blocks blocks = counting_blocks(contacts, rows.n, 1 << k_digit);
  const std::uint64_t all = make_items(rules, rows, from, blocks, team);
  const int bits = std::max(1, static_cast<int>(std::bit_width(all)) + (rows.alive < rows.n ? 1 : 0));
  const int passes = (bits + k_digit - 1) / k_digit, digit = (bits + passes - 1) / passes;
  const std::uint64_t mask = (std::uint64_t{1} << digit) - 1;
  std::vector<std::int32_t> place(static_cast<std::size_t>(blocks.count) << digit);
  const auto places_of = [&](int b) { return place.data() + (static_cast<std::size_t>(b) << digit); };
  for (int pass = 0; pass < passes; ++pass) {
    const int shift = pass * digit;
    const auto digit_of = [&](const double* e) { return (std::bit_cast<std::uint64_t>(e[0]) >> shift) & mask; };
    parallel(team, blocks.count, [&](int b) {
      std::int32_t* number = places_of(b);
      std::memset(number, 0, sizeof(std::int32_t) << digit);
      for (std::int64_t q = blocks.from(b); q < blocks.to(b); ++q) ++number[digit_of(item(from, q))];
    });
    start_places(place, blocks, digit);
    parallel(team, blocks.count, [&](int b) {
      std::int32_t* next = places_of(b);
      for (std::int64_t q = blocks.from(b); q < blocks.to(b); ++q) {
        const double* e = item(from, q);
        const std::int32_t at = next[digit_of(e)]++;
        if (pass + 1 < passes) {
          std::memcpy(item(to, at), e, 2 * sizeof(double));
        } else {
          const auto row = static_cast<std::size_t>(std::bit_cast<std::uint64_t>(e[1]));
          lists.grid.sorted_row[static_cast<std::size_t>(at)] = static_cast<Row>(row);
          lists.grid.cell_of_row[row] = at < rows.alive ? at : -1;
        }
      }
    });
    std::swap(from, to);
  }
}

/// Rows [lo, hi) of `to` are rows old_row[lo, hi) of `from`, `width` bytes each.
void gather(unsigned char* to, const unsigned char* from, std::size_t width, const Row* old_row, std::size_t lo,
            std::size_t hi) {
  const auto rows_of = [&](auto w) {
    for (std::size_t q = lo; q < hi; ++q) std::memcpy(to + w * q, from + w * static_cast<std::size_t>(old_row[q]), w);
  };
  switch (width) {
    case 1:
      return rows_of(std::integral_constant<std::size_t, 1>{});
    case 2:
      return rows_of(std::integral_constant<std::size_t, 2>{});
    case 8:
      return rows_of(std::integral_constant<std::size_t, 8>{});
    case 32:
      return rows_of(std::integral_constant<std::size_t, 32>{});
    case 64:
      return rows_of(std::integral_constant<std::size_t, 64>{});
    default:
      return rows_of(width);
  }
}

/// Moves columns [first, last) of `moving` through the buffer: gathered in the new order, then copied back.
void permute_through(std::span<const Columns::Entry* const> moving, unsigned char* buffer, const Row* old_row,
                     std::size_t n, const Blocks& blocks, Team& team) {
  std::vector<unsigned char*> copies;
  for (const Columns::Entry* e : moving) {
    copies.push_back(buffer);
    buffer += e->bytes * n;
  }
  parallel(team, blocks.count, [&](int b) {
    const auto lo = static_cast<std::size_t>(blocks.from(b)), hi = static_cast<std::size_t>(blocks.to(b));
    for (std::size_t k = 0; k < moving.size(); ++k)
      gather(copies[k], moving[k]->data(), moving[k]->bytes, old_row, lo, hi);
  });
  parallel(team, blocks.count, [&](int b) {
    const auto lo = static_cast<std::size_t>(blocks.from(b)), hi = static_cast<std::size_t>(blocks.to(b));
    for (std::size_t k = 0; k < moving.size(); ++k) {
      const std::size_t width = moving[k]->bytes;
      std::memcpy(moving[k]->data() + width * lo, copies[k] + width * lo, width * (hi - lo));
    }
  });
}

/// Moves all columns of the rows into the new order: those with a second buffer into it, the others through x0.
void permute_rows(Rows& rows, const Contacts& contacts, Lists& lists, Team& team) {
  const Blocks blocks = counting_blocks(contacts, rows.alive, 1);
  const Row* old_row = lists.grid.sorted_row.data();
  const auto n = static_cast<std::size_t>(rows.alive);
  std::vector<const Columns::Entry*> doubled, single;
  for (const Columns::Entry& e : rows.columns.all())
    if (e.info.in && e.info.moves) (e.spare != nullptr ? doubled : single).push_back(&e);
  parallel(team, blocks.count, [&](int b) {
    const auto lo = static_cast<std::size_t>(blocks.from(b)), hi = static_cast<std::size_t>(blocks.to(b));
    for (const Columns::Entry* e : doubled) gather(e->data_of(e->spare), e->data(), e->bytes, old_row, lo, hi);
  });
  for (const Columns::Entry* e : doubled) e->swap(e->column, e->spare);
  // as many at a time as the bytes of x0 hold
  constexpr std::size_t room = 4 * sizeof(double);
  auto* buffer = reinterpret_cast<unsigned char*>(lists.x0.data());
  for (std::size_t from = 0, to = 0; from < single.size(); from = to) {
    std::size_t bytes = 0;
    while (to < single.size() && bytes + single[to]->bytes <= room) bytes += single[to++]->bytes;
    if (to > from) {
      permute_through(std::span(single).subspan(from, to - from), buffer, old_row, n, blocks, team);
      continue;
    }
    Column<unsigned char> own(single[to]->bytes * n);  // wider than x0
    permute_through(std::span(single).subspan(to++, 1), own.data(), old_row, n, blocks, team);
  }
}

/// Every chunk looks up the wall contacts of its rows under their old row, and takes them in the order they had there.
void take_wall_states(const Rules& rules, const Rows& rows, Contacts& contacts, const Lists& lists, Team& team,
                      int chunks, const ChunkMap& old_chunk_of) {
  parallel(team, chunks, [&](int k) {
    Chunk& c = *contacts.chunks[static_cast<std::size_t>(k)];
    c.wall.next.clear();
    c.wall.moment_next.clear();
    for (Row i = contacts.chunk_of.lo(k); i < contacts.chunk_of.hi(k, rows.n); ++i) {
      const Row o = lists.grid.sorted_row[static_cast<std::size_t>(i)];
      const Chunk& old = *contacts.chunks[static_cast<std::size_t>(old_chunk_of(o))];
      const std::vector<WallState>& from = old.wall.state;
      if (from.empty() || o < from.front().row || o > from.back().row) continue;
      auto s = std::lower_bound(from.begin(), from.end(), o, [](const WallState& t, Row row) { return t.row < row; });
      for (; s != from.end() && s->row == o; ++s) {
        c.wall.next.push_back(*s);
        c.wall.next.back().row = i;
        const auto m = old.wall.moment.begin() + (s - from.begin()) * rules.has.moment_columns;
        c.wall.moment_next.insert(c.wall.moment_next.end(), m, m + rules.has.moment_columns);
      }
    }
  });
  for (const auto& c : contacts.chunks) {
    std::swap(c->wall.state, c->wall.next);
    std::swap(c->wall.moment, c->wall.moment_next);
  }
}

/// Hands the contacts of the old lists over to the chunks of the new rows; those of removed grains end here.
void hand_over_lists(const Rules& rules, Rows& rows, Contacts& contacts, Lists& lists, Team& team, int chunks) {
  const Row* new_row = lists.grid.cell_of_row.data();
  const Blocks blocks = counting_blocks(contacts, static_cast<std::int64_t>(contacts.chunks.size()), chunks);
  const auto n = static_cast<std::size_t>(rows.n);
  const std::array<std::span<double>, 3> room{std::span(rows.v2.data(), static_cast<std::size_t>(rules.stride) * n),
                                              std::span(rows.p2.data(), 4 * n), std::span(lists.x0.data(), 4 * n)};
  hand_over(rules, contacts, team, rows.n, blocks, room, [&](int b, const auto& emit) {
    for (std::int64_t k = blocks.from(b); k < blocks.to(b); ++k) {
      const Chunk& c = *contacts.chunks[static_cast<std::size_t>(k)];
      const double* h[k_max_columns];
      for (int q = 0; q < k_max_columns; ++q) h[q] = c.contacts.h[q].data();
      // the chunk above owns the pairs with lower chunks just as well
      std::int64_t contact = c.contacts.end[0];
      for (std::int64_t slot = c.list.end[0]; slot < c.list.end[2]; slot += 8)
        for (unsigned m = c.list.mask[static_cast<std::size_t>(slot >> 3)]; m != 0; m &= m - 1, ++contact) {
          const auto q = static_cast<std::size_t>(slot + __builtin_ctz(m));
          const Row i = new_row[c.list.pi[q]], j = new_row[c.list.pj[q]];
          if (i >= 0 && j >= 0) emit(i, j, h, contact);
        }
    }
  });
}

/// New borders for several threads: chunks of equal cost, so that equal numbers of them are equal shares. A row costs
/// what the rows of its old chunk did; a sample of each group of rows is enough.
ChunkMap equal_cost_chunks(const Rows& rows, const Contacts& contacts, const Lists& lists) {
  const std::vector<double> cost = chunk_costs(contacts);
  const Row step = ChunkMap::group_rows(contacts.chunk_size);
  std::vector<double> group;
  for (Row i = 0; i < rows.n; i += step) {
    const auto old = static_cast<std::size_t>(contacts.chunk_of(lists.grid.sorted_row[static_cast<std::size_t>(i)]));
    group.push_back(cost[old] / std::max(1, contacts.chunks[old]->hi - contacts.chunks[old]->lo) *
                    std::min(step, rows.n - i));
  }
  return ChunkMap(contacts.chunk_size, rows.n, group);
}

}  // namespace

void sort_epoch(const Rules& rules, Rows& rows, Contacts& contacts, Lists& lists, Counters& counters, Team& team) {
  sort_rows(rules, rows, contacts, lists, team);
  permute_rows(rows, contacts, lists, team);
  set_particle_capacity(rows, rows.alive);  // before x0, p2 and v2 take the contacts: it writes the padding rows
  sort_bodies(rows);
  const ChunkMap old_chunk_of = std::exchange(contacts.chunk_of, equal_cost_chunks(rows, contacts, lists));
  keep_bodies_whole(contacts, rows);
  const int chunks = contacts.chunk_of.count(rows.n);
  need_chunks(contacts, chunks);
  hand_over_lists(rules, rows, contacts, lists, team, chunks);
  if (rules.has.walls) take_wall_states(rules, rows, contacts, lists, team, chunks, old_chunk_of);
  rows.velocity_at_old_step = false;
  make_chunks(contacts, rows);
  limit_lanes(rules, contacts, team);
  ++counters.sort_epochs;
}

}  // namespace talus
