// Where a run begins and where it writes: --out, --resume and --overwrite of the command line against what is on disk.
// Called by cli_run, cli_info, cli_compare. Invariants: find_start only looks, open_folder is the first thing that
// writes; the scene in a run folder carries, as comments at its end, what is needed to read it again from anywhere.
#pragma once

#include <optional>
#include <string>

#include "cases/program/cli.hpp"
#include "core/io/checkpoint.hpp"
#include "core/io/run_folder.hpp"
#include "core/scene/scene.hpp"
#include "core/scene/scene_changes.hpp"

namespace talus::cli {

struct Start {
  std::string folder;                          ///< of the results
  std::optional<CheckpointReader> checkpoint;  ///< the state to continue from
  std::optional<RunFolder> own;                ///< locked: continues the files of the interrupted run
  SceneText scene;                             ///< of the command line
  std::vector<SceneChange> changes;            ///< against the scene of the checkpoint
  std::vector<int> walls;                      ///< as wall_numbers(); empty: the same walls
};

/// Error{usage}: the folder holds results and neither --resume nor --overwrite is given. Error{io}: no checkpoint
/// there, or another run writes into the folder. Error{scene}: a key is changed that the state depends on.
Start find_start(const Options& options);

/// Says what is changed, one line per key; `quiet`: only what acts on the trajectory.
void tell_changes(const Start& start, bool quiet);

/// Creates the folder, or takes the one to append to, with a copy of the scene; a scene that differs from the copy
/// there leaves the old one beside it. Error{io}.
RunFolder open_folder(const Options& options, const Start& start);

/// A checkpoint together with the scene of its run.
struct Stored {
  Scene scene;
  CheckpointReader checkpoint;
};
/// `path`: a checkpoint inside a run folder, or a run folder (its newest checkpoint, which must be whole). Error{io},
/// Error{usage}.
Stored open_stored(const std::string& path);
/// The scene in a run folder, with the replacements of its command line. Error{scene}, Error{io}.
Scene stored_scene(const RunFolder& folder);

}  // namespace talus::cli
