// What a checkpoint brings, looked at before lists are built on it. Who calls it: restore_state.
#pragma once

#include <string>
#include <vector>

#include "core/walls/walls.hpp"
#include "scheduler/state/contacts.hpp"

namespace talus {

/// Rows of a checkpoint, once `next_id` and the rules of the scene are known. Error{io}.
void check_restored_rows(const Rules& rules, const Rows& rows, const std::string& path);
void check_restored_contacts(const Rules& rules, const Rows& rows, const WallSet& walls,
                             const std::vector<ContactEntry>& contacts, const std::vector<WallEntry>& entries,
                             const std::string& path);

}  // namespace talus
