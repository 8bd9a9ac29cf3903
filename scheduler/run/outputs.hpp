// Everything a run writes while it goes on: particle frames, CSV series, checkpoints. Called by scheduler/run/run.cpp;
// the writers themselves are in core/io. Invariants: what is written at a step is a function of scene and step alone; a
// resumed run first drops what the interrupted one wrote after the checkpoint, then appends.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/io/run_folder.hpp"
#include "core/scene/scene.hpp"
#include "scheduler/simulation.hpp"

namespace talus {

/// Takes a sentence for the user.
using Tell = std::function<void(const std::string&)>;

class RunOutputs {
 public:
  /// `checkpoint`: what the run continues from, or nullptr. `append`: in its own folder; files there that cannot be
  /// continued (other columns, damaged) are set aside and said. `record`: of the scene, for the checkpoints. Error{io}
  /// names the file.
  RunOutputs(const RunFolder& folder, const Simulation& simulation, const CheckpointReader* checkpoint, bool append,
             std::int64_t checkpoint_every, std::string record, const Tell& warn);
  ~RunOutputs();
  /// First step > `step` at which something is written, INT64_MAX if none.
  std::int64_t next_stop(std::int64_t step) const;
  /// Writes what is due at the present step; nothing that is there already.
  void write(const Simulation& simulation);
  /// At the end: Error{io} if a file that this run wrote was deleted, replaced or truncated by others.
  void check() const;
  /// Writes a checkpoint of the present step, drops all but the newest two; returns its path. Error{io}.
  std::string checkpoint(const Simulation& simulation);
  /// After a physical failure: the last state as failed.tcp, its particles as failed.vtp and those near the
  /// culprits as failed_near.csv. Returns the path of the
  /// checkpoint, empty if it could not be written: the failure itself is the message that counts.
  std::string dump_failure(const Simulation& simulation) noexcept;
  std::string paraview_file() const;  ///< file to open in ParaView; empty if the scene writes no particles
  std::string csv_file() const;       ///< empty if the scene writes no series

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace talus
