// The trajectories of the present state, as numbers in golden.txt. The other tests compare ways of running a scene with
// each other: none of them sees a change that moves all of them. A deliberate change of a trajectory is a changed line:
//   TALUS_UPDATE_GOLDEN=1 build/tests/test_determinism --gtest_filter='*Golden*'
// writes the file anew and prints what has changed. A line holds for every instruction set, thread count, optimisation
// level and x86-64 processor.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "core/scene/scene_file.hpp"
#include "paths.hpp"
#include "tests/determinism/scenes.hpp"

namespace talus::determinism {
namespace {
namespace fs = std::filesystem;

const std::string k_file = TALUS_SOURCE_DIR "/tests/determinism/golden.txt";
const std::string k_cases = TALUS_SOURCE_DIR "/cases/";

std::string hex(std::uint64_t value) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

/// FNV-1a.
std::uint64_t hash_of(const std::string& bytes) {
  std::uint64_t h = 0xcbf29ce484222325U;
  for (const char c : bytes) h = (h ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  return h;
}

std::string bytes_line(const std::string& bytes) {
  return std::to_string(bytes.size()) + " bytes  " + hex(hash_of(bytes));
}

/// Grains and contacts besides the hash: whoever reads a changed line sees whether the scene still does what it is for.
std::string state_line(const Scene& scene, std::int64_t steps) {
  RunOptions options;
  options.threads = 2;
  Simulation sim(scene, options);
  sim.run(steps);
  const Counters c = sim.counters();
  std::ostringstream line;
  line << steps << " steps, " << sim.particles() << " grains, " << c.contacts << " contacts, " << c.wall_contacts
       << " with walls  " << hex(sim.state_hash());
  return line.str();
}

std::string checkpoint_line(const Scene& scene) {
  Simulation sim(scene, RunOptions{});
  sim.run(k_steps);
  return bytes_line(checkpoint_bytes(sim));
}

void shell(const std::string& command) {
  if (std::system(command.c_str()) != 0) throw std::runtime_error("failed: " + command);
}

// ---- the small cases ----

/// Files of a case as its script writes them; returns their folder with a slash at its end.
std::string generated(const std::string& script) {
  const std::string folder = temporary_file("generated");
  shell("/usr/bin/python3 '" + k_cases + script + "' --only small --out '" + folder + "' > /dev/null");
  return folder + "/";
}

std::string avalanche() {
  const std::string folder = generated("avalanche/make_avalanche.py");
  Scene s = load_scene(k_cases + "avalanche/small.toml");
  s.walls.at(0).file = folder + "valley-small.stl";
  s.sources.at(0).file = folder + "snow-small.csv.gz";
  return state_line(s, 1500);
}

std::string grates() { return state_line(load_scene(k_cases + "grates/small.toml"), 3000); }

std::string hopper_20k() { return state_line(load_scene(k_cases + "hopper/hopper-20k.toml"), 1200); }

std::string incline() {
  Scene s = load_scene(k_cases + "incline/small.toml");
  s.walls.at(0).file = generated("incline/make_incline.py") + "rough-small.stl";
  return state_line(s, 2500);
}

std::string levelling() {
  Scene s = load_scene(k_cases + "levelling/small.toml");
  s.walls.at(1).file = generated("levelling/make_levelling.py") + "blade-small.stl";
  return state_line(s, 4000);
}

// ---- impacts, as in the verification ladder ----

/// A spinning grain that hits a plane and, on its way back, a larger one: oblique impacts of every kind.
std::string impact(const std::string& contact) {
  const std::string table = temporary_file("impact.csv",
                                           "x,y,z,radius,vx,vy,vz,wx,wy,wz\n"
                                           "0,0,0.0101,0.01,1,0.3,-2,5,-9,20\n"
                                           "0.004,0.003,0.0352,0.015,0,0,-4,0,3,0\n");
  const Scene s = parse_scene(
      "domain = { lower = [-1, -1, -1], upper = [1, 1, 1], boundary = \"open\" }\n"
      "time = { step = 1e-7, steps = 4000 }\n"
      "[[material]]\nname = \"metal\"\ndensity = 2700\nyoung = 7e10\npoisson = 0.3\n"
      "[[source]]\nkind = \"file\"\nfile = \"" +
          table +
          "\"\n[[wall]]\nname = \"floor\"\nshape = \"plane\"\npoint = [0, 0, 0]\n"
          "normal = [0, 0, 1]\n[contact]\nrestitution = 0.7\nfriction = 0.3\n" +
          contact,
      "impact", TALUS_SOURCE_DIR);
  return state_line(s, 4000);
}

std::string impact_linear() { return impact("model = \"linear\"\nnormal_stiffness = 1e7\n"); }
std::string impact_hertz() { return impact("model = \"hertz_mindlin\"\nrolling = \"epsd\"\nrolling_friction = 0.1\n"); }
std::string impact_tsuji() { return impact("model = \"hertz_tsuji\"\n"); }
std::string impact_jkr() { return impact("model = \"jkr\"\nwork_of_adhesion = 2\n"); }

// ---- time series, as the program writes them ----

std::string series_line(const std::string& scene, const std::string& arguments) {
  const std::string out = temporary_file(scene.substr(0, scene.find('/')));
  shell("'" TALUS_BINARY "' run '" + k_cases + scene + "' --out '" + out +
        "' --threads 1 --quiet --set output.particles_every=0 --set output.energies=true " + arguments);
  return bytes_line(read_bytes(out + "/series.csv"));
}

/// Planes, loads on moving walls, a stream, the energy ledger.
std::string grates_series() {
  std::string numbers;
  for (int k = 0; k < 4; ++k) numbers += " --set source." + std::to_string(k) + ".number=150";
  return series_line("grates/small.toml",
                     "--steps 4000 --set output.csv_every=0.004 --set source.4.start=0.01" + numbers);
}

/// Adhesion, and averages over a region.
std::string levelling_series() {
  const std::string blade = generated("levelling/make_levelling.py") + "blade-small.stl";
  return series_line("levelling/small.toml",
                     "--steps 4000 --set output.csv_every=3e-5 --set source.0.number=600 --set "
                     "source.0.region.upper=[0.00165,0.0003,0.00025] --set wall.1.file='" +
                         blade + "'");
}

struct Golden {
  const char* name;
  std::string (*compute)();
};
void PrintTo(const Golden& g, std::ostream* out) { *out << g.name; }

template <Scene (*build)()>
std::string scene_state() {
  return state_line(build(), k_steps);
}
template <Scene (*build)()>
std::string scene_checkpoint() {
  return checkpoint_line(build());
}

const Golden k_golden[] = {{"scene.hopper", scene_state<hopper>},
                           {"scene.sheared_bed", scene_state<sheared_bed>},
                           {"scene.gas", scene_state<gas>},
                           {"scene.pile_on_mesh", scene_state<pile_on_mesh>},
                           {"scene.hertz_drum", scene_state<hertz_drum>},
                           {"scene.sticky_drum", scene_state<sticky_drum>},
                           {"scene.slipping_drum", scene_state<slipping_drum>},
                           {"scene.cohesive_pile", scene_state<cohesive_pile>},
                           {"scene.crossing_walls", scene_state<crossing_walls>},
                           {"case.avalanche", avalanche},
                           {"case.grates", grates},
                           {"case.hopper_20k", hopper_20k},
                           {"case.incline", incline},
                           {"case.levelling", levelling},
                           {"impact.linear", impact_linear},
                           {"impact.hertz_mindlin", impact_hertz},
                           {"impact.hertz_tsuji", impact_tsuji},
                           {"impact.jkr", impact_jkr},
                           {"checkpoint.hopper", scene_checkpoint<hopper>},
                           {"checkpoint.sticky_drum", scene_checkpoint<sticky_drum>},
                           {"series.grates", grates_series},
                           {"series.levelling", levelling_series}};

bool updating() { return std::getenv("TALUS_UPDATE_GOLDEN") != nullptr; }

/// Name -> rest of its line.
std::map<std::string, std::string> read_golden() {
  std::map<std::string, std::string> golden;
  std::ifstream in(k_file);
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    const auto end = line.find(' '), rest = line.find_first_not_of(' ', end);
    golden[line.substr(0, end)] = rest == std::string::npos ? "" : line.substr(rest);
  }
  return golden;
}

void write_golden(std::map<std::string, std::string> golden) {
  std::ofstream out(k_file);
  out << "# What the trajectories of golden_test.cpp end with; written by TALUS_UPDATE_GOLDEN=1 (see there).\n";
  for (const Golden& g : k_golden)
    if (golden.contains(g.name))
      out << g.name << std::string(26 - std::string(g.name).size(), ' ') << golden[g.name] << '\n';
}

class GoldenLine : public testing::TestWithParam<Golden> {};

TEST_P(GoldenLine, IsWhatTheSceneEndsWith) {
  const std::string name = GetParam().name, now = GetParam().compute();
  std::map<std::string, std::string> golden = read_golden();
  if (!updating()) {
    EXPECT_EQ(golden[name], now) << name << "\n  old: " << golden[name] << "\n  new: " << now
                                 << "\nIf that is meant: TALUS_UPDATE_GOLDEN=1, and review the lines.";
    return;
  }
  if (golden[name] != now) std::printf("%s\n  old: %s\n  new: %s\n", name.c_str(), golden[name].c_str(), now.c_str());
  golden[name] = now;
  write_golden(golden);
  GTEST_SKIP() << "written, not compared";
}

INSTANTIATE_TEST_SUITE_P(Trajectories, GoldenLine, testing::ValuesIn(k_golden), [](const auto& i) {
  std::string name = i.param.name;
  name[name.find('.')] = '_';
  return name;
});

TEST(GoldenFile, HasALineForEveryTestAndNoOther) {
  if (updating()) GTEST_SKIP() << "the lines are being written";
  std::map<std::string, std::string> golden = read_golden();
  for (const Golden& g : k_golden) EXPECT_EQ(golden.erase(g.name), 1U) << g.name;
  for (const auto& [name, line] : golden) ADD_FAILURE() << "of no test: " << name << " " << line;
}

}  // namespace
}  // namespace talus::determinism
