// Elastic energy of grains that leave the domain or are used up: the springs of their contacts leave the balance with
// them. Who calls it: the contact_force node of scenes with balance from which grains may go, and the end of a step.
#pragma once

#include "scheduler/state/contacts.hpp"
#include "scheduler/state/ledger.hpp"

namespace talus {

/// Behind the forces of the chunk's pairs, before those of its walls.
void keep_pairs(Ledger& ledger, const Chunk& c);

/// Elastic energies of the contacts of grains that are about to leave [J], as the last step has left them.
struct LeavingSprings {
  double all = 0;     ///< of walls and pairs; a pair of which both leave counts twice
  double left = 0;    ///< half that of the pairs, which stays in the rows of the others
  bool meet = false;  ///< there are pairs of which both leave
};
LeavingSprings springs_of_leavers(const Rules& rules, const Rows& rows, const Contacts& contacts, const Ledger& ledger);

}  // namespace talus
