// Receiving end of hand_over(), and the contacts of a checkpoint. Invariants: I3, I5 (see hand_over.hpp).
#include "scheduler/lists/hand_over.hpp"

#include <algorithm>
#include <tuple>

#include "scheduler/lists/rebuild.hpp"

namespace talus {

std::vector<double*> room_for_entries(std::span<const std::int32_t> total, std::size_t size,
                                      std::span<const std::span<double>> room, Column<double>& more) {
  std::vector<double*> entries(total.size());
  std::vector<std::span<double>> left(room.begin(), room.end());
  std::size_t missing = 0;
  const auto take = [&](std::size_t k) {
    const std::size_t need = static_cast<std::size_t>(total[k]) * size;
    for (std::span<double>& piece : left)
      if (piece.size() >= need) {
        entries[k] = piece.data();
        piece = piece.subspan(need);
        return true;
      }
    missing += need;
    return false;
  };
  std::vector<std::size_t> homeless;
  for (std::size_t k = 0; k < entries.size(); ++k)
    if (!take(k)) homeless.push_back(k);
  more = Column<double>(missing);
  left.assign(1, std::span<double>(more));
  for (const std::size_t k : homeless) take(k);
  return entries;
}

void receive_contacts(const Rules& rules, Contacts& contacts, Team& team, int k, Row lo, Row hi, const double* entries,
                      std::int32_t count) {
  Chunk& c = *contacts.chunks[static_cast<std::size_t>(k)];
  const int columns = rules.has.history_columns;
  const std::int64_t size = 1 + columns;
  const auto rows = static_cast<std::size_t>(hi - lo);
  ListScratch* t = team.list_scratch.take();
  // counting sort by section and row; the few partners of a row are then sorted by insertion
  Column<std::int32_t>& start = t->build[2];
  grow_discarding(start, 3 * rows + 1);
  grow_discarding(t->keys, static_cast<std::size_t>(count));
  std::fill(start.begin(), start.begin() + static_cast<std::ptrdiff_t>(3 * rows + 1), 0);
  const auto bin_of = [&](std::uint64_t key) {
    const auto i = static_cast<Row>(key >> 32), j = static_cast<Row>(key & 0xffffffffU);
    return static_cast<std::size_t>(i - lo) + (j < lo ? 0 : (j < hi ? rows : 2 * rows));
  };
  const auto key_of = [&](std::int64_t q) { return std::bit_cast<std::uint64_t>(entries[size * q]); };
  for (std::int32_t q = 0; q < count; ++q) ++start[bin_of(key_of(q))];
  std::int32_t sum = 0;
  for (std::size_t b = 0; b < 3 * rows; ++b) {
    const std::int32_t n = start[b];
    start[b] = sum;
    sum += n;
  }
  std::uint64_t* sorted = t->keys.data();  // partner and number of the entry
  for (std::int32_t q = 0; q < count; ++q) {
    const std::uint64_t key = key_of(q);
    sorted[start[bin_of(key)]++] = key << 32 | static_cast<std::uint32_t>(q);
  }
  c.contacts.distributed.resize(static_cast<std::size_t>(count) + 3);
  for (int q = 0; q < columns; ++q) grow_discarding(c.contacts.h[q], static_cast<std::size_t>(count) + k_pad);
  std::uint64_t* keys = c.contacts.distributed.data();
  std::int32_t from = 0;
  for (int s = 0; s < 3; ++s) {
    for (std::size_t r = 0; r < rows; ++r) {
      const std::int32_t to = start[static_cast<std::size_t>(s) * rows + r];
      if (to - from > 64) {
        std::sort(sorted + from, sorted + to);
      } else {
        for (std::int32_t a = from + 1; a < to; ++a) {
          const std::uint64_t x = sorted[a];
          std::int32_t b = a;
          for (; b > from && sorted[b - 1] > x; --b) sorted[b] = sorted[b - 1];
          sorted[b] = x;
        }
      }
      for (; from < to; ++from) {
        *keys++ = pair_key(lo + static_cast<Row>(r), static_cast<Row>(sorted[from] >> 32));
        const double* h = entries + size * static_cast<std::int64_t>(sorted[from] & 0xffffffffU) + 1;
        for (int q = 0; q < columns; ++q) c.contacts.h[q][static_cast<std::size_t>(from)] = h[q];
      }
    }
    *keys++ = ~std::uint64_t{0};
  }
  // whole vectors are read
  for (int q = 0; q < columns; ++q) std::fill_n(c.contacts.h[q].data() + count, k_pad, 0.0);
  team.list_scratch.give(t);
}

void distribute_contacts(const Rules& rules, const Rows& rows, Contacts& contacts, Team& team,
                         const std::vector<ContactEntry>& pairs, const std::vector<WallEntry>& walls) {
  const Blocks blocks = counting_blocks(contacts, static_cast<std::int64_t>(pairs.size()),
                                        static_cast<std::int64_t>(contacts.chunks.size()));
  hand_over(rules, contacts, team, rows.n, blocks, {}, [&](int b, const auto& emit) {
    for (std::int64_t k = blocks.from(b); k < blocks.to(b); ++k) {
      const ContactEntry& e = pairs[static_cast<std::size_t>(k)];
      const double* h[k_max_columns];
      for (int q = 0; q < k_max_columns; ++q) h[q] = e.h + q;
      emit(e.a, e.b, h, 0);
    }
  });
  for (const auto& c : contacts.chunks) {
    c->wall.state.clear();
    c->wall.moment.clear();
  }
  std::vector<WallEntry> sorted = walls;
  // stable: contacts with one element through several images keep their order
  std::stable_sort(sorted.begin(), sorted.end(), [](const WallState& l, const WallState& r) {
    return std::tie(l.row, l.contact.wall, l.contact.element) < std::tie(r.row, r.contact.wall, r.contact.element);
  });
  for (const WallEntry& s : sorted) {
    Chunk& c = *contacts.chunks[static_cast<std::size_t>(contacts.chunk_of(s.row))];
    c.wall.state.push_back(s);
    c.wall.moment.insert(c.wall.moment.end(), s.m, s.m + rules.has.moment_columns);
  }
}

}  // namespace talus
