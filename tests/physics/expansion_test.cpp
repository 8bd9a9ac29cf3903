// Thermal expansion of grains: radii and forces against closed forms, books, the same bits for every way of running.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <string>

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
