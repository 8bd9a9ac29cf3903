// `talus info FILE…`: what is in a checkpoint, a summary or a run folder. Reads only.
#include <fmt/format.h>

#include <filesystem>

#include "cases/program/cli.hpp"
#include "cases/program/cli_console.hpp"
#include "cases/program/cli_folder.hpp"
#include "cases/program/cli_json.hpp"
#include "core/io/particle_frames.hpp"
#include "core/io/series.hpp"
#include "core/io/summary.hpp"
#include "scheduler/simulation.hpp"

namespace talus::cli {
namespace fs = std::filesystem;
namespace {

void checkpoint_info(const std::string& path, const Options& options) {
  const CheckpointReader checkpoint(path);
  const fs::path parent = fs::path(path).parent_path();
  const bool has_scene = fs::exists(parent / "scene.toml");
  Json j;
  j.begin_object().add("checkpoint", path);
  std::string text = fmt::format("{}: checkpoint, {}, checksums good\n", path, human_bytes(fs::file_size(path)));
  if (has_scene) {
    // Only the engine knows how to read its sections, and it needs the scene for that.
    const Simulation simulation(stored_scene(RunFolder::open(parent.empty() ? "." : parent.string())), options.run,
                                checkpoint);
    text += fmt::format("  step {}, t = {:.6g} s, {} particles, state hash {:016x}\n", simulation.step(),
                        simulation.time(), grouped(simulation.particles()), simulation.state_hash());
    j.add("step", simulation.step()).add("time", simulation.time()).add("particles", simulation.particles());
    j.add("state_hash", fmt::format("{:016x}", simulation.state_hash()));
  } else {
    text += "  no scene.toml beside it: only its sections can be shown\n";
  }
  j.begin_object("sections");
  for (const std::string& name : checkpoint.names()) {
    const std::size_t bytes = checkpoint.section(name).size();
    text += fmt::format("  {:<24} {:>14} B\n", name, grouped(static_cast<std::int64_t>(bytes)));
    j.add(name, static_cast<std::int64_t>(bytes));
  }
  j.end_object().end_object();
  put("{}", options.json ? j.text() + "\n" : text);
}

void folder_info(const std::string& path, const Options& options) {
  const RunFolder folder = RunFolder::open(path);
  const Scene scene = stored_scene(folder);
  const bool ended = fs::exists(folder.summary());
  const std::string running = FolderLock::holder(path);
  // What is damaged is said before anything is printed.
  const std::string summary = ended ? read_summary_text(folder.summary()) : "";
  if (fs::exists(folder.series()) && running.empty()) check_series(folder.series());
  for (const std::int64_t step : folder.checkpoints()) CheckpointReader checked(folder.checkpoint(step));
  if (running.empty())
    for (const char* name : {"particles.pvd", "particles.vtkhdf"})
      if (fs::exists(folder.path(name))) ParticleFrames checked(folder.path(name));
  Json j;
  j.begin_object().add("folder", path).add("title", scene.title).add("has_summary", ended);
  if (!options.json) {
    put("{}: run folder{}{}\n", shown_path(path), scene.title.empty() ? "" : ", ", scene.title);
    if (!running.empty()) put("  a run is writing here ({})\n", running);
    if (!ended && running.empty()) put("  no summary.json: the run was killed, or has not begun\n");
  }
  j.begin_object("files");
  for (const auto& entry : fs::directory_iterator(path)) {
    if (!entry.is_regular_file()) continue;
    const auto size = static_cast<std::int64_t>(entry.file_size());
    j.add(entry.path().filename().string(), size);
    if (!options.json) {
      put("  {:<32} {:>12}\n", shown_path(entry.path().filename().string()), human_bytes(static_cast<double>(size)));
    }
  }
  j.end_object().begin_array("checkpoint_steps");
  for (const std::int64_t step : folder.checkpoints()) j.add("", step);
  j.end_array().end_object();
  if (options.json) put("{}\n", j.text());
  if (!options.json && ended) put("summary.json:\n{}", summary);
}
}  // namespace

int info(const Options& options) {
  for (const std::string& path : options.files) {
    if (!fs::exists(path)) throw Error(ErrorCode::io, "no such file or folder", path);
    if (fs::is_directory(path)) {
      folder_info(path, options);
    } else if (fs::path(path).extension() == ".json") {
      put("{}", read_summary_text(path));
    } else {
      checkpoint_info(path, options);
    }
  }
  return 0;
}

}  // namespace talus::cli
