// What contact laws add to the plain step: rolling and twisting, necks that hold beyond touch (JKR), cohesion. Who
// calls it: the nodes of pairs and walls, where the scene has some of it.
#pragma once

#include "core/walls/walls.hpp"
#include "scheduler/nodes/contact_blocks.hpp"
#include "scheduler/state/contacts.hpp"

namespace talus {

/// Narrow phase with extra history or necks.
void narrow_add_ons(const Rules& rules, const Rows& rows, Chunk& c, NarrowArgs& a, std::size_t room);
void evaluate_add_ons(const Rules& rules, const Rows& rows, const MomentArgs& args, Chunk& c, std::int64_t k0, Block& b,
                      BlockBuffers& buffers);
/// Drops wall contacts that neither touch nor hang on a neck; returns how many of the n stay.
int keep_wall_contacts(const Rules& rules, const Rows& rows, const WallSet& walls, Row i, WallContact* found,
                       std::int32_t* from, int n);
/// Moments and cohesion of wall contacts k0 .. k0 + b.n of wall.next, whose law has just run.
void wall_add_ons(const Rules& rules, const Clock& clock, const Rows& rows, const WallSet& walls, Chunk& c,
                  std::size_t k0, Block& b);
void clear_moments(Chunk& c);
void fold_moments(const Rows& rows, Chunk& c);  ///< moment rows into the torque lanes of the force rows

}  // namespace talus
