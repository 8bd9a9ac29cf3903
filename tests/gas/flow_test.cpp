// Flow through beds: pressure drop, drag laws against their tables, sides, robust limits.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "core/base/error.hpp"
#include "core/gas/drag.hpp"
#include "core/gas/species.hpp"
#include "tests/gas/gas_support.hpp"

namespace talus::gas::testing {
namespace {

/// Ergun's pressure drop of a gas that expands on its way: p dp = -R_s T (A G + B G^2) dx, with G = rho U.
double ergun_drop(double length, double e, double d, double mu, double rt, double g, double out) {
  const double a = 150 * mu * (1 - e) * (1 - e) / (e * e * e * d * d), b = 1.75 * (1 - e) / (e * e * e * d);
  return std::sqrt(out * out + 2 * rt * (a * g + b * g * g) * length) - out;
}

Gas settled(const GasSettings& s, const FromGrains& grains, int steps = 50, double dt = 1) {
  Gas gas(s, {}, {});
  gas.start(grains);
  for (int k = 0; k < steps; ++k) gas.step(grains, dt);
  return gas;
}

TEST(Flow, ErgunsPressureDropInAUniformBed) {
  const double e = 0.4, length = 0.5, mu = viscosity(300), rt = specific_gas_constant(k_air) * 300;
  const struct { double d, u; } beds[] = {{5e-3, 0.5}, {10e-3, 1}, {2e-3, 0.1}, {0.2e-3, 0.01}, {20e-3, 5}};
  for (const auto& bed : beds) {
    const GasSettings s = column(length, 200, bed.u);
    const Gas gas = settled(s, uniform_bed(Grid(s.lower, s.upper, s.cells), e, bed.d));
    const double wanted = ergun_drop(length, e, bed.d, mu, rt, 101325 / rt * bed.u, 101325);
    EXPECT_NEAR(gas.pressure_drop(2) / wanted, 1, 1e-6) << "d " << bed.d << " U " << bed.u;
  }
}

TEST(Flow, VelocityFollowsFromAPressureDifference) {
  const double e = 0.45, length = 0.2, d = 4e-3, mu = viscosity(300), rt = specific_gas_constant(k_air) * 300;
  GasSettings s = column(length, 100, 0);
  s.inlets[0].kind = GasInlet::Kind::pressure;
  for (const double drop : {1.0, 100.0, 1e4}) {
    s.inlets[0].pressure = 101325 + drop;
    const Gas gas = settled(s, uniform_bed(Grid(s.lower, s.upper, s.cells), e, d));
    const double g = -leaving(gas, GasSide::bottom) / 1e-4;
    EXPECT_NEAR(ergun_drop(length, e, d, mu, rt, g, 101325) / drop, 1, 1e-6);
  }
}

TEST(Flow, DragLawsHaveTheirTabulatedValues) {
  const double re[] = {1, 10, 100, 1000};
  const struct {
    double e, ergun[4], beetstra[4];
  } rows[] = {{.4, {31.858, 37.326, 92.014, 638.89}, {37.865, 41.195, 89.789, 468.46}},
              {.5, {17.056, 20.556, 55.556, 405.56}, {20.539, 22.774, 50.413, 263.65}},
              {.7, {5.300, 7.086, 24.943, 203.5}, {7.056, 8.279, 19.688, 106.5}},
              {.9, {1.149, 2.229, 13.03, 121.06}, {2.498, 3.218, 8.554, 47.745}}};
  for (const auto& r : rows)
    for (int k = 0; k < 4; ++k) {
      EXPECT_NEAR(drag_factor(GasDrag::ergun, r.e, re[k]) / r.ergun[k], 1, 5e-4);
      EXPECT_NEAR(drag_factor(GasDrag::beetstra, r.e, re[k]) / r.beetstra[k], 1, 5e-4);
    }
}

TEST(Flow, DragLawsEndInThatOfASingleSphere) {
  for (const double re : {1.0, 30.0, 500.0}) {
    const double schiller = 1 + 0.15 * std::pow(re, 0.687);
    EXPECT_NEAR(drag_factor(GasDrag::gidaspow, 1, re), schiller, 1e-12 * schiller);
    EXPECT_NEAR(drag_factor(GasDrag::di_felice, 1, re), std::pow(0.63 * std::sqrt(re) + 4.8, 2) / 24, 1e-10 * schiller);
  }
  // Gidaspow's is Ergun's in dense beds, and has no jump between
  EXPECT_EQ(drag_factor(GasDrag::gidaspow, 0.5, 20), drag_factor(GasDrag::ergun, 0.5, 20));
  double last = drag_factor(GasDrag::gidaspow, 0.69, 50);
  for (double e = 0.69; e < 0.95; e += 0.001) {
    const double f = drag_factor(GasDrag::gidaspow, e, 50);
    EXPECT_LT(std::fabs(f / last - 1), 0.02) << e;
    last = f;
  }
}

TEST(Flow, DragOfEqualGrainsIsTheResistanceOfTheirBed) {
  const double e = 0.45, d = 1e-3, mu = 1.8e-5, rho = 1.2, slip = 0.3;
  for (const GasDrag law : {GasDrag::ergun, GasDrag::gidaspow, GasDrag::di_felice, GasDrag::beetstra}) {
    const double grains = (1 - e) / (3.14159265358979 / 6 * d * d * d);
    const double force = grains * grain_drag(law, e, d, d, mu, rho, slip) * (slip / e);  // per volume
    EXPECT_NEAR(force / e / (bed_resistance(law, e, d, mu, rho, slip) * slip), 1, 1e-12);
  }
}

TEST(Flow, NusseltNumbersHaveTheirTabulatedValues) {
  const double re[] = {1, 10, 100, 1000};
  const struct {
    GasNusselt law;
    double nu[4];
  } rows[] = {{GasNusselt::gunn, {6.661, 10.044, 22.267, 76.02}},
              {GasNusselt::whitaker, {2.399, 3.338, 6.589, 18.17}},
              {GasNusselt::ranz_marshall, {2.533, 3.685, 7.327, 18.85}},
              {GasNusselt::wakao, {2.977, 5.888, 17.480, 63.63}}};
  for (const auto& r : rows)
    for (int k = 0; k < 4; ++k) EXPECT_NEAR(nusselt(r.law, 0.4, re[k], 0.7) / r.nu[k], 1, 5e-4);
}

TEST(Flow, GasAvoidsADenseBlockAndKeepsItsMass) {
  GasSettings s = column(0.1, 20, 0.2);
  s.upper = {0.1, 0.1, 0.1};
  s.cells = {10, 10, 10};
  s.inlets[0].lower = {0, 0, 0};
  s.inlets[0].upper = {0.05, 0.1, 0};
  const Grid g(s.lower, s.upper, s.cells);
  FromGrains grains = uniform_bed(g, 0.5, 2e-3);
  for (std::size_t c = 0; c < grains.solid.size(); ++c)
    if (g.middle(static_cast<int>(c)).x < 0.05 && g.middle(static_cast<int>(c)).z > 0.04) {
      grains.solid[c] = 0.7 * g.volume;
      grains.specific[c] = grains.solid[c] / 2e-3;
    }
  const Gas gas = settled(s, grains, 40, 1);
  double through = 0, dense = 0, loose = 0;
  for (std::size_t k = 0; k < g.outer.size(); ++k) {
    through += gas.flow().outer_flux[k];
    if (g.outer[k].axis == 2 && g.outer[k].high)
      (g.outer[k].middle.x < 0.05 ? dense : loose) += gas.flow().outer_flux[k];
  }
  EXPECT_NEAR(through / loose, 0, 1e-9) << "steady";
  EXPECT_GT(loose, 3 * dense);
  EXPECT_GT(dense, 0);
}

TEST(Flow, EmptyCellsFullCellsAndNoGrainAtAllAreBounded) {
  GasSettings s = column(0.1, 10, 0.3);
  const Grid g(s.lower, s.upper, s.cells);
  for (const GasDrag law : {GasDrag::ergun, GasDrag::gidaspow, GasDrag::di_felice, GasDrag::beetstra}) {
    s.drag = law;
    FromGrains grains = uniform_bed(g, 0.4, 2e-3);
    grains.solid[3] = grains.specific[3] = 0;
    grains.solid[5] = g.volume;  // a cell full of grain
    grains.specific[5] = g.volume / 2e-3;
    const Gas gas = settled(s, grains, 300, 0.02);
    EXPECT_NEAR(-leaving(gas, GasSide::bottom) / leaving(gas, GasSide::top), 1, 1e-8);
    for (const double p : gas.fields().pressure) EXPECT_TRUE(std::isfinite(p) && p > 1e5);
    EXPECT_GE(gas.fields().porosity[5], s.least_porosity);
    const Gas empty = settled(s, FromGrains(g.cells()), 100, 0.02);
    EXPECT_NEAR(-leaving(empty, GasSide::bottom) / leaving(empty, GasSide::top), 1, 1e-8);
  }
}

TEST(Flow, ClosedBoxKeepsItsGasAtRest) {
  GasSettings s = column(0.1, 10, 0);
  s.inlets.clear();
  const Grid g(s.lower, s.upper, s.cells);
  const Gas gas = settled(s, uniform_bed(g, 0.4, 1e-3), 20, 0.1);
  for (const double u : gas.flow().inner) EXPECT_LT(std::fabs(u), 1e-12);
  EXPECT_NEAR(gas.fields().pressure[4], 101325, 1e-6);
}

/// Gas with weight, with these sides open; returns it after it has come to rest.
Gas left_open(const std::vector<GasSide>& sides, const FromGrains& bed, double outside = 300) {
  GasSettings s = column(0.16, 8, 0);
  s.upper = {0.08, 0.04, 0.16};
  s.cells = {4, 1, 8};
  s.inlets.clear();
  for (const GasSide side : sides) {
    GasInlet i;
    i.side = side;
    i.kind = GasInlet::Kind::pressure;
    i.temperature = outside;
    s.inlets.push_back(i);
  }
  Gas gas(s, {}, {0, 0, -9.81});
  gas.start(bed);
  for (int k = 0; k < 40; ++k) gas.step(bed, 1);
  return gas;
}

TEST(Flow, StillAirOutsideLeavesAirAtRestWhicheverSidesAreOpen) {
  const Grid grid({0, 0, 0}, {0.08, 0.04, 0.16}, {4, 1, 8});
  const FromGrains bed = uniform_bed(grid, 0.6, 4e-3);
  for (const std::vector<GasSide>& open : {std::vector<GasSide>{GasSide::left},
                                           {GasSide::left, GasSide::right},
                                           {GasSide::bottom, GasSide::top},
                                           {GasSide::top}}) {
    const Gas gas = left_open(open, bed);
    double through = 0, push = 0;
    for (const double f : gas.flow().outer_flux) through += std::fabs(f);
    for (std::size_t c = 0; c < bed.solid.size(); ++c) push -= bed.solid[c] * gas.fields().gradient[c].z;
    const double weight = 9.81 * gas.fields().density[0] * 0.4 * 0.08 * 0.04 * 0.16;
    EXPECT_LT(through, 1e-9) << "[kg/s]";
    EXPECT_NEAR(push / weight, 1, 1e-4) << "it carries the grains as much as the air weighs that they displace";
  }
}

TEST(Flow, HotGasAboveAnOpeningToColdAirSettles) {
  // Cold air would be sucked in by the light gas within, and light gas pushed out by heavy air: at such a side the flow
  // has no density of its own.
  int turning = 0;
  for (const double hot : {400.0, 1200.0, 2000.0})
    for (const double e : {0.4, 0.7, 0.95})
      for (const int wide : {1, 3}) {
        GasSettings s = column(0.2, 8, 0);
        s.upper.x = 0.01 * wide;
        s.cells[0] = wide;
        s.temperature = hot;
        s.inlets.erase(s.inlets.begin());
        s.inlets[0].side = GasSide::bottom;
        s.inlets[0].temperature = 300;
        Gas gas(s, {}, {0, 0, -9.81});
        const FromGrains grains = uniform_bed(gas.grid(), e, 5e-3);
        gas.start(grains);
        for (int k = 0; k < 30; ++k) {
          ASSERT_NO_THROW(gas.step(grains, 0.05)) << hot << " " << e << " " << wide << " " << k;
          turning += gas.flow().iterations > 30 ? 1 : 0;
        }
        EXPECT_LT(std::fabs(leaving(gas, GasSide::bottom)), 1e-6) << "the gas stands";
      }
  std::printf("steps with more than 30 iterations: %d\n", turning);
}

TEST(Flow, SidesThatNoInletCanCoverAreRefused) {
  GasSettings s = column(0.1, 10, 0.1);
  s.inlets[0].lower = {0.02, 0, 0};
  EXPECT_THROW(Gas(s, {}, {}), Error);
  s = column(0.1, 10, 0.1);
  EXPECT_THROW(Gas(s, {false, false, true}, {}), Error) << "a periodic side";
  s = column(0.1, 10, 0.1);
  s.inlets[0].lower.z = s.lower.z;
  s.inlets[0].upper.z = s.lower.z;
  EXPECT_NO_THROW(Gas(s, {}, {})) << "a rectangle in its side";
  s.inlets[0].lower.z = s.inlets[0].upper.z = 0.5 * (s.lower.z + s.upper.z);
  EXPECT_THROW(Gas(s, {}, {}), Error) << "a rectangle that lies elsewhere";
}

TEST(Flow, FluidisationBeginsWhereTheDropCarriesTheBed) {
  // e, d of a sand of 0.5 mm: Ergun's drop per length equals (1 - e)(rho_s - rho) g
  const double e = 0.42, d = 5e-4, rho_s = 2600, mu = viscosity(300),
               rho = 101325 / (specific_gas_constant(k_air) * 300);
  double low = 1e-3, high = 2;
  const auto lift = [&](double u) { return u * bed_resistance(GasDrag::gidaspow, e, d, mu, rho, u); };
  for (int k = 0; k < 60; ++k) {
    const double u = 0.5 * (low + high);
    (lift(u) < (1 - e) * (rho_s - rho) * 9.81 ? low : high) = u;
  }
  const double a = 1.75 * rho / (e * e * e * d), b = 150 * mu * (1 - e) / (e * e * e * d * d), c = (rho_s - rho) * 9.81;
  EXPECT_NEAR(low, (std::sqrt(b * b + 4 * a * c) - b) / (2 * a), 1e-9);
}

}  // namespace
}  // namespace talus::gas::testing
