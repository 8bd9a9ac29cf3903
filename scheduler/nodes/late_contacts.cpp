// See late_contacts.hpp.
#include "scheduler/nodes/late_contacts.hpp"

#include <algorithm>

namespace talus {

LateList::LateList(Chunk& c) : c_(c), parts_(c.scratch->late) {
  if (!parts_.empty()) parts_[0]->n = 0;
}

void LateList::offer(Block& b, std::int64_t k0) {
  while (last_ + 1 < parts_.size() && parts_[last_]->n == k_block) ++last_;
  while (parts_.size() < last_ + 2) {
    parts_.push_back(std::make_unique<LateContacts>());
    if (parts_.size() > 1) parts_[parts_.size() - 2]->next = parts_.back().get();
  }
  parts_[last_ + 1]->n = 0;
  b.late = parts_[last_].get();
  b.first = static_cast<std::int32_t>(k0);
}

void LateList::add(const Rules& rules, ContactBlocks& blocks, double* f, std::int64_t both_from, std::int64_t both_to) {
  const Scratch& s = *c_.scratch;
  for (const auto& part : parts_) {
    LateContacts& late = *part;
    if (late.n == 0) return;
    std::int32_t i[k_block + k_pad] = {}, j[k_block + k_pad] = {};
    for (int q = 0; q < late.n; ++q) {
      i[q] = s.ci[static_cast<std::size_t>(late.at[q])];
      j[q] = s.cj[static_cast<std::size_t>(late.at[q])];
    }
    const auto before = [&](std::int64_t k) {
      return static_cast<int>(std::lower_bound(late.at, late.at + late.n, k) - late.at);
    };
    const ScatterArgs to_rows{f, i, j, late.n, before(both_from), before(both_to), late.r};
    if (rules.law.trial) {
      const double back = rules.kernels->late(late, blocks.law());
      rules.kernels->scatter_limited(LimitArgs{to_rows,
                                               late.t,
                                               blocks.law().contact_lever != 0 ? late.g[3] : nullptr,
                                               {late.h[0], late.h[1], late.h[2]},
                                               back});
      blocks.put_history(late);
    } else {
      rules.kernels->scatter[rules.has.rotation ? 1 : 0](to_rows);
    }
    if (late.n < k_block) return;
  }
}

}  // namespace talus
