// Contacts that begin or end in a step: the linear law takes them out of their blocks (Block::late), for each is as
// many operations again and a block has only a few. They are computed together, whole vectors at a time, and added
// behind all others of the chunk. A contact is late by its own numbers, so a row's sum has the same order for every
// chunk size and list (I3). Used by the contact_force node.
#pragma once

#include "scheduler/nodes/contact_blocks.hpp"

namespace talus {

class LateList {
 public:
  /// Begins empty, in the buffers of c's scratch.
  explicit LateList(Chunk& c);
  /// Gives the block from contact k0 on room for all of its contacts.
  void offer(Block& b, std::int64_t k0);
  /// After the last block: the forces of what trials have left behind, then all late force rows to rows f of the chunk.
  /// Contacts in [both_from, both_to) of the chunk act on both partners.
  void add(const Rules& rules, ContactBlocks& blocks, double* f, std::int64_t both_from, std::int64_t both_to);

 private:
  Chunk& c_;
  std::vector<std::unique_ptr<LateContacts>>& parts_;
  std::size_t last_ = 0;  ///< part that is being filled
};

}  // namespace talus
