// Folders of runs; see cli_folder.hpp.
#include "cases/cli_folder.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <sstream>

#include "core/io/atomic_file.hpp"
#include "core/io/scene_file.hpp"
#include "core/text.hpp"

namespace talus::cli {
namespace fs = std::filesystem;
namespace {

// Comments, so that the copy is itself a scene. Relative mesh and state files stay relative to the original.
// Only what follows the mark counts: a comment of the scene itself may look like it.
constexpr std::string_view k_mark = "#: how it was run\n", k_directory = "#: directory ", k_set = "#: set ";

std::string scene_text(const Options& options, const Scene& scene) {
  std::string text = read_file_text(options.scene);
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
  for (const std::string& message : loaded->skipped) fmt::print(stderr, "talus: warning: skipped {}\n", message);
  return std::move(loaded->reader);
}
}  // namespace

Start find_start(const Options& options, const Scene& scene) {
  Start start;
  std::string origin;  // run folder that the checkpoint belongs to
  if (!options.resume.empty()) {
    if (fs::is_directory(options.resume)) {
      origin = options.resume;
      start.checkpoint = newest(origin);
    } else {
      start.checkpoint.emplace(options.resume);
      const fs::path parent = fs::absolute(options.resume).parent_path();
      if (fs::exists(parent / "scene.toml")) origin = fs::path(options.resume).parent_path().string();
      if (fs::exists(parent / "scene.toml") && origin.empty()) origin = ".";
    }
  }
  if (!options.out.empty()) {
    start.folder = options.out;
  } else if (!origin.empty()) {
    start.folder = origin;
  } else {
    start.folder = (fs::path("results") / fs::path(scene.file).stem()).string();
  }
  start.append = !origin.empty() && same_folder(origin, start.folder);
  if (!start.append) RunFolder::check(start.folder, options.overwrite);
  return start;
}

RunFolder open_folder(const Options& options, const Scene& scene, const Start& start) {
  const std::string text = scene_text(options, scene);
  if (!start.append) return RunFolder::create(start.folder, text, options.overwrite);
  RunFolder folder = RunFolder::open(start.folder);
  write_file_atomic(folder.scene(), text);
  return folder;
}

Scene stored_scene(const RunFolder& folder) {
  const std::string text = read_file_text(folder.scene());
  std::string directory = folder.dir();
  std::vector<std::string> overrides;
  const std::size_t mark = text.rfind(k_mark);
  std::istringstream lines(mark == std::string::npos ? "" : text.substr(mark + k_mark.size()));
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(k_directory)) directory = unescaped_line(line.substr(k_directory.size()));
    if (line.starts_with(k_set)) overrides.push_back(unescaped_line(line.substr(k_set.size())));
  }
  return parse_scene(text, folder.scene(), directory, overrides);
}

Stored open_stored(const std::string& path) {
  if (fs::is_directory(path)) {
    return {stored_scene(RunFolder::open(path)), newest(path)};
  }
  CheckpointReader checkpoint(path);
  fs::path parent = fs::path(path).parent_path();
  return {stored_scene(RunFolder::open(parent.empty() ? "." : parent.string())), std::move(checkpoint)};
}

}  // namespace talus::cli
