// The insert node: events and batches of the present step, and what removes rows. Reads the scene, sources and walls;
// writes rows, gravity, the ledger's inserted energy, counters.
#pragma once

#include "core/grains/insertion.hpp"
#include "core/walls/walls.hpp"
#include "scheduler/lists/lists.hpp"
#include "scheduler/nodes/monitor.hpp"
#include "scheduler/reports.hpp"
#include "scheduler/state/ledger.hpp"

namespace talus {

struct Parts;

bool event_due(const Rules& rules, const Clock& clock);
/// All events that are due; warns of those that concern no grain.
void apply_events(const Rules& rules, Clock& clock, Rows& rows, Lists& lists, Ledger& ledger, Counters& counters,
                  Parts& parts, Monitor& monitor);
/// Appends the batch of the present step. False: there is none. A pack that finds no room is Error{physics}.
bool insert_batch(const Rules& rules, const Clock& clock, const WallSet& walls, Insertion& insertion, Rows& rows,
                  Contacts& contacts, Ledger& ledger, Counters& counters, Parts& parts);
/// Sum of the elastic energies of rows that are there [J].
double elastic_in(const Column<double>& energies, const Rows& rows);
/// Marks a row dead (I2) and counts it.
void remove_row(const Rules& rules, const Clock& clock, Rows& rows, Lists& lists, Ledger& ledger, Counters& counters,
                Parts& parts, Row i);

}  // namespace talus
