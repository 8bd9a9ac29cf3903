// Heat and species through a bed: Schumann's step, balances, bounds.
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.hpp"
#include "core/gas/species.hpp"
#include "tests/gas/gas_support.hpp"

namespace talus::gas::testing {
namespace {

/// A bed of lumped grains beside the gas: their temperatures per cell.
struct LumpedBed {
  FromGrains grains;
  double capacity;  ///< of the grains of a cell [J/K]
  std::vector<double> t;
  LumpedBed(const Grid& g, double porosity, double d, double conductance, double heat_capacity, double t0)
      : grains(uniform_bed(g, porosity, d)), capacity(heat_capacity), t(grains.solid.size(), t0) {
    for (double& h : grains.conductance) h = conductance;
  }
  void offer() {
    for (std::size_t c = 0; c < t.size(); ++c) grains.heat[c] = grains.conductance[c] * t[c];
  }
  /// What the gas has given, to the bit of what it lost.
  void take(const Gas& gas, double dt) {
    for (std::size_t c = 0; c < t.size(); ++c)
      t[c] += dt * (grains.conductance[c] * gas.fields().exchange_temperature[c] - grains.heat[c]) / capacity;
  }
  double energy() const {
    double e = 0;
    for (const double x : t) e += capacity * x;
    return e;
  }
};

struct SchumannError {
  double gas, solid;
};

/// Largest error of (T - 300) / 1 K at the points of the table, on n cells to Y = 4.
SchumannError schumann(int n) {
  const double length = 0.2, y_end = 4, u = 0.3;
  GasSettings s = column(length, n, u);
  s.inlets[0].temperature = 301;
  Gas gas(s, {}, {});
  const double rt = specific_gas_constant(k_air) * 301, g = 101325 / rt * u * 1e-4, cp = heat_capacity(k_air, 300.5);
  // conductance of the bed: Y = conductance x / (L g cp); of the grains: Z = conductance t / capacity
  const double whole = y_end * g * cp, solid = 2000.0 * 0.2 * 1e-4;  // [W/K], [J/K]: some 700 times that of the gas
  LumpedBed bed(gas.grid(), 0.4, 5e-3, whole / n, solid / n * 1000, 300);
  const double unit = solid * 1000 / whole, dt = 4 * unit / (4 * n);  // [s] of Z = 1
  gas.start(bed.grains);
  SchumannError e{};
  const struct {
    double y, z, gas, solid;
  } table[] = {{1, 1, .654254, .345746}, {2, 2, .603501, .396499}, {2, 4, .851936, .729961}};
  for (int k = 1; k <= 4 * n; ++k) {
    bed.offer();
    gas.step(bed.grains, dt);
    bed.take(gas, dt);
    for (const auto& p : table) {
      if (std::fabs(k * dt / unit - p.z) > 1e-9) continue;
      // between the middles of the cells beside Y
      const double at = p.y / y_end * n - 0.5;
      const auto c = static_cast<std::size_t>(at);
      const double w = at - static_cast<double>(c);
      const auto between = [&](const std::vector<double>& v) { return (1 - w) * v[c] + w * v[c + 1] - 300; };
      e.gas = std::fmax(e.gas, std::fabs(between(gas.fields().temperature) - p.gas));
      e.solid = std::fmax(e.solid, std::fabs(between(bed.t) - p.solid));
    }
  }
  return e;
}

TEST(Transport, SchumannsStepWithinOnePercentAndOfFirstOrder) {
  const SchumannError coarse = schumann(100), fine = schumann(200);
  std::printf("Schumann: largest error gas %.2g, solid %.2g on 100 cells; %.2g, %.2g on 200\n", coarse.gas,
              coarse.solid, fine.gas, fine.solid);
  EXPECT_LT(coarse.gas, 0.01);
  EXPECT_LT(coarse.solid, 0.01);
  EXPECT_GT(coarse.gas / fine.gas, 1.7);
  EXPECT_GT(coarse.solid / fine.solid, 1.7);
}

TEST(Transport, MassAndEnthalpyBalanceToRoundingInEveryStep) {
  GasSettings s = column(0.2, 40, 0.4);
  s.upper = {0.05, 0.05, 0.2};
  s.cells = {3, 3, 12};
  s.combustion = true;
  s.inlets[0].temperature = 900;
  Gas gas(s, {}, {0, 0, -9.81});
  LumpedBed bed(gas.grid(), 0.45, 4e-3, 0.05, 2.0, 300);
  bed.grains.source[20][static_cast<std::size_t>(GasSpecies::ch4)] = 2e-6;
  bed.grains.source[40][static_cast<std::size_t>(GasSpecies::h2o)] = 3e-6;
  bed.grains.source[40][static_cast<std::size_t>(GasSpecies::o2)] = -2e-6;
  bed.grains.enthalpy[20] = 2e-6 * enthalpy(static_cast<int>(GasSpecies::ch4), 700);
  bed.grains.enthalpy[40] = 3e-6 * enthalpy(static_cast<int>(GasSpecies::h2o), 373);
  gas.start(bed.grains);
  for (int k = 0; k < 80; ++k) {
    // a bed that breathes: the void changes under the gas
    for (std::size_t c = 0; c < bed.t.size(); ++c)
      bed.grains.solid[c] = (0.55 + 0.02 * std::sin(0.1 * k + static_cast<double>(c))) * gas.grid().volume;
    bed.offer();
    const Balance before = gas.balance();
    gas.step(bed.grains, 1e-3);
    bed.take(gas, 1e-3);
    const Balance now = gas.balance();
    EXPECT_LT(std::fabs(now.mass_residual() - before.mass_residual()), 1e-12 * sum(now.stored));
    EXPECT_LT(std::fabs(now.enthalpy_residual() - before.enthalpy_residual()),
              1e-10 * std::fabs(now.stored_enthalpy) + 1e-13);
    for (int e = 0; e < k_elements; ++e)
      EXPECT_LT(std::fabs(now.element_residual(e) - before.element_residual(e)), 1e-11 * sum(now.stored)) << e;
  }
  const double took = gas.fields().taken[40][static_cast<std::size_t>(GasSpecies::o2)];
  EXPECT_GT(took, 0);
  EXPECT_LT(took, 1.01);
  EXPECT_GT(gas.fields().temperature[0], 500) << "hot gas has come in";
}

TEST(Transport, NothingLeavesTheRangeOfWhatThereIsAndWhatComes) {
  GasSettings s = column(0.1, 30, 2);
  s.inlets[0].temperature = 1500;
  s.inlets[0].fractions = {0, 0, 0, 1, 0, 0, 0, 0};
  s.inlets[0].own_fractions = true;
  for (const double dt : {1e-6, 1e-3, 1.0, 100.0}) {
    Gas gas(s, {}, {});
    const FromGrains bed = uniform_bed(gas.grid(), 0.4, 3e-3);
    gas.start(bed);
    for (int k = 0; k < 40; ++k) {
      gas.step(bed, dt);
      for (std::size_t c = 0; c < gas.fields().temperature.size(); ++c) {
        EXPECT_GT(gas.fields().temperature[c], 300 - 1e-5) << dt;
        EXPECT_LT(gas.fields().temperature[c], 1500 + 1e-5) << dt;
        EXPECT_GE(gas.fields().fractions[c][static_cast<std::size_t>(GasSpecies::h2o)], 0);
        EXPECT_GE(gas.fields().fractions[c][0], 0);
        EXPECT_NEAR(sum(gas.fields().fractions[c]), 1, 1e-12);
      }
    }
  }
}

TEST(Transport, GrainsNeverGetMoreOxygenThanThereIs) {
  GasSettings s = column(0.1, 5, 0.01);
  Gas gas(s, {}, {});
  FromGrains bed = uniform_bed(gas.grid(), 0.4, 3e-3);
  bed.source[2][0] = -1.0;  // [kg/s], a million times what comes in
  gas.start(bed);
  for (int k = 0; k < 50; ++k) gas.step(bed, 1e-3);
  EXPECT_GE(gas.content().mass[2][0], 0);
  EXPECT_LT(gas.fields().fractions[2][0], 1e-3);
  EXPECT_LT(-sum(gas.balance().passed.grains), sum(gas.balance().passed.in) + sum(gas.balance().start));
}

TEST(Transport, TemperaturesThatNobodyKnowsAreRefused) {
  GasSettings s = column(0.1, 5, 0.1);
  Gas gas(s, {}, {});
  FromGrains bed = uniform_bed(gas.grid(), 0.4, 3e-3);
  bed.heat[2] = 1e6;
  gas.start(bed);
  EXPECT_THROW(for (int k = 0; k < 1000; ++k) gas.step(bed, 1e-3), Error);
}

TEST(Transport, AResumeGoesOnToTheBit) {
  GasSettings s = column(0.1, 30, 1);
  s.inlets[0].temperature = 700;
  Gas whole(s, {}, {});
  const FromGrains bed = uniform_bed(whole.grid(), 0.4, 3e-3);
  whole.start(bed);
  for (int k = 0; k < 20; ++k) whole.step(bed, 1e-3);
  Gas rest(s, {}, {});
  rest.load(whole.save(), "here");
  EXPECT_EQ(rest.save(), whole.save());
  for (int k = 0; k < 20; ++k) whole.step(bed, 1e-3), rest.step(bed, 1e-3);
  EXPECT_EQ(rest.save(), whole.save());
  std::vector<std::uint8_t> cut = whole.save();
  cut.pop_back();
  EXPECT_THROW(rest.load(cut, "here"), Error);
}

}  // namespace
}  // namespace talus::gas::testing
