// Start: what a run starts from, before any row is there. Who makes it: Simulation, frames (a copy).
#pragma once

#include <memory>

#include "core/grains/insertion.hpp"
#include "core/walls/walls.hpp"
#include "scheduler/lists/skin.hpp"
#include "scheduler/state/rules.hpp"

namespace talus {

struct Start {
  Rules rules;
  SkinRule skin;
  WallSet walls;
  std::unique_ptr<Insertion> insertion;
};

/// Judges the scene and its time step. `checkpoint_fixed`: the checkpoint that the run goes on from has a column
/// "fixed"; null: it starts anew. Errors: see Simulation.
Start start_of(const Scene& scene, const RunOptions& options, const bool* checkpoint_fixed);

}  // namespace talus
