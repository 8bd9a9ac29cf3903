// See leavers.hpp.
#include "scheduler/nodes/leavers.hpp"

#include <algorithm>
#include <vector>

namespace talus {
namespace {

/// Rows of the grains that leave, ascending.
std::vector<Row> leaving_rows(const Rules& rules, const Rows& rows, const Contacts& contacts) {
  std::vector<Row> all;
  for (const auto& c : contacts.chunks)
    for (std::int32_t k = 0; k < c->result.out_count; ++k) {
      const Row i = c->result.out[static_cast<std::size_t>(k)];
      const std::int32_t b = rows.body_of(i);
      const Row end = b < 0 ? i + 1 : i + static_cast<Row>(shape_of(rules, rows.bodies, b).spheres.size());
      for (Row q = i; q < end; ++q) all.push_back(q);
    }
  return all;
}

bool any_meet(const Contacts& contacts, const std::vector<Row>& leaving) {
  const auto leaves = [&](Row i) { return std::binary_search(leaving.begin(), leaving.end(), i); };
  for (const auto& c : contacts.chunks) {
    const auto next = std::lower_bound(leaving.begin(), leaving.end(), c->lo);
    if (next == leaving.end() || *next >= c->hi) continue;
    const PairList& list = c->list;
    for (std::int64_t k = 0; k < list.end[1]; ++k) {  // pairs with lower chunks and its own
      const auto at = static_cast<std::size_t>(k);
      if ((list.mask[at / 8] >> (at % 8) & 1) != 0 && leaves(list.pi[at]) && leaves(list.pj[at])) return true;
    }
  }
  return false;
}

}  // namespace

void keep_pairs(Ledger& ledger, const Chunk& c) {
  for (Row i = c.lo; i < c.hi; ++i)
    ledger.pairs[static_cast<std::size_t>(i)] = ledger.rows[4 * static_cast<std::size_t>(i)];
}

LeavingSprings springs_of_leavers(const Rules& rules, const Rows& rows, const Contacts& contacts,
                                  const Ledger& ledger) {
  const std::vector<Row> leaving = leaving_rows(rules, rows, contacts);
  LeavingSprings s;
  int pressed = 0;
  for (const Row q : leaving) {
    const auto i = static_cast<std::size_t>(q);
    if (ledger.pairs[i] != 0) ++pressed;
    s.all = s.all + (ledger.rows[4 * i] + ledger.pairs[i]);  // half of its pairs, once more, and its walls
    s.left = s.left + ledger.pairs[i];
  }
  s.meet = pressed > 1 && any_meet(contacts, leaving);
  return s;
}

}  // namespace talus
