// The solver of many grains gives what that of a single grain gives: a bed of one beside the table of `talus grain`.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "core/base/error.hpp"
#include "core/conversion/grain_run.hpp"
#include "core/scene/scene_file.hpp"
#include "scheduler/simulation.hpp"
#include "tests/part_values.hpp"
#include "tests/physics/physics_support.hpp"

namespace talus::physics {
namespace {

constexpr double k_seconds = 12;

struct Case {
  const char* scheme;
  const char* more;  ///< sections
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.scheme; }

std::string wood(const Case& c) {
  return fmt::format(
      "scheme = \"{}\"\n[time]\nstep = 0.005\nduration = {}\noutput_every = {}\n[grain]\ndiameter = 0.01\nshells = 12\n"
      "temperature = 300\n[material]\ndensity = 600\nash = 0.02\n[conductivity]\nfuel = 0.2\n[surroundings]\ngas = "
      "\"air\"\ntemperature = 1000\nwall_temperature = 1100\nfilm = 60\noxygen = 0.23\n[[char_reaction]]\nA = 1.715\n"
      "E = 74830\n{}",
      c.scheme, k_seconds, k_seconds, c.more);
}

double last(const std::string& table, const std::string& column) {
  std::istringstream in(table);
  std::string head, line, end, cell;
  std::getline(in, head);
  while (std::getline(in, line))
    if (!line.empty()) end = line;
  std::istringstream names(head), row(end);
  while (std::getline(names, cell, ',')) {
    std::string value;
    std::getline(row, value, ',');
    if (cell == column) return std::strtod(value.c_str(), nullptr);
  }
  ADD_FAILURE() << "no column " << column;
  return 0;
}

class GrainInBed : public ::testing::TestWithParam<Case> {};

// Both are of first order in the step or better; the rest between them falls with it (1e-3 here).
TEST_P(GrainInBed, DoesWhatTheSingleGrainDoes) {
  const std::string text = wood(GetParam());
  const auto file =
      std::filesystem::temp_directory_path() / fmt::format("talus-grain-{}-{}.toml", ::getpid(), GetParam().scheme);
  std::ofstream(file) << text;
  Simulation sim(
      parse_scene(
          fmt::format("[domain]\nlower = [0, 0, 0]\nupper = [0.06, 0.06, 0.06]\n[time]\nstep = 0.001\nsteps = {}\n"
                      "[[material]]\nname = \"wood\"\ndensity = 600\ngrain = \"{}\"\n[contact]\n"
                      "normal_stiffness = 1000\nfriction = \"none\"\n[checks]\nallow_unstable_step = true\n"
                      "[[source]]\nkind = \"lattice\"\nnumber = 1\nlattice = \"cubic\"\nregion = {{ lower = "
                      "[0.02495, 0.02495, 0.02495], upper = [0.03505, 0.03505, 0.03505] }}\nsize = {{ diameter "
                      "= 0.01 }}\n[conversion]\nevery = 5\nshells = 12\n",
                      k_seconds * 1000, file.string()),
          "one.toml", "."),
      options());
  sim.run(static_cast<std::int64_t>(k_seconds * 1000));
  std::filesystem::remove(file);
  const std::string table = conversion::grain_table(conversion::parse_grain(text, "g.toml"));
  const double radius = last(table, "radius"), mass = last(table, "mass"), first = 600 * k_pi / 6 * 1e-6;
  EXPECT_GT(first - mass, 0.02 * first) << "something happens";
  EXPECT_NEAR(sim.frame().r[0] / radius, 1, 2e-3);
  EXPECT_NEAR(value_of(sim, "conversion.mass") / mass, 1, 5e-3);
  EXPECT_NEAR(value_of(sim, "conversion.heat_in") / last(table, "heat_in"), 1, 1e-2);
  EXPECT_NEAR(value_of(sim, "conversion.oxygen_taken"), last(table, "oxygen_taken"),
              1e-2 * last(table, "oxygen_taken") + 1e-4 * first);
}

// Gas with heat capacities far from that of the film: blowing thins the film of mass by the mass that comes out.
// Schemes whose first char is a trace: what burns of it takes no volume of the wood around it.
constexpr Case k_cases[] = {
    {"chan", "[heat_capacity]\nfuel = 1500\nchar = 1000\ngas = 2500\n"},
    {"thurner_mann", "[heat_capacity]\nfuel = 1500\nchar = 1000\ngas = 400\n"},
    {"wagenaar", "[heat_capacity]\nfuel = 1500\n[shrinkage]\nburn_off = 0.9\ndevolatilisation = 0.2\n"},
    {"di_blasi", "[heat_capacity]\nfuel = 1500\n[shrinkage]\nburn_off = 0.9\n"},
    {"font", "[heat_capacity]\nfuel = 1500\n[shrinkage]\nburn_off = 0.95\ndevolatilisation = 0.3\n"}};
INSTANTIATE_TEST_SUITE_P(Schemes, GrainInBed, ::testing::ValuesIn(k_cases),
                         [](const auto& c) { return std::string(c.param.scheme); });

TEST(GrainFile, OfACylinderIsRefusedForABed) {
  const auto file = std::filesystem::temp_directory_path() / fmt::format("talus-rod-{}.toml", ::getpid());
  std::string text = wood({"chan", "[heat_capacity]\nfuel = 1500\n"});
  text.replace(text.find("diameter"), 8, "shape = \"cylinder\"\nlength = 0.02\ndiameter");
  std::ofstream(file) << text;
  try {
    Simulation sim(parse_scene("[domain]\nlower = [0, 0, 0]\nupper = [1, 1, 1]\n[time]\nstep = 0.001\nsteps = 1\n"
                               "[[material]]\nname = \"wood\"\ndensity = 600\ngrain = \"" +
                                   file.string() +
                                   "\"\n[contact]\nnormal_stiffness = 1000\n[[source]]\nkind = \"lattice\"\nnumber = "
                                   "1\nregion = { lower = [0.1, 0.1, 0.1], upper = [0.2, 0.2, 0.2] }\nsize = { "
                                   "diameter = 0.05 }\n[conversion]\nevery = 5\n",
                               "rod.toml", "."),
                   options());
    ADD_FAILURE() << "accepted";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("is of no sphere"), std::string::npos) << e.what();
  }
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace talus::physics
