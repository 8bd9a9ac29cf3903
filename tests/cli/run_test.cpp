// The life of a run as users see it: folder, summary, series; resume equal to the uninterrupted run; signals; failures.
#include <pty.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <optional>
#include <thread>

#include "tests/cli/cli_runner.hpp"

namespace talus::test {
namespace {
namespace fs = std::filesystem;

std::vector<std::string> arguments(std::vector<std::string> a, const std::vector<std::string>& more) {
  a.insert(a.end(), more.begin(), more.end());
  return a;
}

std::int64_t lines_of(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }

TEST_F(Cli, RunLeavesSummarySceneAndSeries) {
  write("scene.toml", small_scene());
  const Result r = talus({"run", "scene.toml", "--out", "out", "--threads", "2"});
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const std::string summary = read("out/summary.json");
  for (const char* key : {"particles", "steps", "wall_s", "particle_steps_per_s", "rebuilds", "threads", "isa", "seed",
                          "version", "state_hash"}) {
    EXPECT_FALSE(json_value(summary, key).empty()) << key << " in " << summary;
  }
  EXPECT_EQ(json_value(summary, "particles"), "200");
  EXPECT_EQ(json_value(summary, "steps"), "400");
  EXPECT_EQ(json_value(summary, "state_hash").size(), 16u);
  EXPECT_EQ(read("out/scene.toml").rfind(read("scene.toml"), 0), 0u) << "a copy, with comments after it";
  EXPECT_NE(r.out.find("out"), std::string::npos) << "says where the results are: " << r.out;
  EXPECT_NE(r.out.find(json_value(summary, "state_hash")), std::string::npos);
  // 400 steps of 2e-5 s with a row every 1e-4 s: steps 0, 5, ..., 400, and a header.
  EXPECT_EQ(lines_of(read("out/series.csv")), 82);
}

TEST_F(Cli, ProgressInALogIsALinePerTenPercent) {
  write("scene.toml", small_scene(20));
  const Result r = talus({"run", "scene.toml", "--out", "out", "--steps", "2000"});
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_LE(lines_of(r.err), 10) << r.err;
  EXPECT_GE(lines_of(r.err), 1) << r.err;
  EXPECT_NE(r.err.find("100.0 %"), std::string::npos) << r.err;
  EXPECT_EQ(r.err.find('\r'), std::string::npos) << "a bar does not belong into a log";
  const Result quiet = talus({"run", "scene.toml", "--out", "quiet", "--quiet"});
  EXPECT_EQ(quiet.err + quiet.out, "");
}

/// What `talus` with these arguments shows on a terminal of so many columns (0: of unknown width); nothing where the
/// machine has no pseudo terminals.
std::optional<std::string> shown_on_terminal(const fs::path& folder, std::vector<std::string> words, int columns) {
  struct winsize size = {};
  size.ws_col = static_cast<unsigned short>(columns);
  size.ws_row = 24;
  words.insert(words.begin(), TALUS_BINARY);
  std::vector<char*> argv;
  for (std::string& w : words) argv.push_back(w.data());
  argv.push_back(nullptr);
  const std::string directory = folder;
  int terminal = -1;
  const pid_t child = forkpty(&terminal, nullptr, nullptr, columns > 0 ? &size : nullptr);
  if (child < 0) return {};
  if (child == 0) {
    unsetenv("COLUMNS");
    setenv("TERM", "xterm", 1);
    if (chdir(directory.c_str()) != 0) _exit(126);
    execv(argv[0], argv.data());
    _exit(127);
  }
  std::string shown;
  char buffer[4096];
  for (ssize_t n; (n = ::read(terminal, buffer, sizeof buffer)) > 0;) shown.append(buffer, static_cast<std::size_t>(n));
  int status = 0;
  waitpid(child, &status, 0);
  close(terminal);
  EXPECT_EQ(WEXITSTATUS(status), 0) << shown;
  return shown;
}

TEST_F(Cli, ProgressOnATerminalIsOneLineThatIsRewritten) {
  write("scene.toml", small_scene(50));
  const auto shown = shown_on_terminal(folder, {"run", "scene.toml", "--out", "out"}, 0);
  if (!shown) GTEST_SKIP() << "no pseudo terminals on this machine";  // a chroot without devpts
  const std::string bar = shown->substr(0, shown->find('\n'));
  EXPECT_NE(bar.find("\r["), std::string::npos) << *shown;
  EXPECT_NE(bar.find("100.0 %"), std::string::npos) << *shown;
  EXPECT_NE(bar.find("ETA"), std::string::npos) << *shown;
  EXPECT_NE(bar.find("particle-steps/s"), std::string::npos) << *shown;
}

TEST_F(Cli, ProgressNeverWrapsOnATerminalOfAnyWidth) {
  write("scene.toml", small_scene(50));
  for (const int columns : {20, 40, 80, 132}) {
    const auto shown = shown_on_terminal(
        folder, {"run", "scene.toml", "--out", "out" + std::to_string(columns), "--steps", "3000"}, columns);
    if (!shown) GTEST_SKIP() << "no pseudo terminals on this machine";
    const std::string progress = shown->substr(0, shown->find('\n'));
    int drawn = 0;
    for (std::size_t at = progress.find('\r'); at != std::string::npos && at + 1 < progress.size();) {
      const std::size_t end = std::min(progress.find("\x1b[K", at), progress.size());
      const std::string line = progress.substr(at + 1, end - at - 1);
      EXPECT_LT(static_cast<int>(line.size()), columns) << line;
      EXPECT_NE(line.find(" %"), std::string::npos) << line;
      ++drawn;
      at = progress.find('\r', end);
    }
    EXPECT_GE(drawn, 1) << progress;
    EXPECT_NE(progress.find("100.0 %"), std::string::npos) << progress;
  }
}

TEST_F(Cli, JsonSummaryOnStandardOutput) {
  write("scene.toml", small_scene(20));
  const Result r = talus({"run", "scene.toml", "--out", "out", "--json", "--quiet"});
  EXPECT_EQ(r.exit_code, 0);
  EXPECT_EQ(json_value(r.out, "state_hash"), json_value(read("out/summary.json"), "state_hash"));
}

TEST_F(Cli, ExistingResultsAreKeptUnlessAskedOtherwise) {
  write("scene.toml", small_scene(20));
  ASSERT_EQ(talus({"run", "scene.toml", "--out", "out"}).exit_code, 0);
  const std::string before = read("out/summary.json");
  const Result refused = talus({"run", "scene.toml", "--out", "out"});
  EXPECT_TRUE(refused.exit_code == 2 || refused.exit_code == 5) << refused.exit_code;
  EXPECT_NE(refused.err.find("--overwrite"), std::string::npos) << refused.err;
  EXPECT_NE(refused.err.find("out"), std::string::npos) << refused.err;
  EXPECT_EQ(read("out/summary.json"), before);
  EXPECT_EQ(talus({"run", "scene.toml", "--out", "out", "--overwrite", "--steps", "100"}).exit_code, 0);
  EXPECT_EQ(json_value(read("out/summary.json"), "steps"), "100");
}

TEST_F(Cli, ForeignFolderIsNotOverwritten) {
  write("scene.toml", small_scene(20));
  fs::create_directory(folder / "home");
  write("home/thesis.txt", "years of work");
  talus({"run", "scene.toml", "--out", "home", "--overwrite"});
  EXPECT_EQ(read("home/thesis.txt"), "years of work");
}

TEST_F(Cli, UnwritableFolderExitsWithFive) {
  write("scene.toml", small_scene(20));
  write("file", "in the way");
  const Result r = talus({"run", "scene.toml", "--out", "file/out"});
  EXPECT_EQ(r.exit_code, 5) << r.err;
  EXPECT_NE(r.err.find("file"), std::string::npos) << r.err;
}

/// The resumed run is the uninterrupted one, although K, threads, instruction set and chunk size change in between.
TEST_F(Cli, ResumedRunEndsWithTheHashAndSeriesOfTheUninterruptedOne) {
  write("scene.toml", small_scene(300, "energies = true\n"));
  ASSERT_EQ(talus({"run", "scene.toml", "--out", "whole"}).exit_code, 0);
  // 237 is neither an output step nor a sort epoch.
  ASSERT_EQ(talus({"run", "scene.toml", "--out", "parts", "--steps", "237", "--isa", "sse2"}).exit_code, 0);
  EXPECT_NE(json_value(read("parts/summary.json"), "state_hash"), json_value(read("whole/summary.json"), "state_hash"));
  const Result r = talus({"run", "scene.toml", "--resume", "parts", "--threads", "2", "--isa", "scalar", "--verlet-k",
                          "10", "--chunk", "64"});
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(json_value(read("parts/summary.json"), "state_hash"), json_value(read("whole/summary.json"), "state_hash"));
  EXPECT_EQ(read("parts/series.csv"), read("whole/series.csv"));
  EXPECT_EQ(talus({"compare", "parts", "whole"}).exit_code, 0);
}

TEST_F(Cli, ResumeDropsWhatWasWrittenAfterTheCheckpoint) {
  write("scene.toml", small_scene(100));
  ASSERT_EQ(talus({"run", "scene.toml", "--out", "whole"}).exit_code, 0);
  ASSERT_EQ(talus({"run", "scene.toml", "--out", "parts", "--steps", "200"}).exit_code, 0);
  // The checkpoint of step 200 stays aside while the run goes on: as if the machine had stopped between two of them.
  fs::path checkpoint;
  for (const auto& entry : fs::recursive_directory_iterator(folder / "parts")) {
    if (entry.path().filename().string().rfind("checkpoint-", 0) == 0) checkpoint = entry.path();
  }
  ASSERT_FALSE(checkpoint.empty());
  const fs::path kept = folder / checkpoint.filename();
  fs::copy_file(checkpoint, kept);
  ASSERT_EQ(talus({"run", "scene.toml", "--resume", "parts", "--steps", "400"}).exit_code, 0);
  for (const auto& entry : fs::directory_iterator(checkpoint.parent_path())) {
    if (entry.path().filename().string().rfind("checkpoint-", 0) == 0) fs::remove(entry.path());
  }
  fs::copy_file(kept, checkpoint);
  const Result r = talus({"run", "scene.toml", "--resume", "parts"});
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(read("parts/series.csv"), read("whole/series.csv"));
  EXPECT_EQ(json_value(read("parts/summary.json"), "state_hash"), json_value(read("whole/summary.json"), "state_hash"));
}

TEST_F(Cli, ResumeWithoutGoodCheckpointIsRefused) {
  write("scene.toml", small_scene(20));
  fs::create_directory(folder / "empty");
  EXPECT_EQ(talus({"run", "scene.toml", "--resume", "empty"}).exit_code, 2) << "not the folder of a run";
  EXPECT_EQ(talus({"run", "scene.toml", "--resume", "nowhere"}).exit_code, 5);
  write("checkpoint-1.tcp", "TALUSCP1 but not really");
  EXPECT_EQ(talus({"run", "scene.toml", "--resume", "checkpoint-1.tcp"}).exit_code, 5);
  EXPECT_FALSE(exists("results"));
}

class Signals : public Cli, public ::testing::WithParamInterface<int> {};

/// A signal in the middle: answered within about a second, checkpoint written, exit code 128 + signal, and the resumed
/// run is the uninterrupted one.
TEST_P(Signals, EndTheRunAfterACheckpoint) {
  write("scene.toml", small_scene(300));
  Process process(folder, {"run", "scene.toml", "--out", "parts", "--steps", "100000000"});
  for (int i = 0; i < 600 && lines_of(read("parts/series.csv")) < 20; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  ASSERT_EQ(kill(process.id(), GetParam()), 0);
  const auto sent = std::chrono::steady_clock::now();
  const Result stopped = process.wait();
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - sent).count();
  EXPECT_EQ(stopped.exit_code, 128 + GetParam()) << stopped.err;
  EXPECT_LT(seconds, 5.0) << "one second is the aim, the rest is for a busy machine";
  const std::int64_t step = std::stoll("0" + json_value(read("parts/summary.json"), "steps"));
  EXPECT_GT(step, 0);
  EXPECT_LT(step, 100000000);
  EXPECT_NE(stopped.out.find("--resume"), std::string::npos) << stopped.out;

  // A little beyond the stop, beside an uninterrupted run of that length.
  const std::string end = std::to_string(step + 333);
  ASSERT_EQ(talus({"run", "scene.toml", "--resume", "parts", "--steps", end}).exit_code, 0);
  ASSERT_EQ(talus({"run", "scene.toml", "--out", "whole", "--steps", end}).exit_code, 0);
  EXPECT_EQ(json_value(read("parts/summary.json"), "state_hash"), json_value(read("whole/summary.json"), "state_hash"));
  EXPECT_EQ(read("parts/series.csv"), read("whole/series.csv"));
}

INSTANTIATE_TEST_SUITE_P(Cli, Signals, ::testing::Values(SIGINT, SIGTERM));

TEST_F(Cli, PhysicalFailureExitsWithFourAndKeepsWhatWasWritten) {
  // Two spheres shot at each other so hard that they overlap beyond the allowed depth.
  std::string text = small_scene(1);
  const std::size_t from = text.find("kind = \"random\""), to = text.find("[output]");
  text.replace(from, to - from, "kind = \"file\"\nfile = \"state.csv\"\n");
  write("scene.toml", text + "[checks]\nmax_overlap = 0.01\n");
  write("state.csv", "x,y,z,radius,vx,vy,vz\n0.03,0.05,0.05,0.004,8,0,0\n0.07,0.05,0.05,0.004,-8,0,0\n");
  const Result r = talus({"run", "scene.toml", "--out", "out"});
  EXPECT_EQ(r.exit_code, 4) << r.err;
  EXPECT_NE(r.err.find("step"), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("particle"), std::string::npos) << r.err;
  EXPECT_GT(lines_of(read("out/series.csv")), 10);
  EXPECT_TRUE(exists("out/summary.json"));
  // The dumped state can be looked at.
  bool dumped = false;
  for (const auto& entry : fs::recursive_directory_iterator(folder / "out")) {
    if (entry.path().filename() != "failed.tcp") continue;
    dumped = true;
    const std::string state = fs::relative(entry.path(), folder).string();
    EXPECT_EQ(talus({"info", state}).exit_code, 0);
    // Its contacts' springs are one step ahead: it would go on as no run does.
    const Result again = talus({"run", "scene.toml", "--resume", state, "--out", "again"});
    EXPECT_EQ(again.exit_code, 5) << again.err;
    EXPECT_NE(again.err.find("failed step"), std::string::npos) << again.err;
  }
  EXPECT_TRUE(dumped);
}

TEST_F(Cli, CompareFindsTheFirstDifference) {
  write("scene.toml", small_scene());
  ASSERT_EQ(talus({"run", "scene.toml", "--out", "a", "--steps", "100"}).exit_code, 0);
  ASSERT_EQ(talus({"run", "scene.toml", "--out", "b", "--steps", "100", "--set", "gravity=[0,0,-9.82]"}).exit_code, 0);
  ASSERT_EQ(talus({"run", "scene.toml", "--out", "c", "--steps", "100", "--chunk", "64"}).exit_code, 0);
  const Result different = talus({"compare", "a", "b"});
  EXPECT_EQ(different.exit_code, 1) << different.err;
  EXPECT_NE(different.out.find("first difference: particle 0"), std::string::npos) << different.out;
  EXPECT_EQ(talus({"compare", "a", "c"}).exit_code, 0);
  EXPECT_EQ(json_value(talus({"compare", "a", "b", "--json"}).out, "equal"), "false");
}

TEST_F(Cli, ProfileAndTraceNameTheNodes) {
  write("scene.toml", small_scene());
  const Result r = talus({"run", "scene.toml", "--out", "out", "--profile", "--trace", "trace.json", "--steps", "300"});
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const std::string trace = read("trace.json"), summary = read("out/summary.json");
  for (const char* node : {"narrow_phase", "contact_force", "integrate"}) {
    EXPECT_NE(trace.find(node), std::string::npos) << node;
    EXPECT_NE(summary.find(node), std::string::npos) << node;
  }
}

TEST_F(Cli, SceneOfTheReadmeIsValid) {
  const std::string readme = [] {
    std::ifstream in(std::string(TALUS_SOURCE_DIR) + "/README.md");
    return std::string{std::istreambuf_iterator<char>(in), {}};
  }();
  const std::size_t begin = readme.find("```toml\n");
  ASSERT_NE(begin, std::string::npos);
  const std::size_t end = readme.find("```", begin + 8);
  write("readme.toml", readme.substr(begin + 8, end - begin - 8));
  const Result r = talus({"check", "readme.toml"});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(r.err, "") << "an example must not warn";
  EXPECT_NE(r.out.find("readme.toml: valid\n"), std::string::npos) << r.out;
}

TEST_F(Cli, AKilledRunGoesOnFromTheCheckpointThatTheClockLeft) {
  write("scene.toml", small_scene(50));
  Process process(folder,
                  {"run", "scene.toml", "--out", "out", "--quiet", "--steps", "100000000", "--set",
                   "output.checkpoint_wall=0.01", "--set", "output.csv_every=0", "--set", "output.particles_every=0"});
  const auto steps = [&] {
    std::vector<std::int64_t> found;
    std::error_code gone;
    for (const auto& entry : fs::directory_iterator(folder / "out", gone)) {
      const std::string name = entry.path().filename().string();
      if (name.starts_with("checkpoint-") && name.ends_with(".tcp")) found.push_back(std::stoll(name.substr(11)));
    }
    std::sort(found.begin(), found.end());
    return found;
  };
  for (int k = 0; k < 6000 && steps().size() < 2; ++k) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  kill(process.id(), SIGKILL);
  EXPECT_EQ(process.wait().exit_code, -1 - SIGKILL);
  ASSERT_GE(steps().size(), 2u);
  EXPECT_LE(steps().size(), 3u) << "the newest two, and one that was about to go";
  const std::string last = std::to_string(steps().back() + 150);
  const Result on = talus({"run", "scene.toml", "--resume", "out", "--quiet", "--steps", last, "--set",
                           "output.csv_every=0", "--set", "output.particles_every=0"});
  ASSERT_EQ(on.exit_code, 0) << on.err;
  ASSERT_EQ(talus({"run", "scene.toml", "--out", "whole", "--quiet", "--steps", last, "--set",
                   "output.checkpoint_wall=0", "--set", "output.csv_every=0", "--set", "output.particles_every=0"})
                .exit_code,
            0);
  EXPECT_EQ(json_value(read("out/summary.json"), "state_hash"), json_value(read("whole/summary.json"), "state_hash"));
}

TEST_F(Cli, AResumeSaysWhichFramesItDoesNotContinue) {
  write("scene.toml", small_scene(20));
  ASSERT_EQ(talus({"run", "scene.toml", "--out", "out", "--quiet", "--steps", "100"}).exit_code, 0);
  const Result r =
      talus({"run", "scene.toml", "--resume", "out", "--quiet", "--steps", "200", "--set", "output.vtkhdf=false"});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.err.find("particles.vtkhdf is not continued: output.vtkhdf is false"), std::string::npos) << r.err;
  EXPECT_EQ(r.err.find("particles.pvd"), std::string::npos) << r.err;
}

TEST_F(Cli, CheckpointEveryKeepsTheNewestTwo) {
  write("scene.toml", small_scene(50));
  ASSERT_EQ(talus({"run", "scene.toml", "--out", "out", "--checkpoint-every", "130"}).exit_code, 0);
  EXPECT_FALSE(exists("out/checkpoint-130.tcp"));
  EXPECT_FALSE(exists("out/checkpoint-260.tcp"));
  EXPECT_TRUE(exists("out/checkpoint-390.tcp"));
  EXPECT_TRUE(exists("out/checkpoint-400.tcp"));
}

TEST_F(Cli, CheckAndExplainWriteNothing) {
  write("scene.toml", small_scene());
  for (const char* command : {"check", "explain"}) {
    for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--json"}}) {
      const Result r = talus(arguments({command, "scene.toml"}, more));
      EXPECT_EQ(r.exit_code, 0) << command << r.err;
      EXPECT_FALSE(r.out.empty());
    }
  }
  EXPECT_FALSE(exists("results"));
  EXPECT_EQ(json_value(talus({"check", "scene.toml", "--json"}).out, "particles"), "200");
}

TEST_F(Cli, ExplainNamesTheNodesAndWhatIsLeftOut) {
  write("scene.toml", replaced(small_scene(), "friction = 0.5\n", ""));
  const std::string text = talus({"explain", "scene.toml"}).out;
  for (const char* node : {"displacement_check", "rebuild", "narrow_phase", "contact_force", "integrate"}) {
    EXPECT_NE(text.find(node), std::string::npos) << node << "\n" << text;
  }
  EXPECT_NE(text.find("out"), std::string::npos) << "a frictionless scene leaves something out";
}

TEST_F(Cli, InfoReadsCheckpointSummaryAndFolder) {
  write("scene.toml", small_scene());
  ASSERT_EQ(talus({"run", "scene.toml", "--out", "out", "--steps", "50"}).exit_code, 0);
  const std::string hash = json_value(read("out/summary.json"), "state_hash");
  for (const char* what : {"out", "out/summary.json"}) {
    const Result r = talus({"info", what});
    EXPECT_EQ(r.exit_code, 0) << r.err;
    EXPECT_NE(r.out.find(hash), std::string::npos) << what << "\n" << r.out;
  }
}

}  // namespace
}  // namespace talus::test
