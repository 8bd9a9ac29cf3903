// Burning in the gas: heats, elements, bounds at any step.
#include "core/gas/combustion.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/det_math.hpp"
#include "core/gas/species.hpp"
#include "core/gas/transport.hpp"
#include "tests/gas/gas_support.hpp"

namespace talus::gas::testing {
namespace {

enum { O2, CO2, CO, H2O, H2, CH4, TAR, N2 };

/// A mixture by moles as 1 kg.
GasFractions mixture(const GasFractions& moles) {
  GasFractions m = moles;
  double total = 0;
  for (int k = 0; k < k_gas_species; ++k) total += m[static_cast<std::size_t>(k)] *= species(k).molar_mass;
  for (double& x : m) x /= total;
  return m;
}

double element(const GasFractions& m, int e) {
  double n = 0;
  for (int k = 0; k < k_gas_species; ++k)
    n += m[static_cast<std::size_t>(k)] / species(k).molar_mass * species(k).atoms[e];
  return n;
}

TEST(Combustion, HeatsOfBurningAndOfFormationAreThoseOfTheTables) {
  const double t = 298.15;
  const auto molar = [&](int k) { return enthalpy(k, t) * species(k).molar_mass / 1e3; };
  EXPECT_NEAR(molar(O2), 0, 0.02);
  EXPECT_NEAR(molar(N2), 0, 0.02);
  EXPECT_NEAR(molar(H2), 0, 0.02);
  EXPECT_NEAR(molar(CO2), -393.51, 0.05);
  EXPECT_NEAR(molar(CO), -110.53, 0.05);
  EXPECT_NEAR(molar(H2O), -241.83, 0.05);
  EXPECT_NEAR(molar(CH4), -74.6, 0.4);
  EXPECT_NEAR(molar(TAR), 82.93, 0.01);
  EXPECT_NEAR((molar(CO) - molar(CO2)) / 28.0104, 10.10, 0.02) << "MJ/kg";
  EXPECT_NEAR((molar(H2) - molar(H2O)) / 2.01588, 120.0, 0.1);
  EXPECT_NEAR((molar(CH4) - molar(CO2) - 2 * molar(H2O)) / 16.04276, 50.0, 0.1);
  EXPECT_NEAR(heat_capacity(k_air, 300), 1010, 8);
  for (int k = 0; k < k_gas_species; ++k)  // both ranges meet
    for (const double split : {1000.0, 1500.0})
      EXPECT_NEAR(enthalpy(k, split - 1e-9) / enthalpy(k, split + 1e-9), 1, 2e-4) << species(k).name;
}

TEST(Combustion, MethaneInAirReachesItsAdiabaticTemperature) {
  GasFractions m = mixture({2, 0, 0, 0, 0, 1, 0, 7.52});
  const double h = enthalpy(m, 300);
  // cold gas does not burn, hot gas does
  GasFractions cold = m;
  EXPECT_NEAR(burn(cold, h, 300, 101325, 10), 300, 1e-6);
  const double hot = enthalpy(m, 1200);
  burn(m, hot, 1200, 101325, 10);
  EXPECT_LT(m[CH4], 1e-9);
  EXPECT_LT(m[CO] + m[O2], 1e-4);
  EXPECT_NEAR(temperature_of(m, h, 2000), 2328, 6) << "without dissociation";
}

TEST(Combustion, ElementsMassAndBoundsHoldForEveryStep) {
  const GasFractions starts[] = {mixture({1, 0.2, 0.5, 0.4, 0.3, 0.3, 0.02, 4}), mixture({0.05, 0, 1, 0, 1, 1, 0.5, 1}),
                                 mixture({5, 0, 0.01, 0.01, 0.01, 0.01, 0.001, 20})};
  for (const GasFractions& from : starts)
    for (const double t0 : {300.0, 700.0, 900.0, 1100.0, 1600.0, 2200.0})
      for (double dt = 1e-10; dt < 1e7; dt *= 100) {
        GasFractions m = from;
        const double h = enthalpy(from, t0), t = burn(m, h, t0, 101325, dt);
        double total = 0;
        for (const double x : m) {
          EXPECT_GE(x, 0);
          total += x;
        }
        EXPECT_NEAR(total, 1, 1e-14);
        for (int e = 0; e < k_elements; ++e) EXPECT_NEAR(element(m, e) / element(from, e), 1, 1e-13);
        EXPECT_GE(t, t0 - 1e-9);
        EXPECT_NEAR(enthalpy(m, t) / std::fabs(h), h / std::fabs(h), 1e-9);
        // burnt as far as it goes
        EXPECT_LE(t, 4500);
      }
}

TEST(Combustion, HalvedStepsConvergeBeforeAndAfterIgnition) {
  const GasFractions from = mixture({1, 0, 0.6, 0.3, 0.2, 0.2, 0, 4});
  const double h = enthalpy(from, 1000);
  const auto run = [&](int steps, double time) {
    GasFractions m = from;
    double t = 1000;
    for (int k = 0; k < steps; ++k) t = burn(m, h, t, 101325, time / steps);
    return t;
  };
  for (const double time : {1e-4, 1e-3}) {
    const double a = run(20, time), b = run(40, time), exact = run(2000, time);
    EXPECT_LT(std::fabs(b - exact), 0.7 * std::fabs(a - exact) + 0.02) << time;
  }
  EXPECT_NEAR(run(1, 1.0), run(100, 1.0), 0.5) << "burnt out";
}

TEST(Combustion, OneFuelBurnsAtItsPublishedRate) {
  // CO in wet air, first order while little has burnt
  GasFractions m = mixture({0.21, 0, 0.001, 0.01, 0, 0, 0, 0.78});
  const double t0 = 1000, dt = 1e-5, n = m[CO] / species(CO).molar_mass;
  double moles = 0;
  for (int k = 0; k < k_gas_species; ++k) moles += m[static_cast<std::size_t>(k)] / species(k).molar_mass;
  GasFractions c;
  for (int k = 0; k < k_gas_species; ++k)
    c[static_cast<std::size_t>(k)] =
        m[static_cast<std::size_t>(k)] / species(k).molar_mass / moles * 101325 / (k_gas_constant * t0);
  const double rate = burning_rate(0, c, t0);
  EXPECT_NEAR(rate / (1.3e8 * std::exp(-125520 / (8.314462618 * 1000)) * c[CO] * std::sqrt(c[H2O] * c[O2])), 1, 1e-12);
  burn(m, enthalpy(m, t0), t0, 101325, dt);
  EXPECT_NEAR((n - m[CO] / species(CO).molar_mass) / n / (rate / c[CO] * dt), 1, 0.02);
}

TEST(Combustion, AFlameStandsInAnEmptyTube) {
  // hot gas with fuel burns on its way; nothing overshoots the adiabatic temperature
  GasSettings s = column(0.2, 40, 0.5);
  s.combustion = true;
  s.inlets[0].temperature = 1000;
  s.inlets[0].own_fractions = true;
  s.inlets[0].fractions = mixture({2, 0, 0.3, 0.5, 0.1, 0.3, 0.01, 9});
  GasFractions burnt = s.inlets[0].fractions;
  const double most = burn(burnt, enthalpy(s.inlets[0].fractions, 1000), 1000, 101325, 1e4);
  Gas gas(s, {}, {});
  const FromGrains bed = uniform_bed(gas.grid(), 0.5, 5e-3);
  gas.start(bed);
  for (int k = 0; k < 250; ++k) gas.step(bed, 1e-3);
  const auto& t = gas.fields().temperature;
  for (const double x : t) EXPECT_LT(x, most + 1e-6);
  EXPECT_NEAR(t.back(), most, 1);
}

}  // namespace
}  // namespace talus::gas::testing
