// Gas in a vessel that no side opens to a given pressure: heat warms it at constant volume, pressure follows.
#include <gtest/gtest.h>

#include <cmath>

#include "core/gas/species.hpp"
#include "tests/gas/gas_support.hpp"

namespace talus::gas::testing {
namespace {

GasSettings box(std::array<int, 3> cells) {
  GasSettings s;
  s.on = true;
  s.upper = {0.02, 0.01, 0.04};
  s.cells = cells;
  return s;
}

double inner_energy(double t) { return enthalpy(k_air, t) - specific_gas_constant(k_air) * t; }

/// At which air has this inner energy [K].
double temperature_at(double u) {
  double low = 200, high = 3000;
  for (int k = 0; k < 80; ++k) (inner_energy(0.5 * (low + high)) < u ? low : high) = 0.5 * (low + high);
  return low;
}

/// Mass times R T of all cells: pressure times volume [J].
double pressure_volume(const Gas& gas) {
  double pv = 0;
  for (std::size_t c = 0; c < gas.content().mass.size(); ++c)
    pv += sum(gas.content().mass[c]) * specific_gas_constant(gas.fields().fractions[c]) * gas.content().temperature[c];
  return pv;
}

TEST(SealedVessel, HeatWarmsItAtConstantVolume) {
  for (const double dt : {0.01, 0.5}) {
    Gas gas(box({2, 1, 4}), {}, {});
    FromGrains bed = uniform_bed(gas.grid(), 0.5, 2e-3);
    for (double& q : bed.heat) q = 2e-4;  // [W] per cell
    gas.start(bed);
    const double mass = sum(gas.balance().start), volume = 0.5 * 8e-6, p0 = 101325;
    double heat = 0;
    for (double t = 0; t < 0.999; t += dt) gas.step(bed, dt), heat += 8 * 2e-4 * dt;
    const double expected = temperature_at(inner_energy(300) + heat / mass), rise = expected - 300;
    std::printf("sealed, steps of %g s: %.9f K, expected %.9f K; %.6f Pa\n", dt, gas.fields().temperature[3], expected,
                gas.pressure());
    const double cv = heat_capacity(k_air, 300) - specific_gas_constant(k_air);
    EXPECT_NEAR(rise, heat / (mass * cv), 0.02 * rise);
    for (const double t : gas.fields().temperature) EXPECT_NEAR(t, expected, 1e-8 * rise);
    for (const double p : gas.fields().pressure) EXPECT_NEAR(p, p0 * expected / 300, 1e-8 * p0);
    EXPECT_NEAR(gas.pressure(), mass * specific_gas_constant(k_air) * expected / volume, 1e-8 * p0);
    EXPECT_NEAR(gas.balance().passed.pressure_work, volume * (gas.pressure() - p0), 1e-12 * volume * p0);
    EXPECT_LT(std::fabs(gas.balance().enthalpy_residual()), 1e-12 * std::fabs(gas.balance().stored_enthalpy));
  }
}

TEST(SealedVessel, UnevenHeatIsKeptToo) {
  Gas gas(box({2, 1, 4}), {}, {0, 0, -9.81});
  FromGrains bed = uniform_bed(gas.grid(), 0.5, 2e-3);
  gas.start(bed);
  const double h0 = gas.balance().start_enthalpy, p0 = pressure_volume(gas);
  double heat = 0;
  for (int k = 0; k < 200; ++k) {
    bed.heat[1] = k < 100 ? 5.0 : 0;
    gas.step(bed, 0.005);
    heat += bed.heat[1] * 0.005;
  }
  // enthalpy less pressure times volume is what heat has raised
  const double h1 = gas.balance().stored_enthalpy, p1 = pressure_volume(gas);
  EXPECT_GT(p1, 1.5 * p0);
  EXPECT_NEAR((h1 - p1) - (h0 - p0), heat, 1e-9 * heat);
  EXPECT_EQ(sum(gas.balance().passed.out), 0);
}

TEST(SealedVessel, GrainsNeverWarmItBeyondThemselves) {
  for (const double conductance : {1e-4, 1e-3, 1e-2, 1.0}) {
    Gas gas(box({1, 1, 4}), {}, {});
    FromGrains bed = uniform_bed(gas.grid(), 0.5, 2e-3);
    for (double& g : bed.conductance) g = conductance;
    for (double& q : bed.heat) q = conductance * 900;
    gas.start(bed);
    for (int k = 0; k < 200; ++k) {
      gas.step(bed, 0.02);
      for (const double t : gas.fields().temperature) EXPECT_LT(t, 900 + 1e-6) << conductance;
    }
    if (conductance > 2e-3) {
      EXPECT_NEAR(gas.pressure(), 3 * 101325, 3);
    }
  }
}

TEST(SealedVessel, WhatIsBlownInIsCompressed) {
  GasSettings s = box({1, 1, 4});
  GasInlet in;
  in.side = GasSide::bottom;
  in.velocity = 0.1;
  in.temperature = 400;
  s.inlets = {in};
  Gas gas(s, {}, {});
  const FromGrains bed = uniform_bed(gas.grid(), 0.5, 2e-3);
  gas.start(bed);
  const double m0 = sum(gas.balance().start);
  for (int k = 0; k < 400; ++k) gas.step(bed, 0.005);
  const double came = sum(gas.balance().passed.in), mass = m0 + came;
  const double h0 = gas.balance().start_enthalpy, h1 = gas.balance().stored_enthalpy;
  const double energy = (h1 - pressure_volume(gas)) - (h0 - m0 * specific_gas_constant(k_air) * 300);
  const double brought = came * enthalpy(k_air, 400);
  EXPECT_NEAR(energy, brought, 1e-9 * came * heat_capacity(k_air, 400) * 400);
  // were it mixed: hotter than what comes in
  const double mixed = temperature_at((m0 * inner_energy(300) + brought) / mass);
  EXPECT_GT(came, 5 * m0);
  EXPECT_GT(mixed, 470);
  double mean = 0;
  for (std::size_t c = 0; c < 4; ++c) mean += sum(gas.content().mass[c]) * gas.content().temperature[c] / mass;
  EXPECT_NEAR(mean, mixed, 1);  // heat capacities differ between the cells
  EXPECT_NEAR(gas.pressure() * 0.5 * 8e-6, pressure_volume(gas), 1e-9 * pressure_volume(gas));
}

/// Temperature after grains have taken a third of the voids in n steps [K].
double squeezed(int n) {
  Gas gas(box({1, 1, 2}), {}, {});
  gas.start(uniform_bed(gas.grid(), 0.6, 2e-3));
  for (int k = 1; k <= n; ++k) gas.step(uniform_bed(gas.grid(), 0.6 - 0.2 * k / n, 2e-3), 0.01);
  return gas.fields().temperature[0];
}

TEST(SealedVessel, GrainsThatTakeRoomCompressItAdiabatically) {
  // int cv dT / T = R ln(V0/V1)
  const double r = specific_gas_constant(k_air), room = r * std::log(0.6 / 0.4);
  double s = 0, expected = 300;
  while (s < room) s += (heat_capacity(k_air, expected) - r) * 0.001 / expected, expected += 0.001;
  // grains push with the pressure of a step's end: first order
  const double coarse = squeezed(100) - expected, fine = squeezed(200) - expected;
  std::printf("squeezed: %.3f K, errors %.4f, %.4f K\n", expected, coarse, fine);
  EXPECT_LT(std::fabs(fine), 0.5);
  EXPECT_NEAR(coarse / fine, 2, 0.1);
}

TEST(SealedVessel, AnOpenSideHoldsThePressureAndNoWorkIsDone) {
  GasSettings s = box({1, 1, 4});
  GasInlet top;
  top.side = GasSide::top;
  top.kind = GasInlet::Kind::pressure;
  s.inlets = {top};
  Gas gas(s, {}, {});
  FromGrains bed = uniform_bed(gas.grid(), 0.5, 2e-3);
  for (double& q : bed.heat) q = 0.002;
  gas.start(bed);
  for (int k = 0; k < 100; ++k) gas.step(bed, 0.01);
  EXPECT_EQ(gas.balance().passed.pressure_work, 0);
  EXPECT_NEAR(gas.pressure(), 101325, 1);
  EXPECT_GT(sum(gas.balance().passed.out), 0);
}

TEST(SealedVessel, AResumeGoesOnToTheBit) {
  Gas whole(box({2, 1, 4}), {}, {});
  FromGrains bed = uniform_bed(whole.grid(), 0.5, 2e-3);
  bed.heat[5] = 0.01;
  whole.start(bed);
  for (int k = 0; k < 10; ++k) whole.step(bed, 0.005);
  Gas rest(box({2, 1, 4}), {}, {});
  rest.load(whole.save(), "here");
  for (int k = 0; k < 10; ++k) whole.step(bed, 0.005), rest.step(bed, 0.005);
  EXPECT_EQ(rest.save(), whole.save());
  EXPECT_EQ(rest.pressure(), whole.pressure());
}

}  // namespace
}  // namespace talus::gas::testing
