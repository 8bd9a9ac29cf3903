// Folders of runs; see cli_folder.hpp.
#include "cases/program/cli_folder.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <sstream>

#include "cases/program/cli_console.hpp"
#include "core/base/text.hpp"
#include "core/grains/region.hpp"
#include "core/io/atomic_file.hpp"
#include "core/scene/scene_file.hpp"
#include "core/walls/shapes/jump.hpp"
#include "scheduler/simulation.hpp"

namespace talus::cli {
namespace fs = std::filesystem;
namespace {

// Comments, so that the copy is itself a scene. Relative mesh and state files stay relative to the original.
// Only what follows the mark counts: a comment of the scene itself may look like it.
constexpr std::string_view k_mark = "#: how it was run\n", k_directory = "#: directory ", k_set = "#: set ";
constexpr std::string_view k_record = "scene";  // section of a checkpoint

std::string scene_text(const Options& options, const Scene& scene) {
  std::string text = read_scene_file(options.scene);
  if (!text.empty() && text.back() != '\n') text += '\n';
  text += k_mark;
  text += fmt::format("{}{}\n", k_directory, escaped_line(fs::absolute(scene.directory).lexically_normal().string()));
  for (const std::string& set : overrides_of(options)) text += fmt::format("{}{}\n", k_set, escaped_line(set));
  return text;
}

bool same_folder(const std::string& a, const std::string& b) {
  std::error_code ignored;
  return fs::equivalent(a, b, ignored);
}

CheckpointReader newest(const std::string& folder) {
  auto loaded = RunFolder::open(folder).newest_checkpoint();
  if (!loaded)
    throw Error(ErrorCode::io, "holds no checkpoint", folder, "run with --checkpoint-every N, or from the start");
  for (const std::string& message : loaded->skipped) tell("talus: warning: skipped {}\n", message);
  return std::move(loaded->reader);
}

/// The scene in a run folder as text, with the comments read that tell where it came from.
SceneText stored_text(const RunFolder& folder) {
  const std::string text = read_file_text(folder.scene());
  std::string directory = folder.dir();
  std::vector<std::string> overrides;
  const std::size_t mark = text.rfind(k_mark);
  // Copies of older versions have no mark.
  std::istringstream lines(mark == std::string::npos ? text : text.substr(mark + k_mark.size()));
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(k_directory)) directory = unescaped_line(line.substr(k_directory.size()));
    if (line.starts_with(k_set)) overrides.push_back(unescaped_line(line.substr(k_set.size())));
  }
  return read_scene_text(text, folder.scene(), directory, overrides);
}

/// Which scene the checkpoint belongs to: it carries a record; older ones have only the scene beside them.
SceneBefore scene_before(const CheckpointReader& checkpoint, const std::string& origin) {
  SceneBefore before;
  if (checkpoint.has(k_record)) {
    const auto bytes = checkpoint.section(k_record);
    const std::string text(bytes.begin(), bytes.end());
    try {
      before.record = read_scene_text(text, checkpoint.path(), ".", {});
      before.contents = contents_in(text);
    } catch (const Error& e) {
      tell("talus: warning: the scene in the checkpoint cannot be read ({})\n", e.what());
    }
  }
  if (origin.empty()) return before;
  try {
    before.folder = stored_text(RunFolder::open(origin));
  } catch (const Error& e) {
    tell("talus: warning: the scene beside the checkpoint cannot be read ({})\n", e.what());
  }
  return before;
}

void refuse(const Start& start) {
  std::string list;
  std::size_t refused = 0;
  constexpr std::size_t k_named = 4;
  for (const SceneChange& c : start.changes) {
    if (c.rule != AtResume::fixed || ++refused > k_named) continue;
    list += fmt::format("{}{} ({})", list.empty() ? "" : "; ", change_text(c), c.why);
  }
  if (refused > k_named) list += fmt::format("; and {} more", refused - k_named);
  if (refused > 0)
    throw Error(ErrorCode::scene, "cannot be changed at a resume: " + list, start.checkpoint->path(),
                "resume with the former values, or start a new run");
}

/// A wall that stands elsewhere all at once could pass grains unseen, or stand in them.
void refuse_jump(const Scene& before, const Start& start) {
  const Scene& scene = start.scene.scene;
  const std::int64_t step = Simulation::step_of(*start.checkpoint);
  const WallJump jump = largest_jump(before, scene, step);
  if (!(jump.distance > 1e-6 * norm(scene.domain.upper - scene.domain.lower))) return;
  throw Error(
      ErrorCode::scene,
      fmt::format("wall '{}' would jump by {:.3g} m at step {}: its motion counts from its start and not from the "
                  "resume",
                  jump.wall, jump.distance, step),
      start.checkpoint->path(),
      fmt::format("keep its motion until {:g} s; a wall with another name begins anew, where its keys put it",
                  static_cast<double>(step) * scene.dt));
}

