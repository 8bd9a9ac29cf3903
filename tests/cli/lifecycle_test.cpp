// What ends, disturbs or continues a run: changed scenes, files that vanish, full disks, closed descriptors, a second
// run in the folder, signals at odd moments.
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <thread>

#include "core/io/folder_lock.hpp"
#include "tests/cli/cli_runner.hpp"

namespace talus::test {
namespace {
namespace fs = std::filesystem;
using Strings = std::vector<std::string>;

std::int64_t lines_of(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }
bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

class Lifecycle : public Cli {
 protected:
  /// A run of 200 of 400 steps in `out`.
  void half(const std::string& scene, const Strings& more = {}) {
    write("scene.toml", scene);
    Strings words{"run", "scene.toml", "--out", "out", "--steps", "200", "--quiet", "--threads", "1"};
    words.insert(words.end(), more.begin(), more.end());
    const Result r = talus(words);
    ASSERT_EQ(r.exit_code, 0) << r.err;
  }
  Result resume(const Strings& more) {
    Strings words{"run", "scene.toml", "--resume", "out", "--threads", "1"};
    words.insert(words.end(), more.begin(), more.end());
    return talus(words);
  }
  std::string hash(const std::string& run) const { return json_value(read(run + "/summary.json"), "state_hash"); }
  /// Waits until the series of a running process has rows.
  bool under_way(const std::string& run, std::int64_t rows = 5) const {
    for (int i = 0; i < 1200; ++i) {
      if (lines_of(read(run + "/series.csv")) > rows) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(25));
    }
    return false;
  }
};

// ---- another scene at a resume ----

TEST_F(Lifecycle, ChangesThatTheStateDependsOnAreRefusedWithOldAndNewValue) {
  half(small_scene(50));
  const std::string scene = read("out/scene.toml"), summary = read("out/summary.json");
  for (const auto& [set, said] : std::vector<std::pair<std::string, std::string>>{
           {"domain.lower=[-0.01,0,0]", "domain.lower: [0, 0, 0] -> [-0.01, 0, 0]"},
           {"domain.upper=[0.1,0.1,0.3]", "domain.upper: [0.1, 0.1, 0.2] -> [0.1, 0.1, 0.3]"},
           {"domain.boundary=wall", "domain.boundary: [\"periodic\", \"periodic\", \"wall\"] -> \"wall\""},
           {"gravity=[0,0,-1]", "gravity: [0, 0, -9.81] -> [0, 0, -1]"},
           {"seed=4", "seed: 3 -> 4"},
           {"time.step=1e-5", "time.step: 2e-05 -> 1e-05"},
           {"material.0.density=2600", "material.0.density: 2500 -> 2600"},
           {"contact.friction=none", "contact.friction: 0.5 -> \"none\""},
           {"contact.dashpot=lagged", "contact.dashpot: \"centred\" -> \"lagged\""},
           {"contact.twisting_friction=0.1", "contact.twisting_friction: 0 -> 0.1"},
           {"source.0.number=60", "source.0.number: 50 -> 60"},
           {"source.0.size.max=0.01", "source.0.size.max: 0.009 -> 0.01"},
           {"output.energies=true", "output.energies: false -> true"},
           {"integrator=leapfrog", "integrator: \"velocity_verlet\" -> \"leapfrog\""}}) {
    const Result r = resume({"--set", set});
    EXPECT_EQ(r.exit_code, 3) << set << r.err;
    EXPECT_EQ(lines_of(r.err), 1) << r.err;
    EXPECT_TRUE(contains(r.err, said)) << r.err;
  }
  EXPECT_EQ(read("out/scene.toml"), scene) << "a refused resume changes nothing";
  EXPECT_EQ(read("out/summary.json"), summary);
}

TEST_F(Lifecycle, AllowedChangesAreSaidActAndLeaveTheOldSceneBeside) {
  half(small_scene(100));
  const std::string scene = read("out/scene.toml");
  const Result r =
      resume({"--set", "contact.friction=0.1", "--set", "list.policy=paper", "--set", "output.csv_every=2e-4"});
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_TRUE(contains(r.err, "changed from step 200 on: contact.friction: 0.5 -> 0.1\n")) << r.err;
  EXPECT_TRUE(contains(r.err, "changed from step 200 on: output.csv_every: 0.0001 -> 0.0002\n")) << r.err;
  EXPECT_TRUE(contains(r.err, "list.policy")) << r.err;
  EXPECT_TRUE(contains(r.err, "changed from step 200 on: time.steps: 200 -> 400\n")) << r.err;
  EXPECT_EQ(read("out/scene-until-200.toml"), scene);
  EXPECT_TRUE(contains(read("out/scene.toml"), "contact.friction=0.1"));
  // 41 rows until step 200, 20 of the longer interval, a header
  EXPECT_EQ(lines_of(read("out/series.csv")), 62);
  // The friction acts: another end than that of the undisturbed run.
  ASSERT_EQ(talus({"run", "scene.toml", "--out", "whole", "--quiet", "--threads", "1"}).exit_code, 0);
  EXPECT_NE(hash("out"), hash("whole"));
}

TEST_F(Lifecycle, TheSameSceneIsNoChange) {
  half(small_scene(50));
  const Result r = resume({"--steps", "200"});
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_FALSE(contains(r.err, "changed")) << r.err;
  EXPECT_FALSE(exists("out/scene-until-200.toml"));
  // Other spelling, same values.
  write("scene.toml", replaced(small_scene(50), "friction = 0.5", "friction = 0.50\ntwisting_friction = 0"));
  const Result again = resume({"--steps", "200"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_FALSE(contains(again.err, "changed")) << again.err;
}

TEST_F(Lifecycle, ACheckpointKnowsItsSceneAlsoWithoutItsFolder) {
  half(small_scene(50));
  fs::create_directory(folder / "else");
  fs::copy_file(folder / "out/checkpoint-200.tcp", folder / "else/kept.tcp");
  const Result shifted =
      talus({"run", "scene.toml", "--resume", "else/kept.tcp", "--out", "b", "--set", "domain.lower=[-0.01,0,0]"});
  EXPECT_EQ(shifted.exit_code, 3) << shifted.err;
  EXPECT_TRUE(contains(shifted.err, "domain.lower: [0, 0, 0] -> [-0.01, 0, 0]")) << shifted.err;
  EXPECT_FALSE(exists("b"));
  const Result same = talus({"run", "scene.toml", "--resume", "else/kept.tcp", "--out", "b", "--quiet"});
  EXPECT_EQ(same.exit_code, 0) << same.err;
  EXPECT_EQ(same.err, "");
}

TEST_F(Lifecycle, EventsThatHaveHappenedStayAndLaterOnesMayChange) {
  const std::string events =
      "[[group]]\nname = \"all\"\nids = [0, 99]\n"
      "[[event]]\ntime = 0.002\naction = \"freeze\"\ngroup = \"all\"\n"  // step 100
      "[[event]]\ntime = 0.006\naction = \"release\"\ngroup = \"all\"\n";
  half(small_scene(50, events));
  const Result past = resume({"--set", "event.0.time=0.001"});
  EXPECT_EQ(past.exit_code, 3) << past.err;
  EXPECT_TRUE(contains(past.err, "event.0.time: 0.002 -> 0.001")) << past.err;
  const Result later = resume({"--set", "event.1.time=0.007", "--quiet"});
  EXPECT_EQ(later.exit_code, 0) << later.err;
  EXPECT_EQ(later.err, "talus: changed from step 200 on: event.1.time: 0.006 -> 0.007\n");
}

/// An event that is added at a resume acts although nothing was ever held before.
TEST_F(Lifecycle, AnAddedEventActs) {
  half(small_scene(50, "[[group]]\nname = \"all\"\nids = [0, 99]\n"));
  write("scene.toml", small_scene(50,
                                  "[[group]]\nname = \"all\"\nids = [0, 99]\n"
                                  "[[event]]\ntime = 0.005\naction = \"freeze\"\ngroup = \"all\"\n"));
  const Result r = resume({"--quiet"});
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(table_of(read("out/series.csv")).at("kinetic_energy").back(), 0);
}

/// The state numbers walls and their elements; a wall in front of the others must not take their history.
TEST_F(Lifecycle, AddedWallsLeaveTheContactsOfTheOthersAlone) {
  const std::string wall =
      "[[wall]]\nname = \"far\"\nshape = \"box\"\nlower = [0.04, 0.04, 0.19]\nupper = [0.05, 0.05, 0.195]\n";
  const auto scene = [](const std::string& more) {
    return replaced(small_scene(100, more), "velocity_jitter = 1.0", "velocity_jitter = 1.0\nvelocity = [0, 0, -2]");
  };
  half(scene(""));
  ASSERT_EQ(talus({"run", "scene.toml", "--out", "whole", "--quiet", "--threads", "1"}).exit_code, 0);
  const double grains_on_floor = table_of(read("out/series.csv")).at("wall_contacts").back();
  ASSERT_GT(grains_on_floor, 0) << "else the test says nothing";
  write("scene.toml", scene(wall));
  const Result r = resume({"--quiet"});
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_TRUE(contains(r.err, "wall.0.name")) << r.err;
  EXPECT_EQ(talus({"compare", "out/checkpoint-400.tcp", "whole/checkpoint-400.tcp"}).out.find("particles differ"),
            std::string::npos)
      << "the wall is out of reach: the grains move as without it";
}

/// A motion counts from its start: another rate would move the wall at once by what it would have made until now.
TEST_F(Lifecycle, AWallThatWouldJumpAtAResumeIsRefused) {
  const auto scene = [](const std::string& motion) {
    return small_scene(50,
                       "[[wall]]\nname = \"paddle\"\nshape = \"box\"\nlower = [0.04, 0.049, 0.12]\nupper = [0.06, "
                       "0.051, 0.15]\nmotion = { " +
                           motion +
                           " }\n[[wall]]\nname = \"tube\"\nshape = \"cylinder\"\npoint = [0.05, 0.05, 0.16]\nlength = "
                           "0.03\nradius = 0.01\nmotion = { rotation_rate = 5, rotation_origin = [0.05, 0.05, 0] }\n");
  };
  const std::string turning = "rotation_rate = 20, rotation_origin = [0.05, 0.05, 0]";
  half(scene(turning));
  write("scene.toml", scene("rotation_rate = 25, rotation_origin = [0.05, 0.05, 0]"));
  Result r = resume({"--quiet"});
  EXPECT_EQ(r.exit_code, 3) << r.err;
  // the corners lie 0.01005 m from the axis and would turn by 5 rad/s * 0.004 s more
  EXPECT_TRUE(contains(r.err, "wall 'paddle' would jump by 0.000201 m at step 200")) << r.err;
  write("scene.toml", scene("velocity = [0, 0, 0.3]"));
  r = resume({"--quiet"});
  EXPECT_EQ(r.exit_code, 3) << r.err;
  // a plane, by what its vibration would have reached: 0.01 m sin(2 pi 50/s 0.004 s), beyond the side above
  half(scene(turning) + "[[wall]]\nname = \"lid\"\nshape = \"plane\"\npoint = [0, 0, 0.195]\nnormal = [0, 0, -1]\n",
       {"--overwrite"});
  write("scene.toml", scene(turning) +
                          "[[wall]]\nname = \"lid\"\nshape = \"plane\"\npoint = [0, 0, 0.195]\nnormal = [0, 0, "
                          "-1]\nmotion = { amplitude = [0, 0, 0.01], frequency = 50 }\n");
  r = resume({"--quiet"});
  EXPECT_EQ(r.exit_code, 3) << r.err;
  EXPECT_TRUE(contains(r.err, "wall 'lid' would jump by 0.00951 m")) << r.err;
  half(scene(turning), {"--overwrite"});
  write("scene.toml", scene(turning + ", end = 0.005"));  // from where it is then, later
  r = resume({"--quiet"});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  // a tube that turns about its own axis stays where it is
  half(scene(turning), {"--overwrite"});
  write("scene.toml", replaced(scene(turning), "rotation_rate = 5,", "rotation_rate = -50,"));
  r = resume({"--quiet"});
  EXPECT_EQ(r.exit_code, 0) << r.err;
}

TEST_F(Lifecycle, AnEventThatConcernsNobodyIsSaid) {
  const std::string event = "[[event]]\ntime = 0.002\naction = \"freeze\"\ngroup = \"g\"\n";
  for (const auto& [ids, said] : {std::pair{"[100, 200]", true}, {"[49, 200]", false}}) {
    write("scene.toml", small_scene(50, std::string("[[group]]\nname = \"g\"\nids = ") + ids + "\n" + event));
    const Result r = talus({"run", "scene.toml", "--out", "out", "--quiet", "--overwrite"});
    EXPECT_EQ(r.exit_code, 0) << r.err;
    EXPECT_EQ(contains(r.err, "the event at 0.002 s (freeze) concerns no grain: group 'g' has none at step 100"), said)
        << r.err;
  }
}

TEST_F(Lifecycle, ACheckpointAwayFromItsSceneIsToldByItsOwnName) {
  half(small_scene(20));
  fs::create_directory(folder / "away");
  fs::copy_file(folder / "out/checkpoint-200.tcp", folder / "away/c.tcp");
  for (const Strings& words : {Strings{"compare", "away/c.tcp", "out"}, Strings{"convert", "away/c.tcp", "c.csv"}}) {
    const Result r = talus(words);
    EXPECT_EQ(r.exit_code, 2) << r.err;
    EXPECT_TRUE(contains(r.err, "away/c.tcp: has no scene.toml beside it")) << r.err;
  }
}

TEST_F(Lifecycle, FilesThatCannotBeContinuedAreSetAside) {
  half(small_scene(50));
  const std::string before = read("out/series.csv");
  fs::resize_file(folder / "out/particles.vtkhdf", 1000);
  const Result r = resume({"--set", "output.coordination=true"});
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(fs::file_size(folder / "out/particles-until-200.vtkhdf"), 1000u);
  EXPECT_TRUE(contains(r.err, "particles-until-200.vtkhdf")) << r.err;
  write("scene.toml",
        small_scene(50, "[[output.region]]\nname = \"core\"\nlower = [0, 0, 0]\nupper = [0.1, 0.1, 0.1]\n"));
  const Result columns = resume({"--steps", "420"});
  ASSERT_EQ(columns.exit_code, 0) << columns.err;
  EXPECT_EQ(read("out/series-until-400.csv").rfind(before, 0), 0u);
  EXPECT_TRUE(contains(read("out/series.csv"), "region.core.particles"));
  EXPECT_EQ(talus({"run", "scene.toml", "--out", "out", "--overwrite", "--quiet"}).exit_code, 0)
      << "what was set aside is a run's own";
}

// ---- files that vanish during a run ----

struct Vanishing {
  std::string file;
  bool truncated;
};
class Vanished : public Lifecycle, public ::testing::WithParamInterface<Vanishing> {};

TEST_P(Vanished, EndsTheRunWithOneMessageAndACheckpoint) {
  write("scene.toml", replaced(small_scene(50), "csv_every = 1e-4", "csv_every = 1e-4\nvtp = true"));
  Process run(folder, {"run", "scene.toml", "--out", "out", "--steps", "100000000", "--threads", "1", "--quiet",
                       "--set", "output.particles_every=0.02"});
  ASSERT_TRUE(under_way("out"));
  const fs::path file = folder / "out" / GetParam().file;
  for (int i = 0; i < 1200 && !fs::exists(file); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(25));
  if (GetParam().truncated)
    fs::resize_file(file, fs::file_size(file) / 2);
  else
    fs::remove_all(file);
  // The list and its files are looked at when the run ends.
  if (GetParam().file.find("vtp") == 0) kill(run.id(), SIGTERM);
  const Result r = run.wait();
  EXPECT_EQ(r.exit_code, 5) << r.err;
  EXPECT_TRUE(contains(r.err, GetParam().file)) << r.err;
  EXPECT_EQ(r.err.find("error:"), r.err.rfind("error:")) << r.err;
  const Result info = talus({"info", "out"});
  bool checkpoint = false;
  for (const auto& entry : fs::directory_iterator(folder / "out"))
    checkpoint = checkpoint || entry.path().extension() == ".tcp";
  EXPECT_TRUE(checkpoint);
  EXPECT_EQ(json_value(read("out/summary.json"), "status").rfind("failed", 0), 0u);
}

INSTANTIATE_TEST_SUITE_P(Lifecycle, Vanished,
                         ::testing::Values(Vanishing{"series.csv", false}, Vanishing{"series.csv", true},
                                           Vanishing{"particles.vtkhdf", false}, Vanishing{"particles.vtkhdf", true},
                                           Vanishing{"vtp/particles-000000000000.vtp", false}));

// ---- damaged files, odd paths ----

TEST_F(Lifecycle, DamagedFilesAreOneLineAndExitFive) {
  half(small_scene(50));
  for (const std::string file : {"summary.json", "series.csv", "checkpoint-200.tcp", "particles.vtkhdf"}) {
    const std::string whole = read("out/" + file);
    for (const std::size_t bytes : {std::size_t{0}, std::size_t{150}, whole.size() - 2}) {
      write("out/" + file, whole.substr(0, bytes));
      for (const Strings& words :
           {Strings{"info", "out"}, Strings{"report", "out"}, Strings{"compare", "out", "out"}}) {
        const bool unread = words[0] == "compare" && (file == "summary.json" || file == "series.csv");
        const Result r = talus(words);
        EXPECT_EQ(r.exit_code, unread ? 0 : 5) << words[0] << " " << file << " " << bytes << "\n" << r.err;
        if (unread) continue;
        EXPECT_EQ(lines_of(r.err), 1) << words[0] << " " << file << " " << bytes << "\n" << r.err;
        EXPECT_TRUE(contains(r.err, file)) << r.err;
        EXPECT_EQ(r.out, "");
      }
    }
    write("out/" + file, whole);
  }
  EXPECT_EQ(talus({"info", "out/summary.json"}).exit_code, 0);
  write("out/summary.json", "{}");
  EXPECT_EQ(talus({"info", "out/summary.json"}).exit_code, 5) << "JSON, but no summary";
}

TEST_F(Lifecycle, PathsThatTheSystemRefusesAreOneLineWithItsReason) {
  write("scene.toml", small_scene(20));
  const std::string name(300, 'x');
  fs::create_symlink("loop", folder / "loop");
  for (const std::string& path : {name, std::string("loop"), std::string("loop/out")}) {
    for (const Strings& words :
         {Strings{"info", path}, Strings{"report", path}, Strings{"compare", path, path},
          Strings{"run", "scene.toml", "--resume", path}, Strings{"run", "scene.toml", "--out", path}}) {
      const Result r = talus(words);
      EXPECT_EQ(r.exit_code, 5) << words[0] << r.err;
      EXPECT_EQ(lines_of(r.err), 1) << r.err;
      EXPECT_TRUE(contains(r.err, path.substr(0, 4))) << r.err;
      EXPECT_TRUE(contains(r.err, path == name ? "File name too long" : "symbolic links")) << r.err;
    }
  }
}

// ---- room, descriptors, locks ----

/// No file may be longer than this: every write beyond it fails, and raises SIGXFSZ.
TEST_F(Lifecycle, FilesThatMayNotGrowEndTheRunWithExitFiveAndItCanBeResumed) {
  write("scene.toml", small_scene(200));
  ASSERT_EQ(talus({"run", "scene.toml", "--out", "whole", "--quiet", "--threads", "1"}).exit_code, 0);
  const rlim_t most = fs::file_size(folder / "whole/particles.vtkhdf");
  bool resumed = false;
  for (const double share : {0.1, 0.5, 0.97}) {
    fs::remove_all(folder / "out");
    const auto limit = static_cast<rlim_t>(share * static_cast<double>(most));
    const Result r =
        talus({"run", "scene.toml", "--out", "out", "--quiet", "--threads", "1", "--checkpoint-every", "30"}, [limit] {
          const rlimit files{limit, limit};
          setrlimit(RLIMIT_FSIZE, &files);
        });
    EXPECT_EQ(r.exit_code, 5) << share << r.err;
    EXPECT_TRUE(contains(r.err, "File too large")) << r.err;
    EXPECT_EQ(r.err.find("error:"), r.err.rfind("error:")) << r.err;
    if (!exists("out/particles.vtkhdf")) continue;  // it never had room
    EXPECT_EQ(talus({"info", "out"}).exit_code, 0) << "readable";
    const Result more = resume({"--quiet"});
    EXPECT_EQ(more.exit_code, 0) << more.err;
    EXPECT_EQ(hash("out"), hash("whole"));
    EXPECT_EQ(read("out/series.csv"), read("whole/series.csv"));
    resumed = true;
  }
  EXPECT_TRUE(resumed);
}

TEST_F(Lifecycle, KilledRunsAndFullDisksLoseNothing) {
  const std::string log = folder / "kills.log";
  const int status = std::system(("/usr/bin/python3 " TALUS_SOURCE_DIR "/tests/kills.py --kills 3 --sizes 2 --build " +
                                  fs::path(TALUS_BINARY).parent_path().string() + " > " + log + " 2>&1")
                                     .c_str());
  EXPECT_EQ(WEXITSTATUS(status), 0) << read("kills.log");
  if (contains(read("kills.log"), "no tmpfs")) GTEST_SKIP() << "no tmpfs may be mounted here: limits on files instead";
}

TEST_F(Lifecycle, ClosedDescriptorsDoNotBecomeResultFiles) {
  write("scene.toml", small_scene(50));
  ASSERT_EQ(talus({"run", "scene.toml", "--out", "whole", "--threads", "1"}).exit_code, 0);
  for (int closed = 1; closed < 8; ++closed) {
    fs::remove_all(folder / "out");
    const Result r = talus({"run", "scene.toml", "--out", "out", "--threads", "1"}, [closed] {
      for (int fd = 0; fd < 3; ++fd)
        if ((closed >> fd & 1) != 0) close(fd);
    });
    EXPECT_EQ(r.exit_code, 0) << closed << r.err;
    for (const char* file : {"series.csv", "particles.vtkhdf", "walls.vtkhdf", "checkpoint-400.tcp"})
      EXPECT_EQ(read(std::string("out/") + file), read(std::string("whole/") + file)) << file << " " << closed;
  }
}

TEST_F(Lifecycle, TextThatCannotBeWrittenIsAnError) {
  half(small_scene(20));
  const auto full = [] {
    const int fd = open("/dev/full", O_WRONLY);
    dup2(fd, 1);
  };
  const auto broken = [] {
    int ends[2];
    if (pipe(ends) == 0) dup2(ends[1], 1), close(ends[0]), close(ends[1]);
  };
  for (const Strings& words :
       {Strings{"help"}, Strings{"--help"}, Strings{"help", "scene"}, Strings{"help", "run"}, Strings{"info", "out"},
        Strings{"info", "out/summary.json"}, Strings{"info", "out/checkpoint-200.tcp"},
        Strings{"explain", "scene.toml"}, Strings{"check", "scene.toml", "--json", "--calibrate", "0"},
        Strings{"compare", "out", "out"}, Strings{"report", "out"}}) {
    const Result on_full = talus(words, full), unread = talus(words, broken);
    EXPECT_EQ(on_full.exit_code, 5) << words[0] << on_full.err;
    EXPECT_TRUE(contains(on_full.err, "standard output")) << words[0] << on_full.err;
    EXPECT_TRUE(contains(on_full.err, "No space left")) << words[0] << on_full.err;
    EXPECT_EQ(lines_of(on_full.err), 1) << words[0] << on_full.err;
    // `talus help scene | head`: no message, the code of a program that SIGPIPE ends
    EXPECT_EQ(unread.exit_code, 128 + SIGPIPE) << words[0] << unread.err;
    EXPECT_EQ(unread.err, "") << words[0];
  }
}

TEST_F(Lifecycle, ASecondRunInTheFolderIsRefusedAndADeadOnesLockIsTakenOver) {
  write("scene.toml", small_scene(50));
  Process first(folder, {"run", "scene.toml", "--out", "out", "--steps", "100000000", "--threads", "1", "--quiet",
                         "--checkpoint-every", "1000"});
  ASSERT_TRUE(under_way("out"));
  const fs::path second = folder / "second";
  fs::create_directory(second);
  for (const Strings& more : {Strings{"--resume", "../out"}, Strings{"--out", "../out", "--overwrite"}}) {
    Strings words{"run", "../scene.toml", "--steps", "200000000"};
    words.insert(words.end(), more.begin(), more.end());
    const Result r = Process(second, words).wait();
    EXPECT_EQ(r.exit_code, 5) << r.err;
    EXPECT_EQ(lines_of(r.err), 1) << r.err;
    EXPECT_TRUE(contains(r.err, "pid " + std::to_string(first.id()) + " on host ")) << r.err;
  }
  EXPECT_TRUE(contains(Process(second, {"info", "../out"}).wait().out, "a run is writing here"));
  for (int i = 0; i < 1200; ++i) {
    bool there = false;
    for (const auto& entry : fs::directory_iterator(folder / "out"))
      there = there || entry.path().extension() == ".tcp";
    if (there) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(25));
  }
  kill(first.id(), SIGKILL);
  first.wait();
  const Result after = resume({"--quiet", "--steps", "200"});
  EXPECT_TRUE(after.exit_code == 0 || contains(after.err, "after the last step")) << after.err;
  EXPECT_FALSE(contains(after.err, "another run")) << after.err;
}

// ---- folders of others ----

TEST_F(Lifecycle, ScratchNamesOfOthersAreNotTouched) {
  write("scene.toml", small_scene(20));
  for (const char* name : {"m.old", "m.tmp"}) {
    fs::create_directories(folder / "results" / name);
    write(std::string("results/") + name + "/scene.toml", "backup");
    write(std::string("results/") + name + "/summary.json", "backup");
  }
  ASSERT_EQ(talus({"run", "scene.toml", "--out", "results/m", "--steps", "50", "--quiet"}).exit_code, 0);
  write("results/m/summary.json.tmp", "mine");
  EXPECT_EQ(talus({"run", "scene.toml", "--out", "results/m", "--steps", "50", "--quiet", "--overwrite"}).exit_code, 2);
  fs::remove(folder / "results/m/summary.json.tmp");
  ASSERT_EQ(talus({"run", "scene.toml", "--out", "results/m", "--steps", "50", "--quiet", "--overwrite"}).exit_code, 0);
  for (const char* file : {"m.old/scene.toml", "m.old/summary.json", "m.tmp/scene.toml", "m.tmp/summary.json"})
    EXPECT_EQ(read(std::string("results/") + file), "backup") << file;
  std::int64_t entries = 0;
  for ([[maybe_unused]] const auto& e : fs::directory_iterator(folder / "results")) ++entries;
  EXPECT_EQ(entries, 3) << "no scratch is left";
}

TEST_F(Lifecycle, AFolderWithoutTheMarkOfARunIsNotOverwritten) {
  fs::create_directory(folder / "mine");
  write("mine/scene.toml", small_scene(20));
  const Result r = talus({"run", "mine/scene.toml", "--out", "mine", "--overwrite"});
  EXPECT_EQ(r.exit_code, 2) << r.err;
  EXPECT_TRUE(contains(r.err, "no mark of a run")) << r.err;
  EXPECT_EQ(read("mine/scene.toml"), small_scene(20));
  EXPECT_FALSE(exists("mine/run.lock"));
}

// ---- signals ----

class OddSignals : public Lifecycle, public ::testing::WithParamInterface<int> {};

/// The signal is pending when the program starts: it arrives as soon as the run listens.
TEST_P(OddSignals, BeforeTheFirstStepLeaveACheckpointToContinueFrom) {
  write("scene.toml", small_scene(50));
  const int number = GetParam();
  const Result r = talus({"run", "scene.toml", "--out", "out", "--threads", "1", "--quiet"}, [number] {
    signal(number, SIG_DFL);  // nohup hands on an ignored SIGHUP, which a run then ignores as well
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, number);
    sigprocmask(SIG_BLOCK, &set, nullptr);
    raise(number);
  });
  EXPECT_EQ(r.exit_code, 128 + number) << r.err;
  EXPECT_TRUE(exists("out/checkpoint-0.tcp"));
  EXPECT_EQ(json_value(read("out/summary.json"), "status"), "interrupted");
  ASSERT_EQ(resume({"--quiet"}).exit_code, 0);
  ASSERT_EQ(talus({"run", "scene.toml", "--out", "whole", "--threads", "1", "--quiet"}).exit_code, 0);
  EXPECT_EQ(hash("out"), hash("whole"));
  EXPECT_EQ(read("out/series.csv"), read("whole/series.csv"));
}

INSTANTIATE_TEST_SUITE_P(Lifecycle, OddSignals, ::testing::Values(SIGTERM, SIGHUP, SIGPIPE, SIGXFSZ));

TEST_F(Lifecycle, ABrokenPipeOfTheProgressEndsTheRunWithACheckpoint) {
  write("scene.toml", small_scene(50));
  const Result r = talus({"run", "scene.toml", "--out", "out", "--threads", "1"}, [] {
    int ends[2];
    if (pipe(ends) == 0) dup2(ends[1], 2), close(ends[0]), close(ends[1]);
  });
  EXPECT_EQ(r.exit_code, 128 + SIGPIPE);
  bool checkpoint = false;
  for (const auto& entry : fs::directory_iterator(folder / "out"))
    checkpoint = checkpoint || entry.path().extension() == ".tcp";
  EXPECT_TRUE(checkpoint);
  EXPECT_EQ(json_value(read("out/summary.json"), "status"), "interrupted");
}

TEST_F(Lifecycle, HangUpIsIgnoredWhereTheCallerIgnoresIt) {
  write("scene.toml", small_scene(50));
  const Result r = talus({"run", "scene.toml", "--out", "out", "--threads", "1", "--quiet"}, [] {
    signal(SIGHUP, SIG_IGN);  // nohup
    raise(SIGHUP);
  });
  EXPECT_EQ(r.exit_code, 0) << r.err;
}

}  // namespace
}  // namespace talus::test
