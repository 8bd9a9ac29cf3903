// See faults.hpp.
#include "scheduler/state/faults.hpp"

namespace talus {

std::vector<std::int64_t> Faults::order(const PairContacts& contacts, std::int64_t& from, std::int64_t& to) const {
  std::vector<std::int64_t> order;
  const std::int64_t lower = contacts.end[0], interior = contacts.end[1], total = contacts.end[2];
  if (fault_ == 1) {
    for (std::int64_t k = lower; k < total; ++k) order.push_back(k);
    for (std::int64_t k = 0; k < lower; ++k) order.push_back(k);
    to -= from;
    from = 0;
  } else {
    for (std::int64_t k = 0; k < lower; ++k) order.push_back(k);
    for (std::int64_t k = interior; k-- > lower;) order.push_back(k);
    for (std::int64_t k = interior; k < total; ++k) order.push_back(k);
  }
  return order;
}

void permute_contacts(int columns, Chunk& c, const std::vector<std::int64_t>& order) {
  Scratch& s = *c.scratch;
  const auto permute = [&](auto& column) {
    const auto old = column;
    for (std::size_t k = 0; k < order.size(); ++k) column[k] = old[static_cast<std::size_t>(order[k])];
  };
  permute(s.ci);
  permute(s.cj);
  for (int q = 0; q < columns; ++q) permute(c.contacts.h[q]);
}

std::vector<std::int64_t> inverse(const std::vector<std::int64_t>& order) {
  std::vector<std::int64_t> back(order.size());
  for (std::size_t k = 0; k < order.size(); ++k)
    back[static_cast<std::size_t>(order[k])] = static_cast<std::int64_t>(k);
  return back;
}

}  // namespace talus
