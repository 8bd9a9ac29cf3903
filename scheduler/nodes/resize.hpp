// Sizes that a part gives to the rows of a chunk, behind their integration: radius, mass, what the lists have left of
// their skins. Who calls it: the step. Invariants: I2 (|dx| + dR <= skin, charged in the step in
// which a row grows), I7.
#pragma once

#include "scheduler/lists/lists.hpp"
#include "scheduler/part.hpp"

namespace talus {

void resize_chunk(const PartView& w, const Parts& parts, Rows& rows, Lists& lists, Chunk& c);

}  // namespace talus
