// Fills summary.json from the engine at the end of a run, however it ended. Called by scheduler/run/run.cpp.
#pragma once

#include <cstdint>
#include <string>

#include "core/io/summary.hpp"
#include "scheduler/simulation.hpp"

namespace talus {

/// How a run went, as far as the engine does not know it.
struct RunFacts {
  double wall_s = 0;          ///< stepping and writing, without set-up [s]
  double particle_steps = 0;  ///< sum of present particles over the executed steps
  std::int64_t first_step = 0;
  int signal = 0;        ///< that ended it, or 0
  bool audited = false;  ///< --audit
  std::string failure;   ///< message of a physical failure, or empty
  std::string version;   ///< of the program
};

Summary summary_of(const Simulation& simulation, const RunFacts& facts);

}  // namespace talus
