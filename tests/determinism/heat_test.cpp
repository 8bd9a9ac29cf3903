// Part "heat": temperatures depend on the trajectory alone, a resume goes on to the bit, a scene without it has nothing
// of it; energy balances while grains come, go and rub.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "scheduler/step/access.hpp"
#include "tests/determinism/part_final.hpp"
#include "tests/determinism/scenes.hpp"
#include "tests/determinism/variants.hpp"

namespace talus::determinism {
namespace {

constexpr std::int64_t k_run = 1500;  // with two sort epochs

const std::vector<Scene (*)()>& builds() {
  static const std::vector<Scene (*)()> all{hopper, pile_on_mesh, sticky_drum, sheared_bed};
  return all;
}

TEST(HeatPart, EnergyBalancesWhileGrainsComeGoAndRub) {
  for (Scene (*build)() : builds()) {
    Simulation sim(heated(build()), RunOptions{});
    const double before = value_of(sim, "heat.mean");
    sim.run(k_run);
    EXPECT_LT(std::fabs(value_of(sim, "heat.residual")), 1e-11 * value_of(sim, "heat.total")) << build().title;
    EXPECT_NE(value_of(sim, "heat.in_by_friction"), 0) << build().title;
    EXPECT_NE(value_of(sim, "heat.mean"), before);
    EXPECT_GE(value_of(sim, "heat.lowest"), 300) << build().title;
  }
}

TEST(HeatPart, ValuesDependOnTheTrajectoryAlone) {
  for (Scene (*build)() : builds()) {
    const Scene s = heated(build());
    const Variant plain{ListPolicy::local, 200, 1, 0, Isa::automatic};
    Simulation first(plain.apply(s), plain.options());
    first.run(k_run);
    const Final wanted = final_of(first);
    expect_same_in_other_ways(s, k_run, wanted);
  }
}

TEST(HeatPart, ResumeGoesOnToTheBitBetweenTwoHeatSteps) {
  const Scene s = heated(hopper());
  expect_same_after_resume(s, k_run, {733});  // 8 steps into a heat step
}

/// Steps of a length that the temperatures choose.
Scene paced(Scene s) {
  s.heat.every = 4;
  s.heat.error = 3;
  s.heat.sources.back() = {350, false};
  return s;
}

TEST(HeatPart, ChosenHeatStepsDependOnTheTrajectoryAloneAndGoOnAfterAResume) {
  const Scene s = paced(heated(sheared_bed()));
  const Variant plain{ListPolicy::local, 200, 1, 0, Isa::automatic};
  Simulation first(plain.apply(s), plain.options());
  std::vector<double> lengths;
  for (std::int64_t done = 0; done < k_run; done += 100) {
    first.run(100);
    if (lengths.empty() || lengths.back() != value_of(first, "heat.steps"))
      lengths.push_back(value_of(first, "heat.steps"));
  }
  EXPECT_GE(lengths.size(), 2U) << "they change";
  EXPECT_LT(std::fabs(value_of(first, "heat.residual")), 1e-11 * value_of(first, "heat.total"));
  expect_same_in_other_ways(s, k_run, final_of(first));
  expect_same_after_resume(s, k_run, {733});
}

TEST(HeatPart, ChangesNoMotionAndIsLeftOutWhereTheSceneDoesNotAsk) {
  const Scene s = hopper();
  Simulation without(s, RunOptions{}), with(heated(s), RunOptions{});
  without.run(300);
  with.run(300);
  EXPECT_TRUE(without.part_values().empty());
  EXPECT_TRUE(without.frame().extra.empty());
  EXPECT_EQ(without.plan().graph.find("heat"), std::string::npos);
  EXPECT_NE(with.plan().graph.find("wall_contact[c] -> heat_contacts[c] -> integrate[c] -> heat_friction[c]"),
            std::string::npos)
      << with.plan().graph;
  EXPECT_EQ(checkpoint_bytes(without).find("temperature"), std::string::npos);
  for (const auto& a : without.plan().arrays) EXPECT_EQ(a.name.find("temperature"), std::string::npos);
  const Frame a = without.frame(), b = with.frame();
  ASSERT_EQ(a.id, b.id);
  for (std::size_t k = 0; k < a.x.size(); ++k) EXPECT_EQ(norm2(a.x[k] - b.x[k]), 0);
  EXPECT_NE(without.state_hash(), with.state_hash()) << "temperatures are state";
}

}  // namespace
}  // namespace talus::determinism
