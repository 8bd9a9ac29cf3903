// The contact_force node: forces, history and energies of a chunk's touching pairs. Reads p, v and the chunk's
// contacts; writes their history, the chunk's force rows (scratch) and its energy rows.
#pragma once

#include "scheduler/nodes/next_chunk.hpp"
#include "scheduler/state/contacts.hpp"

namespace talus {

void force_chunk(const Rules& rules, const Clock& clock, const Rows& rows, Column<double>& energy, Chunk& c,
                 NextChunk ahead);

}  // namespace talus
