// Thermal expansion of grains: radii and forces against closed forms, books, the same bits for every way of running.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "core/base/error.hpp"
#include "core/scene/scene_file.hpp"
#include "scheduler/step/access.hpp"
#include "tests/part_values.hpp"
#include "tests/physics/physics_support.hpp"

namespace talus::physics {
namespace {

constexpr double k_r = 5e-3, k_alpha = 1e-4, k_kn = 1e5;

/// Grains in gas of 800 K that warms them within some ms; 300 K at the start.
Scene warmed(const std::vector<Grain>& grains) {
  Scene s = open_scene({-0.05, -0.05, -0.05}, {0.05, 0.05, 0.05}, 2e-6);
  linear_restitution(s, k_kn, 0.5);
  s.output.energies = true;
  s.heat.on = true;
  s.heat.every = 10;
  s.heat.temperature = 300;
  MatterHeat m;
  m.capacity = Curve::constant(10);
  m.conductivity = Curve::constant(1);
  m.expansion = k_alpha;
  s.heat.matter = {m};
  s.heat.gas.on = true;
  s.heat.gas.film = 3000;
  s.heat.gas.temperature = TimeTable::constant(800);
  add_grains(s, grains);
  s.heat.sources = {{300, false}};
  return s;
}

double radius_at(double T) { return k_r * (1 + k_alpha * T) / (1 + k_alpha * 300); }
double only(const Simulation& sim, const char* name) {
  for (const ExtraColumn& c : sim.frame().extra)
    if (c.name == name) return c.values.at(0);
  return 0;
}

TEST(Expansion, FreeGrainHasTheRadiusOfItsTemperatureAndKeepsMassAndSpin) {
  Scene s = warmed({{{}, {0.01, 0, 0}, k_r, {0, 3, 0}}});
  s.contact.friction = true;
  Simulation sim(s, options());
  const double mass = mass_of(EngineAccess::world(sim).rules, EngineAccess::world(sim).rows, 0);
  sim.run(40000);
  const double T = only(sim, "temperature");
  EXPECT_GT(T, 790);
  const Frame f = sim.frame();
  // the radius goes to that of the last heat step until the next one
  EXPECT_NEAR(f.r[0], radius_at(T), 1e-6 * k_r);
  EXPECT_GT(f.r[0], 1.04 * k_r);
  EXPECT_NEAR(mass_of(EngineAccess::world(sim).rules, EngineAccess::world(sim).rows, 0), mass, 1e-12 * mass);
  if (!f.w.empty()) {
    EXPECT_NEAR(f.w[0].y, 3, 1e-9);
  }
  const Energies e = sim.energies();
  EXPECT_LT(std::fabs(e.residual), 1e-12 * e.kinetic_translation);
}

TEST(Expansion, ClampedGrainPressesWithTheForceOfItsOverlap) {
  Scene s = warmed({{{}, {}, k_r}});
  s.walls = {plane("floor", {0, 0, -k_r}, {0, 0, 1}), plane("lid", {0, 0, k_r}, {0, 0, -1})};
  Simulation sim(s, options());
  sim.run(40000);
  const Frame f = sim.frame({.walls = true, .wall_loads = true});
  const double overlap = radius_at(only(sim, "temperature")) - k_r;
  EXPECT_GT(overlap, 0.04 * k_r);
  EXPECT_NEAR(f.wall_loads[1].force.z, k_kn * overlap, 1e-4 * k_kn * overlap);
  EXPECT_NEAR(f.wall_loads[0].force.z, -k_kn * overlap, 1e-4 * k_kn * overlap);
  // both springs hold what the radius has put in, and nothing else has moved
  const Energies e = sim.energies();
  figure("clamped grain that expands: elastic energy / closed form - 1", e.elastic / (k_kn * overlap * overlap) - 1);
  figure("clamped grain that expands: residual / elastic energy", e.residual / e.elastic);
  EXPECT_NEAR(e.elastic, k_kn * overlap * overlap, 1e-4 * e.elastic);
  EXPECT_LT(std::fabs(e.residual), 1e-6 * e.elastic);
  EXPECT_NEAR(e.sizes, e.elastic, 1e-6 * e.elastic);
}

/// A scene beside a grain file.
Scene scene_of(std::string text, const std::string& grain_file) {
  const std::string path = testing::TempDir() + "expansion-" + std::to_string(getpid()) + ".toml";
  std::ofstream(path) << grain_file;
  if (const std::size_t at = text.find("GRAIN"); at != std::string::npos) text.replace(at, 5, path);
  return parse_scene(text, "held", ".");
}

constexpr const char* k_held = R"(
gravity = [0, 0, 0]
domain = { lower = [0, 0, 0], upper = [0.03, 0.03, 0.03] }
contact = { normal_stiffness = 0.001, friction = "none" }
checks = { allow_unstable_step = true }
group = [{ name = "g", ids = [0, 10] }]
[[source]]
kind = "lattice"
number = 1
region = { lower = [0.009, 0.009, 0.009], upper = [0.021, 0.021, 0.021] }
size = { diameter = 0.01 }
[[event]]
time = 0
action = "freeze"
group = "g"
)";

TEST(Expansion, ReleasedGrainGoesInAStraightLineFromTheRadiusThatItWasHeldAt) {
  // heat steps of 10 steps; released before step 1503
  const Scene s = scene_of(std::string(k_held) + R"(
[[event]]
time = 0.01503
action = "release"
group = "g"
[time]
step = 1e-5
steps = 2000
[[material]]
name = "m"
density = 2500
[material.heat]
expansion = 1e-3
[heat]
every = 10
temperature = 300
capacity = 100
conductivity = 30
[heat.gas]
temperature = 1300
film = 1e4
)",
                           "");
  Simulation sim(s, options());
  sim.run(1503);
  std::vector<double> r{sim.frame().r[0]};
  EXPECT_EQ(r[0], k_r) << "held";
  while (sim.frame().step < 1510) sim.run(1), r.push_back(sim.frame().r[0]);
  ASSERT_EQ(r.size(), 8u);
  EXPECT_GT(r.back(), 1.01 * k_r);
  for (std::size_t k = 1; k < r.size(); ++k)
    EXPECT_NEAR(r[k], r[0] + (r.back() - r[0]) * static_cast<double>(k) / 7, 1e-12 * k_r) << k;
}

