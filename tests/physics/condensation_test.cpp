// Steam that condenses on cold wet grains: what comes, what it keeps, where it ends, and that no step is too long for
// it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/conversion/film.hpp"
#include "core/conversion/grain_file.hpp"
#include "core/gas/species.hpp"
#include "core/scene/scene_file.hpp"
#include "tests/part_values.hpp"
#include "tests/physics/physics_support.hpp"

namespace talus::physics {
namespace {

constexpr double k_d = 0.004, k_density = 700, k_moisture = 0.3;
constexpr double k_grain = 3.14159265358979324 / 6 * k_d * k_d * k_d;
constexpr double k_slope = 2.2569e6 * 0.018015 / 8.31446261815324;  // of the drying law's saturation
const GasFractions k_moist{0, 0, 0, 0.3, 0, 0, 0, 0.7};

double saturation(double T) { return 101325 * std::exp(k_slope / 373.15 - k_slope / T); }

std::string file(const std::string& name, const std::string& text) {
  const std::string path =
      (std::filesystem::temp_directory_path() / fmt::format("talus-dew-{}-{}", getpid(), name)).string();
  std::ofstream(path) << text;
  return path;
}

/// Moist wood that does nothing but dry and get wet.
std::string wood(const std::string& law, const std::string& more = "") {
  return fmt::format(
      "[time]\nstep = 1\nduration = 1\n[grain]\ndiameter = {}\ntemperature = 300\n[material]\ndensity = {}\n"
      "moisture = {}\n{}[drying]\nlaw = \"{}\"\n[heat_capacity]\nfuel = 1500\n[conductivity]\nfuel = 0.2\nwet = 0.4\n"
      "[surroundings]\ngas = \"nitrogen\"\ntemperature = 300\n",
      k_d, k_density, k_moisture, more, law);
}

/// Eight fixed grains of 300 K in a sealed cube of steam and nitrogen of 370 K, every other from a source of its own;
/// heat, conversion and gas at every step. `gas`: another one; `start`: temperature of the grains [K].
Scene box(double dt, const std::string& grain, double side = 0.02, int cells = 2,
          const std::string& gas = "temperature = 370\nfractions = [0, 0, 0, 0.3, 0, 0, 0, 0.7]", double start = 300) {
  std::string rows[2] = {"x,y,z,diameter,fixed\n", "x,y,z,diameter,fixed\n"};
  const double at[2] = {side / 4 + 0.002 * (side > 0.015), 3 * side / 4 - 0.002 * (side > 0.015)};
  for (int k = 0; k < 8; ++k) rows[k % 2] += fmt::format("{},{},{},{},1\n", at[k % 2], at[k / 2 % 2], at[k / 4], k_d);
  return parse_scene(
      fmt::format(
          "domain = {{ lower = [0, 0, 0], upper = [{0}, {0}, {0}] }}\ntime = {{ step = {1}, steps = 100000 }}\n"
          "checks = {{ allow_unstable_step = true }}\n[contact]\nnormal_stiffness = 1\nrestitution = 1\nfriction = 0\n"
          "[[source]]\nkind = \"file\"\nfile = \"{2}\"\n[[source]]\nkind = \"file\"\nfile = \"{3}\"\n[heat]\n"
          "temperature = {8}\nevery = 1\n[conversion]\nevery = 1\nshells = 5\nresize = false\n[gas]\n"
          "cells = [{4}, {4}, {4}]\nevery = 1\nnusselt = \"wakao\"\n{7}\n[[material]]\nname = \"m\"\n"
          "density = {5}\ngrain = \"{6}\"\n",
          side, dt, file("0.csv", rows[0]), file("1.csv", rows[1]), cells, k_density, file("wood.toml", grain), gas,
          start),
      "dew", "/");
}

double energy(const Simulation& sim) {
  return value_of(sim, "heat.total") + value_of(sim, "conversion.heat") + value_of(sim, "conversion.formation") +
         (value_of(sim, "gas.enthalpy") - value_of(sim, "gas.pressure_work"));
}
double room(double side) { return side * side * side - 8 * k_grain; }
double steam_at_first(double side = 0.02) {
  return 0.3 * 101325 / (gas::specific_gas_constant(k_moist) * 370) * room(side);
}

TEST(Condensation, KeepsWaterAndEnergyAndSaysNothingMore) {
  for (const std::string more : {"", "reference_temperature = 298.15\n"}) {
    Simulation sim(box(0.01, wood("equilibrium", more)), RunOptions{});
    sim.run(1);
    const double before = energy(sim), mass = value_of(sim, "conversion.mass");
    const double water = value_of(sim, "conversion.moisture") - value_of(sim, "conversion.steam_taken");
    sim.run(2000);
    const double got = value_of(sim, "conversion.steam_taken"), passed = got * 2.6e6;
    EXPECT_GT(got, 0.5 * steam_at_first()) << "most of the steam is on the grains";
    EXPECT_LT(std::fabs(value_of(sim, "conversion.moisture") - got + value_of(sim, "conversion.released_H2O") - water),
              1e-12 * mass);
    EXPECT_LT(std::fabs(value_of(sim, "conversion.mass_residual")), 1e-12 * mass);
    EXPECT_LT(std::fabs(value_of(sim, "conversion.water_residual")), 1e-12 * mass);
    EXPECT_LT(std::fabs(value_of(sim, "gas.mass_residual")), 1e-12 * steam_at_first());
    EXPECT_LT(value_of(sim, "gas.element_residual"), 1e-12 * steam_at_first());
    EXPECT_LT(std::fabs(energy(sim) - before), 1e-12 * std::max(passed, std::fabs(value_of(sim, "gas.enthalpy"))));
    EXPECT_LT(std::fabs(value_of(sim, "conversion.heat_residual")), 1e-12 * value_of(sim, "conversion.heat"));
    for (const Warning& w : sim.warnings()) EXPECT_EQ(w.text.find("grains of 3"), std::string::npos) << w.text;
    figure("condensation", (energy(sim) - before) / passed, "change of all energy / heat of what condensed");
  }
}

TEST(Condensation, BeginsAtTheRateOfTheFilm) {
  const double dt = 1e-4;
  Simulation sim(box(dt, wood("equilibrium")), RunOptions{});
  sim.run(1);
  // fluxes of a film without flow (Sh = Nu = 2) at its mean temperature; saturated above 300 K by the law of drying
  const conversion::Film f =
      conversion::film_of(conversion::k_nitrogen, conversion::FilmLaw::ranz_marshall, k_d, 0, 370, 300, 101325);
  const double h = 2 * gas::conductivity(k_moist, 370) / k_d;
  const double saturated = saturation(300);
  const double steam = gas::steam_pressure(k_moist, 101325);
  const double rho = 101325 / (gas::specific_gas_constant(k_moist) * 335);
  const double flux = f.mass * h / f.heat * rho * 0.3 * (1 - saturated / steam);
  const double wanted = 8 * 3.14159265358979324 * k_d * k_d * flux * dt;
  figure("condensation, first step", value_of(sim, "conversion.steam_taken") / wanted - 1, "of the film's rate");
  EXPECT_NEAR(value_of(sim, "conversion.steam_taken"), wanted, 0.01 * wanted);
}

/// In the narrow cube the film could take many times the steam that there is in half a second.
TEST(Condensation, EndsWhereSteamIsSaturatedWhateverTheStep) {
  for (const double side : {0.02, 0.0082}) {
    double finest = 0;
    for (const double dt : {0.02, 0.1, 0.5}) {
      Simulation sim(box(dt, wood("equilibrium"), side), RunOptions{});
      double high = 0, got = 0;
      for (double t = 0; t < 40; t += 10 * dt) {
        sim.run(10);
        high = std::max({high, value_of(sim, "heat.highest"), value_of(sim, "gas.temperature_max")});
        const double now = value_of(sim, "conversion.steam_taken");
        EXPECT_GE(now, got);
        got = now;
      }
      EXPECT_LT(high, 370 + 1e-9) << dt << ": nothing gets hotter than what was hottest";
      EXPECT_EQ(value_of(sim, "conversion.released_H2O"), 0) << dt << ": what came stays";
      const double T = value_of(sim, "gas.temperature_max");
      const double pressure = (steam_at_first(side) - got) * 8.31446261815324 / 0.01801528 * T / room(side);
      figure("condensation, end", pressure / saturation(T) - 1,
             fmt::format("of saturation at {:.2f} K, steps of {} s, {} m", T, dt, side));
      EXPECT_NEAR(value_of(sim, "heat.highest"), T, 0.05);
      EXPECT_NEAR(pressure, saturation(T), 1e-4 * saturation(T)) << dt;
      if (finest == 0) finest = got;
      EXPECT_NEAR(got, finest, 0.01 * finest) << dt;
    }
  }
}

/// Gases from 2 to 44 g/mol, which the grain file calls nitrogen.
struct Bath {
  const char* name;
  GasFractions y;
  std::string text(double temperature) const {
    std::string list;
    for (const double x : y) list += fmt::format("{}{}", list.empty() ? "" : ", ", x);
    return fmt::format("temperature = {}\nfractions = [{}]", temperature, list);
  }
};
const Bath k_baths[] = {{"H2", {0.02, 0, 0, 0, 0.98, 0, 0, 0}},
                        {"N2", {0.02, 0, 0, 0, 0, 0, 0, 0.98}},
                        {"CO2", {0.02, 0.98, 0, 0, 0, 0, 0, 0}}};

TEST(GasAroundGrains, DryingEndsWhereSteamIsSaturatedInEveryGas) {
  for (const Bath& bath : k_baths) {
    Simulation sim(box(0.1, wood("equilibrium"), 0.02, 2, bath.text(320), 330), RunOptions{});
    sim.run(6000);
    const double steam = value_of(sim, "conversion.released_H2O") - value_of(sim, "conversion.steam_taken");
    const double T = value_of(sim, "gas.temperature_max"),
                 pressure = steam * 8.31446261815324 / 0.01801528 * T / room(0.02);
    figure("drying, end", pressure / saturation(T) - 1, fmt::format("of saturation at {:.2f} K in {}", T, bath.name));
    EXPECT_GT(steam, 1e-7);
    EXPECT_NEAR(value_of(sim, "heat.highest"), T, 1e-3) << bath.name << ": no heat goes round in circles";
    EXPECT_NEAR(pressure, saturation(T), 1e-3 * saturation(T)) << bath.name;
  }
}

TEST(GasAroundGrains, CharTakesOxygenByItsConcentrationInEveryGas) {
  constexpr double k_rate = 0.01, dt = 1e-5, area = 3.14159265358979324 * k_d * k_d;  // [m/s], [s], [m2]
  const std::string coal = fmt::format(
      "[time]\nstep = 1\nduration = 1\n[grain]\ndiameter = {}\ntemperature = 1000\n[material]\ndensity = {}\n"
      "initial = {{ char = 1 }}\nblowing = false\n[heat_capacity]\nfuel = 1500\n[conductivity]\nfuel = 5\n[[solid]]\n"
      "name = \"char\"\nkind = \"char\"\ncomposition = {{ C = 1 }}\n[[char_reaction]]\nA = {}\nn = 0\nE = 0\n"
      "ratio_A = 0\n[surroundings]\ngas = \"nitrogen\"\ntemperature = 1000\noxygen = 0.02\n",
      k_d, k_density, k_rate);
  for (const Bath& bath : k_baths) {
    Simulation sim(box(dt, coal, 0.02, 2, bath.text(1000), 1000), RunOptions{});
    sim.run(1);
    const double rho = 101325 / (gas::specific_gas_constant(bath.y) * 1000);
    const conversion::Film f =
        conversion::film_of(conversion::k_nitrogen, conversion::FilmLaw::wakao, k_d, 0, 1000, 1000, 101325);
    const double film = f.mass * (2 * gas::conductivity(bath.y, 1000) / k_d) / f.heat;
    const double wanted = 8 * area * rho * 0.02 * dt / (1 / k_rate + 1 / film);
    figure("char in " + std::string(bath.name), value_of(sim, "conversion.oxygen_taken") / wanted - 1, "of the rate");
    EXPECT_NEAR(value_of(sim, "conversion.oxygen_taken"), wanted, 2e-3 * wanted) << bath.name;
  }
}

TEST(GasAroundGrains, OfGivenFractionsIsTheMixture) {
  using conversion::mixture_molar;
  EXPECT_NEAR(mixture_molar(0, 0, 0.302, 0.028013), 1 / (0.302 / 0.018015 + 0.698 / 0.028013), 1e-12);
  EXPECT_NEAR(mixture_molar(0.233, 0, 0, conversion::k_air.inert), conversion::k_air.molar, 2e-6);
  const auto around = [](const std::string& surroundings) {
    const std::string text = wood("equilibrium");
    return conversion::parse_grain(text.substr(0, text.find("[surroundings]")) + "[surroundings]\n" + surroundings, "g")
        .around;
  };
  // partial pressure of steam, whatever the rest is
  for (const char* gas : {"air", "nitrogen"}) {
    const auto a = around(fmt::format("gas = \"{}\"\ntemperature = 350\nsteam = 0.302\n", gas));
    const double other = std::string(gas) == "air" ? 0.028965 : 0.028013,
                 share = 0.302 / 0.018015 / (0.302 / 0.018015 + 0.698 / other);
    EXPECT_NEAR(a.gas_at(0, 0.002, 350).vapour, share * 101325 * 0.018015 / (8.31446261815324 * 350), 1e-6) << gas;
  }
}

TEST(Condensation, WarmGrainsAndOtherLawsTakeNone) {
  Scene warm = box(0.01, wood("equilibrium"));
  for (SourceHeat& h : warm.heat.sources) h.temperature = 369;
  for (Scene s : {warm, box(0.01, wood("boiling")), box(0.01, wood("arrhenius"))}) {
    Simulation sim(s, RunOptions{});
    sim.run(50);
    EXPECT_EQ(value_of(sim, "conversion.steam_taken"), 0);
    EXPECT_LE(value_of(sim, "conversion.moisture"), 8 * k_grain * k_density * k_moisture * (1 + 1e-12));
  }
}

TEST(Condensation, ColdAndWarmGrainsOfOneCellShareItsSteam) {
  Scene s = box(0.5, wood("equilibrium"), 0.0082, 1);
  s.heat.sources[1].temperature = 340;  // dew comes at 348 K, but the cold ones leave the warm ones none
  Simulation sim(s, RunOptions{});
  sim.run(1);
  const double took = value_of(sim, "conversion.steam_taken");
  EXPECT_GT(took, 0.5 * steam_at_first(0.0082));
  // implicit: not below what is in balance with the coldest surface
  const double T = value_of(sim, "gas.temperature_max");
  const double pressure = (steam_at_first(0.0082) - took) * 8.31446261815324 / 0.01801528 * T / room(0.0082);
  EXPECT_GT(pressure, saturation(300));
  std::vector<double> water;
  for (const ExtraColumn& c : sim.frame().extra)
    if (c.name == "moisture") water = c.values;
  ASSERT_EQ(water.size(), 8u);
  const double first = k_grain * k_density * k_moisture;
  int wetter = 0;
  for (const double w : water) wetter += w > first * (1 + 1e-9);
  EXPECT_EQ(wetter, 4);
}

}  // namespace
}  // namespace talus::physics
