// Heat in one grain against closed forms: Newton's law, the error of one temperature, series of plate, cylinder and
// sphere in gas; orders of convergence in shells and step; bounds; energy to rounding. Errors and orders are printed.
#include "tests/conversion/grain_support.hpp"

namespace talus::conversion {
namespace {
using namespace test;

constexpr double k_rho = 540, k_c = 1800, k_k = 0.12, k_R = 5e-4, k_h = 350, k_T0 = 293, k_T1 = 773;

/// Left side of the eigenvalue equation of a body in gas, zero at the roots; Bi = h R / k.
double condition(heat::Shape shape, double z, double Bi) {
  switch (shape) {
    case heat::Shape::plate:
      return z * std::sin(z) - Bi * std::cos(z);
    case heat::Shape::cylinder:
      return z * std::cyl_bessel_j(1, z) - Bi * std::cyl_bessel_j(0, z);
    case heat::Shape::sphere:
      return std::sin(z) * (1 - Bi) - z * std::cos(z);
  }
  return 0;
}

std::vector<double> roots(heat::Shape shape, double Bi, std::size_t number) {
  std::vector<double> found;
  double a = 1e-6;
  for (double b = 0.01; found.size() < number; b += 0.01) {
    if (condition(shape, a, Bi) * condition(shape, b, Bi) <= 0 && b > 0.02) {
      double low = a, high = b;
      for (int k = 0; k < 80; ++k) {
        const double x = 0.5 * (low + high);
        (condition(shape, low, Bi) * condition(shape, x, Bi) <= 0 ? high : low) = x;
      }
      found.push_back(0.5 * (low + high));
    }
    a = b;
  }
  return found;
}

/// (T - T_gas) / (T0 - T_gas) at r / R after Fourier number Fo.
double series(heat::Shape shape, double Bi, double Fo, double x) {
  double sum = 0;
  for (const double z : roots(shape, Bi, 20)) {
    double term = 0;
    if (shape == heat::Shape::plate)
      term = 4 * std::sin(z) / (2 * z + std::sin(2 * z)) * std::cos(z * x);
    else if (shape == heat::Shape::cylinder)
      term = 2 / z * std::cyl_bessel_j(1, z) /
             (std::pow(std::cyl_bessel_j(0, z), 2) + std::pow(std::cyl_bessel_j(1, z), 2)) *
             std::cyl_bessel_j(0, z * x);
    else
      term = 4 * (std::sin(z) - z * std::cos(z)) / (2 * z - std::sin(2 * z)) * (x > 0 ? std::sin(z * x) / (z * x) : 1);
    sum += term * std::exp(-z * z * Fo);
  }
  return sum;
}

struct Answer {
  double centre, surface;
};
Answer computed(heat::Shape shape, std::size_t shells, double until, int steps, Method method) {
  Grain<double> g(checked(inert(k_rho, k_c, k_k)), {shape, k_R, 1, shells}, k_T0, {method, 2, false});
  run(g, gas_at(k_T1, k_h), until / steps, steps);
  return {g.centre(), g.state.surface};
}
Answer exact(heat::Shape shape, double until) {
  const double Bi = k_h * k_R / k_k, Fo = k_k / (k_rho * k_c) * until / (k_R * k_R);
  return {k_T1 + (k_T0 - k_T1) * series(shape, Bi, Fo, 0), k_T1 + (k_T0 - k_T1) * series(shape, Bi, Fo, 1)};
}
double error(heat::Shape shape, std::size_t shells, int steps, Method method) {
  const Answer a = computed(shape, shells, 0.5, steps, method), b = exact(shape, 0.5);
  return std::max(std::fabs(a.centre - b.centre), std::fabs(a.surface - b.surface));
}

TEST(Sphere, FollowsTheSeriesAtAllTimes) {
  const double t[] = {0.25, 0.5, 1, 2, 3};
  const double centre[] = {349.98, 481.78, 643.79, 747.73, 768.06};
  const double surface[] = {535.24, 616.96, 704.08, 759.52, 770.36};
  double worst = 0;
  for (int k = 0; k < 5; ++k) {
    const Answer a = computed(heat::Shape::sphere, 40, t[k], 100, Method::tr_bdf2),
                 b = exact(heat::Shape::sphere, t[k]);
    EXPECT_NEAR(b.centre, centre[k], 0.01);
    EXPECT_NEAR(b.surface, surface[k], 0.01);
    worst = std::max({worst, std::fabs(a.centre - centre[k]), std::fabs(a.surface - surface[k])});
  }
  std::printf("sphere in gas, 40 shells, 100 steps: worst error of centre and surface %.4f K\n", worst);
  EXPECT_LT(worst, 0.15);
}

TEST(Shells, ErrorsFallWithTheSquareOfTheirNumber) {
  for (const heat::Shape shape : {heat::Shape::plate, heat::Shape::cylinder, heat::Shape::sphere}) {
    const double a = error(shape, 10, 200, Method::tr_bdf2), b = error(shape, 20, 200, Method::tr_bdf2),
                 c = error(shape, 40, 200, Method::tr_bdf2);
    std::printf("shape %d: errors %.4f %.4f %.4f K with 10, 20, 40 shells, orders %.2f %.2f\n", static_cast<int>(shape),
                a, b, c, order(a, b), order(b, c));
    EXPECT_GT(order(a, b), 1.8);
    EXPECT_GT(order(b, c), 1.8);
    EXPECT_LT(b, 0.6);
  }
}

TEST(HeatStep, OrderIsTwoWithTrBdf2AndOneWithEuler) {
  // against the same shells with a very small step, so that the step's error alone is seen
  const Answer fine = computed(heat::Shape::sphere, 20, 0.5, 1600, Method::tr_bdf2);
  const auto off = [&](int steps, Method m) {
    const Answer a = computed(heat::Shape::sphere, 20, 0.5, steps, m);
    return std::max(std::fabs(a.centre - fine.centre), std::fabs(a.surface - fine.surface));
  };
  const double a = off(50, Method::tr_bdf2), b = off(100, Method::tr_bdf2);
  const double c = off(50, Method::euler), d = off(100, Method::euler);
  std::printf("tr_bdf2: %.3e %.3e K (order %.2f); euler: %.3e %.3e K (order %.2f)\n", a, b, order(a, b), c, d,
              order(c, d));
  EXPECT_GT(order(a, b), 1.8);
  EXPECT_NEAR(order(c, d), 1, 0.15);
  EXPECT_LT(a, 0.1 * c);
}

TEST(Lumped, FollowsNewtonsLaw) {
  Grain<double> g(checked(inert(2700, 900, 200)), {heat::Shape::sphere, 0.005, 1, 1}, 800, {Method::tr_bdf2, 2, true});
  run(g, gas_at(300, 50), 0.5, 200);
  const double tau = 2700 * 900 * 0.005 / (3 * 50.0);
  EXPECT_NEAR(g.state.temperature[0], 300 + 500 * std::exp(-100 / tau), 1e-3);
}

TEST(Lumped, IsTooFastByTheKnownShareOfTheSlowestDecay) {
  // slowest rate zeta1^2 over the lumped one, 3 Bi
  const double Bi[] = {0.01, 0.1, 1, 10}, share[] = {0.9980, 0.9802, 0.8225, 0.2682};
  for (int k = 0; k < 4; ++k) {
    const double z = roots(heat::Shape::sphere, Bi[k], 1)[0];
    EXPECT_NEAR(z * z / (3 * Bi[k]), share[k], 1e-4);
    Grain<double> g(checked(inert(1000, 1000, 0.01 / Bi[k])), {heat::Shape::sphere, 0.01, 1, 20}, 400,
                    {Method::tr_bdf2, 2, false});
    const auto s = gas_at(300, 1);
    const double tau = 1000 * 1000 * 0.01 / 3;  // of the lumped grain
    run(g, s, tau / 50, 200);
    const double before = g.totals().mean - 300;
    for (int n = 0; n < 50; ++n) g.advance(tau / 50, s, s, {});
    EXPECT_NEAR(std::log(before / (g.totals().mean - 300)), share[k], (Bi[k] > 1 ? 0.02 : 0.003) * share[k]) << Bi[k];
  }
}

TEST(Surface, ContactFluxAndRadiationGiveTheirHeat) {
  Matter m = inert(1000, 1000, 100);
  Surroundings<double> s = gas_at(300, 0);
  s.flux = 1000;
  Grain<double> flux(checked(m), {heat::Shape::sphere, 0.01, 1, 5}, 300, {});
  run(flux, s, 1, 10);
  EXPECT_NEAR(flux.state.heat_in, 1000 * 4 * det::k_pi * 1e-4 * 10, 1e-9);
  // contact: tau = m c / H
  s.flux = 0;
  s.contact_conductance = 0.05;
  s.contact_temperature = 400;
  Grain<double> contact(checked(m), {heat::Shape::sphere, 0.01, 1, 1}, 300, {Method::tr_bdf2, 2, true});
  const double tau = 1e6 * 4.0 / 3 * det::k_pi * 1e-6 / 0.05;
  run(contact, s, tau / 200, 200);
  EXPECT_NEAR(contact.state.temperature[0], 400 - 100 * std::exp(-1.0), 2e-3);
  // radiation to equilibrium with walls
  s.contact_conductance = 0;
  s.emissivity = 1;
  s.wall_temperature = 900;
  Grain<double> hot(checked(m), {heat::Shape::sphere, 0.01, 1, 5}, 300, {});
  run(hot, s, 5, 2000);
  EXPECT_NEAR(hot.state.surface, 900, 1e-6);
}

TEST(Energy, ClosesToRoundingWhereHeatCapacityDependsOnTemperature) {
  Matter m = inert(540, 1800, 0.12);
  m.heat_capacity[1] = Property::table({300, 500, 501, 1500}, {800, 1500, 2900, 2500});
  Grain<double> g(checked(m), {heat::Shape::sphere, 5e-4, 1, 20}, 293, {});
  run(g, gas_at(1200, 350), 0.02, 1000);
  EXPECT_LT(std::fabs(g.heat_residual()), 1e-12 * std::fabs(g.state.heat_in));
  EXPECT_NEAR(g.state.temperature[0], 1200, 0.1);
}

TEST(Bounds, EulerNeverLeavesThemForAnyStepAndBiot) {
  for (const double Bi : {1e-3, 1.0, 1e3}) {
    for (const double step : {1e-3, 1.0, 1e3, 1e6}) {
      Grain<double> g(checked(inert(1000, 1000, 0.1)), {heat::Shape::sphere, 0.01, 1, 20}, 300,
                      {Method::euler, 3, false});
      const auto s = gas_at(2300, Bi * 0.1 / 0.01);
      g.begin(s);
      for (int k = 0; k < 20; ++k) {
        g.advance(step, s, s, {});
        for (const double T : g.state.temperature) {
          ASSERT_GE(T, 300 - 1e-9) << Bi << " " << step;
          ASSERT_LE(T, 2300 + 1e-9) << Bi << " " << step;
        }
      }
    }
  }
}

TEST(Bounds, TrBdf2KeepsThemUpToTheStepThatIsAdvised) {
  const double D = 0.1 / 1e6, dx = 0.01 / 20;
  const auto worst = [&](double step) {
    Grain<double> g(checked(inert(1000, 1000, 0.1)), {heat::Shape::sphere, 0.01, 1, 20}, 300, {});
    const auto s = gas_at(2300, 1e4);
    g.begin(s);
    double over = 0;
    for (int k = 0; k < 50; ++k) {
      g.advance(step, s, s, {});
      for (const double T : g.state.temperature) over = std::max({over, T - 2300, 300 - T});
    }
    return over;
  };
  EXPECT_LT(worst(2.41 * dx * dx / (4 * D)), 1e-6);
  EXPECT_LT(worst(1e4), 0.25 * 2000);  // beyond it a bounded swing that dies out
}

TEST(Property, IntegralIsThatOfItsValue) {
  const Property p = Property::polynomial({1112, 4.85, 1e-3}, 273.15, 280, 900);
  const Property t = Property::table({300, 400, 800}, {1, 3, 2});
  for (const Property* x : {&p, &t}) {
    for (const double T : {250.0, 310.0, 650.0, 1000.0}) {
      const double h = 1e-3;
      EXPECT_NEAR((x->integral(T + h) - x->integral(T - h)) / (2 * h), x->at(T), 1e-4) << T;
    }
  }
  EXPECT_NEAR(p.at(500.0), 1112 + 4.85 * 226.85 + 1e-3 * 226.85 * 226.85, 1e-9);
  EXPECT_EQ(t.at(900.0), 2);
}

}  // namespace
}  // namespace talus::conversion
