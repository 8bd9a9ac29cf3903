// Grains at the ends of what a grain file may say: other pressures, fuel without ash, starts within a range of melting,
// shrinkage of what is not there.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <sstream>
#include <string>
#include <vector>

#include "core/base/error.hpp"
#include "core/conversion/grain.hpp"
#include "core/conversion/grain_run.hpp"

namespace talus::conversion {
namespace {

/// The last value of a column of the table.
double last(const std::string& table, const std::string& column) {
  std::istringstream in(table);
  std::string line, cell, end;
  std::getline(in, line);
  std::size_t at = 0, k = 0;
  for (std::istringstream names(line); std::getline(names, cell, ','); ++k)
    if (cell == column) at = k + 1;
  if (at == 0) ADD_FAILURE() << column << " is no column of " << line;
  while (std::getline(in, line))
    if (!line.empty()) end = line;
  std::istringstream row(end);
  for (k = 0; k < at; ++k) std::getline(row, cell, ',');
  return std::stod(cell);
}

double end_of(const std::string& text, const char* column) {
  return last(grain_table(parse_grain(text, "g.toml")), column);
}

std::string refusal(const std::string& text) {
  try {
    parse_grain(text, "g.toml");
  } catch (const Error& e) {
    return e.what();
  }
  return "accepted";
}

std::string ball_of_char(const std::string& surroundings,
                         const std::string& ash = "initial = { c = 0.95 }\nash = 0.05\n") {
  return "[time]\nstep = 0.5\nduration = 20\noutput_every = 5\n[grain]\ndiameter = 0.004\ntemperature = 1200\n"
         "[material]\ndensity = 300\n" +
         ash +
         "blowing = false\n[heat_capacity]\nfuel = 1500\n[conductivity]\nfuel = 100\n[[solid]]\nname = \"c\"\nkind = "
         "\"char\"\n"
         "[[char_reaction]]\nA = 50\nn = 0\nE = 0\n[surroundings]\ntemperature = 1200\noxygen = 0.05\n" +
         surroundings;
}

/// A film lets rho D of oxygen through, which no pressure changes (rho ~ p, D ~ 1/p). Ash and kinetics add a little.
TEST(GrainPressure, FilmLimitedBurningDoesNotDependOnIt) {
  const std::string held = "contact_conductance = 100\ncontact_temperature = 1200\n";
  const double one = end_of(ball_of_char(held), "oxygen_taken"),
               ten = end_of(ball_of_char(held + "pressure = 1013250\n"), "oxygen_taken");
  EXPECT_GT(ten, one);  // kinetics have ten times the oxygen
  EXPECT_LT(ten, 1.15 * one);
  EXPECT_EQ(gas_diffusivity(300.0, 101325) / 4, gas_diffusivity(300.0, 4 * 101325));
}

TEST(GrainPressure, BoilingIsThatOfThePressure) {
  const std::string wet =
      "[time]\nstep = 0.1\nduration = 1\n[grain]\ndiameter = 0.01\ntemperature = 300\n[material]\ndensity = 600\n"
      "moisture = 0.3\n[heat_capacity]\nfuel = 1500\n[conductivity]\nfuel = 0.2\n[surroundings]\ntemperature = 800\n"
      "film = 50\npressure = 5e5\n";
  const std::string said = refusal(wet);  // steam tables: 425 K at 5 bar
  EXPECT_NE(said.find("drying.temperature"), std::string::npos) << said;
  EXPECT_NE(said.find("boils at about 42"), std::string::npos) << said;
  EXPECT_EQ(refusal(wet + "[drying]\ntemperature = 425\n"), "accepted");
  DryingLaw law;
  law.temperature = 425;
  EXPECT_NEAR(saturated_vapour(425.0, law, 5e5) / gas_density(425.0, 5e5, 0.018015), 1, 1e-12) << "boils there";
}

TEST(GrainWithoutAsh, BurnsToNothingAndStaysBounded) {
  const std::string text = ball_of_char("velocity = 1\n", "initial = { c = 1 }\n");
  const std::string whole = [&] {
    std::string t = text;
    t.replace(t.find("duration = 20"), 13, "duration = 400");
    t.replace(t.find("oxygen = 0.05"), 13, "oxygen = 0.23");
    return t;
  }();
  const std::string table = grain_table(parse_grain(whole, "g.toml"));
  const double first = 300 * 4.0 / 3.0 * 3.14159265358979 * std::pow(0.002, 3);
  EXPECT_LT(last(table, "mass"), 1e-6 * first);
  EXPECT_NEAR(last(table, "mean_temperature"), 1200, 5) << "what is left has the temperature of its gas";
}

/// A kilogram of char burns its carbon; the rest leaves as steam and hydrogen, and every element is accounted for.
TEST(GrainChar, ThatIsNoPureCarbonBurnsItsCarbonAndKeepsEveryElement) {
  const auto text = [](const std::string& composition) {
    std::string t = ball_of_char("velocity = 1\n");
    const std::string kind = "kind = \"char\"\n";
    return t.replace(t.find(kind), kind.size(), kind + composition);
  };
  const std::string mixed = grain_table(parse_grain(text("composition = { C = 0.9, H = 0.04, O = 0.06 }\n"), "g.toml")),
                    pure = grain_table(parse_grain(text(""), "g.toml"));
  const double first = 300 * 4.0 / 3.0 * 3.14159265358979 * std::pow(0.002, 3);
  const auto burnt = [&](const std::string& t) { return 0.95 * first - last(t, "char"); };
  ASSERT_GT(burnt(mixed), 0.05 * first);
  for (const char* element : {"carbon", "hydrogen", "oxygen"})
    EXPECT_LT(std::fabs(last(mixed, std::string(element) + "_residual")), 1e-9 * first) << element;
  EXPECT_LT(std::fabs(last(mixed, "mass_residual")), 1e-12 * first);
  const double steam = 0.06 / (15.999 / 18.015), hydrogen = 0.04 - steam * 2.016 / 18.015;
  EXPECT_NEAR(last(mixed, "released_vapour") / burnt(mixed), steam, 1e-4);
  EXPECT_NEAR(last(mixed, "released_H2") / burnt(mixed), hydrogen, 1e-4);
  EXPECT_NEAR(last(mixed, "oxygen_taken") / burnt(mixed) / (last(pure, "oxygen_taken") / burnt(pure)), 0.9, 1e-3);
  const std::string said = refusal(text("composition = { C = 0.5, H = 0.01, O = 0.49 }\n"));
  EXPECT_NE(said.find("oxygen of its steam"), std::string::npos) << said;
}

TEST(GrainFlux, OfAPulseWithinAStepIsAllHeat) {
  const std::string ball =
      "[time]\nstep = 0.5\nduration = 5\noutput_every = 5\n[grain]\ndiameter = 0.01\ntemperature = 300\n[material]\n"
      "density = 600\n[heat_capacity]\nfuel = 1500\n[conductivity]\nfuel = 0.2\n[surroundings]\ntemperature = 300\n"
      "film = 0\nflux = [[0, 0], [1.1, 0], [1.2, 4e4], [1.3, 0], [9, 0]]\n";  // 4000 J/m2
  EXPECT_NEAR(end_of(ball, "heat_in") / (4000 * 3.14159265358979 * 1e-4), 1, 1e-6);
}

TEST(GrainOxidants, ThatNoReactionTakesAreRefused) {
  const std::string ball = ball_of_char("");
  EXPECT_EQ(refusal(ball), "accepted");
  for (const char* oxidant : {"carbon_dioxide", "steam"}) {
    const std::string said = refusal(ball + oxidant + " = 0.1\n");
    EXPECT_NE(said.find("has no effect"), std::string::npos) << said;
  }
  std::string other = ball;
  other.replace(other.find("oxygen = 0.05"), 13, "steam = 0.5");
  other.replace(other.find("A = 50"), 6, "oxidant = \"H2O\"\nA = 50");
  const std::string table = grain_table(parse_grain(other, "g.toml"));
  EXPECT_GT(last(table, "steam_taken"), 0);
  EXPECT_NEAR(last(table, "released_H2") / last(table, "steam_taken"), 2.016 / 18.015, 1e-4);
}

/// A shrinking core (Levenspiel): kinetics, film and ash in series. t = rho/(y C) (R/k (1 - r) + R/(3 h) (1 - r^3) +
/// R^2/(6 D) (1 - 3 r^2 + 2 r^3)), r^3 the share of char that is left, y the char that a kilogram of oxygen burns.
TEST(GrainChar, BurnsAsAShrinkingCoreWhateverItsShells) {
  const auto text = [](double A, const std::string& level, double step, double end) {
    std::ostringstream t;
    t << "[time]\nstep = " << step << "\nduration = " << end << "\noutput_every = " << end
      << "\n[grain]\ndiameter = 0.01\ntemperature = 800\n"
      << level
      << "[material]\ndensity = 300\ninitial = { c = 0.95 }\nash = 0.05\nblowing = false\nporosity = 0.5\n"
         "pore_diffusion = 0.1\n[heat_capacity]\nfuel = 1500\n[conductivity]\nfuel = 1e4\n[[solid]]\nname = \"c\"\n"
         "kind = \"char\"\n[[char_reaction]]\nA = "
      << A
      << "\nn = 0\nE = 0\nratio_A = 0\n[surroundings]\ntemperature = 800\noxygen = 0.23\ncontact_conductance = 1e5\n"
         "contact_temperature = 800\n";
    return t.str();
  };
  const double R = 0.005, first = 285 * 4.0 / 3.0 * 3.14159265358979 * R * R * R, y = 0.012011 / 0.0319988;
  for (const double A : {1e-4, 3e-3, 10.0})  // kinetics; all three; ash and film
    for (const char* level : {"level = \"lumped\"\n", "shells = 2\n", "shells = 4\n", "shells = 20\n"}) {
      const GrainJob job = parse_grain(text(A, level, 1, 2), "g.toml");
      const GasAround<double> gas = job.around.gas_at(0, R, 800);
      const double D = job.matter.porosity * job.matter.tortuosity_factor * gas_diffusivity(800.0, 101325);
      const auto time_of = [&](double r) {
        return 285 / (y * gas.oxygen) *
               (R / A * (1 - r) + R / (3 * gas.film) * (1 - r * r * r) +
                R * R / (6 * D) * (1 - 3 * r * r + 2 * r * r * r));
      };
      const double end = time_of(std::cbrt(0.4));
      const double found = time_of(std::cbrt(end_of(text(A, level, end / 1000, end), "char") / first));
      EXPECT_NEAR(found / end, 1, 0.005) << A << " " << level;
      std::printf("[figure] char, A = %g m/s, %.*s: time / that of the shrinking core %.4f\n", A,
                  static_cast<int>(std::string(level).size()) - 1, level, end / found);
    }
}

TEST(GrainShrinkage, OfWhatWasNeverThereIsNone) {
  const std::string dry = ball_of_char("film = 50\n");
  const auto radius = [&](const std::string& shrinkage) { return end_of(dry + "[shrinkage]\n" + shrinkage, "radius"); };
  EXPECT_EQ(radius("drying = 0.3\n"), 0.002) << "there is no moisture";
  EXPECT_EQ(radius("devolatilisation = 0.3\n"), 0.002) << "nor wood";
  EXPECT_LT(radius("burn_off = 0.3\n"), 0.00199);
}

TEST(GrainMelting, BeginsWithTheShareThatItsTemperatureMeans) {
  const auto liquid = [](double solidus, double liquidus, double T) {
    const std::string text =
        "[time]\nstep = 0.001\nduration = 1\n[grain]\ndiameter = 0.001\ntemperature = " + std::to_string(T) +
        "\n[material]\ndensity = 7800\n[heat_capacity]\nfuel = 700\n[conductivity]\nfuel = 30\n[melting]\nsolidus = " +
        std::to_string(solidus) + "\nliquidus = " + std::to_string(liquidus) +
        "\nlatent_heat = 2.7e5\n[surroundings]\ntemperature = 300\nfilm = 500\n";
    const GrainJob job = parse_grain(text, "g.toml");
    return Grain<double>(job.matter, job.form, job.temperature, job.options).state.liquid[0];
  };
  EXPECT_NEAR(liquid(1650, 1700, 1680), 0.6, 1e-12);
  EXPECT_EQ(liquid(1650, 1700, 1600), 0);
  EXPECT_EQ(liquid(1650, 1700, 1750), 1);
  EXPECT_EQ(liquid(1700, 1700, 1700), 0) << "at the melting point it is still solid";
  EXPECT_EQ(liquid(1700, 1700, 1701), 1);
}

}  // namespace
}  // namespace talus::conversion
