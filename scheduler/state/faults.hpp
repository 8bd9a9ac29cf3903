// Faults that tests put into a run on purpose (RunOptions::seeded_fault), to see that what should notice them does. The
// nodes ask here; without a fault every answer is the neutral one.
#pragma once

#include <cstdint>
#include <vector>

#include "scheduler/state/contacts.hpp"
#include "scheduler/state/rules.hpp"

namespace talus {

class Faults {
 public:
  explicit Faults(const RunOptions& options) : fault_(options.seeded_fault) {}
  /// The check believes in skins this much larger than those the lists were made for.
  double skin() const noexcept { return fault_ == 3 ? 3 : 1; }
  /// Lists are made without the stretch of a velocity profile.
  double stretch(double right) const noexcept { return fault_ == 3 ? 1 : right; }
  /// A force of the first chunk becomes NaN in step 50.
  void spoil_force(std::int64_t step, int chunk, double* f) const noexcept {
    if (fault_ == 4 && step == 50 && chunk == 0) f[0] = __builtin_nan("");
  }
  /// Contacts are summed in another order: 1, pairs with lower chunks after the interior, which depends on the chunk
  /// size; 2, interior pairs as they would arrive from the far end.
  bool reorders() const noexcept { return fault_ == 1 || fault_ == 2; }
  /// That order, of the chunk's contacts. [from, to): those that act on both ends, as they then lie.
  std::vector<std::int64_t> order(const PairContacts& contacts, std::int64_t& from, std::int64_t& to) const;

 private:
  int fault_;
};

/// Contact k becomes contact order[k], history included.
void permute_contacts(int columns, Chunk& c, const std::vector<std::int64_t>& order);
std::vector<std::int64_t> inverse(const std::vector<std::int64_t>& order);

}  // namespace talus
