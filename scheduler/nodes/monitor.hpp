// Run-time monitor (DESIGN I9): looks at overlap, travel, stiffness and energy balance in sampled steps, warns once per
// kind, stops where the scene asks, and steps back to the state that shows why. Who calls it: integrate
// (observe_chunk), the check (judge_step), construction.
// Invariants: what is sampled, warned of or stopped is a function of the trajectory alone: steps that are multiples of
// k_sample_every, and those with sort epochs, insertion or events, never list rebuilds; ties go to the lower ids.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/types.hpp"
#include "core/frame/frame.hpp"
#include "core/grains/insertion.hpp"
#include "core/walls/walls.hpp"
#include "scheduler/reports.hpp"
#include "scheduler/state/contacts.hpp"
#include "scheduler/team/team.hpp"

namespace talus {

inline constexpr int k_sample_every = 64;   ///< [steps]; a full look costs about 20 ns per particle
inline constexpr int k_energy_every = 256;  ///< [steps]

/// Warnings so far, and who is to blame for a failure; not part of the state.
struct Monitor {
  std::vector<Warning> warnings;
  double energy_scale = 0;           ///< largest energy turned over so far [J]
  std::vector<ParticleId> culprits;  ///< named by the failure
};

/// Warns at construction of a domain so wide that coordinates resolve overlaps badly.
void warn_of_extent(const Rules& rules, const Clock& clock, Monitor& monitor);
/// Warns at construction of sources whose region lies on both sides of a closed wall.
void warn_of_sources(const Rules& rules, const Clock& clock, WallSet& walls, Monitor& monitor);
/// Warns of streams that could not place all that was due in the batch of this step.
void warn_of_shortfalls(const Rules& rules, const Clock& clock, const Insertion& insertion, Monitor& monitor);
/// Warns of what a part has found in the step that ends.
void warn_of_part(const Clock& clock, const std::string& part, const PartConcern& found, Monitor& monitor);
/// Warns at construction of meshes with defects, or known less well than the grains need.
void warn_of_meshes(const Rules& rules, const Clock& clock, const WallSet& walls, Monitor& monitor);
/// Begins the chunk's extremes of a sampled step with the stiffness of the contacts of each row: before the
/// integration, which clears the force rows.
void observe_stiffness(const Rules& rules, const Rows& rows, Chunk& c);
/// The other extremes, from the step that has just been integrated.
void observe_chunk(const Rules& rules, const Clock& clock, const Rows& rows, Chunk& c);
/// Stops where a wall has gone so far in the last step that it could have passed a particle unseen. StepFailure.
void judge_walls(const Rules& rules, const Rows& rows, const WallSet& walls);
/// Warnings and stops of the last step. `energies`: where the balance is due, else null. StepFailure.
void judge_step(const Rules& rules, const Clock& clock, const Contacts& contacts, const WallSet& walls,
                Monitor& monitor, const Energies* energies);
/// StepFailure where some row is not finite; before storage is permuted.
void check_finite(const Rows& rows, const Contacts& contacts, const WallSet& walls, Team& team);

}  // namespace talus