/// The folder whose newest checkpoint, or the file which, --resume names; returns the folder it belongs to, or "".
std::string origin_of(const std::string& resume) {
  if (fs::is_directory(resume)) return resume;
  const fs::path parent = fs::path(resume).parent_path();
  const std::string folder = parent.empty() ? "." : parent.string();
  return fs::exists(fs::path(folder) / "scene.toml") ? folder : "";
}
}  // namespace

Start find_start(const Options& options) {
  Start start;
  start.scene = read_scene_text(read_scene_file(options.scene), options.scene, scene_directory(options.scene),
                                overrides_of(options));
  load_regions(start.scene.scene);
  const std::string origin = options.resume.empty() ? "" : origin_of(options.resume);
  if (!options.out.empty()) {
    start.folder = options.out;
  } else if (!origin.empty()) {
    start.folder = origin;
  } else {
    start.folder = (fs::path("results") / fs::path(options.scene).stem()).string();
  }
  // The lock first: another run in this folder may replace the checkpoint while it is read.
  if (!origin.empty() && same_folder(origin, start.folder))
    start.own = RunFolder::resume(start.folder);
  else
    RunFolder::check(start.folder, options.overwrite);
  if (options.resume.empty()) return start;
  start.checkpoint = fs::is_directory(options.resume) ? newest(origin) : CheckpointReader(options.resume);
  Simulation::check_continuable(*start.checkpoint);
  const SceneBefore before = scene_before(*start.checkpoint, origin);
  if (!before.record && !before.folder) {
    tell("talus: warning: {} does not tell its scene; whether this one fits cannot be checked\n",
         start.checkpoint->path());
    return start;
  }
  start.changes = scene_changes(before, start.scene, Simulation::step_of(*start.checkpoint));
  refuse(start);
  const Scene& old = (before.record ? before.record : before.folder)->scene;
  refuse_jump(old, start);
  start.walls = wall_numbers(old, start.scene.scene, start.changes);
  return start;
}

void tell_changes(const Start& start, bool quiet) {
  if (!start.checkpoint) return;
  for (const SceneChange& c : start.changes)
    if (!quiet || c.rule == AtResume::physics)
      tell("talus: changed from step {} on: {}\n", Simulation::step_of(*start.checkpoint), change_text(c));
  if (!start.walls.empty())
    tell("talus: warning: walls that are gone or have another shape lose the history of their contacts\n");
}

RunFolder open_folder(const Options& options, const Start& start) {
  const std::string text = scene_text(options, start.scene.scene);
  if (!start.own) return RunFolder::create(start.folder, text, options.overwrite);
  const RunFolder& folder = *start.own;
  if (!start.changes.empty()) {
    // A copy, not a rename: the folder has a scene at every instant.
    const std::string aside = folder.name_aside(folder.scene(), Simulation::step_of(*start.checkpoint));
    write_file_atomic(aside, read_file_text(folder.scene()));
    if (!options.quiet) tell("talus: the former scene is now {}\n", aside);
  }
  write_file_atomic(folder.scene(), text);
  return folder;
}

Scene stored_scene(const RunFolder& folder) {
  Scene scene = stored_text(folder).scene;
  load_regions(scene);
  return scene;
}

Stored open_stored(const std::string& path) {
  if (fs::is_directory(path)) {
    const RunFolder folder = RunFolder::open(path);
    // The newest one, or none: another step than the one asked for would be a wrong answer.
    const std::vector<std::int64_t> steps = folder.checkpoints();
    if (steps.empty())
      throw Error(ErrorCode::io, "holds no checkpoint", path, "give the folder of a run that has ended");
    CheckpointReader checkpoint(folder.checkpoint(steps.back()));
    return {stored_scene(folder), std::move(checkpoint)};
  }
  CheckpointReader checkpoint(path);
  const fs::path parent = fs::path(path).parent_path();
  const std::string folder = parent.empty() ? "." : parent.string();
  if (!fs::exists(fs::path(folder) / "scene.toml"))
    throw Error(ErrorCode::usage, "has no scene.toml beside it, which tells what it holds", path,
                "leave checkpoints in the folder of their run, or copy its scene.toml beside them");
  return {stored_scene(RunFolder::open(folder)), std::move(checkpoint)};
}

}  // namespace talus::cli
