// Parts "laser" and "heat" of grains that melt: temperatures, molten fractions and sums depend on the trajectory alone,
// a resume in the middle of the track goes on to the bit, a scene without them has nothing of them.
#include <gtest/gtest.h>

#include <cmath>

#include "scheduler/step/access.hpp"
#include "tests/determinism/part_final.hpp"
#include "tests/determinism/scenes.hpp"
#include "tests/determinism/variants.hpp"

namespace talus::determinism {
namespace {

constexpr std::int64_t k_run = 1500;  // with two sort epochs

/// A beam that crosses the scene's middle in the run, over grains that melt at 450 K.
Scene lit(Scene s) {
  s = heated(s);
  for (MatterHeat& m : s.heat.matter) {
    m.solidus = 400;
    m.liquidus = 450;
    m.latent_heat = 5e4;
  }
  const Vec3 a = s.domain.lower, b = s.domain.upper;
  Laser l;
  l.power = TimeTable{{0, 0.01}, {200, 400}};
  l.radius = 0.15 * (b.x - a.x);
  l.absorptivity = 0.7;
  l.x = {a.x + 0.3 * (b.x - a.x), a.x + 0.9 * (b.x - a.x)};
  l.y = {0.5 * (a.y + b.y), 0.4 * a.y + 0.6 * b.y};
  const double time = s.dt * static_cast<double>(k_run);
  l.speed = 0.6 * (b.x - a.x) / time;
  l.start = 0.1 * time;
  l.stop = k_never;
  s.heat.lasers = {l};
  return s;
}

const std::vector<Scene (*)()>& builds() {
  static const std::vector<Scene (*)()> all{hopper, sheared_bed};
  return all;
}

TEST(LaserPart, EnergyBalancesWhileABeamMeltsATrack) {
  for (Scene (*build)() : builds()) {
    Simulation sim(lit(build()), RunOptions{});
    sim.run(k_run);
    EXPECT_LT(std::fabs(value_of(sim, "heat.residual")), 1e-11 * value_of(sim, "heat.total")) << build().title;
    EXPECT_GT(value_of(sim, "laser.absorbed"), 0) << build().title;
    EXPECT_GT(value_of(sim, "heat.molten"), 0) << build().title;
    EXPECT_NEAR(value_of(sim, "laser.absorbed") + value_of(sim, "laser.reflected") + value_of(sim, "laser.passed"),
                value_of(sim, "laser.emitted"), 1e-12 * value_of(sim, "laser.emitted"));
  }
}

TEST(LaserPart, ValuesDependOnTheTrajectoryAlone) {
  for (Scene (*build)() : builds()) {
    const Scene s = lit(build());
    const Variant plain{ListPolicy::local, 200, 1, 0, Isa::automatic};
    Simulation first(plain.apply(s), plain.options());
    first.run(k_run);
    const Final wanted = final_of(first);
    expect_same_in_other_ways(s, k_run, wanted);
  }
}

TEST(LaserPart, ResumeInTheMiddleOfTheTrackGoesOnToTheBit) {
  const Scene s = lit(hopper());
  Simulation half(s, RunOptions{});
  half.run(733);  // 8 steps into a heat step
  EXPECT_GT(value_of(half, "laser.power"), 0);
  expect_same_after_resume(s, k_run, {733});
}

TEST(LaserPart, IsLeftOutWhereTheSceneDoesNotAsk) {
  const Scene s = heated(hopper());
  Simulation without(s, RunOptions{}), with(lit(hopper()), RunOptions{});
  for (const Simulation* sim : {&without, &with}) {
    int columns = 0;
    for (const PartValue& v : sim->part_values()) columns += v.name.starts_with("laser.") || v.name == "heat.molten";
    EXPECT_EQ(columns, sim == &with ? 6 : 0);
  }
  const auto has = [](const Simulation& sim, const std::string& name) {
    for (const auto& a : sim.plan().arrays)
      if (a.name.find(name) != std::string::npos && a.bytes_per_particle > 0) return true;
    return false;
  };
  for (const char* name : {"molten", "laser heat"}) {
    EXPECT_FALSE(has(without, name)) << name;
    EXPECT_TRUE(has(with, name)) << name;
  }
}

}  // namespace
}  // namespace talus::determinism
