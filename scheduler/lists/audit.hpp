// The audit of the lists (RunOptions::audit). Who calls it: the node that starts a step.
#pragma once

#include <cstdint>

#include "core/walls/walls.hpp"
#include "scheduler/lists/lists.hpp"

namespace talus {

/// How many pairs and wall contacts touch now and are in no list.
std::int64_t audit_lists(const Rules& rules, const Rows& rows, const Contacts& contacts, const Lists& lists,
                         const WallSet& walls);

}  // namespace talus
