// Contacts as checkpoints hold them: sections contacts, contact_history, wall_contacts, wall_centres, wall_moments.
#pragma once

#include <vector>

#include "core/io/checkpoint.hpp"
#include "core/walls/walls.hpp"
#include "scheduler/state/contacts.hpp"

namespace talus {

/// Without the columns that the scene does not have: pairs of rows, then the columns of each contact. `failed`: see
/// contacts_of.
void write_contacts(const Rules& rules, const Contacts& contacts, const WallSet& walls, bool failed,
                    CheckpointWriter& out);
/// Error{io}: sections that do not fit together.
std::vector<ContactEntry> read_contacts(const Rules& rules, const CheckpointReader& in);
/// `numbers`: what each wall of the checkpoint is now, -1: gone; empty: the same walls. Error{io}.
std::vector<WallEntry> read_walls(const Rules& rules, const WallSet& walls, const CheckpointReader& in,
                                  const std::vector<int>& numbers);

}  // namespace talus
