// When outputs are written and what they leave alone: rows and frames at the steps that their times say, the same
// numbers whatever else is written and however often, the same after a resume in the very step of an output.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <sstream>
#include <thread>

#include "tests/cli/cli_runner.hpp"

namespace talus::test {
namespace {
namespace fs = std::filesystem;

class Outputs : public Cli {
 protected:
  std::string run(const std::string& scene, const std::string& out, const std::vector<std::string>& sets = {},
                  const std::vector<std::string>& more = {}) {
    std::vector<std::string> a{"run", scene, "--out", out, "--quiet", "--threads", "1"};
    for (const std::string& s : sets) {
      a.push_back("--set");
      a.push_back(s);
    }
    a.insert(a.end(), more.begin(), more.end());
    const Result r = talus(a);
    EXPECT_EQ(r.exit_code, 0) << r.err;
    return read(out + "/summary.json");
  }
  Table series(const std::string& out) const { return table_of(read(out + "/series.csv")); }
};

/// Grains rain through an open bottom; the plane `out` lies on their way, `round` across a periodic axis.
std::string rain(const std::string& output) {
  return R"(title = "rain"
gravity = [0, 0, -9.81]
[domain]
lower = [0, 0, 0]
upper = [0.02, 0.02, 0.05]
boundary = ["periodic", "wall", ["open", "wall"]]
[time]
step = 1e-5
duration = 0.2
[[material]]
name = "g"
density = 2500
[contact]
normal_stiffness = 2000.0
restitution = 0.5
friction = 0.4
[[source]]
kind = "stream"
number_rate = 5000
interval = 0.01
velocity = [0.7, 0, -0.5]
[source.region]
lower = [0, 0, 0.02]
upper = [0.02, 0.02, 0.05]
[source.size]
kind = "uniform"
min = 0.0015
max = 0.0025
[output]
)" + output +
         R"(
[[output.plane]]
name = "out"
point = [0, 0, 0.01]
normal = [0, 0, -1]
[[output.plane]]
name = "round"
point = [0.02, 0, 0]
normal = [1, 0, 0]
)";
}

TEST_F(Outputs, PlanesCountTheSameWhateverTheIntervalOfTheSeriesAlsoWithNone) {
  write("scene.toml", rain("csv_every = 0.0001"));
  const std::string fine = run("scene.toml", "fine");
  EXPECT_GT(std::stoi(json_value(fine, "particles")), 0);
  const Table rows = series("fine");
  const auto last = [](const Table& t, const std::string& column) { return t.at(column).back(); };
  EXPECT_GT(last(rows, "plane.out.particles"), 500);
  EXPECT_GT(last(rows, "plane.round.particles"), 500);
  EXPECT_GE(last(rows, "plane.out.particles"), last(rows, "removed")) << "what has left has passed the plane";
  for (const char* every : {"0.003", "0.01", "0.05", "0.2", "0"}) {
    const std::string out = std::string("every") + every;
    const std::string summary = run("scene.toml", out, {std::string("output.csv_every=") + every});
    EXPECT_EQ(json_value(summary, "planes_hash"), json_value(fine, "planes_hash")) << every;
    EXPECT_EQ(json_value(summary, "state_hash"), json_value(fine, "state_hash")) << every;
    EXPECT_NE(summary.find("\"name\": \"out\", \"particles\": " +
                           std::to_string(std::llround(last(rows, "plane.out.particles"))) + ","),
              std::string::npos)
        << summary;
    if (std::string(every) == "0") {
      EXPECT_FALSE(exists(out + "/series.csv"));
      continue;
    }
    // every sum of the coarse rows is that of the fine one at the same step
    const Table coarse = series(out);
    for (const char* column : {"plane.out.particles", "plane.out.mass", "plane.round.particles", "plane.round.mass",
                               "removed", "removed_mass", "inserted", "particles", "kinetic_energy", "contacts"}) {
      std::size_t k = 0;
      for (std::size_t i = 0; i < coarse.at("step").size(); ++i) {
        while (rows.at("step")[k] < coarse.at("step")[i]) ++k;
        ASSERT_EQ(coarse.at(column)[i], rows.at(column)[k]) << column << " at step " << coarse.at("step")[i];
      }
    }
  }
}

