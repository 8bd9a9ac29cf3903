// Faults that tests put into runs on purpose (scheduler/state/hooks.hpp). A simulation that is made while a SeededFault
// lives has its fault.
#pragma once

#include <vector>

#include "scheduler/state/contacts.hpp"
#include "scheduler/state/hooks.hpp"
#include "scheduler/team/pools.hpp"

namespace talus::faults {

enum class Fault {
  none,
  border_order,   ///< pairs with lower chunks are summed after the interior, which depends on the chunk size
  contact_order,  ///< interior pairs are summed as they would arrive from the far end
  skin,           ///< the check believes in skins three times as large as the lists were made for
  force           ///< a force of the first chunk becomes NaN in step 50
};

/// The wrong order, of the chunk's contacts; [from, to) as they then lie.
template <Fault fault>
std::vector<std::int64_t> order_of(const PairContacts& contacts, std::int64_t& from, std::int64_t& to) {
  std::vector<std::int64_t> order;
  const std::int64_t lower = contacts.end[0], interior = contacts.end[1], total = contacts.end[2];
  if constexpr (fault == Fault::border_order) {
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

inline std::vector<std::int64_t> inverse(const std::vector<std::int64_t>& order) {
  std::vector<std::int64_t> back(order.size());
  for (std::size_t k = 0; k < order.size(); ++k)
    back[static_cast<std::size_t>(order[k])] = static_cast<std::int64_t>(k);
  return back;
}

inline void permute_contacts(int columns, Chunk& c, const std::vector<std::int64_t>& order) {
  Scratch& s = *c.scratch;
  const auto permute = [&](auto& column) {
    const auto old = column;
    for (std::size_t k = 0; k < order.size(); ++k) column[k] = old[static_cast<std::size_t>(order[k])];
  };
  permute(s.ci);
  permute(s.cj);
  for (int q = 0; q < columns; ++q) permute(c.contacts.h[q]);
}

template <Fault fault>
void reorder(int columns, Chunk& c, std::int64_t& from, std::int64_t& to, bool back) {
  std::int64_t first = from, last = to;
  const std::vector<std::int64_t> order = order_of<fault>(c.contacts, first, last);
  permute_contacts(columns, c, back ? inverse(order) : order);
  if (back) return;
  from = first;
  to = last;
}

inline Hooks hooks_of(Fault fault) {
  Hooks h;
  if (fault == Fault::border_order) h.reorder = reorder<Fault::border_order>;
  if (fault == Fault::contact_order) h.reorder = reorder<Fault::contact_order>;
  if (fault == Fault::skin) h.skin = 3, h.stretch = false;
  if (fault == Fault::force)
    h.spoil = [](std::int64_t step, const Chunk& c, double* f) {
      if (step == 50 && c.index == 0) f[0] = __builtin_nan("");
    };
  return h;
}

class SeededFault {
 public:
  explicit SeededFault(Fault fault) { hooks_of_tests = hooks_of(fault); }
  SeededFault(const SeededFault&) = delete;
  SeededFault& operator=(const SeededFault&) = delete;
  ~SeededFault() { hooks_of_tests = {}; }
};

}  // namespace talus::faults
