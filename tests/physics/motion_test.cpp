// Motion of one or two particles against closed forms: free fall, bouncing (MFiX DEM02), a stacked pair between walls
// (MFiX DEM03), slip to roll (MFiX DEM04), and the order of the integrators in translation and rotation.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "physics_support.hpp"

namespace talus::physics {
namespace {

TEST(PhysicsMotion, FreeFallIsExact) {
  // Velocity Verlet is exact under constant acceleration; 1000 additions round to about 1e-13.
  const double dt = 1e-3, g = 9.81;
  Scene s = open_scene({-10, -10, -10}, {10, 10, 10}, dt);
  linear_law(s, 1e3, 0);
  s.gravity = {1.5, -2.25, -g};
  const Vec3 x0{1, 2, 8}, v0{-3, 1, 2.5};
  add_grains(s, {{x0, v0, 0.01}});
  Simulation sim(s, options());
  sim.run(1000);
  const Frame f = sim.frame();
  double worst = 0;
  for (int k = 0; k < 3; ++k) {
    worst = std::max(worst, std::fabs(f.x[0][k] - (x0[k] + v0[k] + 0.5 * s.gravity[k])));
    worst = std::max(worst, std::fabs(f.v[0][k] - (v0[k] + s.gravity[k] * (1 - 0.5 * dt))));
  }
  figure("free fall for 1 s: largest error [m, m/s]", worst);
  EXPECT_LT(worst, 1e-12);
}

TEST(PhysicsMotion, GrainsLeaveThroughEveryOpenSideInTheStepInWhichTheyCrossIt) {
  for (const bool turning : {false, true}) {
    const double dt = 1e-3, speed = 10;
    Scene s = open_scene({-1, -2, -3}, {1, 2, 3}, dt);
    linear_law(s, 100, 0, turning ? 20 : 0, 0, turning ? 0.5 : 0);
    std::vector<Grain> grains = {{{0, 0, 0}, {0, 0, 0}, 0.05}};
    for (int a = 0; a < 3; ++a)
      for (const double way : {-1.0, 1.0}) {
        Grain g{{0, 0, 0}, {0, 0, 0}, 0.05};
        g.x[a] = way * (s.domain.upper[a] - 3.5 * speed * dt);
        g.v[a] = way * speed;
        grains.push_back(g);
      }
    add_grains(s, grains);
    Simulation sim(s, options());
    sim.run(3);
    EXPECT_EQ(sim.counters().removed, 0) << "3 of 3.5 steps";
    sim.run(1);
    EXPECT_EQ(sim.counters().removed, 6);
    EXPECT_EQ(sim.particles(), 1);
    EXPECT_EQ(sim.frame().id, std::vector<ParticleId>{0}) << "the one in the middle";
  }
}

TEST(PhysicsMotion, WallReturnsTheRestitution) {
  for (const double e : {0.2, 0.5, 0.8, 1.0}) {
    const double r = 0.1, m = sphere_mass(2500, r),
                 zeta = -std::log(e) / std::sqrt(k_pi * k_pi + std::log(e) * std::log(e));
    const double kn = m * k_pi * k_pi / (1 - zeta * zeta) * 1e4;  // t_c = 0.01 s
    Scene s = open_scene({-1, -1, -1}, {1, 1, 1}, 1e-5);
    linear_restitution(s, kn, e);
    const Vec3 n{0.6, 0, 0.8};
    s.walls.push_back(plane("slope", {0, 0, -0.5}, n));
    add_grains(s, {{Vec3{0, 0, -0.5} + (r + 2.5e-5) * n, -1.0 * n, r}});
    Simulation sim(s, options());
    sim.run(1100);
    const double got = dot(sim.frame().v[0], n);
    figure("linear, inclined wall: restitution error at e = " + std::to_string(e).substr(0, 3), std::fabs(got - e));
    EXPECT_NEAR(got, e, 5e-6);
  }
}

TEST(PhysicsMotion, BouncingPeaksFollowTheSquareOfRestitution) {
  // MFiX DEM02: h_k = R + (h_0 - R) e^(2k) for an instantaneous contact. With t_c = 1e-4 s the time and depth of the
  // contact change the peaks by (g t_c / v)^2 and the weight's work over the depth, below 1e-3 down to the fourth peak.
  const double r = 0.1, h0 = 1.1, g = 9.81, e = 0.8, m = sphere_mass(2500, r), tc = 1e-4, dt = 1e-6;
  const double zeta = -std::log(e) / std::sqrt(k_pi * k_pi + std::log(e) * std::log(e));
  Scene s = open_scene({-1, -1, -1}, {1, 1, 2}, dt);
  linear_restitution(s, m * (k_pi / tc) * (k_pi / tc) / (1 - zeta * zeta), e);
  s.gravity = {0, 0, -g};
  s.walls.push_back(plane("floor", {0, 0, 0}, {0, 0, 1}));
  add_grains(s, {{{0, 0, h0}, {0, 0, 0}, r}});
  Simulation sim(s, options());
  double worst = 0, time = std::sqrt(2 * (h0 - r) / g);
  for (int k = 1; k <= 4; ++k) {
    const double peak = r + (h0 - r) * std::pow(e, 2 * k), rise = std::sqrt(2 * (peak - r) / g);
    time += rise;
    // a little before the peak: height and speed there give the peak's height without searching for it
    sim.run(std::llround(time / dt) - sim.step());
    const Frame f = sim.frame();
    const double v = f.v[0].z - 0.5 * g * dt, height = f.x[0].z + 0.5 * v * v / g;
    worst = std::max(worst, std::fabs((height - r) / (peak - r) - 1));
    time += rise;
  }
  figure("bouncing ball: largest relative error of four peaks", worst);
  EXPECT_LT(worst, 1e-3);
}

TEST(PhysicsMotion, StackedPairFollowsItsDifferentialEquation) {
  // MFiX DEM03: two particles squeezed between two walls, linear law with damping. Reference: RK4 in this test with a
  // 20 times smaller step. Stays in contact throughout, so that the comparison is smooth.
  const double r = 0.05, kn = 2e4, g = 9.81, rate = 20, dt = 2e-5, height = 3.96 * r;
  const double m1 = sphere_mass(2500, r), m2 = sphere_mass(4000, r);
  Scene s = open_scene({-1, -1, 0}, {1, 1, height}, dt);
  s.materials = {{"light", 2500, 0, 0}, {"heavy", 4000, 0, 0}};
  s.pairs.assign(4, {});
  linear_law(s, kn, rate);
  s.gravity = {0, 0, -g};
  s.allow_initial_overlap = true;
  s.walls = {plane("floor", {0, 0, 0}, {0, 0, 1}), plane("lid", {0, 0, height}, {0, 0, -1})};
  const double z1 = 0.985 * r, z2 = 2.975 * r;
  Grain upper{{0, 0, z2}, {0, 0, 0}, r};
  upper.material = 1;
  add_grains(s, {{{0, 0, z1}, {0, 0, 0}, r}, upper});
  Simulation sim(s, options());
  using State = std::array<double, 4>;
  const double m12 = m1 * m2 / (m1 + m2);
  const auto rhs = [&](const State& y) {
    const double floor = kn * std::max(0.0, r - y[0]) - (y[0] < r ? rate * m1 * y[2] : 0);
    const double d = 2 * r - (y[1] - y[0]);
    const double middle = d > 0 ? kn * d - rate * m12 * (y[3] - y[2]) : 0;
    const double lid = y[1] > height - r ? kn * (y[1] - height + r) + rate * m2 * y[3] : 0;
    return State{y[2], y[3], (floor - middle) / m1 - g, (middle - lid) / m2 - g};
  };
  State y{z1, z2, 0, 0};
  const double h = dt / 20;
  double worst = 0, range = 0;
  for (int n = 0; n < 5000; ++n) {
    sim.run(1);
    for (int k = 0; k < 20; ++k) {
      const auto add = [](const State& a, double q, const State& b) {
        return State{a[0] + q * b[0], a[1] + q * b[1], a[2] + q * b[2], a[3] + q * b[3]};
      };
      const State a = rhs(y), b = rhs(add(y, h / 2, a)), c = rhs(add(y, h / 2, b)), d = rhs(add(y, h, c));
      for (int q = 0; q < 4; ++q) y[static_cast<std::size_t>(q)] += h / 6 * (a[q] + 2 * b[q] + 2 * c[q] + d[q]);
    }
    const Frame f = sim.frame();
    worst = std::max({worst, std::fabs(f.x[0].z - y[0]), std::fabs(f.x[1].z - y[1])});
    range = std::max({range, std::fabs(y[0] - z1), std::fabs(y[1] - z2)});
  }
  figure("stacked pair: largest position error / range of motion", worst / range);
  // omega dt is 4e-3; damping is centred for the pair alone, each grain has two contacts: first order in their
  // coupling.
  EXPECT_LT(worst / range, 1e-3);
}

/// Sphere set down sliding on a plane: time at which it rolls and speed from then on.
void slip_to_roll(const std::string& name, bool hertz) {
  const double r = 0.01, g = 9.81, mu = 0.3, u0 = 1, m = sphere_mass(2500, r), dt = 4e-6;
  Scene s = open_scene({-1, -1, -1}, {1, 1, 1}, dt);
  double depth = 1e-5 * r;
  if (hertz) {
    s.materials[0].young = 1e9;
    s.materials[0].poisson = 0.3;
    hertz_law(s, 0.5, mu);
    depth = std::pow(m * g / (4.0 / 3.0 * (1e9 / (2 * (1 - 0.09))) * std::sqrt(r)), 2.0 / 3.0);
  } else {
    const double kn = m * g / depth;
    linear_law(s, kn, 500, 2.0 / 7.0 * kn, 2000, mu);
  }
  s.gravity = {0, 0, -g};
  s.allow_initial_overlap = true;
  s.walls.push_back(plane("floor", {0, 0, 0}, {0, 0, 1}));
  add_grains(s, {{{-0.5, 0, r - depth}, {u0, 0, 0}, r}});
  Simulation sim(s, options());
  const double ts = 2 * u0 / (7 * mu * g);
  // slipping: u and the slip u - w r fall linearly; the slip's zero from two instants
  double slip[2], at[2] = {0.3 * ts, 0.8 * ts}, decay = 0;
  for (int k = 0; k < 2; ++k) {
    sim.run(std::llround(at[k] / dt) - sim.step());
    const Frame f = sim.frame();
    slip[k] = f.v[0].x - f.w[0].y * r;
    decay = std::max(decay, std::fabs(f.v[0].x / (u0 - mu * g * (sim.time() - 0.5 * dt)) - 1));
  }
  const double zero = at[0] + (at[1] - at[0]) * slip[0] / (slip[0] - slip[1]);
  // the end of slipping itself: friction drops below half of mu m g
  double end = -1, before = sim.frame().v[0].x;
  while (end < 0 && sim.time() < 2 * ts) {
    sim.run(1);
    const double u = sim.frame().v[0].x;
    if ((before - u) / dt < 0.5 * mu * g) end = sim.time();
    before = u;
  }
  sim.run(std::llround(0.2 / dt));
  const Frame f = sim.frame();
  figure(name + " slip to roll: relative error of u while slipping", decay);
  const double lever = (r - depth) / r, rolling = u0 / (1 + 0.4 / (lever * lever));
  figure(name + " slip to roll: u / (5 u0 / 7) - 1", f.v[0].x / (5 * u0 / 7) - 1);
  figure(name + " slip to roll: u / (5 u0 / 7 with the lever R - depth) - 1", f.v[0].x / rolling - 1);
  figure(name + " slip to roll: t_s by extrapolated slip, relative error", zero / ts - 1);
  figure(name + " slip to roll: t_s by end of sliding friction, relative error", end / ts - 1);
  figure(name + " slip to roll: remaining slip / u0", (f.v[0].x - f.w[0].y * r) / u0);
  // The lever is R - depth, which takes 4/7 depth/R = 6e-6 (Hertz at 1 GPa: 7e-5) off 5/7. The last instants before
  // rolling load the tangential spring, whose period is 1e-3 of t_s.
  EXPECT_LT(decay, 1e-8);
  EXPECT_NEAR(f.v[0].x / (5 * u0 / 7), 1, 1e-4);
  EXPECT_NEAR(f.v[0].x / rolling, 1, 1e-6);
  EXPECT_NEAR(zero / ts, 1, 2e-4);
  EXPECT_NEAR(end / ts, 1, 5e-3);
  EXPECT_LT(std::fabs(f.v[0].x - lever * f.w[0].y * r) / u0, 1e-6);
}

TEST(PhysicsMotion, SlippingLinearSphereRollsAtFiveSevenths) { slip_to_roll("linear", false); }
TEST(PhysicsMotion, SlippingHertzSphereRollsAtFiveSevenths) { slip_to_roll("hertz", true); }

TEST(PhysicsMotion, FrictionlessContactsLeaveSpinUnchanged) {
  // mu = 0 with the frictional kernels: the Coulomb cap is zero, spins keep their bits.
  const double r = 0.5, dt = 1e-3;
  for (const bool hertz : {false, true}) {
    Scene s = open_scene({-5, -5, -5}, {5, 5, 5}, dt);
    if (hertz) {
      s.materials[0].young = 1e8;
      s.materials[0].poisson = 0.2;
      hertz_law(s, 0.7, 0);
      s.contact.friction = true;
    } else {
      linear_law(s, 1e6, 20, 3e5, 10, 0);
    }
    const Vec3 wa{3, -2, 5}, wb{-1, 7, 0.5};
    add_grains(s, {{{-0.6, 0, 0}, {1, 0.1, 0}, r, wa}, {{0.6, 0.3, 0.1}, {-1, 0, 0.2}, r, wb}});
    Simulation sim(s, options());
    sim.run(100);
    const bool touched = !sim.frame({.contacts = true}).contacts.empty();
    sim.run(900);
    const Frame f = sim.frame();
    EXPECT_TRUE(touched || f.v[0].x < 0.5) << "no impact happened";
    for (int k = 0; k < 3; ++k) {
      // stored as r w: r = 1/2 loses no bit
      EXPECT_EQ(f.w[0][k], wa[k]);
      EXPECT_EQ(f.w[1][k], wb[k]);
    }
  }
}

/// Position and velocity error after one second of a sphere held by two walls along x (a spring), and of the rolling
/// oscillation of a sphere on a sticky plane that is pulled from rest.
struct IntegratorErrors {
  double x, v, spin;
};

enum class Start { at_step_0, half_step_back };

IntegratorErrors oscillate(Integrator integrator, Start start, double steps) {
  const double r = 0.5, dt = 1.0 / steps;
  IntegratorErrors out{};
  {
    // spring: walls at both sides with initial overlap, m x'' = -2 k x
    const double omega = 2 * k_pi * 1.7;
    Scene s = open_scene({-2, -2, -2}, {2, 2, 2}, dt);
    s.materials[0].density = 1 / sphere_mass(1, r);
    s.integrator = integrator;
    linear_law(s, 0.5 * omega * omega, 0);
    s.allow_initial_overlap = true;
    s.walls = {plane("left", {-0.45, 0, 0}, {1, 0, 0}), plane("right", {0.45, 0, 0}, {-1, 0, 0})};
    const double x0 = 0.01, v0 = 0.2;
    const auto position = [&](double t) { return x0 * std::cos(omega * t) + v0 / omega * std::sin(omega * t); };
    const auto velocity = [&](double t) { return v0 * std::cos(omega * t) - x0 * omega * std::sin(omega * t); };
    add_grains(s, {{{x0, 0, 0}, {start == Start::at_step_0 ? v0 : velocity(-0.5 * dt), 0, 0}, r}});
    Simulation sim(s, options());
    sim.run(std::llround(steps));
    const Frame f = sim.frame();
    out.x = std::fabs(f.x[0].x - position(1));
    out.v = std::fabs(f.v[0].x - velocity(1 - 0.5 * dt));
  }
  {
    // rolling: slip s'' = g - 7/2 k_t/m s from rest, so r w = 5/7 g (t - sin(W t)/W), W^2 = 7/2 k_t/m
    const double big = 2 * k_pi * 1.3, kt = big * big * 2 / 7, g = 0.3, weight = 10, kn = 2e3;
    Scene s = open_scene({-2, -2, -2}, {2, 2, 2}, dt);
    s.materials[0].density = 1 / sphere_mass(1, r);
    s.integrator = integrator;
    linear_law(s, kn, 0, kt, 0, 100);
    s.contact.lever = Lever::radius;
    s.allow_initial_overlap = true;
    s.gravity = {g, 0, -weight};
    s.walls = {plane("floor", {0, 0, -0.5}, {0, 0, 1})};
    const double back =
        start == Start::at_step_0 ? 0 : -0.5 * dt;  // at rest at t = 0: v(-dt/2) = -g dt/2, no force yet
    add_grains(s, {{{0, 0, -weight / kn}, {g * back, 0, 0}, r}});
    Simulation sim(s, options());
    sim.run(std::llround(steps));
    const double t = 1 - 0.5 * dt;
    out.spin = std::fabs(r * sim.frame().w[0].y - 5.0 / 7.0 * g * (t - std::sin(big * t) / big));
  }
  return out;
}

void check_order(const std::string& name, Integrator integrator, Start start, double low, double high) {
  std::vector<double> dt, x, v, spin;
  for (const double n : {400.0, 800.0, 1600.0, 3200.0}) {
    const IntegratorErrors e = oscillate(integrator, start, n);
    dt.push_back(1 / n);
    x.push_back(e.x);
    v.push_back(e.v);
    spin.push_back(e.spin);
  }
  const double sx = log_slope(dt, x), sv = log_slope(dt, v), sw = log_slope(dt, spin);
  figure(name + ": order of position", sx);
  figure(name + ": order of velocity", sv);
  figure(name + ": order of spin", sw);
  for (const double slope : {sx, sv, sw}) {
    EXPECT_GT(slope, low) << name;
    EXPECT_LT(slope, high) << name;
  }
}

TEST(PhysicsMotion, VelocityVerletIsOfSecondOrder) {
  check_order("velocity Verlet", Integrator::velocity_verlet, Start::at_step_0, 1.9, 2.1);
}

TEST(PhysicsMotion, LeapfrogIsOfSecondOrderFromHalfAStepBack) {
  check_order("leapfrog from v(-dt/2)", Integrator::leapfrog, Start::half_step_back, 1.9, 2.1);
}

TEST(PhysicsMotion, LeapfrogFromVelocitiesAtStepZeroIsOfFirstOrder) {
  // What velocity Verlet's half kick is for: leapfrog takes the initial velocities as those of half a step before.
  check_order("leapfrog from v(0)", Integrator::leapfrog, Start::at_step_0, 0.85, 1.2);
}

}  // namespace
}  // namespace talus::physics
