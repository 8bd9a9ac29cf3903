// `talus report DIR`: hands the run folder to perf/report.py, which writes one self-contained HTML page. The script is
// found by cli_parts.
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "cases/program/cli.hpp"
#include "cases/program/cli_parts.hpp"
#include "core/io/particle_frames.hpp"
#include "core/io/run_folder.hpp"
#include "core/io/series.hpp"
#include "core/io/summary.hpp"

extern char** environ;

namespace talus::cli {
namespace fs = std::filesystem;
namespace {
// Debian's own interpreter: the one for which install.sh provides numpy, h5py and matplotlib.
constexpr const char* k_python = "/usr/bin/python3";

/// The page names what it cannot show; what a run left damaged is an error, since its figures would be missing unseen.
/// While a run writes, and after a kill, a last row or frame may be incomplete: the page leaves it out.
void check_folder(const std::string& folder) {
  if (!fs::exists(fs::path(folder) / "scene.toml") || !FolderLock::holder(folder).empty()) return;
  const RunFolder run = RunFolder::open(folder);
  for (const std::int64_t step : run.checkpoints()) CheckpointReader checked(run.checkpoint(step));
  if (!fs::exists(run.summary())) return;
  read_summary_text(run.summary());
  if (fs::exists(run.series())) check_series(run.series());
  for (const char* name : {"particles.pvd", "particles.vtkhdf"})
    if (fs::exists(run.path(name))) ParticleFrames checked(run.path(name));
}
}  // namespace

int report(const Options& options) {
  const std::string folder = options.files.at(0);
  if (!fs::is_directory(folder)) {
    throw Error(ErrorCode::io, "is not a folder", folder, "give the folder of a run, e.g. results/hopper-20k");
  }
  if (!fs::exists(fs::path(folder) / "summary.json") && !fs::exists(fs::path(folder) / "scene.toml"))
    throw Error(ErrorCode::io, "holds neither summary.json nor scene.toml, so it is not the folder of a run", folder);
  check_folder(folder);
  const std::string script = part("perf/report.py");
  std::vector<std::string> words{k_python, script, folder};
  if (!options.out.empty()) words.insert(words.end(), {"--out", options.out});
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  pid_t child = 0;
  if (const int reason = posix_spawn(&child, k_python, nullptr, nullptr, argv.data(), environ); reason != 0) {
    throw Error(ErrorCode::io, std::strerror(reason), k_python, "apt-get install python3");
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  const int io = static_cast<int>(ErrorCode::io);
  if (WIFEXITED(status) && WEXITSTATUS(status) == io) return io;  // it has said why
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw Error(ErrorCode::io, "the report script failed (its message is above)", folder);
  }
  return 0;
}

}  // namespace talus::cli
