// The displacement_check node: what the chunks' nodes have found in the last step. Reads results, judges; writes dead
// rows, counters. Once per step, in chunk order.
#pragma once

#include "core/walls/walls.hpp"
#include "scheduler/lists/lists.hpp"
#include "scheduler/reports.hpp"
#include "scheduler/state/contacts.hpp"
#include "scheduler/state/ledger.hpp"

namespace talus {

struct Parts;

/// StepFailure: overlaps too deep, unstable rows, rows that are no number.
void report_failures(const Rules& rules, const Clock& clock, const Rows& rows, const Contacts& contacts,
                     const WallSet& walls);
/// Rows that have left through open sides. StepFailure: through a closed one.
void remove_leavers(const Rules& rules, const Clock& clock, Rows& rows, Contacts& contacts, Lists& lists,
                    Ledger& ledger, Counters& counters, Parts& parts);
void forget_results(Contacts& contacts);  ///< of a step that is taken back
ListRecord list_record(const Rules& rules, const Clock& clock, const Contacts& contacts, const Lists& lists,
                       const Counters& counters);

}  // namespace talus
