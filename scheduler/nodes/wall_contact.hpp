// The wall_contact node: contacts of a chunk's rows with walls, their forces and history. Reads p, v, walls and the
// chunk's candidates; writes its wall contacts, adds to its force rows (scratch) and energy rows.
#pragma once

#include "core/walls/walls.hpp"
#include "scheduler/lists/lists.hpp"

namespace talus {

void wall_chunk(const Rules& rules, const Clock& clock, const Rows& rows, const Lists& lists, const WallSet& walls,
                Column<double>& energy, Chunk& c);

}  // namespace talus
