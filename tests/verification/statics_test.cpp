// Statics with an exact answer: a grain in a wedge and in a corner of three walls (every contact carries its share),
// and a column of a thousand grains (overlaps of the exact solution stay; from rest, momentum is what wall and weight
// give).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ladder.hpp"

namespace talus::verification {
namespace {

/// Lets one grain come to rest between planes through the origin with the given unit normals; returns the frame.
struct Rest {
  Frame frame;
  double residual = 0;  ///< |sum of contact forces + weight| / weight
  double weight = 0;
};

Rest settle_between(const std::vector<Vec3>& normals, Vec3 start, bool hertz, double mu, double time = 0.8) {
  const double r = 0.01, g = 9.81, dt = hertz ? 1e-5 : 4e-6, m = sphere_mass(2500, r);
  Scene s = open_scene({-1, -1, -1}, {1, 1, 1}, dt);
  s.materials[0].young = 1e7;
  s.materials[0].poisson = 0.25;
  if (hertz)
    hertz_law(s, 0.3, mu);
  else
    linear_law(s, 2e4, 1500, mu > 0 ? 6e3 : 0, 800, mu);
  s.gravity = {0, 0, -g};
  for (std::size_t k = 0; k < normals.size(); ++k)
    s.walls.push_back(plane("side " + std::to_string(k), {0, 0, 0}, normals[k]));
  add_grains(s, {{start, {0, 0, 0}, r}});
  Simulation sim(s, options());
  sim.run(std::llround(time / dt));
  Rest out;
  out.frame = sim.frame({.contacts = true});
  out.weight = m * g;
  Vec3 sum{0, 0, -out.weight};
  for (const ContactRecord& c : out.frame.contacts) sum = sum + c.normal_force + c.tangential_force;
  out.residual = norm(sum) / out.weight;
  return out;
}

TEST(Statics, GrainInAWedgeLeansOnBothSides) {
  // Symmetric wedge of half angle a, frictionless: each side carries m g / (2 sin a). And an uneven one.
  const double r = 0.01;
  for (const bool hertz : {false, true})
    for (const double a : {0.3, 0.7, 1.2}) {
      const std::vector<Vec3> sides{{std::cos(a), 0, std::sin(a)}, {-std::cos(a), 0, std::sin(a)}};
      const Rest q = settle_between(sides, {0, 0, 1.001 * r / std::sin(a)}, hertz, 0);
      ASSERT_EQ(q.frame.contacts.size(), 2U) << a;
      double worst = 0;
      for (const ContactRecord& c : q.frame.contacts)
        worst = std::max(worst, std::fabs(norm(c.normal_force) / (q.weight / (2 * std::sin(a))) - 1));
      const std::string name =
          std::string(hertz ? "Hertz" : "linear") + " wedge, half angle " + std::to_string(a).substr(0, 3);
      figure(name + ": equilibrium residual / weight", q.residual);
      figure(name + ": largest relative error of the side forces", worst);
      EXPECT_LT(q.residual, 1e-9);
      EXPECT_LT(worst, 1e-9);
    }
}

TEST(Statics, GrainInAnUnevenWedgeWithFrictionIsInEquilibrium) {
  const Rest q = settle_between({{0.6, 0, 0.8}, {-0.96, 0, 0.28}}, {-0.0056, 0, 0.0169}, false, 0.4, 3);
  ASSERT_EQ(q.frame.contacts.size(), 2U);
  const double w = norm(q.frame.w[0]);
  for (const ContactRecord& c : q.frame.contacts)
    EXPECT_LE(norm(c.tangential_force), 0.4 * norm(c.normal_force) * (1 + 1e-9));
  figure("uneven wedge with friction: equilibrium residual / weight", q.residual);
  figure("uneven wedge with friction: spin at rest [rad/s]", w);
  EXPECT_LT(q.residual, 1e-9);
  EXPECT_LT(w, 1e-9);
}

TEST(Statics, GrainInACornerOfThreeWallsLeansOnAllThree) {
  // Cube corner standing on its tip: normals at the magic angle, each wall carries m g / sqrt(3). Two walls of the
  // corner are neighbours of each other everywhere: a code that keeps one contact per body, or merges near ones, fails
  // here.
  for (const bool hertz : {false, true})
    for (const double mu : {0.0, 0.5}) {
      const double u = 1 / std::sqrt(3.0), h = std::sqrt(2.0 / 3.0), q3 = std::sqrt(3.0) / 2;
      const std::vector<Vec3> sides{{h, 0, u}, {-0.5 * h, q3 * h, u}, {-0.5 * h, -q3 * h, u}};
      const Rest q = settle_between(sides, {0, 0, 1.0001 * 0.01 * std::sqrt(3.0)}, hertz, mu);
      ASSERT_EQ(q.frame.contacts.size(), 3U);
      double worst = 0;
      for (const ContactRecord& c : q.frame.contacts)
        worst = std::max(worst, std::fabs(norm(c.normal_force + c.tangential_force) / (q.weight * u) - 1));
      const std::string name =
          std::string(hertz ? "Hertz" : "linear") + " three-wall corner, mu " + std::to_string(mu).substr(0, 3);
      figure(name + ": equilibrium residual / weight", q.residual);
      if (mu == 0) figure(name + ": largest relative error of the wall forces", worst);
      EXPECT_LT(q.residual, 1e-9);
      if (mu == 0) {
        EXPECT_LT(worst, 1e-9);
      }
    }
}

TEST(Statics, GrainInABoxCornerTouchesFloorAndTwoSides) {
  // Walls of the domain itself; gravity along the diagonal loads all three equally: m g / sqrt(3) each.
  const double r = 0.01, dt = 4e-6, m = sphere_mass(2500, r), g = 9.81;
  Scene s = open_scene({0, 0, 0}, {0.1, 0.1, 0.1}, dt);
  for (auto& axis : s.domain.boundary) axis = {Boundary::wall, Boundary::open};
  linear_law(s, 2e4, 1500);
  s.gravity = {-g / std::sqrt(3.0), -g / std::sqrt(3.0), -g / std::sqrt(3.0)};
  add_grains(s, {{{1.01 * r, 1.02 * r, 1.03 * r}, {0, 0, 0}, r}});
  Simulation sim(s, options());
  sim.run(100000);
  const Frame f = sim.frame({.contacts = true});
  ASSERT_EQ(f.contacts.size(), 3U);
  double worst = 0;
  for (const ContactRecord& c : f.contacts)
    worst = std::max(worst, std::fabs(norm(c.normal_force) / (m * g / std::sqrt(3.0)) - 1));
  figure("box corner: largest relative error of the three wall forces", worst);
  EXPECT_LT(worst, 1e-9);
}

constexpr int k_column = 1000;
constexpr double k_stiff = 1e7;       ///< k_n d / (m g): the lowest grain is squeezed by 1e-4 d
constexpr double k_column_dt = 2e-5;  ///< t_c/dt = 35

/// Overlap of a resting contact over load/k_n. The pairwise dashpot divides the whole normal force by 1 + gamma dt/2,
/// which is right for a pair alone (its velocity at n is not yet known) but not for one that rests under other forces.
double rest_overlap(Dashpot dashpot, double restitution, bool wall) {
  const double gamma = 2 * damping_ratio(restitution) * std::sqrt(k_stiff / (wall ? 1.0 : 0.5));
  return dashpot == Dashpot::pairwise ? 1 + 0.5 * gamma * k_column_dt : 1;
}

/// Column on a floor, d = m = g = 1, in its exact state of rest or just touching.
Scene column(bool friction, Dashpot dashpot, double restitution, bool squeezed) {
  const double r = 0.5;
  Scene s = open_scene({-2, -2, 0}, {2, 2, k_column + 2.0}, k_column_dt);
  s.materials[0].density = density_of(1, r);
  linear_restitution(s, k_stiff, restitution, friction ? 2.0 / 7.0 * k_stiff : 0, friction ? 0.5 : 0);
  s.contact.dashpot = dashpot;
  s.gravity = {0, 0, -1};
  s.allow_initial_overlap = true;
  s.walls.push_back(plane("floor", {0, 0, 0}, {0, 0, 1}));
  std::vector<Grain> grains;
  double z = 0;
  for (int k = 0; k < k_column; ++k) {
    // the contact below grain k carries k_column - k weights
    const double overlap = (k_column - k) / k_stiff * rest_overlap(dashpot, restitution, k == 0);
    z += (k == 0 ? r : 2 * r) - (squeezed ? overlap : 0);
    grains.push_back({{0, 0, z}, {0, 0, 0}, r});
  }
  add_grains(s, grains);
  return s;
}

/// Lets the column stand; asserts that it neither drifts, nor moves, nor leaves its axis.
void stand(const std::string& name, const Scene& s) {
  const std::int64_t steps = full() ? 100000 : 20000;
  Simulation sim(s, options());
  const Frame start = sim.frame();
  double speed = 0, drift = 0, aside = 0;
  for (int part = 0; part < 10; ++part) {
    sim.run(steps / 10);
    const Frame f = sim.frame();
    for (std::size_t k = 0; k < k_column; ++k) {
      speed = std::max(speed, norm(f.v[k]));
      drift = std::max(drift, std::fabs(f.x[k].z - start.x[k].z));
      aside = std::max({aside, std::fabs(f.x[k].x), std::fabs(f.x[k].y)});
    }
  }
  drift *= k_stiff / k_column;
  figure(name + ": largest drift / lowest overlap in " + std::to_string(steps) + " steps", drift);
  figure(name + ": largest speed / sqrt(g d)", speed);
  // Heights are rounded to 1e-13 (1000 d), which moves a contact force by k_n 1e-13 = 1e-6 weights: grains are pushed
  // with 1e-6 g at random, over 20 steps (a contact time) that is 4e-10 of speed. Nothing may grow from there.
  EXPECT_LT(drift, 1e-5) << name;
  EXPECT_LT(speed, 1e-8) << name;
  EXPECT_EQ(aside, 0.0) << name;
}

TEST(Statics, ColumnOfAThousandGrainsStandsStillOnItsExactOverlaps) {
  stand("column of 1000, lagged dashpot, e 0.9", column(false, Dashpot::lagged, 0.9, true));
  stand("column of 1000, centred dashpot, e 0.9", column(false, Dashpot::centred, 0.9, true));
  stand("column of 1000, centred dashpot, e 0.9, friction", column(true, Dashpot::centred, 0.9, true));
  stand("column of 1000, pairwise dashpot, e 0.9", column(false, Dashpot::pairwise, 0.9, true));
  // What "exact" means with the pairwise dashpot: the forces are those of statics, the overlaps are larger than
  // load/k_n by gamma dt/2, about pi z dt/t_c, of first order in the step. Nothing else shows it.
  for (const double e : {0.9, 0.5})
    figure("pairwise dashpot at rest: overlap / (load/k_n) - 1, t_c/dt = 35, e " + std::to_string(e).substr(0, 3),
           rest_overlap(Dashpot::pairwise, e, false) - 1);
}

TEST(Statics, MomentumOfAColumnIsTheIntegralOfFloorForceAndWeight) {
  // The column starts unsqueezed and falls into itself: waves, impacts, rebound. Sum m v(n+1/2) changes each step by
  // dt (F_floor(n) - M g) whatever happens inside: action equals reaction to the bit, what is left is rounding of sums.
  const double dt = k_column_dt;
  Simulation sim(column(true, Dashpot::centred, 0.7, false), options());
  double impulse = 0, moved = 0, worst = 0, lost = 0;
  const int steps = 3000;
  for (int n = 0; n < steps; ++n) {
    // frame() sees the contacts of step n before the kick that uses them
    double floor = 0;
    for (const ContactRecord& c : sim.frame({.contacts = true}).contacts)
      if (c.b < 0) floor += c.normal_force.z;
    impulse += (n == 0 ? 0.5 : 1.0) * dt * (floor - k_column);  // velocity Verlet starts with half a kick
    moved += dt * floor;
    sim.run(1);
    double momentum = 0;
    for (const Vec3& v : sim.frame().v) momentum += v.z;
    worst = std::max(worst, std::fabs(momentum - impulse));
    lost = std::max(lost, std::fabs(momentum));
  }
  figure("column from rest: impulse of the floor [m sqrt(g d)]", moved);
  figure("column from rest: largest momentum [m sqrt(g d)]", lost);
  figure("column from rest: largest |momentum - impulse| / weight impulse", worst / (k_column * dt * steps));
  EXPECT_GT(moved, 0.1);
  EXPECT_LT(worst / (k_column * dt * steps), 1e-12);
}

}  // namespace
}  // namespace talus::verification
