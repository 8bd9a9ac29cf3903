// Run-time monitor (DESIGN I9): looks at overlap, travel, stiffness and energy balance in sampled steps, warns once per
// kind, stops where the scene asks, and steps back to the state that shows why. Who calls it: chunk_work.cpp
// (observe_chunk, relax_chunk), step_graph.cpp (judge_step), the failures of scheduler/*.cpp (fail_step).
// Invariants: what is sampled, warned of or stopped is a function of the trajectory alone: steps that are multiples of
// k_sample_every, and those with sort epochs, insertion or events, never list rebuilds; ties go to the lower ids.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/types.hpp"
#include "scheduler/simulation.hpp"

namespace talus {

struct World;
struct Chunk;

inline constexpr int k_sample_every = 64;   ///< [steps]; a full look costs about 20 ns per particle
inline constexpr int k_energy_every = 256;  ///< [steps]

enum class Watch : int { overlap, travel, stiffness, count };

/// Largest values of one chunk in a sampled step, and how many were above the warning level.
struct ChunkExtremes {
  struct Extreme {
    double value = 0;
    ParticleId id = -1, partner = -1;  ///< partner: another particle, or -2 - wall
    std::int64_t count = 0;
  };
  bool filled = false;
  Extreme of[static_cast<int>(Watch::count)];
};

/// Warnings so far; not part of the state.
struct MonitorState {
  std::vector<Warning> warnings;
  double energy_scale = 0;  ///< largest energy turned over so far [J]
};

/// Warns at construction of a domain so wide that coordinates resolve overlaps badly.
void warn_of_extent(World& w);
/// Warns at construction of sources whose region lies on both sides of a closed wall.
void warn_of_sources(World& w);
/// Warns of streams that could not place all that was due in the batch of this step.
void warn_of_shortfalls(World& w);
/// Warns at construction of meshes with defects, or known less well than the grains need.
void warn_of_meshes(World& w);
/// Fills c.extremes from the step that has just been integrated; p, v2, scratch and wall contacts of the chunk.
void observe_chunk(World& w, Chunk& c);
/// Stops where a wall has gone so far in the last step that it could have passed a particle unseen. Error{physics}.
void judge_walls(World& w);
/// Warnings and stops of the last step. Error{physics}.
void judge_step(World& w);

/// Ends the run: goes back to the state before the last integration, where every number is still finite, so that it can
/// be saved and looked at, and throws. `ids`: who is to blame. `after_step`: a step has been executed since the last
/// change of storage.
[[noreturn]] void fail_step(World& w, std::vector<ParticleId> ids, const std::string& what, const std::string& cure);
/// The same for a row with a position or velocity that is no number; names what it touches.
[[noreturn]] void fail_non_finite(World& w, Row row);
/// Throws fail_non_finite where some row is not finite; before storage is permuted.
void check_finite(World& w);
/// True if coordinates and velocity of a present row are finite.
bool finite_row(const World& w, Row row);

/// Replaces the integration in the first scene.relax.steps steps: no inertia but along the force, no gravity, no
/// history, displacement capped.
void relax_chunk(World& w, Chunk& c);

}  // namespace talus
