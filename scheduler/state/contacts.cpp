// See contacts.hpp.
#include "scheduler/state/contacts.hpp"

#include <algorithm>
#include <tuple>

namespace talus {

void need_chunks(Contacts& contacts, int count) {
  while (static_cast<int>(contacts.chunks.size()) < count) {
    contacts.chunks.push_back(std::make_unique<Chunk>());
    contacts.chunks.back()->index = static_cast<int>(contacts.chunks.size()) - 1;
  }
}

namespace {

/// Borders lie between bodies.
Row border_near(const Rows& rows, Row i) {
  const std::int32_t b = rows.body[static_cast<std::size_t>(i)];
  return b < 0 ? i : rows.bodies.first[static_cast<std::size_t>(b)];
}

}  // namespace

void keep_bodies_whole(Contacts& contacts, const Rows& rows) {
  if (rows.bodies.in) contacts.chunk_of = contacts.chunk_of.moved(rows.n, [&](Row i) { return border_near(rows, i); });
}

void make_chunks(Contacts& contacts, const Rows& rows) {
  const Row n = rows.n;
  keep_bodies_whole(contacts, rows);
  const int count = contacts.chunk_of.count(n);
  need_chunks(contacts, count);
  contacts.chunks.resize(static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k) {
    Chunk& c = *contacts.chunks[static_cast<std::size_t>(k)];
    c.lo = contacts.chunk_of.lo(k);
    c.hi = contacts.chunk_of.hi(k, n);
  }
}

std::vector<ContactEntry> contacts_of(const Rules& rules, const Chunk& c, bool failed) {
  std::vector<ContactEntry> out;
  std::size_t n = 0;
  // a step that failed half way may have new masks and old columns
  const auto known = [&](int k) { return !failed || n < c.contacts.h[k].size(); };
  for (std::int64_t s = 0; s < c.list.end[2]; ++s) {
    if (((c.list.mask[static_cast<std::size_t>(s >> 3)] >> (s & 7)) & 1U) == 0) continue;
    if (c.list.pi[static_cast<std::size_t>(s)] < c.list.pj[static_cast<std::size_t>(s)]) {
      ContactEntry e;
      e.a = c.list.pi[static_cast<std::size_t>(s)];
      e.b = c.list.pj[static_cast<std::size_t>(s)];
      for (int k = 0; k < rules.has.history_columns; ++k) e.h[k] = known(k) ? c.contacts.h[k][n] : 0;
      out.push_back(e);
    }
    ++n;
  }
  // in every chunk a is one of its own rows: chunk after chunk the pairs ascend, whatever the chunks
  std::sort(out.begin(), out.end(),
            [](const ContactEntry& l, const ContactEntry& r) { return std::tie(l.a, l.b) < std::tie(r.a, r.b); });
  return out;
}

std::vector<WallEntry> collect_wall_states(const Rules& rules, const Contacts& contacts) {
  std::vector<WallEntry> out;
  for (const auto& c : contacts.chunks) {
    const auto columns = static_cast<std::size_t>(rules.has.moment_columns);
    for (std::size_t k = 0; k < c->wall.state.size(); ++k) {
      WallEntry e;
      static_cast<WallState&>(e) = c->wall.state[k];
      for (std::size_t q = 0; q < columns; ++q) e.m[q] = c->wall.moment[k * columns + q];
      out.push_back(e);
    }
  }
  return out;
}

}  // namespace talus
