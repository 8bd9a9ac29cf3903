// The plane_count node, only with flux planes. Reads p and p2; writes the chunk's crossings, and after the step the
// totals.
#pragma once

#include "core/frame/plane_count.hpp"
#include "scheduler/state/contacts.hpp"

namespace talus {

/// Which rows have passed a plane in the drift p -> p2.
void plane_chunk(const Rows& rows, const PlaneCounts& counts, Chunk& c);
/// Adds them to the totals, in storage order (I3).
void add_crossings(const Rules& rules, const Rows& rows, const Contacts& contacts, PlaneCounts& planes);

}  // namespace talus
