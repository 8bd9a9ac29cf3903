// The state hash: order-free, over id, x, v, w, history, inserters and n. Who calls it: Simulation::state_hash(),
// tests.
#pragma once

#include <cstdint>

#include "core/grains/insertion.hpp"
#include "scheduler/state/contacts.hpp"

namespace talus {

/// `failed`: the step ended half way (see contacts_of).
std::uint64_t state_hash(const Rules& rules, const Clock& clock, const Rows& rows, const Contacts& contacts,
                         const Insertion& insertion, bool failed);

}  // namespace talus
