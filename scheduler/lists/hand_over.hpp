// Handing contacts over to the chunks that own them, in parallel. Who calls it: the sort epoch and set-up from a
// checkpoint. Invariants: I3 (every chunk sorts what it gets by section, i, j, so the
// order is that of the rows alone), I5 (history goes with its pair, negated where the pair turns round).
#pragma once

#include <bit>
#include <span>
#include <vector>

#include "scheduler/team/parallel.hpp"

namespace talus {

/// Sorts what chunk k got, rows [lo, hi), by section, i, j into its keys and history. An entry is a pair_key() and the
/// history, all as doubles.
void receive_contacts(const Rules& rules, Contacts& contacts, Team& team, int k, Row lo, Row hi, const double* entries,
                      std::int32_t count);

/// Where each chunk's entries go, `size` doubles each: they lie together in the first piece of `room` that has space
/// left for them, else in `more`.
std::vector<double*> room_for_entries(std::span<const std::int32_t> total, std::size_t size,
                                      std::span<const std::span<double>> room, Column<double>& more);

/// Gives every contact to the chunks of its rows. `contacts_of(b, emit)` calls emit(i, j, h, at) for each
/// undirected contact of block b, the same way both times it is called: history column q, oriented i - j, is
/// h[q][at]. `room` is memory that may be overwritten; what does not fit is allocated.
template <class F>
void hand_over(const Rules& rules, Contacts& contacts, Team& team, Row n, const Blocks& blocks,
               std::span<const std::span<double>> room, const F& contacts_of) {
  const ChunkMap& chunk_of = contacts.chunk_of;
  const int chunks = chunk_of.count(n);
  const int columns = rules.has.history_columns, size = 1 + columns;
  bool flips[k_max_columns];
  for (int q = 0; q < columns; ++q) flips[q] = rules.flips(q);
  std::vector<std::int32_t> place(static_cast<std::size_t>(blocks.count) * static_cast<std::size_t>(chunks), 0);
  parallel(team, blocks.count, [&](int b) {
    std::int32_t* count = place.data() + static_cast<std::size_t>(b) * static_cast<std::size_t>(chunks);
    contacts_of(b, [&](Row i, Row j, const double* const*, std::int64_t) {
      const int ci = chunk_of(i), cj = chunk_of(j);
      ++count[ci];
      if (ci != cj) ++count[cj];
    });
  });
  const std::vector<std::int32_t> total = scan_blocks(place, blocks.count);
  Column<double> more;
  const std::vector<double*> entries = room_for_entries(total, static_cast<std::size_t>(size), room, more);
  parallel(team, blocks.count, [&](int b) {
    std::int32_t* next = place.data() + static_cast<std::size_t>(b) * static_cast<std::size_t>(chunks);
    const auto put = [&](int k, Row i, Row j, const double* const* h, std::int64_t at, bool flip) {
      double* e = entries[static_cast<std::size_t>(k)] + std::int64_t{size} * next[k]++;
      e[0] = std::bit_cast<double>(pair_key(i, j));
      for (int q = 0; q < columns; ++q) e[1 + q] = flip && flips[q] ? -h[q][at] : h[q][at];
    };
    contacts_of(b, [&](Row i, Row j, const double* const* h, std::int64_t at) {
      const int ci = chunk_of(i), cj = chunk_of(j);
      if (ci != cj) {
        put(ci, i, j, h, at, false);
        put(cj, j, i, h, at, true);
      } else if (i < j) {
        put(ci, i, j, h, at, false);
      } else {
        put(ci, j, i, h, at, true);
      }
    });
  });
  parallel(team, chunks, [&](int k) {
    receive_contacts(rules, contacts, team, k, chunk_of.lo(k), chunk_of.hi(k, n), entries[static_cast<std::size_t>(k)],
                     total[static_cast<std::size_t>(k)]);
  });
}

}  // namespace talus
