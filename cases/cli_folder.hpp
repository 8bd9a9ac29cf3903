// Where a run begins and where it writes: --out, --resume and --overwrite of the command line against what is on disk.
// Called by cli_run, cli_info, cli_compare. Invariants: find_start only looks, open_folder is the first thing that
// writes; the scene in a run folder carries, as comments at its end, what is needed to read it again from anywhere.
#pragma once

#include <optional>
#include <string>

#include "cases/cli.hpp"
#include "core/io/checkpoint.hpp"
#include "core/io/run_folder.hpp"
#include "core/scene.hpp"

namespace talus::cli {

struct Start {
  std::string folder;                          ///< of the results
  std::optional<CheckpointReader> checkpoint;  ///< the state to continue from
  bool append = false;                         ///< continues the files of the interrupted run
};

/// Error{usage}: the folder holds results and neither --resume nor --overwrite is given. Error{io}: no checkpoint
/// there.
Start find_start(const Options& options, const Scene& scene);

/// Creates the folder, or opens the one to append to, with a copy of the scene. Error{io}.
RunFolder open_folder(const Options& options, const Scene& scene, const Start& start);

/// A checkpoint together with the scene of its run.
struct Stored {
  Scene scene;
  CheckpointReader checkpoint;
};
/// `path`: a checkpoint inside a run folder, or a run folder (its newest checkpoint). Error{io}, Error{usage}.
Stored open_stored(const std::string& path);
/// The scene in a run folder, with the replacements of its command line. Error{scene}, Error{io}.
Scene stored_scene(const RunFolder& folder);

}  // namespace talus::cli
