// Heat of grains against closed forms: conduction of pairs, chains and lattices, Newton's law, radiation, walls; orders
// of convergence are printed. Energy of closed boxes, and what a heat step refuses.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/error.hpp"
#include "core/heat/contact.hpp"
#include "core/heat/radiation.hpp"
#include "tests/part_values.hpp"
#include "tests/physics/physics_support.hpp"

namespace talus::physics {
namespace {

constexpr double k_R = 5e-3, k_rho = 2700, k_c = 900, k_k = 200;  // two spheres of the usual example
constexpr double k_a = 1.50554e-4;                                // radius of their contact [m]
const double k_delta = k_a * k_a / (k_R / 2), k_H = 2 * k_k * k_a, k_mc = sphere_mass(k_rho, k_R) * k_c;

std::vector<double> temperatures(const Simulation& sim) {
  for (const ExtraColumn& c : sim.frame().extra)
    if (c.name == "temperature") return c.values;
  ADD_FAILURE() << "no temperatures";
  return {};
}

/// Fixed grains; each of its own temperature where `T` gives them. Lengths of steps are heat steps.
Scene heat_scene(const std::vector<Grain>& grains, const std::vector<double>& T, double dt) {
  Scene s = open_scene({-1, -1, -1}, {1, 1, 1}, dt);
  s.materials[0].density = k_rho;
  s.allow_unstable_step = s.allow_initial_overlap = true;
  linear_law(s, 1, 0);
  s.heat.on = true;
  s.heat.every = 1;
  s.heat.temperature = 300;
  MatterHeat m;
  m.capacity = Curve::constant(k_c);
  m.conductivity = Curve::constant(k_k);
  s.heat.matter = {m};
  for (std::size_t k = 0; k < grains.size(); ++k) {
    add_grains(s, {grains[k]});
    s.heat.sources.push_back({T[T.size() == 1 ? 0 : k], false});
  }
  return s;
}
std::vector<Grain> row_of(int n) {
  std::vector<Grain> g(static_cast<std::size_t>(n));
  for (int k = 0; k < n; ++k) {
    g[static_cast<std::size_t>(k)].x = {(2 * k_R - k_delta) * k, 0, 0};
    g[static_cast<std::size_t>(k)].r = k_R;
    g[static_cast<std::size_t>(k)].fixed = true;
  }
  return g;
}

/// Errors at the end of `time` in so many steps each; prints them, returns the order of the last two.
template <class F>
double order_of(const std::string& name, const std::vector<int>& steps, F error) {
  std::vector<double> n, e;
  for (const int k : steps) {
    n.push_back(k);
    e.push_back(error(k));
    figure(name, e.back(), fmt::format("error [K], {} heat steps", k));
  }
  const std::size_t last = n.size() - 1;
  const double order = std::log(e[last - 1] / e[last]) / std::log(n[last] / n[last - 1]);
  figure(name, order, "order");
  return order;
}

TEST(Heat, TwoSpheresEqualiseAtTheClosedFormsRate) {
  const double tau = k_mc / (2 * k_H), time = tau;
  EXPECT_NEAR(tau, 10.564, 1e-3);
  EXPECT_NEAR(k_H, 0.060221, 1e-6);
  const double order = order_of("two spheres", {50, 100, 200}, [&](int n) {
    Simulation sim(heat_scene(row_of(2), {400, 300}, time / n), options());
    sim.run(n);
    const std::vector<double> T = temperatures(sim);
    EXPECT_NEAR(T[0] + T[1], 700, 1e-10);
    return std::fabs(T[0] - T[1] - 100 * std::exp(-time / tau));
  });
  EXPECT_NEAR(order, 1, 0.05);
}

TEST(Heat, ChainsSlowestModeDecaysAtTheClosedFormsRate) {
  constexpr int k_n = 10;
  const double s = std::sin(std::numbers::pi / (2 * k_n)), tau = k_mc / (4 * k_H * s * s), time = 0.5 * tau;
  EXPECT_NEAR(tau, 215.84, 0.02);
  std::vector<double> start;
  for (int k = 0; k < k_n; ++k) start.push_back(350 + 50 * std::cos(std::numbers::pi * (k + 0.5) / k_n));
  const double order = order_of("chain of 10", {50, 100, 200}, [&](int n) {
    Simulation sim(heat_scene(row_of(k_n), start, time / n), options());
    sim.run(n);
    double worst = 0;
    const std::vector<double> T = temperatures(sim);
    for (std::size_t k = 0; k < T.size(); ++k)
      worst = std::max(worst, std::fabs(T[k] - (350 + (start[k] - 350) * std::exp(-time / tau))));
    return worst;
  });
  EXPECT_NEAR(order, 1, 0.05);
}

TEST(Heat, GrainInGasFollowsNewtonsLaw) {
  const double h = 50, tau = k_rho * k_c * k_R / (3 * h), time = tau;
  const double order = order_of("Newton cooling", {50, 100, 200}, [&](int n) {
    Scene s = heat_scene(row_of(1), {800}, time / n);
    s.heat.gas.on = true;
    s.heat.gas.film = h;
    s.heat.gas.temperature = TimeTable::constant(300);
    Simulation sim(s, options());
    sim.run(n);
    EXPECT_NEAR(value_of(sim, "heat.residual"), 0, 1e-12 * value_of(sim, "heat.total"));
    EXPECT_NEAR(value_of(sim, "heat.in_by_gas"), k_mc * (temperatures(sim)[0] - 800), 1e-10 * k_mc * 500);
    return std::fabs(temperatures(sim)[0] - (300 + 500 * std::exp(-time / tau)));
  });
  EXPECT_NEAR(order, 1, 0.05);
}

TEST(Heat, GrainInAnEnclosureFollowsTheFourthPower) {
  constexpr double k_e = 0.8, Te = 300, T0 = 1000;
  const double rate = heat::k_stefan * k_e * 4 * k_pi * k_R * k_R / k_mc;
  const auto time_to = [&](double T) {  // from far above
    return (std::log((T + Te) / (T - Te)) + 2 * std::atan(T / Te)) / (4 * rate * Te * Te * Te);
  };
  const double time = time_to(600) - time_to(T0);
  const double order = order_of("radiation to an enclosure", {50, 100, 200}, [&](int n) {
    Scene s = heat_scene(row_of(1), {T0}, time / n);
    s.heat.matter[0].emissivity = k_e;
    s.heat.radiation.enclosure = TimeTable::constant(Te);
    Simulation sim(s, options());
    sim.run(n);
    return std::fabs(temperatures(sim)[0] - 600);
  });
  EXPECT_NEAR(order, 1, 0.05);
}

TEST(Heat, TwoGrainsRadiateWithoutTouchingUntilTheyAreAlike) {
  std::vector<Grain> two = row_of(2);
  two[1].x.x = 2.2 * k_R;
  Scene s = heat_scene(two, {1200, 400}, 1);
  s.heat.radiation.grains = true;
  Simulation sim(s, options());
  sim.run(1);
  const double X = heat::exchange_area(k_R, k_R, 2.2 * k_R), grey = heat::grey_factor(0.9, 0.9);
  EXPECT_NEAR(1200 - temperatures(sim)[0], heat::k_stefan * X * grey * (std::pow(1200, 4) - std::pow(400, 4)) / k_mc,
              1e-9);
  EXPECT_NEAR(X / (4 * k_pi * k_R * k_R), 0.0546, 5e-4) << "share of the view";
  sim.run(20000);
  const std::vector<double> T = temperatures(sim);
  EXPECT_NEAR(T[0], 800, 0.5);
  EXPECT_NEAR(T[0] + T[1], 1600, 1e-9);
}

TEST(Heat, SimpleCubicArrayHasTheConductivityOfItsContacts) {
  // 4 x 4 columns of 6 spheres, periodic across; the end layers are held
  constexpr int k_n = 4, k_high = 6;
  const double l = 2 * k_R - k_delta;
  Scene s = open_scene({0, 0, 0}, {k_n * l, k_n * l, k_high * l}, 0.4 * k_mc / (6 * k_H));
  for (std::size_t axis : {0U, 1U}) s.domain.boundary[axis] = {Boundary::periodic, Boundary::periodic};
  const Scene heat = heat_scene({}, {300}, s.dt);
  s.materials = heat.materials;
  s.contact = heat.contact;
  s.allow_unstable_step = s.allow_initial_overlap = true;
  s.heat = heat.heat;
  for (int z = 0; z < k_high; ++z) {
    std::vector<Grain> layer;
    for (int k = 0; k < k_n * k_n; ++k) {
      Grain g;
      g.x = {(k % k_n + 0.5) * l, (k / k_n + 0.5) * l, (z + 0.5) * l};
      g.r = k_R;
      g.fixed = true;
      layer.push_back(g);
    }
    add_grains(s, layer);
    s.heat.sources.push_back({z == 0 ? 400.0 : 300.0, z == 0 || z == k_high - 1});
  }
  Simulation sim(s, options());
  sim.run(3000);
  const double area = k_n * k_n * l * l, gradient = 100 / ((k_high - 1) * l);
  const double expected = 2 * k_k * k_a / l;
  for (const char* name : {"heat.flow.source_0", "heat.flow.source_5"}) {
    const double k_eff = std::fabs(value_of(sim, name)) / (area * gradient);
    figure("simple cubic array", k_eff / expected - 1, fmt::format("relative error of k_eff by {}", name));
    EXPECT_NEAR(k_eff / expected, 1, 1e-10);
  }
  EXPECT_NEAR(value_of(sim, "heat.residual"), 0, 1e-12 * value_of(sim, "heat.total"));
}

TEST(Heat, EnthalpyIsWhatTwoGrainsShareWhereTheCapacityDependsOnTemperature) {
  Scene s = heat_scene(row_of(2), {900, 300}, 0.5);
  s.heat.matter[0].capacity = {{600, 0.8}, 0, 250, 2000, {}, {}};
  s.heat.matter[0].conductivity = {{}, 0, 0, 0, {300, 900}, {100, 200}};
  Simulation sim(s, options());
  const double before = value_of(sim, "heat.total");
  sim.run(4000);
  // 600 T + 0.4 T^2 of both halves
  const double h = 0.5 * (600 * 1200 + 0.4 * (900 * 900 + 300 * 300));
  const double T = (-600 + std::sqrt(600 * 600 + 1.6 * h)) / 0.8;
  EXPECT_NEAR(temperatures(sim)[0], T, 1e-8);
  EXPECT_NEAR(temperatures(sim)[1], T, 1e-8);
  EXPECT_NEAR(value_of(sim, "heat.total") / before, 1, 1e-13);
}

TEST(Heat, ClosedBoxAtRestKeepsItsEnergyOverManyHeatSteps) {
  // unequal grains that touch, nearly touch or see each other; conduction, gas between them, radiation
  std::vector<Grain> grains;
  std::vector<double> T;
  for (int k = 0; k < 27; ++k) {
    Grain g;
    g.r = k_R * (0.8 + 0.2 * uniform(5, static_cast<std::uint64_t>(k)));
    g.x = {1.8 * k_R * (k % 3), 1.9 * k_R * (k / 3 % 3), 2.05 * k_R * (k / 9)};
    g.fixed = true;
    grains.push_back(g);
    T.push_back(300 + 900 * uniform(6, static_cast<std::uint64_t>(k)));
  }
  Scene s = heat_scene(grains, T, 0.002);
  s.heat.gap.conductivity = 0.06;
  s.heat.radiation.grains = true;
  s.max_overlap = 1;
  Simulation sim(s, options());
  const double before = value_of(sim, "heat.total");
  sim.run(100000);
  const double change = value_of(sim, "heat.total") / before - 1;
  figure("closed box", change, "relative change of the energy over 1e5 heat steps");
  EXPECT_LT(std::fabs(change), 1e-12);
  EXPECT_LT(value_of(sim, "heat.highest") - value_of(sim, "heat.lowest"), 200) << "heat has moved";
  EXPECT_GE(value_of(sim, "heat.lowest"), *std::min_element(T.begin(), T.end()));
  EXPECT_LE(value_of(sim, "heat.highest"), *std::max_element(T.begin(), T.end()));
}

TEST(Heat, WhatContactsDissipateHeatsTheGrains) {
  Scene s = open_scene({0, 0, 0}, {0.05, 0.05, 0.05}, 2e-6);
  for (auto& axis : s.domain.boundary) axis = {Boundary::wall, Boundary::wall};
  s.gravity = {0, 0, -9.81};
  std::vector<Grain> grains;
  for (int k = 0; k < 64; ++k) {
    Grain g;
    g.r = 0.004;
    g.x = {0.008 + 0.011 * (k % 4), 0.008 + 0.011 * (k / 4 % 4), 0.008 + 0.011 * (k / 16)};
    for (int a = 0; a < 3; ++a) g.v[a] = 4 * uniform(7, static_cast<std::uint64_t>(3 * k + a)) - 2;
    grains.push_back(g);
  }
  add_grains(s, grains);
  linear_law(s, 5e4, 300, 2e4, 100, 0.4);
  s.output.energies = true;
  s.heat = heat_scene({}, {300}, 1).heat;
  s.heat.every = 100;
  s.heat.friction = true;
  s.heat.sources = {{300, false}};
  Simulation sim(s, options());
  const double before = value_of(sim, "heat.total");
  sim.run(20000);
  const Energies e = sim.energies();
  const double lost = e.dissipated_damping + e.dissipated_friction, gained = value_of(sim, "heat.total") - before;
  EXPECT_GT(lost, 0.05 * (e.kinetic_translation + e.kinetic_rotation));
  EXPECT_NEAR(gained, lost, 1e-12 * before + 1e-9 * lost);
  EXPECT_NEAR(value_of(sim, "heat.in_by_friction"), lost, 1e-9 * lost);
  figure("closed box of moving grains", (gained - lost) / lost, "heat gained less energy dissipated, relative");
  figure("closed box of moving grains", e.residual / lost, "residual of the mechanical balance, relative");
}

TEST(Heat, WallsHoldTemperaturesAndGiveFluxes) {
  Scene s = heat_scene(row_of(1), {300}, 0.2);
  s.walls = {plane("floor", {0, 0, -k_R + k_delta}, {0, 0, 1}), plane("lid", {0, 0, k_R - k_delta}, {0, 0, -1})};
  WallHeat floor, lid;
  floor.wall = "floor";
  floor.temperature = TimeTable::constant(500);
  lid.wall = "lid";
  lid.temperature = TimeTable::constant(300);
  lid.layer = {1e-3, 0.3};
  s.heat.walls = {floor, lid};
  Simulation sim(s, options());
  sim.run(5000);
  const double a = std::sqrt(k_R * k_delta), G = 2 * k_k * a;
  const double other = 1 / (1 / G + 1e-3 / (0.3 * k_pi * k_R * k_R));
  EXPECT_NEAR(temperatures(sim)[0], (500 * G + 300 * other) / (G + other), 1e-8);
  EXPECT_NEAR(value_of(sim, "heat.flow.floor"), -value_of(sim, "heat.flow.lid"), 1e-9);
  EXPECT_NEAR(value_of(sim, "heat.residual"), 0, 1e-12 * value_of(sim, "heat.total"));

  s.domain.lower = {-0.1, -0.1, -0.1};
  s.domain.upper = {0.1, 0.1, 0.1};
  s.heat.walls[0] = {"floor", {}, TimeTable::constant(250), {}};
  s.heat.walls.pop_back();
  Simulation heated(s, options());
  heated.run(100);
  EXPECT_NEAR(value_of(heated, "heat.in_by_walls"), 250 * 0.04 * 20, 1e-8);
  EXPECT_NEAR(temperatures(heated)[0], 300 + 250 * 0.04 * 20 / k_mc, 1e-8);
}

TEST(Heat, ContactsShowWhatTheyConductIntoTheirFirstGrain) {
  std::vector<Grain> row = row_of(3);
  row[1].fixed = false;  // contact files leave out pairs of fixed grains
  Scene s = heat_scene(row, {400, 300, 350}, 0.2);
  s.walls = {plane("floor", {0, 0, -k_R + k_delta}, {0, 0, 1})};
  WallHeat floor;
  floor.wall = "floor";
  floor.temperature = TimeTable::constant(500);
  s.heat.walls = {floor};
  const Simulation sim(s, options());
  const std::vector<double> T = temperatures(sim);
  const Frame f = sim.frame({.contacts = true});
  ASSERT_EQ(f.contact_extra.size(), 1u);
  EXPECT_EQ(f.contact_extra[0].name, "heat_flow");
  ASSERT_EQ(f.contact_extra[0].values.size(), f.contacts.size());
  ASSERT_EQ(f.contacts.size(), 5u) << "two pairs and three grains on the floor";
  const double on_wall = 2 * k_k * std::sqrt(k_R * k_delta);
  for (std::size_t k = 0; k < f.contacts.size(); ++k) {
    const ContactRecord& c = f.contacts[k];
    const double here = T[static_cast<std::size_t>(c.a)];
    const double wanted = c.b < 0 ? on_wall * (500 - here) : k_H * (T[static_cast<std::size_t>(c.b)] - here);
    EXPECT_GT(std::fabs(wanted), 0.1);
    EXPECT_NEAR(f.contact_extra[0].values[k], wanted, 1e-9 * std::fabs(wanted) + 1e-12) << c.a << " " << c.b;
  }
}

TEST(Heat, FluxIsThatOfTheWallOnceHoweverItMeetsPeriodicSidesAndWhenEverItAppears) {
  const double area = 2 * (0.4 * 0.2 + 0.4 * 0.1 + 0.2 * 0.1), flux = 400, dt = 0.2, c = k_mc;
  const auto warmed = [&](double low, double grain, double appear) {
    Scene s = heat_scene({{{grain, 0.3, 0.2 + 0.99 * k_R}, {}, k_R, {}, 0, true}}, {300}, dt);
    s.domain = Domain{{0, 0, 0}, {1, 1, 1}, {}};
    for (int k = 0; k < 2; ++k)
      s.domain.boundary[static_cast<std::size_t>(k)] = {Boundary::periodic, Boundary::periodic};
    WallSpec w;
    w.name = "w";
    w.shape = WallShape::box;
    w.lower = {low, 0.2, 0.1};
    w.upper = {low + 0.4, 0.4, 0.2};
    w.appear = appear;
    s.walls = {w};
    WallHeat h;
    h.wall = "w";
    h.flux = TimeTable::constant(flux);
    s.heat.walls = {h};
    Simulation sim(s, options());
    sim.run(10);
    return (temperatures(sim)[0] - 300) * c;
  };
  EXPECT_NEAR(warmed(0.2, 0.4, 0) / (flux * area * 10 * dt), 1, 1e-9);
  EXPECT_NEAR(warmed(0.8, 0.95, 0) / (flux * area * 10 * dt), 1, 1e-9) << "it reaches across a side";
  EXPECT_NEAR(warmed(0.2, 0.4, 4 * dt) / (flux * area * 6 * dt), 1, 1e-9) << "it appears after four steps";
}

TEST(Heat, GapConductsAsItsIntegral) {
  for (const double gap : {-2e-5, 0.0, 1e-6, 1e-4, 2e-3}) {
    const double R = k_R, layer = 0.4, least = 2.75e-8, k = 0.026, d = gap + 2 * R;
    const double edge = std::max(0.0, R * R - d * d / 4),
                 out = std::min(R * R, std::pow(R * (1 + layer), 2) - d * d / 4);
    double sum = 0;
    const int n = 2000000;
    for (int q = 0; q < n; ++q) {
      // squares of r, finer near the axis where the gap is narrow
      const double x = (q + 0.5) / n, r2 = edge + (out - edge) * x * x * x;
      sum += k_pi * k * (out - edge) * 3 * x * x / n / std::max(least, d - 2 * std::sqrt(R * R - r2));
    }
    EXPECT_NEAR(heat::gap_conductance(k, R, gap, layer, least) / sum, 1, 1e-4) << gap;
  }
  EXPECT_EQ(heat::gap_conductance(0.026, k_R, 0.81 * k_R, 0.4, 1e-8), 0) << "beyond both layers";
}

TEST(Heat, ContactsOfSoftenedModelsConductAsRealOnes) {
  // the same load on a Hertz contact of 1/1000 of the modulus
  const double r_star = k_R / 2, soft = 5e6, real = 5e9, force = 0.1;
  const double wide = heat::hertz_radius_of_force(r_star, force, soft);
  EXPECT_NEAR(wide, heat::hertz_contact_radius(r_star, wide * wide / r_star), 1e-12);
  EXPECT_NEAR(wide * std::cbrt(soft / real), heat::hertz_radius_of_force(r_star, force, real), 1e-15);
  // JKR: the radius without load, (6 pi w R*^2 / (4/3 E*) * ...): delta = a^2/R* - 4 sqrt(kappa a)
  const double kappa = 1e-9, a = heat::jkr_contact_radius(r_star, 1e-6, kappa);
  EXPECT_NEAR(a * a / r_star - 4 * std::sqrt(kappa * a), 1e-6, 1e-15);
}

TEST(Heat, HeatStepThatWouldOvershootIsRefusedWithTheLargestThatWouldNot) {
  const double limit = k_mc / (2 * k_H);  // of the grain in the middle
  Scene s = heat_scene(row_of(3), {400, 300, 500}, limit / 10.5);
  s.heat.every = 11;
  Simulation sim(s, options());
  try {
    sim.run(11);
    FAIL() << "accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::physics);
    EXPECT_NE(std::string(e.what()).find("heat.every = 10 at most"), std::string::npos) << e.what();
  }
  s.heat.every = 10;
  Simulation good(s, options());
  good.run(1000);
  for (const double T : temperatures(good)) {
    EXPECT_GE(T, 300);
    EXPECT_LE(T, 500);
  }
}

}  // namespace
}  // namespace talus::physics
