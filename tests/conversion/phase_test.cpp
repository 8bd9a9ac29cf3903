// Melting and drying: plateaus, latent heat, fronts against closed forms.
#include "tests/conversion/grain_support.hpp"

namespace talus::conversion {
namespace {
using namespace test;

TEST(Melting, LumpedGrainStaysAtTheMeltingPointUntilItsLatentHeatIsIn) {
  Matter m = inert(1000, 1000, 1);
  m.melting = {500, 500, 2e5};
  Surroundings<double> s;
  s.flux = 1e5;
  Grain<double> g(checked(m), {heat::Shape::sphere, 0.01, 1, 1}, 300, {Method::tr_bdf2, 4, true});
  const double power = 1e5 * 3 / 0.01 / 1000;  // [W/kg]
  run(g, s, 0.05, static_cast<int>(1000.0 * 200 / power / 0.05 + 0.5) + 40);
  EXPECT_EQ(g.state.temperature[0], 500);
  EXPECT_NEAR(g.state.liquid[0], power * 2.0 / 2e5, 0.01);
  run(g, s, 0.05, 200);
  EXPECT_NEAR(g.state.temperature[0], 300 + (power * g.state.time - 2e5) / 1000, 1e-6);
  EXPECT_EQ(g.state.liquid[0], 1);
  EXPECT_LT(std::fabs(g.heat_residual()), 1e-12 * g.state.heat_in);
}

/// Neumann's root of lambda exp(lambda^2) erf(lambda) = St / sqrt(pi).
double neumann(double stefan) {
  double low = 1e-6, high = 3;
  for (int k = 0; k < 100; ++k) {
    const double x = 0.5 * (low + high);
    (x * std::exp(x * x) * std::erf(x) < stefan / std::sqrt(det::k_pi) ? low : high) = x;
  }
  return low;
}

TEST(Melting, FrontFollowsNeumannsSolution) {
  Matter m = inert(1000, 1000, 1);
  m.melting = {500, 500, 1e5};
  double errors[2];
  for (int k = 0; k < 2; ++k) {
    const std::size_t shells = k == 0 ? 40 : 80;
    Grain<double> g(checked(m), {heat::Shape::plate, 0.1, 1, shells}, 499.9999, {Method::euler, 6, false});
    run(g, surface_at(600), 1.0 / (k + 1), 1000 * (k + 1));
    double molten = 0;
    for (const double x : g.state.liquid) molten += x * 0.1 / static_cast<double>(shells);
    const double wanted = 2 * neumann(1000 * 100 / 1e5) * std::sqrt(1e-6 * 1000);
    errors[k] = std::fabs(molten - wanted) / wanted;
    EXPECT_LT(std::fabs(g.heat_residual()), 1e-12 * g.state.heat_in);
  }
  std::printf("melting front: relative errors %.4f %.4f with 40, 80 shells\n", errors[0], errors[1]);
  EXPECT_LT(errors[1], 0.01);
}

TEST(Melting, MushyRangeKeepsEnergyAndOrder) {
  Matter m = inert(1000, 1000, 1);
  m.melting = {450, 550, 1e5};
  Grain<double> g(checked(m), {heat::Shape::sphere, 0.01, 1, 20}, 300, {Method::tr_bdf2, 5, false});
  run(g, gas_at(900, 500), 0.1, 600);
  for (std::size_t i = 1; i < g.state.size(); ++i) {
    EXPECT_GE(g.state.temperature[i], g.state.temperature[i - 1] - 1e-9);
    EXPECT_GE(g.state.liquid[i], g.state.liquid[i - 1] - 1e-12);
  }
  EXPECT_LT(std::fabs(g.heat_residual()), 1e-12 * g.state.heat_in);
}

Matter wet(double c) {
  Matter m = inert(600, c, 0.15);
  m.solids = {{"wood", Kind::fuel, 0.5, {}}, {"moisture", Kind::moisture, 0.5, {}}};
  m.drying = {Drying::boiling, 0, 0, 373.15, 2.26e6};
  return m;
}

TEST(Drying, FrontTakesTheQuasiSteadyTime) {
  // 300 kg/m3 of water, heat capacity of next to nothing, 227 K above boiling
  const double wanted = 300 * 2.26e6 / 227 * (0.005 * 0.005 / (6 * 0.15) + 0.005 / (3 * 50.0));
  EXPECT_NEAR(wanted, 182.5, 0.05);
  double times[2];
  for (int k = 0; k < 2; ++k) {
    Grain<double> g(checked(wet(0.5)), {heat::Shape::sphere, 0.005, 1, k == 0 ? 20u : 40u}, 373.15,
                    {Method::euler, 6, false});
    const auto s = gas_at(600.15, 50);
    g.begin(s);
    double dry = 0;
    for (int n = 1; n <= 4000 && dry == 0; ++n) {
      g.advance(0.1, s, s, {});
      if (g.totals().moisture < 1e-6 * g.at_start().moisture) dry = 0.1 * n;
    }
    times[k] = dry;
    EXPECT_LT(std::fabs(g.heat_residual()), 1e-12 * g.state.heat_in);
    EXPECT_LT(std::fabs(g.element_residual(water)), 1e-12 * g.at_start().mass);
  }
  std::printf("drying front: %.2f and %.2f s with 20, 40 shells; quasi-steady %.2f s\n", times[0], times[1], wanted);
  EXPECT_NEAR(times[1], wanted, 0.02 * wanted);
}

TEST(Drying, TemperatureOfWetShellsNeverPassesBoiling) {
  Grain<double> g(checked(wet(1500)), {heat::Shape::sphere, 0.005, 1, 20}, 300, {Method::tr_bdf2, 5, false});
  const auto s = gas_at(1200, 100);
  g.begin(s);
  for (int n = 0; n < 600; ++n) {
    g.advance(0.1, s, s, {});
    for (std::size_t i = 0; i < g.state.size(); ++i) {
      if (g.state.m(1, i) > 1e-9 * g.state.m0(Kind::moisture, i)) {
        ASSERT_LE(g.state.temperature[i], 373.15 + 0.5) << n << " " << i;
      }
    }
  }
  EXPECT_LT(g.totals().moisture, 1e-9 * g.at_start().moisture);
}

TEST(Drying, EquilibriumReachesTheWetBulbBelowBoiling) {
  Matter m = wet(20);
  m.drying.kind = Drying::equilibrium;
  m = checked(m);
  Grain<double> g(m, {heat::Shape::sphere, 0.005, 1, 20}, 293, {Method::tr_bdf2, 4, false});
  const double h = 50;
  const auto s = gas_at(400, h);
  GasAround<double> gas;
  gas.film = 0.01;  // its resistance is far above that of half a shell
  run(g, s, 0.1, 200, gas);
  // heat of the film = heat of evaporation at the surface while the outermost shell is wet
  ASSERT_GT(g.state.m(1, 19), 0.1 * g.state.m0(Kind::moisture, 19));
  const double T = g.state.temperature[19];
  const double evaporation = 2.26e6 * saturated_vapour(T, m.drying, 101325) * gas.film;
  EXPECT_LT(T, 345);
  EXPECT_NEAR(h * (400 - g.state.surface), evaporation, 0.15 * evaporation);
  EXPECT_LT(std::fabs(g.heat_residual()), 1e-12 * g.state.heat_in);
}

TEST(Drying, StiffRateNeitherOvershootsNorLosesWater) {
  Matter m = wet(1500);
  m.drying.kind = Drying::none;
  m.gases = {{"steam", Composition{0, 0, 0, 0, 1}}};
  m.reactions = {{"drying", 1, false, 5.13e10, 0, 88000, 2.26e6, {}, {{0, 1}}}};
  Grain<double> g(checked(m), {heat::Shape::sphere, 0.005, 1, 20}, 300, {Method::tr_bdf2, 4, false});
  const auto s = gas_at(2300, 500);
  g.begin(s);
  for (int n = 0; n < 400; ++n) {
    g.advance(0.1, s, s, {});
    for (const double x : g.state.mass) ASSERT_GE(x, 0);
    for (const double T : g.state.temperature) {
      ASSERT_GE(T, 299.9);
      ASSERT_LE(T, 2300.1);
    }
  }
  EXPECT_LT(std::fabs(g.element_residual(water)), 1e-12 * g.at_start().mass);
  EXPECT_LT(std::fabs(g.heat_residual()), 1e-11 * g.state.heat_in);
}

}  // namespace
}  // namespace talus::conversion
