// The contacts of one chunk in blocks that fit into L1: geometry, motion and history of each block.
// Used by the contact_force node and by the record of contacts. Invariant: I5 (a pair keeps its history while it
// touches), whatever happened to the order of the contacts since the last step.
#pragma once

#include <memory>

#include "scheduler/state/contacts.hpp"
#include "scheduler/state/rows.hpp"
#include "scheduler/state/rules.hpp"

namespace talus {

/// L1 buffers of one block of contacts; padding lanes must hold finite values.
struct BlockBuffers {
  alignas(64) double x[4][k_block + k_pad], g[4][k_block + k_pad], r[8][k_block + k_pad], e[3][k_block + k_pad],
      reff[k_block + k_pad];
  alignas(64) double slid[k_block + k_pad];              ///< see Block::slid; rolling and twisting only
  alignas(64) double t[3][k_block + k_pad];              ///< see Block::t
  alignas(64) double s[4][k_block + k_pad];              ///< spins, then moments; rolling and twisting only
  alignas(64) double h[k_max_history][k_block + k_pad];  ///< history of a block whose contacts have moved
  alignas(64) std::int32_t pair[k_block + k_pad];
  BlockBuffers() noexcept {
    for (int k = 0; k < k_block + k_pad; ++k) {
      reff[k] = 1;
      pair[k] = 0;
    }
  }
};

/// Sets what the gather pass prefetches: rows and history of the block behind the one from contact k0 on.
void prefetch_next(const Rules& rules, const Rows& rows, const Chunk& c, std::int64_t k0, GatherArgs& g);

class LateList;
class ShapedContacts;

class ContactBlocks {
 public:
  /// After the narrow phase of the chunk. Where contacts have moved, the laws write into the scratch's columns.
  ContactBlocks(const Rules& rules, const Clock& clock, const Rows& rows, Chunk& c);
  ~ContactBlocks();
  /// Gathers the contacts from k0 on, at most k_block. Blocks have to be asked for in ascending order.
  Block gather(std::int64_t k0, BlockBuffers& buffers);
  /// The same, and evaluates the law; forces are in the returned block's r, but for those that go to late.
  Block evaluate(std::int64_t k0, BlockBuffers& buffers, LateList* late = nullptr);
  const LawArgs& law() const noexcept { return law_; }                     ///< of the present step
  const ShapedContacts* shaped() const noexcept { return shaped_.get(); }  ///< of the last block; null: spheres alone
  /// After the last block: what the laws have written becomes the chunk's history.
  void keep_history();
  /// History of contacts that were computed apart from their blocks, to its place in the chunk.
  void put_history(const LateContacts& late);
  /// Brings the chunk's history into the present order (tests that permute contacts need it so).
  void settle_history();

 private:
  void find_history(std::int64_t k0, int n, BlockBuffers& buffers, Block& b);
  [[nodiscard]] std::int64_t run_end(std::int32_t run) const;

  const Rules& rules_;
  const Rows& rows_;
  Chunk& c_;
  const LawArgs law_;
  const MomentArgs moment_;
  GatherArgs args_;  ///< what all blocks have in common
  std::int32_t run_ = 0;
  std::unique_ptr<ShapedContacts> shaped_;  ///< only with superquadrics
};

}  // namespace talus
