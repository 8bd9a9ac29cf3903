// Ledger: work and energies of a run, and the counters. Who writes it: force nodes (rows of their chunk), the step's
// end (totals), insert and removal (what comes and goes). Invariant: totals reduce over fixed blocks of rows in a fixed
// tree (I3). Only with output.energies, but for what removal and insertion count.
#pragma once

#include <array>
#include <vector>

#include "core/frame/frame.hpp"
#include "scheduler/state/contacts.hpp"
#include "scheduler/state/rows.hpp"
#include "scheduler/state/rules.hpp"

namespace talus {

inline constexpr int k_energy_block = 1024;
/// Work of a step, or of a block of its rows [J]: place 1 damping, 2 friction, 3 background, 4 drive, 5 gravity, 6 and
/// 7 changing sizes on the way to n and on that to n + 1.
using StepWork = std::array<double, 8>;

/// Work since the start [J]: sums over all steps.
struct WorkTotals {
  double damping = 0, friction = 0, background = 0;  ///< dissipated
  double wall = 0;                                   ///< of moving walls and driven grains on the others
  double drive = 0;                                  ///< the part of the last step alone, times dt
  double gravity = 0;                                ///< along periodic axes, where a height means nothing
  double sizes = 0;                                  ///< what changing radii and masses have brought in
  double sizes_ahead = 0;                            ///< the part of the way to the next step that is known
};

struct Team;

struct Ledger {
  Column<double> rows;  ///< [4 n]: elastic, damping, friction, work of a driven row or what local damping takes [J]
  WorkTotals work, work_before;  ///< before: what a step that fails goes back to
  Column<double> pairs;          ///< [n], only where grains can leave: half the elastic energy of the row's pairs [J]
  double left = 0;  ///< of `rows` after a removal, in pairs whose other grain is gone: until the next forces [J]
  // only where sizes change:
  Column<double> push;           ///< [n]: size_push.hpp: derivative of elastic energy by radius [N]
  Column<double> grown, spare;   ///< [n]: by how much radii have changed in the last step [m]; the step before
  double inserted = 0;           ///< brought in less taken out by sources, removals, events [J]
  std::vector<StepWork> blocks;  ///< of the last step, by block of k_energy_block rows
  Energies resumed;              ///< of the step before the checkpoint that this run goes on from
  double start = 0;              ///< energy at the start [J]
  bool start_known = false;

  Ledger(const Rules& rules, Columns& columns);
  void count_leavers(Columns& columns);  ///< grains may leave, and take the springs of their contacts along
  void count_sizes(Columns& columns);    ///< radii and masses of rows change
};

/// Adds the work of the finished step to the run's totals. The first step of the motion has no way behind it.
void add_step_work(const Rules& rules, const Clock& clock, const Rows& rows, const Contacts& contacts, Ledger& ledger,
                   Team& team);
/// Energies of the last executed step (of step 0: those given). `executed`: steps by this object; `springs`: energy
/// rows of that step's contacts. Zeros where not asked for.
Energies energies_of(const Rules& rules, const Clock& clock, const Rows& rows, const Ledger& ledger,
                     std::int64_t executed, const double* springs);
/// Translation, from v(n-1/2) [J].
double kinetic_energy_of(const Rules& rules, const Rows& rows);

}  // namespace talus
