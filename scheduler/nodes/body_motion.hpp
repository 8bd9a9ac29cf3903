// Motion of the bodies of a chunk: what integration is for the other rows. Reads their force rows, p, v and the bodies;
// writes p2, v2 and the second buffers of the bodies, leaves zeros in their force rows. Who calls it: integrate_chunk,
// only with bodies.
#pragma once

#include "scheduler/lists/lists.hpp"
#include "scheduler/nodes/body_rows.hpp"
#include "scheduler/state/contacts.hpp"

namespace talus {

/// Adds to the chunk's results, which sphere rows may have begun.
void move_bodies(const Rules& rules, const Clock& clock, Rows& rows, const Lists& lists, Column<double>& energy,
                 Chunk& c);

/// One body, whatever it does; i: its first row.
void move_body(const BodyMotion& m, std::int32_t b, Row i);

}  // namespace talus
