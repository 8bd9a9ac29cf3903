// Everything behind a Simulation, for benchmarks and tests; nothing else may use it.
#pragma once

#include "scheduler/simulation.hpp"
#include "scheduler/step/world.hpp"

namespace talus {

struct EngineAccess {
  static World& world(Simulation& simulation) noexcept;
};

}  // namespace talus