TEST_F(Outputs, PlanesGoOnAfterAResumeAndAMovedOneIsRefused) {
  write("scene.toml", rain("csv_every = 0.003"));
  const std::string whole = run("scene.toml", "whole");
  run("scene.toml", "parts", {}, {"--steps", "12345"});
  const Result moved = talus(
      {"run", "scene.toml", "--resume", "parts", "--out", "moved", "--set", "output.plane.0.point=[0, 0, 0.011]"});
  EXPECT_EQ(moved.exit_code, 3) << moved.err;
  EXPECT_NE(moved.err.find("output.plane.0.point"), std::string::npos) << moved.err;
  EXPECT_FALSE(exists("moved"));
  const Result r = talus({"run", "scene.toml", "--resume", "parts", "--quiet", "--out", "elsewhere"});
  ASSERT_EQ(r.exit_code, 0) << r.err;
  ASSERT_EQ(talus({"run", "scene.toml", "--resume", "parts", "--quiet"}).exit_code, 0);
  EXPECT_EQ(json_value(read("parts/summary.json"), "planes_hash"), json_value(whole, "planes_hash"));
  EXPECT_EQ(read("parts/series.csv"), read("whole/series.csv"));
  // in another folder the first row's means count from the resume
  const Table rest = series("elsewhere"), all = series("whole");
  const std::size_t at = all.at("step").size() - rest.at("step").size();
  ASSERT_EQ(rest.at("step").front(), all.at("step")[at]);
  EXPECT_EQ(rest.at("plane.out.particles").front(), all.at("plane.out.particles")[at]);
  EXPECT_GT(rest.at("plane.out.mass_flow").front(), 0.3 * all.at("plane.out.mass_flow")[at]);
  EXPECT_EQ(rest.at("plane.out.mass_flow")[1], all.at("plane.out.mass_flow")[at + 1]);
}

TEST_F(Outputs, NoColumnDependsOnWhatElseIsWritten) {
  write("scene.toml", small_scene(300, "energies = true\n"));
  const std::string plain = run("scene.toml", "plain", {"output.particles_every=0"}, {"--steps", "240"});
  // frames of contacts at odd steps, and at those of the rows
  for (const char* every : {"2.6e-4", "1e-4"}) {
    const std::string out = std::string("all") + every;
    const std::string summary =
        run("scene.toml", out,
            {std::string("output.particles_every=") + every, "output.contacts=true", "output.coordination=true",
             "output.stress=true", "output.grid=[3, 3, 5]", "output.vtp=true"},
            {"--steps", "240"});
    EXPECT_EQ(read(out + "/series.csv"), read("plain/series.csv")) << every;
    EXPECT_EQ(json_value(summary, "state_hash"), json_value(plain, "state_hash"));
    EXPECT_EQ(json_value(summary, "elastic_energy"), json_value(plain, "elastic_energy"));
    EXPECT_EQ(json_value(summary, "dissipated_energy"), json_value(plain, "dissipated_energy"));
  }
}

TEST_F(Outputs, StepsAreTheRoundedMultiplesOfAnIntervalThatIsNoMultipleOfTheStep) {
  write("scene.toml", small_scene(20));
  run("scene.toml", "out", {"output.csv_every=7.44e-5", "output.particles_every=2.72e-4", "output.vtp=true"},
      {"--steps", "60"});
  // 3.72 and 13.6 steps
  const std::vector<double> rows{0, 4, 7, 11, 15, 19, 22, 26, 30, 33, 37, 41, 45, 48, 52, 56, 60};
  EXPECT_EQ(series("out").at("step"), rows);
  const std::string pvd = read("out/particles.pvd");
  std::vector<double> frames;
  for (std::size_t at = pvd.find("timestep=\""); at != std::string::npos; at = pvd.find("timestep=\"", at + 1))
    frames.push_back(std::round(std::stod(pvd.substr(at + 10)) / 2e-5));
  EXPECT_EQ(frames, (std::vector<double>{0, 14, 27, 41, 54})) << pvd;
}

TEST_F(Outputs, AnIntervalBelowTheStepMeansEveryStep) {
  write("scene.toml", small_scene(20));
  for (const char* every : {"1.9e-5", "6e-6", "1e-9"}) {
    const std::string out = std::string("every") + every;
    run("scene.toml", out, {std::string("output.csv_every=") + every, "output.particles_every=0"}, {"--steps", "40"});
    const std::vector<double> steps = series(out).at("step");
    ASSERT_EQ(steps.size(), 41U) << every;
    for (std::size_t k = 0; k < steps.size(); ++k) EXPECT_EQ(steps[k], static_cast<double>(k));
  }
}

