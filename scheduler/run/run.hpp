// A run from its present step to its last one: steps, outputs, checkpoints, failures. Who calls it: cases/program, and
// whatever else drives a simulation. Invariants: slices, looks and signals change no result; whatever ends a run leaves
// readable files.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/base/error.hpp"
#include "scheduler/run/outputs.hpp"
#include "scheduler/simulation.hpp"

namespace talus {

/// What is asked of a run besides its scene.
struct RunWish {
  std::int64_t warm = 0;                   ///< first steps that seconds and particle_steps leave out
  std::string trace{};                     ///< Chrome trace file; empty: none
  std::optional<std::int64_t> trace_from;  ///< first traced step; default: the first of this run
  std::int64_t trace_steps = 200;
};

/// Who looks on between slices of some milliseconds.
class RunWatcher {
 public:
  virtual ~RunWatcher() = default;
  /// A number other than 0 ends the run there, with a checkpoint.
  virtual int stop() { return 0; }
  virtual void stepped(const Simulation&) {}
  virtual void warmed_up() {}               ///< clock and work count from now on
  virtual void warn(const std::string&) {}  ///< each kind of warning once
};

struct RunOutcome {
  int signal = 0;                       ///< what stop() returned
  std::string failure{};                ///< message of the error that ended it
  ErrorCode code = ErrorCode::physics;  ///< of the failure
  std::string checkpoint{};             ///< the last one
  double seconds = 0;                   ///< of the timed steps: after `warm`, without the closing checkpoint
  double particle_steps = 0;            ///< grains summed over the timed steps
};

/// Runs to the scene's last step, a stop, or an error of the physics or of an output; other errors are thrown.
/// Error{usage} where no step of the run is in the trace.
RunOutcome run_to_end(Simulation& simulation, RunOutputs& outputs, const RunWish& wish, RunWatcher& watcher);

}  // namespace talus
