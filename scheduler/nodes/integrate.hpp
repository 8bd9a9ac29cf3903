// The integrate node: new positions and velocities of a chunk's rows, and what the check wants to know of them. Reads
// p, v, x0 and the chunk's force rows; writes its rows of p2 and v2, its results, and the work of driven rows.
#pragma once

#include "scheduler/lists/lists.hpp"

namespace talus {

void integrate_chunk(const Rules& rules, const Clock& clock, Rows& rows, const Lists& lists, Column<double>& energy,
                     Chunk& c);
/// Replaces the integration in the first scene.relax.steps steps: no inertia but along the force, no gravity, no
/// history, displacement capped (relax.cpp).
void relax_chunk(const Rules& rules, const Clock& clock, Rows& rows, const Lists& lists, Chunk& c);

}  // namespace talus
