// `talus report DIR`: hands the run folder to perf/report.py, which writes one self-contained HTML page; several
// folders make an index. The script is found by cli_parts.
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "cases/program/cli.hpp"
#include "cases/program/cli_console.hpp"
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

void check_is_run(const std::string& folder) {
  if (!fs::is_directory(folder))
    throw Error(ErrorCode::io, "is not a folder", folder, "give the folder of a run, e.g. results/hopper-20k");
  if (!fs::exists(fs::path(folder) / "summary.json") && !fs::exists(fs::path(folder) / "scene.toml"))
    throw Error(ErrorCode::io, "holds neither summary.json nor scene.toml, so it is not the folder of a run", folder);
}

/// The status of the ended child, as waitpid tells it. Error{io}: it cannot be started.
int run_and_wait(std::vector<std::string>& words) {
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  pid_t child = 0;
  if (const int reason = posix_spawn(&child, argv[0], nullptr, nullptr, argv.data(), environ); reason != 0)
    throw Error(ErrorCode::io, std::strerror(reason), words[0], "apt-get install python3");
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}
}  // namespace

int report(const Options& options) {
  if (options.index.empty() && options.files.size() > 1)
    throw Error(ErrorCode::usage, "several folders make an index", options.files[1], "give --index FILE");
  for (const std::string& folder : options.files) {
    check_is_run(folder);
    check_folder(folder);
  }
  std::vector<std::string> words{k_python, part("perf/report.py")};
  if (!options.out.empty()) words.insert(words.end(), {"--out", options.out});
  if (!options.index.empty()) words.insert(words.end(), {"--index", options.index});
  if (!options.figures.empty()) words.insert(words.end(), {"--figures", options.figures});
  words.emplace_back("--");
  words.insert(words.end(), options.files.begin(), options.files.end());

  const int status = run_and_wait(words);
  const int io = static_cast<int>(ErrorCode::io);
  if (WIFEXITED(status) && WEXITSTATUS(status) == io) return io;  // it has said why
  if (WIFEXITED(status) && WEXITSTATUS(status) == 128 + SIGPIPE) throw ReaderGone();
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw Error(ErrorCode::io, "the report script failed (its message is above)", options.files.at(0));
  }
  return 0;
}

}  // namespace talus::cli
