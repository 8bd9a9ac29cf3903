// The contacts of one chunk in blocks that fit into L1: geometry, motion and history of each block.
// Used by the contact_force node and by the record of contacts. Invariant: I5 (a pair keeps its history while it
// touches), whatever happened to the order of the contacts since the last step.
#pragma once

#include "scheduler/step/world.hpp"

namespace talus {

/// Sets what the gather pass prefetches: rows and history of the block behind the one from contact k0 on.
void prefetch_next(const World& w, const Chunk& c, std::int64_t k0, GatherArgs& g);

class ContactBlocks {
 public:
  /// After narrow_chunk. Where contacts have moved, the laws write into the scratch's columns.
  ContactBlocks(const World& w, Chunk& c);
  /// Gathers the contacts from k0 on, at most k_block. Blocks have to be asked for in ascending order.
  Block gather(std::int64_t k0, BlockBuffers& buffers);
  /// The same, and evaluates the law; forces are in the returned block's r.
  Block evaluate(std::int64_t k0, BlockBuffers& buffers);
  /// After the last block: what the laws have written becomes the chunk's history.
  void keep_history();
  /// Brings the chunk's history into the present order (tests that permute contacts need it so).
  void settle_history();

 private:
  void find_history(std::int64_t k0, int n, BlockBuffers& buffers, Block& b);
  [[nodiscard]] std::int64_t run_end(std::int32_t run) const;

  const World& w_;
  Chunk& c_;
  GatherArgs args_;  ///< what all blocks have in common
  std::int32_t run_ = 0;
};

}  // namespace talus
