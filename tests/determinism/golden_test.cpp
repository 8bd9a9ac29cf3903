// The trajectories of the present state, as numbers in golden.txt: the other tests compare ways of running a scene with
// each other and would not see a change that moves all of them. A deliberate change of a trajectory is a changed line
// there: TALUS_UPDATE_GOLDEN=1 build/tests/test_determinism --gtest_filter='Golden*' writes the file anew.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>

#include "core/io/scene_file.hpp"
#include "paths.hpp"
#include "tests/determinism/scenes.hpp"

namespace talus::determinism {
namespace {

const std::string k_file = std::string(TALUS_SOURCE_DIR) + "/tests/determinism/golden.txt";

/// Name -> rest of the line: steps and hash.
std::map<std::string, std::string> read_golden() {
  std::map<std::string, std::string> golden;
  std::ifstream in(k_file);
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    const auto space = line.find(' ');
    golden[line.substr(0, space)] = line.substr(line.find_first_not_of(' ', space));
  }
  return golden;
}

void compare(const std::map<std::string, std::string>& now) {
  if (std::getenv("TALUS_UPDATE_GOLDEN") != nullptr) {
    std::map<std::string, std::string> all = read_golden();
    for (const auto& [name, text] : now) all[name] = text;
    std::ofstream out(k_file);
    out << "# name, steps, state hash (or xxh3 of the bytes); see golden_test.cpp\n";
    for (const auto& [name, text] : all)
      out << name << std::string(name.size() < 32 ? 32 - name.size() : 1, ' ') << text << '\n';
    GTEST_SKIP() << "golden.txt is written anew";
  }
  const std::map<std::string, std::string> golden = read_golden();
  for (const auto& [name, text] : now) {
    const auto line = golden.find(name);
    ASSERT_NE(line, golden.end()) << name << " has no line in golden.txt";
    EXPECT_EQ(line->second, text) << name << ": the trajectory has changed; was that meant?";
  }
}

std::string line_of(std::int64_t steps, std::uint64_t hash) {
  char text[64];
  std::snprintf(text, sizeof text, "%lld %016llx", static_cast<long long>(steps),
                static_cast<unsigned long long>(hash));
  return text;
}

std::string hash_after(const Scene& scene, std::int64_t steps) {
  RunOptions options;
  options.threads = 2;
  Simulation sim(scene, options);
  sim.run(steps);
  return line_of(steps, sim.state_hash());
}

TEST(Golden, DeterminismScenesKeepTheirTrajectories) {
  std::map<std::string, std::string> now;
  for (const NamedScene& s : scenes()) now[std::string("scene.") + s.name] = hash_after(s.build(), k_steps);
  compare(now);
}

TEST(Golden, SmallCasesKeepTheirTrajectories) {
  std::map<std::string, std::string> now;
  for (const char* file : {"avalanche/small", "grates/small", "hopper/hopper-20k", "incline/small", "levelling/small"})
    now[std::string("case.") + file] =
        hash_after(load_scene(std::string(TALUS_SOURCE_DIR) + "/cases/" + file + ".toml"), 2000);
  compare(now);
}

/// Two grains on their way to an oblique impact, or one onto a plane: the impacts that the verification ladder is made
/// of.
Scene impact(const std::string& contact, const std::string& wall) {
  const std::string text =
      "domain = { lower = [-1, -1, -1], upper = [1, 1, 1], boundary = \"open\" }\n"
      "time = { step = 1e-7, steps = 4000 }\n"
      "material = [{ name = \"a\", density = 2700, young = 7e10, poisson = 0.3 }]\n" +
      contact + wall;
  Scene s = parse_scene(text, "impact", TALUS_SOURCE_DIR);
  Source source;
  source.kind = Source::Kind::file;
  source.file = temporary_file("impact.csv",
                               "x,y,z,radius,vx,vy,vz,wx,wy,wz\n0,0,0.0101,0.01,1,0.3,-2,5,-9,20\n"
                               "0.004,0.003,0.0352,0.015,0,0,-4,0,3,0\n");
  s.sources = {source};
  return s;
}

TEST(Golden, ImpactsKeepTheirTrajectories) {
  const std::string linear =
                        "[contact]\nmodel = \"linear\"\nnormal_stiffness = 1e7\nrestitution = 0.7\nfriction = 0.3\n",
                    hertz = "[contact]\nmodel = \"hertz_mindlin\"\nrestitution = 0.7\nfriction = 0.3\n",
                    plane = "[[wall]]\nname = \"floor\"\nshape = \"plane\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\n";
  compare({{"impact.linear", hash_after(impact(linear, plane), 4000)},
           {"impact.hertz", hash_after(impact(hertz, plane), 4000)},
           {"impact.pair", hash_after(impact(hertz, ""), 4000)}});
}

}  // namespace
}  // namespace talus::determinism