TEST(Expansion, HeldGrainThatBurnsOutLeaves) {
  const Scene s = scene_of(std::string(k_held) + R"(
[time]
step = 1e-2
steps = 40000
[[material]]
name = "c"
density = 600
grain = "GRAIN"
[conversion]
every = 100
gone_below = 0.6
)",
                           R"(
time = { step = 0.05, duration = 60, output_every = 10 }
grain = { shape = "sphere", diameter = 0.01, temperature = 1000 }
material = { density = 600, initial = { c = 0.99 }, ash = 0.01 }
heat_capacity = { fuel = 1500 }
conductivity = { fuel = 10 }
shrinkage = { burn_off = 0.95 }
surroundings = { temperature = 1000, oxygen = 1.0, film = 500 }
solid = [{ name = "c", kind = "char" }]
char_reaction = [{ A = 5, n = 0, E = 0, ratio_A = 0 }]
)");
  Simulation sim(s, options());
  sim.run(40000);
  EXPECT_EQ(sim.particles(), 0);
}

TEST(Expansion, BitsDependOnTheTrajectoryAloneAndAResumeGoesOnToTheBit) {
  std::vector<Grain> grains;
  for (int k = 0; k < 200; ++k) {
    const auto q = [k](int c) { return uniform(5, static_cast<std::uint64_t>(8 * k + c)) - 0.5; };
    grains.push_back({{-0.04 + 0.0105 * (k % 8), -0.04 + 0.0105 * (k / 8 % 5), -0.03 + 0.0105 * (k / 40)},
                      {q(0), q(1), q(2)},
                      k_r * (0.9 + 0.2 * q(3))});
  }
  Scene s = warmed(grains);
  for (auto& axis : s.domain.boundary) axis = {Boundary::wall, Boundary::wall};
  s.max_overlap = 1;
  const auto run = [&](int threads, int chunk, ListPolicy policy, Isa isa) {
    RunOptions o;
    o.threads = threads;
    o.chunk = chunk;
    o.isa = isa;
    Scene copy = s;
    copy.list.policy = policy;
    Simulation sim(copy, o);
    sim.run(2005);
    return sim.state_hash();
  };
  const std::uint64_t wanted = run(1, 4096, ListPolicy::always, Isa::scalar);
  EXPECT_EQ(run(2, 64, ListPolicy::local, Isa::automatic), wanted);
  EXPECT_EQ(run(3, 100, ListPolicy::paper, Isa::automatic), wanted);
  EXPECT_EQ(run(2, 64, ListPolicy::outer_inner, Isa::scalar), wanted);
  const std::string path = testing::TempDir() + "expansion-" + std::to_string(getpid()) + ".checkpoint";
  Simulation first(s, options());
  first.run(1003);  // between two heat steps
  CheckpointWriter out;
  first.save(out);
  out.commit(path);
  Simulation second(s, options(), CheckpointReader(path));
  std::remove(path.c_str());
  first.run(1002);
  second.run(1002);
  EXPECT_EQ(first.state_hash(), wanted);
  EXPECT_EQ(second.state_hash(), wanted);
  EXPECT_EQ(first.energies().sizes, second.energies().sizes);
  EXPECT_EQ(first.energies().residual, second.energies().residual);
}

}  // namespace
}  // namespace talus::physics
