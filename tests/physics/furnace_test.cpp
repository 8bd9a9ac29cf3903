// Heat, conversion and gas of the same grains together: what one loses another gains, and the closed forms that need
// two of them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "core/base/error.hpp"
#include "core/gas/drag.hpp"
#include "core/gas/species.hpp"
#include "tests/part_values.hpp"
#include "tests/physics/physics_support.hpp"

namespace talus::physics {
namespace {

std::vector<double> column_of(const Simulation& sim, const std::string& name) {
  for (const ExtraColumn& c : sim.frame().extra)
    if (c.name == name) return c.values;
  ADD_FAILURE() << "no column " << name;
  return {};
}

std::string grain_file(const std::string& text) {
  static int n = 0;
  const std::string path =
      (std::filesystem::temp_directory_path() / fmt::format("talus-furnace-{}-{}.toml", getpid(), n++)).string();
  std::ofstream(path) << text;
  return path;
}

/// Matter that only conducts.
std::string inert(double density, double capacity, double conductivity) {
  return fmt::format(
      "[time]\nstep = 1\nduration = 1\n[grain]\ndiameter = 0.01\ntemperature = 300\n[material]\ndensity = {}\n"
      "emissivity = 0.8\n[heat_capacity]\nfuel = {}\n[conductivity]\nfuel = {}\n[surroundings]\ntemperature = 300\n",
      density, capacity, conductivity);
}

/// Wet wood that becomes char and gas, and burns.
std::string wood(double density) {
  return fmt::format(R"([time]
step = 1
duration = 1
[grain]
diameter = 0.01
temperature = 300
[material]
density = {}
moisture = 0.2
ash = 0.01
initial = {{ wood = 0.79 }}
emissivity = 0.9
[heat_capacity]
fuel = {{ polynomial = [1112, 4.85], origin = 273.15, range = [273, 900] }}
char = 1300
ash = 900
gas = 1100
[conductivity]
fuel = 0.15
wet = 0.25
char = 0.1
ash = 0.2
[[solid]]
name = "wood"
composition = {{ C = 0.5, H = 0.06, O = 0.44 }}
[[solid]]
name = "char"
kind = "char"
composition = {{ C = 1 }}
[[gas]]
name = "volatiles"
[[reaction]]
reactant = "wood"
products = {{ char = 0.2, volatiles = 0.8 }}
A = 1e8
E = 1.25e5
heat = 1e5
[drying]
law = "boiling"
[shrinkage]
drying = 0.05
devolatilisation = 0.3
burn_off = 0.9
[[char_reaction]]
oxidant = "O2"
A = 1.715
n = 1
E = 74830
[[char_reaction]]
oxidant = "H2O"
A = 3.42
n = 1
E = 129700
[surroundings]
gas = "air"
temperature = 300
)",
                     density);
}

constexpr double k_R = 5e-3;

/// 27 unequal fixed grains that touch, nearly touch or see each other; every third is of material 1.
std::vector<Grain> cluster() {
  std::vector<Grain> grains;
  for (int k = 0; k < 27; ++k) {
    Grain g;
    g.r = k_R * (0.8 + 0.2 * uniform(5, static_cast<std::uint64_t>(k)));
    g.x = {0.012 + 1.8 * k_R * (k % 3), 0.012 + 1.9 * k_R * (k / 3 % 3), 0.012 + 2.05 * k_R * (k / 9)};
    g.fixed = true;
    g.material = k % 3 == 0 ? 1 : 0;
    grains.push_back(g);
  }
  return grains;
}

/// Heat steps as steps; each grain of its own temperature.
Scene heat_scene(const std::vector<Grain>& grains, const std::vector<double>& T, double dt) {
  Scene s = open_scene({0, 0, 0}, {0.045, 0.045, 0.045}, dt);
  for (auto& axis : s.domain.boundary) axis = {Boundary::wall, Boundary::wall};
  s.allow_unstable_step = s.allow_initial_overlap = true;
  s.max_overlap = 1;
  linear_law(s, 1, 0);
  s.materials[0].density = 2700;
  s.heat.on = true;
  s.heat.every = 1;
  s.heat.temperature = 300;
  MatterHeat m;
  m.capacity = Curve::constant(900);
  m.conductivity = Curve::constant(20);
  s.heat.matter = {m};
  for (std::size_t k = 0; k < grains.size(); ++k) {
    add_grains(s, {grains[k]});
    s.heat.sources.push_back({T[T.size() == 1 ? 0 : k], false});
  }
  return s;
}

/// Material 1 converts as the text says.
void converts(Scene& s, double density, const std::string& text, int shells) {
  if (s.materials.size() < 2) {
    s.materials.push_back(Material{"grain", density});
    s.pairs.assign(4, s.pairs.front());
    s.heat.matter.push_back(s.heat.matter.front());
  }
  s.conversion.on = true;
  s.conversion.every = s.heat.every;
  s.conversion.shells = shells;
  s.conversion.grain = {"", grain_file(text)};
}

void fill_with_gas(Scene& s, std::array<int, 3> cells) {
  s.gas.on = true;
  s.gas.lower = s.domain.lower;
  s.gas.upper = s.domain.upper;
  s.gas.cells = cells;
  s.gas.every = s.heat.every;
}

// --- heat and conversion ---------------------------------------------------------------------------------------------

TEST(Furnace, SphereInGasWarmsAsTheSeriesSays) {
  // d 1 mm, k 0.12, rho 540, c 1800, h 350, 293 K in 773 K; at 0.5 s centre 481.78, surface 616.96 K
  double error[2] = {};
  for (int q = 0; q < 2; ++q) {
    Grain g;
    g.r = 5e-4;
    g.x = {0.02, 0.02, 0.02};
    g.fixed = true;
    g.material = 1;
    const int n = q == 0 ? 500 : 1000;
    Scene s = heat_scene({g}, {293}, 0.5 / n);
    converts(s, 540, inert(540, 1800, 0.12), q == 0 ? 16 : 32);
    s.heat.gas.on = true;
    s.heat.gas.film = 350;
    s.heat.gas.temperature = TimeTable::constant(773);
    Simulation sim(s, options());
    sim.run(n);
    const double surface = column_of(sim, "temperature")[0], centre = column_of(sim, "centre_temperature")[0];
    error[q] = std::fabs(surface - 616.96);
    figure("sphere in gas", surface - 616.96,
           fmt::format("surface, error [K], {} steps, {} shells", n, q == 0 ? 16 : 32));
    figure("sphere in gas", centre - 481.78, "centre, error [K]");
    EXPECT_NEAR(surface, 616.96, q == 0 ? 1.5 : 0.8);
    EXPECT_NEAR(centre, 481.78, q == 0 ? 1.5 : 0.8);
    EXPECT_NEAR(value_of(sim, "heat.into_shells"), value_of(sim, "heat.in_by_gas"), 1e-12);
    EXPECT_NEAR(value_of(sim, "heat.into_shells"), value_of(sim, "conversion.heat_in"),
                1e-12 * value_of(sim, "conversion.heat_in"));
  }
  EXPECT_LT(error[1], 0.7 * error[0]);
}

TEST(Furnace, ClosedBoxOfLumpedAndShelledGrainsKeepsItsEnergy) {
  std::vector<double> T;
  for (int k = 0; k < 27; ++k) T.push_back(300 + 900 * uniform(6, static_cast<std::uint64_t>(k)));
  Scene s = heat_scene(cluster(), T, 0.002);
  converts(s, 900, inert(900, 1500, 0.3), 10);
  s.heat.gap.conductivity = 0.06;
  s.heat.radiation.grains = true;
  Simulation sim(s, options());
  const auto energy = [&] { return value_of(sim, "heat.total") + value_of(sim, "conversion.heat"); };
  const double before = energy();
  sim.run(20000);
  figure("closed box of lumped and shelled grains", energy() / before - 1, "relative change over 2e4 heat steps");
  EXPECT_LT(std::fabs(energy() / before - 1), 1e-12);
  EXPECT_GT(std::fabs(value_of(sim, "heat.into_shells")), 1e-3 * before) << "heat has moved";
  EXPECT_GE(value_of(sim, "heat.lowest"), *std::min_element(T.begin(), T.end()));
  EXPECT_LE(value_of(sim, "heat.highest"), *std::max_element(T.begin(), T.end()));
}

TEST(Furnace, ShelledGrainsThatConductWellDoWhatLumpedOnesDo) {
  double T[2] = {};
  for (int q = 0; q < 2; ++q) {
    std::vector<Grain> two(2);
    for (int k = 0; k < 2; ++k) {
      two[static_cast<std::size_t>(k)].x = {0.01 + 1.99 * k_R * k, 0.02, 0.02};
      two[static_cast<std::size_t>(k)].r = k_R;
      two[static_cast<std::size_t>(k)].fixed = true;
      two[static_cast<std::size_t>(k)].material = k == 0 ? q : 0;
    }
    Scene s = heat_scene(two, {500, 300}, 0.01);
    if (q == 1) converts(s, 2700, inert(2700, 900, 20), 5);
    s.heat.matter[0].emissivity = 0.8;
    s.heat.radiation.enclosure = TimeTable::constant(600);
    Simulation sim(s, options());
    sim.run(1000);
    T[q] = column_of(sim, "temperature")[1];
  }
  EXPECT_GT(T[0], 320);
  EXPECT_NEAR(T[1], T[0], 0.02 * (T[0] - 300));
}

TEST(Furnace, HeatStepThatIsTooLongForTheSurfaceShellIsRefusedByName) {
  Grain g;
  g.r = 5e-4;
  g.x = {0.02, 0.02, 0.02};
  g.fixed = true;
  g.material = 1;
  // rho c dx^2 / k of a shell is 5.06 ms, and half of it behind half a shell, when the film is no obstacle
  Scene s = heat_scene({g}, {293}, 1e-4);
  converts(s, 540, inert(540, 1800, 0.12), 20);
  s.heat.every = s.conversion.every = 40;
  s.heat.gas.on = true;
  s.heat.gas.film = 1e5;
  s.heat.gas.temperature = TimeTable::constant(773);
  Simulation sim(s, options());
  try {
    sim.run(1000);
    FAIL() << "accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::physics);
    EXPECT_NE(std::string(e.what()).find("grain 0"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("heat.every = 2"), std::string::npos) << e.what();
  }
}

// --- gas and heat ----------------------------------------------------------------------------------------------------

TEST(Furnace, GasAndGrainsOfAClosedBoxShareTheirEnergy) {
  std::vector<double> T;
  for (int k = 0; k < 27; ++k) T.push_back(400 + 300 * uniform(6, static_cast<std::uint64_t>(k)));
  std::vector<Grain> grains = cluster();
  for (Grain& g : grains) g.material = 0;
  Scene s = heat_scene(grains, T, 0.002);
  fill_with_gas(s, {1, 1, 3});
  Simulation sim(s, options());
  sim.run(1);
  const auto energy = [&] {
    return value_of(sim, "heat.total") + (value_of(sim, "gas.enthalpy") - value_of(sim, "gas.pressure_work"));
  };
  double before = energy();
  double worst = 0;
  for (int k = 0; k < 400; ++k) {
    sim.run(1);
    worst = std::max(worst, std::fabs(energy() - before));
    before = energy();
  }
  figure("gas and grains in a closed box", worst / std::fabs(before),
         "largest relative change of the enthalpy in a step");
  EXPECT_LT(worst, 1e-10 * std::fabs(before));
  EXPECT_NEAR(value_of(sim, "heat.in_by_gas"), -value_of(sim, "gas.heat_from_grains"),
              1e-10 * value_of(sim, "gas.heat_from_grains"));
  EXPECT_GT(value_of(sim, "gas.temperature_min"), 350) << "the gas has warmed";
  EXPECT_LT(value_of(sim, "gas.temperature_max"), *std::max_element(T.begin(), T.end()));
}

TEST(Furnace, NusseltLawOfTheGasSaysWhatGrainsGetFromIt) {
  // a grain in still gas: 2 of Ranz and Marshall, and of Wakao; 7 - 10 e + 5 e^2 of Gunn
  Grain g;
  g.r = k_R;
  g.x = {0.0225, 0.0225, 0.0225};
  g.fixed = true;
  double heat[2] = {};
  for (int q = 0; q < 2; ++q) {
    Scene s = heat_scene({g}, {500}, 1e-6);
    s.domain.lower = {-0.1, -0.1, -0.1};
    s.domain.upper = {0.145, 0.145, 0.145};
    fill_with_gas(s, {1, 1, 1});
    s.gas.nusselt = q == 0 ? GasNusselt::ranz_marshall : GasNusselt::gunn;
    Simulation sim(s, options());
    sim.run(1);
    heat[q] = -value_of(sim, "heat.in_by_gas") / 1e-6;
  }
  const double k = gas::conductivity(GasFractions{0.233, 0, 0, 0, 0, 0, 0, 0.767}, 300);
  EXPECT_NEAR(heat[0], 2 * k / (2 * k_R) * 4 * k_pi * k_R * k_R * 200, 1e-4 * heat[0]);
  const double e = 1 - 4.0 / 3 * k_pi * std::pow(k_R / 0.245, 3);
  EXPECT_NEAR(heat[1] / heat[0], (7 - 10 * e + 5 * e * e) / 2, 1e-6);
}

/// Schumann (1929): 1 - J(Z, Y), temperature of the grains over that of the gas that comes in.
double schumann_solid(double Y, double Z) {
  const int n = 4000;
  double sum = 0;
  for (int k = 0; k < n; ++k) {
    const double y = Z * (k + 0.5) / n;
    sum += Z / n * std::exp(-Y - y) * std::cyl_bessel_i(0, 2 * std::sqrt(Y * y));
  }
  return sum;
}

TEST(Furnace, StepOfTheGasTemperatureRunsThroughABedAsSchumannSays) {
  EXPECT_NEAR(schumann_solid(1, 1), 0.345746, 1e-5);
  EXPECT_NEAR(schumann_solid(2, 4), 0.729961, 1e-5);
  // 3 x 3 columns of 40 grains, periodic across, in a wind of 3 m/s that has 5 K more than they; 10, 20, 40 cells
  constexpr double p = 0.01, d = 0.0098, dt = 0.1, end = 60;
  constexpr int k_high = 40;
  double error[3] = {};
  for (int q = 0; q < 3; ++q) {
    Scene s = heat_scene({}, {300}, dt);
    s.domain.upper = {3 * p, 3 * p, k_high * p};
    for (std::size_t axis : {0U, 1U}) s.domain.boundary[axis] = {Boundary::periodic, Boundary::periodic};
    std::vector<Grain> grains;
    for (int k = 0; k < 9 * k_high; ++k) {
      Grain g;
      g.x = {(k % 3 + 0.5) * p, (k / 3 % 3 + 0.5) * p, (k / 9 + 0.5) * p};
      g.r = 0.5 * d;
      g.fixed = true;
      grains.push_back(g);
    }
    add_grains(s, grains);
    s.heat.sources = {{300, false}};
    s.materials[0].density = 1000;
    s.heat.matter[0].capacity = Curve::constant(1000);
    fill_with_gas(s, {1, 1, 10 << q});
    s.gas.nusselt = GasNusselt::whitaker;
    GasInlet in, out;
    in.velocity = 3;
    in.temperature = 305;
    out.side = GasSide::top;
    out.kind = GasInlet::Kind::pressure;
    s.gas.inlets = {in, out};
    Simulation sim(s, options());
    sim.run(static_cast<std::int64_t>(end / dt));
    const GasFractions air = s.gas.fractions;
    const double e = 1 - k_pi / 6 * std::pow(d / p, 3), T = 302.5;
    const double flow = 3 * 101325 / (gas::specific_gas_constant(air) * 305);  // [kg/m2/s]
    const double re = flow * d / gas::viscosity(T);
    const double h = gas::nusselt(s.gas.nusselt, e, re, gas::k_prandtl) * gas::conductivity(air, T) / d;
    const double per_volume = h * k_pi * d * d / (p * p * p);
    const std::vector<double> solid = column_of(sim, "temperature");
    for (int k = 0; k < k_high; ++k) {
      const double Y = per_volume * (k + 0.5) * p / (flow * gas::heat_capacity(air, T));
      const double Z = per_volume * end / ((1 - e) * 1e6);
      error[q] =
          std::max(error[q], std::fabs((solid[static_cast<std::size_t>(9 * k)] - 300) / 5 - schumann_solid(Y, Z)));
    }
    figure("Schumann", error[q], fmt::format("largest error of the grains over the step, {} cells", 10 << q));
  }
  EXPECT_LT(error[2], 0.01);
  EXPECT_GT(std::log2(error[0] / error[1]), 0.8) << "first order in the cells";
}

// --- all three -------------------------------------------------------------------------------------------------------

/// Mass of elements C, H, O in what the grid holds [kg].
std::array<double, 3> elements_of(const GasFractions& mass) {
  static constexpr double weight[3] = {12.011e-3, 1.00794e-3, 15.9994e-3};
  std::array<double, 3> e{};
  for (int k = 0; k < k_gas_species; ++k)
    for (int q = 0; q < 3; ++q)
      e[static_cast<std::size_t>(q)] +=
          mass[static_cast<std::size_t>(k)] * gas::species(k).atoms[q] * weight[q] / gas::species(k).molar_mass;
  return e;
}

/// What grains have given to the gas, less what they took, by the books of conversion.
GasFractions given(const Simulation& sim) {
  GasFractions m{};
  for (int k = 0; k < k_gas_species; ++k)
    m[static_cast<std::size_t>(k)] = value_of(sim, "conversion.released_" + std::string(gas::species(k).name));
  m[0] -= value_of(sim, "conversion.oxygen_taken");
  m[3] -= value_of(sim, "conversion.steam_taken");
  return m;
}

Scene burning_box() {
  std::vector<double> T(27, 1300.0);
  std::vector<Grain> grains = cluster();
  for (std::size_t k = 0; k < grains.size(); ++k)
    if (grains[k].material == 1) T[k] = 320;
  Scene s = heat_scene(grains, T, 0.01);
  converts(s, 650, wood(650), 8);
  s.conversion.gone_below = 0.3;
  s.heat.gap.conductivity = 0.06;
  s.heat.radiation.grains = true;
  fill_with_gas(s, {1, 1, 3});
  s.gas.temperature = 900;
  s.gas.combustion = true;
  GasInlet in, out;
  in.velocity = 0.3;
  in.temperature = 1000;
  out.side = GasSide::top;
  out.kind = GasInlet::Kind::pressure;
  s.gas.inlets = {in, out};
  return s;
}

TEST(Furnace, ElementsAndEnthalpyOfGasAndBurningGrainsClose) {
  Simulation sim(burning_box(), options());
  const double mass = value_of(sim, "conversion.mass");
  sim.run(4000);
  EXPECT_LT(value_of(sim, "conversion.mass"), 0.6 * mass);
  EXPECT_GT(value_of(sim, "conversion.oxygen_taken"), 1e-4 * mass) << "char has burnt";
  const double scale = value_of(sim, "gas.mass_in") + mass;
  EXPECT_LT(std::fabs(value_of(sim, "gas.mass_residual")), 1e-10 * scale);
  EXPECT_LT(value_of(sim, "gas.element_residual"), 1e-10 * scale);
  EXPECT_LT(std::fabs(value_of(sim, "gas.enthalpy_residual")), 1e-10 * scale * 1e6);
  EXPECT_LT(std::fabs(value_of(sim, "conversion.mass_residual")), 1e-10 * mass);
  for (const char* e : {"carbon", "hydrogen", "oxygen", "ash", "water"})
    EXPECT_LT(std::fabs(value_of(sim, std::string("conversion.") + e + "_residual")), 1e-12 * mass) << e;
  // what grains have given by their books is what the gas has got by its own
  const GasFractions m = given(sim);
  double sum = 0;
  for (const double x : m) sum += x;
  EXPECT_NEAR(value_of(sim, "gas.mass_from_grains"), sum, 1e-12 * mass);
  // and its elements are those that the solids have lost
  const std::array<double, 3> e = elements_of(m);
  const double water = value_of(sim, "conversion.gone_water"), h = 2 * 1.00794 / 18.01528;
  EXPECT_NEAR(e[0], value_of(sim, "conversion.gone_carbon"), 1e-12 * mass);
  EXPECT_NEAR(e[1], value_of(sim, "conversion.gone_hydrogen") + h * water, 1e-12 * mass);
  EXPECT_NEAR(e[2], value_of(sim, "conversion.gone_oxygen") + (1 - h) * water, 1e-12 * mass);
  EXPECT_NEAR(value_of(sim, "heat.in_by_gas"), -value_of(sim, "gas.heat_from_grains"),
              1e-10 * std::fabs(value_of(sim, "gas.heat_from_grains")) + 1e-12);
  EXPECT_LT(std::fabs(value_of(sim, "heat.residual")), 1e-11 * value_of(sim, "heat.total"));
  EXPECT_LT(std::fabs(value_of(sim, "conversion.heat_residual")),
            1e-10 * (std::fabs(value_of(sim, "conversion.heat_in")) + 1));
  figure("burning box", value_of(sim, "gas.temperature_max"), "highest temperature of the gas [K]");
}

/// Grains, gas and what reactions set free, by columns of the series.
/// In a closed box: the gas's enthalpy less what its rising pressure has done, which is inner energy.
double all_energy(const Simulation& sim) {
  return value_of(sim, "heat.total") + value_of(sim, "conversion.heat") + value_of(sim, "conversion.formation") +
         (value_of(sim, "gas.enthalpy") - value_of(sim, "gas.pressure_work"));
}

TEST(Furnace, EnergyOfAClosedBoxOfBurningGrainsAndGasStays) {
  for (const bool at_298 : {false, true}) {
    Scene s = burning_box();
    std::string text = wood(650);
    if (at_298) text.insert(text.find("emissivity"), "reference_temperature = 298.15\n");
    text.replace(text.find("initial = { wood = 0.79 }"), 25, "initial = { wood = 0.5, char = 0.29 }");
    converts(s, 650, text, 8);
    s.gas.inlets.clear();
    s.gas.combustion = !at_298;  // without it the oxygen is left to the char
    s.gas.fractions = {0.5, 0, 0, 0, 0, 0, 0, 0.5};
    s.conversion.gone_below = 0;
    Simulation sim(s, options());
    sim.run(1);
    const double before = all_energy(sim), mass = value_of(sim, "conversion.mass");
    sim.run(4000);
    EXPECT_LT(value_of(sim, "conversion.mass"), 0.7 * mass) << "wet wood has dried and given off its gas";
    if (at_298) {
      EXPECT_GT(value_of(sim, "conversion.oxygen_taken"), 1e-3 * mass) << "char has burnt";
    }
    const double passed = std::fabs(value_of(sim, "gas.enthalpy_from_grains"));
    figure("closed box of burning grains and gas", (all_energy(sim) - before) / passed,
           fmt::format("change of all energy / {:.3g} J that the gas got from grains, {}", passed,
                       at_298 ? "heats at 298.15 K" : "heats at the temperature of reaction, gas burns"));
    EXPECT_LT(std::fabs(all_energy(sim) - before), 1e-9 * passed);
    EXPECT_LT(std::fabs(value_of(sim, "gas.enthalpy_residual")), 1e-9 * passed);
  }
}

TEST(Furnace, ReleasedGasComesAtTheTemperatureOfItsGrain) {
  // hot inert grains drive water, then volatiles out of the others; nothing burns, so that no gas is hotter or colder
  for (const char* reference : {"", "reference_temperature = 298.15\n"}) {
    Scene s = burning_box();
    std::string text = wood(650);
    text.replace(text.find("emissivity = 0.9\n"), 17, std::string("emissivity = 0.9\n") + reference);
    converts(s, 650, text, 8);
    s.gas.inlets.erase(s.gas.inlets.begin());
    s.gas.combustion = false;
    s.gas.temperature = 600;
    s.gas.fractions = {0, 0, 0, 0, 0, 0, 0, 1};
    Simulation sim(s, options());
    double low = 1e9, high = 0;
    for (int k = 0; k < 40; ++k) {
      sim.run(100);
      low = std::min(low, value_of(sim, "gas.temperature_min"));
      high = std::max(high, value_of(sim, "gas.temperature_max"));
    }
    figure("released gas", low, "lowest temperature of the gas [K]");
    figure("released gas", high, "highest [K]");
    EXPECT_GT(low, 320);
    EXPECT_LT(high, 1300);
  }
}

TEST(Furnace, CharAloneBurnsInTheGas) {
  // matter of one solid, pure carbon
  std::string text = wood(650);
  const auto cut = [&](const char* from, const char* to) {
    const std::size_t at = text.find(from);
    text.erase(at, text.find(to) - at);
  };
  cut("moisture = 0.2", "emissivity");
  cut("[[solid]]", "[[char_reaction]]");
  text.insert(text.find("[[char_reaction]]"), "[[solid]]\nname = \"char\"\nkind = \"char\"\n");
  text.insert(text.find("emissivity"), "initial = { char = 1 }\n");
  Scene s = burning_box();
  converts(s, 650, text, 8);
  s.gas.inlets.clear();
  s.conversion.gone_below = 0;
  Simulation sim(s, options());
  sim.run(1);
  const double before = all_energy(sim);
  sim.run(1000);
  EXPECT_GT(value_of(sim, "conversion.oxygen_taken"), 0);
  EXPECT_LT(std::fabs(all_energy(sim) - before), 1e-9 * std::fabs(value_of(sim, "gas.enthalpy_from_grains")));
}

TEST(Furnace, SchemesOfParallelReactionsKeepElementsAndEnergyBesideGas) {
  // wood becomes gas, tar or char, each alone: char then holds hydrogen and oxygen, which leave as it burns
  std::string text = wood(650);
  const std::size_t from = text.find("[[solid]]");
  text.erase(from, text.find("[drying]") - from);
  text.replace(text.find("initial = { wood = 0.79 }"), 25, "");
  Scene s = burning_box();
  converts(s, 650, "scheme = \"thurner_mann\"\n" + text, 8);
  s.gas.inlets.clear();
  s.gas.combustion = false;
  s.gas.fractions = {0.5, 0, 0, 0, 0, 0, 0, 0.5};
  s.conversion.gone_below = 0;
  Simulation sim(s, options());
  sim.run(1);
  const double before = all_energy(sim), mass = value_of(sim, "conversion.mass");
  sim.run(4000);
  EXPECT_LT(value_of(sim, "conversion.mass"), 0.7 * mass);
  EXPECT_GT(value_of(sim, "conversion.char"), 0.02 * mass);
  EXPECT_GT(value_of(sim, "conversion.oxygen_taken"), 1e-3 * mass) << "char has burnt";
  EXPECT_LT(std::fabs(all_energy(sim) - before), 1e-9 * std::fabs(value_of(sim, "gas.enthalpy_from_grains")));
  EXPECT_LT(value_of(sim, "gas.element_residual"), 1e-12 * mass);
  const std::array<double, 3> e = elements_of(given(sim));
  const double water = value_of(sim, "conversion.gone_water"), h = 2 * 1.00794 / 18.01528;
  EXPECT_NEAR(e[0], value_of(sim, "conversion.gone_carbon"), 1e-12 * mass);
  EXPECT_NEAR(e[1], value_of(sim, "conversion.gone_hydrogen") + h * water, 1e-12 * mass);
  EXPECT_NEAR(e[2], value_of(sim, "conversion.gone_oxygen") + (1 - h) * water, 1e-12 * mass);
}

TEST(Furnace, GrainsCannotTakeMoreOxygenThanTheirCellsHold) {
  // hot char in little air without inlets: the oxygen is used up, and not a molecule more
  std::vector<double> T(27, 1400.0);
  std::vector<Grain> grains = cluster();
  for (Grain& g : grains) g.material = 1;
  Scene s = heat_scene(grains, T, 0.01);
  std::string text = wood(650);
  text.replace(text.find("moisture = 0.2"), 14, "moisture = 0.0");
  text.replace(text.find("[drying]"), 24, "");
  text.replace(text.find("initial = { wood = 0.79 }"), 25, "initial = { char = 0.99 }");
  converts(s, 650, text, 8);
  fill_with_gas(s, {1, 1, 3});
  s.gas.temperature = 1400;
  Simulation sim(s, options());
  sim.run(1);
  const double there = 0.233 * 101325 / (gas::specific_gas_constant(s.gas.fractions) * 1400);
  double solid = 0;
  for (const Grain& g : grains) solid += 4.0 / 3 * k_pi * g.r * g.r * g.r;
  const double oxygen = there * (std::pow(0.045, 3) - solid);
  sim.run(400);
  const double taken = value_of(sim, "conversion.oxygen_taken");
  EXPECT_LT(taken, (1 + 1e-9) * oxygen);
  EXPECT_GT(taken, 0.9 * oxygen);
  EXPECT_LT(std::fabs(value_of(sim, "gas.mass_residual")), 1e-12);
}

}  // namespace
}  // namespace talus::physics
