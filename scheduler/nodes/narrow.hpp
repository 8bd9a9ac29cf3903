// The narrow_phase node: candidates of a chunk that touch, each with where its history lies. Reads p and the chunk's
// list; writes the chunk's mask, contacts and scratch.
#pragma once

#include "scheduler/state/contacts.hpp"

namespace talus {

/// c.scratch has been taken. Error{physics}: a worker thread has another rounding mode.
void narrow_chunk(const Rules& rules, const Clock& clock, const Rows& rows, Chunk& c);

}  // namespace talus
