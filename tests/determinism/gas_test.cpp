// Part "gas": its values depend on the trajectory alone; a resume goes on to the bit; its work balances; a scene
// without it has nothing of it.
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.hpp"
#include "scheduler/step/access.hpp"
#include "tests/determinism/part_final.hpp"
#include "tests/determinism/scenes.hpp"
#include "tests/determinism/variants.hpp"

namespace talus::determinism {
namespace {

constexpr std::int64_t k_run = 1200;  // with a sort epoch

/// The scene in an upward wind that warms and burns a little.
Scene blown(Scene s) {
  s.gas.on = true;
  s.gas.lower = s.domain.lower;
  s.gas.upper = s.domain.upper;
  s.gas.cells = {3, 3, 6};
  s.gas.every = 50;
  s.gas.combustion = true;
  GasInlet in, out;
  in.velocity = 0.8;
  in.temperature = 900;
  in.fractions = {0.2, 0.02, 0.02, 0.02, 0.01, 0.01, 0, 0.72};
  in.own_fractions = true;
  out.side = GasSide::top;
  out.kind = GasInlet::Kind::pressure;
  s.gas.inlets = {in, out};
  return s;
}

TEST(Gas, ValuesDependOnTheTrajectoryAlone) {
  for (Scene (*build)() : {hopper, hertz_drum}) {
    const Scene s = blown(build());
    const Variant plain{ListPolicy::local, 200, 1, 0, Isa::automatic};
    Simulation first(plain.apply(s), plain.options());
    first.run(k_run);
    const Final wanted = final_of(first);
    EXPECT_GT(value_of(first, "gas.mass_in"), 0);
    EXPECT_GT(value_of(first, "gas.force_z"), 0);
    EXPECT_GT(value_of(first, "gas.temperature_max"), 310);
    expect_same_in_other_ways(s, k_run, wanted);
  }
}

TEST(Gas, ResumeGoesOnToTheBit) {
  const Scene s = blown(hopper());
  expect_same_after_resume(s, k_run, {20, 777});  // before the first gas step, and between two
}

TEST(Gas, BalancesHoldWhileGrainsComeAndGo) {
  Simulation sim(blown(hopper()), RunOptions{});
  sim.run(k_run);
  const double scale = value_of(sim, "gas.mass_in") + value_of(sim, "gas.mass_out");
  EXPECT_LT(std::fabs(value_of(sim, "gas.mass_residual")), 1e-10 * scale);
  EXPECT_LT(value_of(sim, "gas.element_residual"), 1e-10 * scale);
  EXPECT_LT(std::fabs(value_of(sim, "gas.enthalpy_residual")), 1e-10 * scale * 1e6);
}

TEST(Gas, ItsWorkOnTheGrainsIsInTheLedger) {
  Scene s = blown(hopper());
  s.output.energies = true;
  Scene still = hopper();
  still.output.energies = true;
  Simulation with(s, RunOptions{}), without(still, RunOptions{});
  with.run(k_run);
  without.run(k_run);
  const Energies e = with.energies(), plain = without.energies();
  EXPECT_GT(std::fabs(e.wall_work - plain.wall_work), 1e-3 * std::fabs(e.kinetic_translation));
  EXPECT_LT(std::fabs(e.residual), 3 * std::fabs(plain.residual) + 0.02 * std::fabs(e.wall_work - plain.wall_work));
}

TEST(Gas, ItsHashIsThatOfTheStateWhetherEnergiesAreSummedOrNot) {
  Scene s = blown(hopper());
  Simulation without(s, RunOptions{});
  s.output.energies = true;
  Simulation with(s, RunOptions{});
  for (Simulation* sim : {&without, &with}) sim->run(300);
  EXPECT_EQ(with.state_hash(), without.state_hash());
}

TEST(Gas, IsLeftOutWhereTheSceneDoesNotAsk) {
  Simulation without(hopper(), RunOptions{}), with(blown(hopper()), RunOptions{});
  without.run(60);
  with.run(60);
  EXPECT_TRUE(without.part_values().empty());
  EXPECT_TRUE(without.part_grids().empty());
  EXPECT_EQ(without.plan().graph.find("gas"), std::string::npos);
  EXPECT_NE(with.plan().graph.find("wall_contact[c] -> gas_force[c] -> integrate[c]"), std::string::npos);
  EXPECT_EQ(checkpoint_bytes(without).find("gas"), std::string::npos);
  EXPECT_NE(checkpoint_bytes(with).find("part gas"), std::string::npos);
  for (const auto& a : without.plan().arrays) EXPECT_EQ(a.name.find("gas"), std::string::npos);
  ASSERT_EQ(with.part_grids().size(), 1U);
  EXPECT_EQ(with.part_grids()[0].first, "gas");
  EXPECT_NE(without.state_hash(), with.state_hash());
}

TEST(Gas, TheStepIsTimedWhereItIsMade) {
  Simulation sim(blown(hopper()), RunOptions{});
  sim.run(500);
  std::int64_t calls = 0;
  for (const NodeTime& n : sim.profile().nodes)
    if (n.node == "gas_step") calls = n.calls;
  EXPECT_EQ(calls, 10);
}

TEST(Gas, CellsThatAreTooSmallForTheGrainsAreRefused) {
  Scene s = blown(hopper());
  s.gas.cells = {1000, 1, 1};
  EXPECT_THROW(Simulation(s, RunOptions{}), Error);
}

}  // namespace
}  // namespace talus::determinism