TEST_F(Outputs, AStreamMayFeedInEveryStepButNotMoreOften) {
  std::string text = rain("csv_every = 1e-5");
  text = replaced(text, "number_rate = 5000", "number_rate = 2e5");  // two grains per step
  write("every.toml", replaced(text, "interval = 0.01", "interval = 1e-5"));
  run("every.toml", "every", {}, {"--steps", "20"});
  const Table t = series("every");
  for (std::size_t k = 1; k < t.at("step").size(); ++k) EXPECT_EQ(t.at("inserted")[k], 2.0 * static_cast<double>(k));
  write("below.toml", replaced(text, "interval = 0.01", "interval = 9.9e-6"));
  const Result r = talus({"run", "below.toml", "--out", "below"});
  EXPECT_EQ(r.exit_code, 3);
  EXPECT_NE(r.err.find("source.0.interval"), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("1e-05"), std::string::npos) << "names the step: " << r.err;
  EXPECT_FALSE(exists("below"));
}

TEST_F(Outputs, AResumeInTheStepOfAFrameAndARowEndsWithTheFilesOfTheUninterruptedRun) {
  write("scene.toml", small_scene(200,
                                  "energies = true\ncontacts = true\nstress = true\nvtp = true\nvtkhdf = false\n"
                                  "grid = [2, 2, 4]\n"));
  run("scene.toml", "whole");
  // step 200: a frame (every 50 steps), a row (every 5)
  run("scene.toml", "parts", {}, {"--steps", "200"});
  ASSERT_EQ(talus({"run", "scene.toml", "--resume", "parts", "--quiet", "--threads", "2", "--chunk", "64"}).exit_code,
            0);
  run("scene.toml", "half", {}, {"--steps", "200"});
  ASSERT_EQ(talus({"run", "scene.toml", "--resume", "half", "--out", "rest", "--quiet"}).exit_code, 0);
  std::size_t compared = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder / "whole")) {
    const std::string name = fs::relative(entry.path(), folder / "whole").string();
    if (name.find(".vt") == std::string::npos && name.find(".pvd") == std::string::npos && name != "series.csv")
      continue;
    EXPECT_TRUE(read("parts/" + name) == read("whole/" + name)) << name;
    if (exists("rest/" + name) && name.find(".vt") != std::string::npos) {
      EXPECT_TRUE(read("rest/" + name) == read("whole/" + name)) << name << " of the resumed part alone";
    }
    ++compared;
  }
  EXPECT_GT(compared, 25U) << "nine frames of particles, contacts and averages";
}

TEST_F(Outputs, AnOptionalPartAddsItsColumnsToFramesAndSeriesAlsoAfterAResumeAndNoneWithoutIt) {
  const std::string scene = rain("csv_every = 0.005\nparticles_every = 0.05\nvtkhdf = true\nvtp = true");
  write("without.toml", scene);
  const std::string traced = replaced(scene, "interval = 0.01\n", "interval = 0.01\ntracer = 1\n");
  write("with.toml", traced + "[tracer]\nrate = 100\n");
  run("without.toml", "without");
  run("with.toml", "with");
  run("with.toml", "half", {}, {"--steps", "10000"});
  const Result more = talus({"run", "with.toml", "--resume", "half", "--quiet", "--threads", "1"});
  ASSERT_EQ(more.exit_code, 0) << more.err;
  EXPECT_EQ(read("half/series.csv"), read("with/series.csv"));
  Table rows = series("with");
  for (const char* name : {"tracer.total", "tracer.residual", "tracer.mixing_index"}) {
    EXPECT_EQ(rows.count(name), 1U) << name;
    EXPECT_EQ(series("without").count(name), 0U) << name;
  }
  EXPECT_NEAR(rows["tracer.total"].back(), rows["particles"].back(), 1e-9);  // all grains carry 1
  EXPECT_GT(rows["tracer.total"].back(), 10);
  const std::string last = "/vtp/particles-000000020000.vtp";
  ASSERT_TRUE(exists("with" + last));
  EXPECT_NE(read("with" + last).find("Name=\"tracer\""), std::string::npos);
  EXPECT_EQ(read("without" + last).find("Name=\"tracer\""), std::string::npos);

  write("alone.toml", traced);
  const Result alone = talus({"run", "alone.toml", "--out", "alone"});
  EXPECT_EQ(alone.exit_code, 3);
  EXPECT_NE(alone.err.find("source.0.tracer"), std::string::npos) << alone.err;
  EXPECT_FALSE(exists("alone"));
}

