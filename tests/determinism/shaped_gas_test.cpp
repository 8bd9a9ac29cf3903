// Gas among clumps, superquadrics and spheres that dry, char and burn in it: books close, the same bits for every way
// of running, exact across a resume.
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.hpp"
#include "core/scene/scene_file.hpp"
#include "scheduler/step/access.hpp"
#include "tests/determinism/charring_wood.hpp"
#include "tests/determinism/part_final.hpp"
#include "tests/determinism/shaped_bed.hpp"

namespace talus::determinism {
namespace {

const std::string k_wood = k_charring_wood + R"([[char_reaction]]
oxidant = "H2O"
A = 34.2
n = 1
E = 129700
)",
                  k_surroundings = "[surroundings]\ngas = \"air\"\ntemperature = 300\n";

/// Without water, which would boil off hot grains at once.
std::string dry(std::string wood) {
  for (const auto& [from, to] : {std::pair{"moisture = 0.1", "moisture = 0"}, {"char = 0.38", "char = 0.48"}})
    wood.replace(wood.find(from), std::string(from).size(), to);
  return wood;
}

constexpr std::int64_t k_run = 900;  // with three sort epochs

/// `inlets`: sections of [[gas.inlet]].
Scene furnace(const std::string& wood, double grains, const std::string& gas, const std::string& inlets,
              double gone_below = 0) {
  const std::string parts = fmt::format(
      "[heat]\ntemperature = {}\ncapacity = 800\nconductivity = 2\nevery = 20\nfriction = true\n[heat.radiation]\n"
      "enclosure = 1300\n[[heat.wall]]\nwall = \"domain_z_lower\"\ntemperature = 1100\n[conversion]\nevery = 20\n"
      "shells = 6\ngone_below = {}\n[gas]\ncells = [4, 3, 6]\nevery = 20\ncombustion = true\n{}\n{}",
      grains, gone_below, gas, inlets);
  return parse_scene(bed_text(parts, "grain = \"" + grain_file(wood + k_surroundings) + "\"", k_law), "shaped gas", "",
                     {});
}

constexpr const char* k_blown =
    "[[gas.inlet]]\nside = \"bottom\"\nvelocity = 0.8\ntemperature = 1100\n[[gas.inlet]]\nside = \"top\"\nkind = "
    "\"pressure\"\n";

Scene burning(double gone_below = 0) { return furnace(dry(k_wood), 640, "temperature = 1400", k_blown, gone_below); }

void expect_closed_books(const Simulation& sim) {
  const double mass = value_of(sim, "conversion.mass"), gas = mass + value_of(sim, "gas.mass_in");
  EXPECT_LT(std::fabs(value_of(sim, "conversion.mass_residual")), 1e-12 * mass);
  for (const char* element : {"carbon", "hydrogen", "oxygen", "ash", "water"})
    EXPECT_LT(std::fabs(value_of(sim, fmt::format("conversion.{}_residual", element))), 1e-12 * mass) << element;
  EXPECT_LT(std::fabs(value_of(sim, "conversion.heat_residual")), 1e-12 * value_of(sim, "conversion.heat"));
  EXPECT_LT(std::fabs(value_of(sim, "heat.residual")), 1e-12 * value_of(sim, "conversion.heat"));
  EXPECT_NEAR(value_of(sim, "heat.into_shells") / value_of(sim, "conversion.heat_in"), 1, 1e-12);
  EXPECT_LT(std::fabs(value_of(sim, "gas.mass_residual")), 1e-12 * gas);
  EXPECT_LT(value_of(sim, "gas.element_residual"), 1e-12 * gas);
  EXPECT_LT(std::fabs(value_of(sim, "gas.enthalpy_residual")), 1e-12 * gas * 1e6);
  // what all spheres of the grains have released, less what they have taken, is what the gas has got
  double released = 0;
  for (const PartValue& v : sim.part_values())
    if (v.name.starts_with("conversion.released_")) released += v.value;
  for (const char* taken : {"oxygen", "carbon_dioxide", "steam"})
    released -= value_of(sim, fmt::format("conversion.{}_taken", taken));
  EXPECT_NEAR(value_of(sim, "gas.mass_from_grains") / released, 1, 1e-12);
}

TEST(ShapedGas, DependsOnTheTrajectoryAloneAndItsBooksClose) {
  const Scene s = burning();
  const Variant plain{ListPolicy::local, 200, 1, 0, Isa::automatic};
  Simulation first(plain.apply(s), plain.options());
  first.run(k_run);
  const double mass = value_of(first, "conversion.mass");
  EXPECT_GT(first.counters().contacts, 5);
  EXPECT_GT(first.counters().inserted, 50);
  EXPECT_GT(value_of(first, "conversion.oxygen_taken"), 1e-6 * mass);
  EXPECT_GT(value_of(first, "conversion.released_CO"), 1e-6 * mass);
  EXPECT_GT(value_of(first, "gas.force_z"), 0);
  expect_closed_books(first);
  expect_same_in_other_ways(s, k_run, final_of(first));
}

TEST(ShapedGas, ResumeGoesOnToTheBitWhileBodiesComeShrinkAndGo) {
  expect_same_after_resume(burning(0.9996), k_run, {10, 333, 727});
}

TEST(ShapedGas, SteamCondensesOnColdBodies) {
  const Scene s = furnace(k_wood + "[drying]\nlaw = \"equilibrium\"\n", 300,
                          "temperature = 365\nfractions = [0.1, 0, 0, 0.3, 0, 0, 0, 0.6]", "");
  const Variant plain{ListPolicy::local, 200, 1, 0, Isa::automatic};
  Simulation first(plain.apply(s), plain.options());
  first.run(k_run);
  EXPECT_GT(value_of(first, "conversion.steam_taken"), 1e-6 * value_of(first, "conversion.mass"));
  expect_closed_books(first);
  expect_same_in_other_ways(s, k_run, final_of(first));
}

/// Sealed, without walls that heat and sources to come: grains and gas have their energy and mass for themselves.
TEST(ShapedGas, ASealedBoxKeepsMassAndEnergyOfGrainsAndGas) {
  Scene s = furnace(dry(k_wood), 640, "temperature = 1400", "");
  std::erase_if(s.sources, [](const Source& q) { return q.kind == Source::Kind::stream; });
  s.heat.sources.erase(s.heat.sources.begin() + 1);
  s.heat.walls.clear();
  s.heat.radiation = {};
  s.heat.friction = false;
  for (auto& axis : s.domain.boundary) axis = {Boundary::wall, Boundary::wall};
  Simulation sim(s, {});
  sim.run(20);
  const auto mass = [&] { return value_of(sim, "conversion.mass") + value_of(sim, "gas.mass_from_grains"); };
  const auto energy = [&] {
    return value_of(sim, "conversion.heat") + value_of(sim, "gas.enthalpy") - value_of(sim, "gas.pressure_work") +
           value_of(sim, "conversion.formation");
  };
  const double m = mass(), e = energy(), fuel = value_of(sim, "conversion.fuel");
  sim.run(880);
  EXPECT_LT(value_of(sim, "conversion.fuel"), (1 - 1e-4) * fuel);
  EXPECT_NEAR(mass() / m, 1, 1e-12);
  EXPECT_NEAR((energy() - e) / value_of(sim, "conversion.heat"), 0, 1e-12);
  expect_closed_books(sim);
}

TEST(ShapedGas, BooksCloseWhileBurntOutBodiesLeave) {
  Simulation sim(burning(0.9996), {});
  sim.run(k_run);
  EXPECT_GT(sim.counters().removed, 100);
  EXPECT_GT(sim.particles(), 30);
  expect_closed_books(sim);
}

}  // namespace
}  // namespace talus::determinism