TEST_F(Outputs, ColumnsThatPartsAddToContactsAreInEveryFormat) {
  const std::string scene = replaced(small_scene(300,
                                                 "contacts = true\nvtkhdf = true\nvtp = true\n[heat]\ntemperature = "
                                                 "300\nevery = 10\ncapacity = 800\nconductivity = 1\n"),
                                     "velocity_jitter = 1.0", "velocity_jitter = 1.0\nvelocity = [0, 0, -3]");
  write("scene.toml", scene);
  run("scene.toml", "out");
  EXPECT_NE(read("out/vtp/contacts-000000000400.vtp").find("Name=\"heat_flow\""), std::string::npos);
  EXPECT_NE(read("out/contacts.vtkhdf").find("heat_flow"), std::string::npos);
  run("scene.toml", "half", {}, {"--steps", "200"});
  const Result more = talus({"run", "scene.toml", "--resume", "half", "--quiet", "--threads", "1"});
  ASSERT_EQ(more.exit_code, 0) << more.err;
  EXPECT_EQ(more.err.find("cannot be continued"), std::string::npos) << more.err;
}

TEST_F(Outputs, FramesOfContactsUseNoMoreThreadsThanTheRun) {
  write("scene.toml", small_scene(300, "contacts = true\nstress = true\n"));
  Process process(folder, {"run", "scene.toml", "--out", "out", "--quiet", "--threads", "1", "--chunk", "64", "--steps",
                           "300", "--set", "output.particles_every=2e-5"});
  const fs::path tasks = "/proc/" + std::to_string(process.id()) + "/task";
  std::ptrdiff_t most = 0;
  for (int k = 0; k < 4000 && !exists("out/summary.json"); ++k) {
    std::error_code gone;
    most = std::max(most, std::distance(fs::directory_iterator(tasks, gone), fs::directory_iterator()));
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_EQ(process.wait().exit_code, 0);
  EXPECT_EQ(most, 1);
}

// Two chips with surfaces, a rod of two spheres and three spheres: five spheres are left to draw.
TEST_F(Outputs, ParaViewShowsGrainsAndWallsOfARunByTheScript) {
  if (std::system("command -v pvpython > /dev/null 2>&1") != 0) GTEST_SKIP() << "no ParaView here";
  std::string scene = R"(title = "mixed"
[domain]
lower = [0, 0, 0]
upper = [0.06, 0.02, 0.02]
boundary = ["wall", "periodic", "open"]
[time]
step = 1e-5
duration = 1e-3
[[material]]
name = "g"
density = 1000
[contact]
normal_stiffness = 1000.0
restitution = 0.5
[[shape]]
name = "chip"
kind = "superquadric"
semi_axes = [0.002, 0.002, 0.001]
exponents = [6, 6]
[[shape]]
name = "rod"
spheres = [-0.001, 0, 0, 0.001, 0.001, 0, 0, 0.001]
[output]
particles_every = 5e-4
csv_every = 5e-4
)";
  for (const auto& [shape, number] : {std::pair{"chip", 2}, {"rod", 1}, {"", 3}}) {
    scene += "[[source]]\nkind = \"random\"\nnumber = " + std::to_string(number) + "\n";
    if (*shape != 0) scene += "shape = \"" + std::string(shape) + "\"\n";
    scene +=
        "region = { lower = [0.005, 0, 0], upper = [0.055, 0.02, 0.02] }\nsize = { kind = \"constant\", diameter = "
        "0.003 }\n";
  }
  run(write("s.toml", scene), "out");
  const std::string command =
      "cd '" + folder.string() + "' && pvpython '" TALUS_SOURCE_DIR "/cases/view.py' out --check > said.txt 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0) << read("said.txt");
  // 24 points around a body in 13 rings.
  EXPECT_NE(read("said.txt")
                .find("3 frames, 5 spheres and " + std::to_string(2 * 24 * 13) +
                      " points of surfaces in the last, walls: domain_x_lower, domain_x_upper"),
            std::string::npos)
      << read("said.txt");
}

}  // namespace
}  // namespace talus::test
