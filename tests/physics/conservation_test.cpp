// Conservation laws of many particles: momentum and angular momentum of a closed system to rounding, energy of an
// elastic gas, and the energy balance of a settling frictional bed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "physics_support.hpp"

namespace talus::physics {
namespace {

struct Momenta {
  Vec3 linear, angular;
  double linear_scale = 0, angular_scale = 0;  ///< sums of magnitudes
};

Momenta momenta(const Frame& f, double density) {
  Momenta m;
  for (std::size_t k = 0; k < f.x.size(); ++k) {
    const double mass = sphere_mass(density, f.r[k]);
    // x(n) x v(n-1/2) = x(n-1) x v(n-1/2): the pair of leapfrog times that conserves exactly
    const Vec3 p = mass * f.v[k], l = cross(f.x[k], p) + (0.4 * mass * f.r[k] * f.r[k]) * f.w[k];
    m.linear = m.linear + p;
    m.angular = m.angular + l;
    m.linear_scale += norm(p);
    m.angular_scale += norm(l);
  }
  return m;
}

/// Polydisperse frictional cloud that collapses under its initial velocities; nothing acts from outside.
void closed_system(const std::string& name, bool hertz, Lever lever, double& linear, double& angular,
                   double& contacts) {
  const double dt = 2e-6, pitch = 0.0062;
  // a tight box: positions are stored from its corner, and each drift rounds to that distance
  Scene s = open_scene({-0.05, -0.05, -0.05}, {0.05, 0.05, 0.05}, dt);
  s.materials[0].young = 1e7;
  s.materials[0].poisson = 0.25;
  if (hertz)
    hertz_law(s, 0.6, 0.5);
  else
    linear_law(s, 2e3, 200, 1500, 100, 0.5);
  s.contact.lever = lever;
  s.max_overlap = 1;
  std::vector<Grain> grains;
  for (int k = 0; k < 512; ++k) {
    const auto q = [k](int c) { return uniform(3, static_cast<std::uint64_t>(16 * k + c)); };
    const Vec3 x{pitch * (k % 8 - 3.5), pitch * (k / 8 % 8 - 3.5), pitch * (k / 64 - 3.5)};
    const Vec3 v = -100.0 * x + Vec3{q(0) - 0.5, q(1) - 0.5, q(2) - 0.5} + cross({10, -5, 20}, x);
    grains.push_back({x, v, 0.001 + 0.002 * q(3), {40 * q(4) - 20, 40 * q(5) - 20, 40 * q(6) - 20}});
  }
  add_grains(s, grains);
  RunOptions o = options();
  o.chunk = 64;  // pairs across chunk borders are evaluated twice: they must stay antisymmetric
  Simulation sim(s, o);
  const Momenta before = momenta(sim.frame(), 2500);
  contacts = 0;
  linear = angular = 0;
  for (int k = 0; k < 10; ++k) {
    sim.run(400);
    const Momenta now = momenta(sim.frame(), 2500);
    linear = std::max(linear, norm(now.linear - before.linear) / before.linear_scale);
    angular = std::max(angular, norm(now.angular - before.angular) / before.angular_scale);
    contacts = std::max(contacts, static_cast<double>(sim.counters().contacts));
  }
  EXPECT_EQ(sim.particles(), 512) << name;
  figure(name + ": largest number of contacts", contacts);
  figure(name + ": relative change of momentum in 4000 steps", linear);
  figure(name + ": relative change of angular momentum in 4000 steps", angular);
}

TEST(PhysicsConservation, ClosedFrictionalSystemKeepsMomentumAndAngularMomentum) {
  for (const bool hertz : {false, true}) {
    double linear = 0, angular = 0, contacts = 0;
    closed_system(hertz ? "closed system, hertz" : "closed system, linear", hertz, Lever::contact, linear, angular,
                  contacts);
    EXPECT_GT(contacts, 300);
    // Forces cancel to the last bit; what is left is the rounding of 4000 drifts, 1e-17 m against arms of 0.02 m each.
    EXPECT_LT(linear, 1e-13);
    EXPECT_LT(angular, 1e-13);
  }
}

TEST(PhysicsConservation, LeverOfTheRadiusLosesAngularMomentum) {
  // contact.lever = "radius" is what LAMMPS gran/hooke/history does; also the control of the test above.
  double linear = 0, angular = 0, contacts = 0;
  closed_system("closed system, linear, lever radius (as LAMMPS)", false, Lever::radius, linear, angular, contacts);
  EXPECT_LT(linear, 1e-13);
  EXPECT_GT(angular, 1e-7);
}

TEST(PhysicsConservation, ElasticGasKeepsItsEnergyOverAHundredThousandCollisions) {
  // Linear elastic spheres, periodic box. In a contact the energy of leapfrog oscillates by (omega dt)^2/4 of the
  // stored part: with t_c/dt = 400 and 3 % of the time in contact, 5e-7 of the total.
  const double r = 0.5, density = 1 / sphere_mass(1, r), dt = 1.0 / 400;  // t_c = 1
  const int per_axis = 16, n = per_axis * per_axis * per_axis;
  const double pitch = 1.35, length = pitch * per_axis;
  Scene s = open_scene({0, 0, 0}, {length, length, length}, dt);
  for (auto& axis : s.domain.boundary) axis = {Boundary::periodic, Boundary::periodic};
  s.materials[0].density = density;
  linear_law(s, 0.5 * k_pi * k_pi, 0);  // m_eff = 1/2
  s.output.energies = true;
  std::vector<Grain> grains;
  for (int k = 0; k < n; ++k) {
    const auto q = [k](int c) { return uniform(5, static_cast<std::uint64_t>(8 * k + c)); };
    const double jitter = 0.3;
    const Vec3 x{pitch * (k % per_axis + 0.5) + jitter * (q(3) - 0.5),
                 pitch * (k / per_axis % per_axis + 0.5) + jitter * (q(4) - 0.5),
                 pitch * (k / per_axis / per_axis + 0.5) + jitter * (q(5) - 0.5)};
    grains.push_back({x, {0.06 * (q(0) - 0.5), 0.06 * (q(1) - 0.5), 0.06 * (q(2) - 0.5)}, r});
  }
  add_grains(s, grains);
  RunOptions o;
  o.threads = 2;
  Simulation sim(s, o);
  sim.run(1);
  const Energies e0 = sim.energies();
  const double start = e0.kinetic_translation + e0.elastic;
  std::set<std::pair<ParticleId, ParticleId>> touching;
  std::int64_t collisions = 0;
  double worst = 0, share = 0;
  const std::int64_t wanted = 100000;
  while (collisions < wanted && sim.step() < 400000) {
    // every contact lasts 400 steps or more, none can begin and end unseen; two of the same pair within 300 steps
    // cannot be
    sim.run(300);
    std::set<std::pair<ParticleId, ParticleId>> now;
    for (const ContactRecord& c : sim.frame({.contacts = true}).contacts) {
      now.emplace(std::min(c.a, c.b), std::max(c.a, c.b));
      collisions += touching.count({std::min(c.a, c.b), std::max(c.a, c.b)}) == 0 ? 1 : 0;
    }
    touching = std::move(now);
    sim.run(1);  // energies are those of an executed step
    const Energies e = sim.energies();
    worst = std::max(worst, std::fabs((e.kinetic_translation + e.elastic) / start - 1));
    share = std::max(share, e.elastic / start);
  }
  figure("elastic gas: collisions", static_cast<double>(collisions), "in " + std::to_string(sim.step()) + " steps");
  figure("elastic gas: largest share of stored energy", share);
  figure("elastic gas: largest relative change of energy", worst);
  EXPECT_GE(collisions, wanted);
  EXPECT_LT(worst, 1e-6);
}

/// Largest balance residual over the largest energy in play while 250 frictional grains fall on a floor and settle.
double settle(bool hertz, double restitution, double dt, double& dissipated,
              const std::function<void(Scene&)>& change = {}, Energies* end = nullptr) {
  Scene s = open_scene({0, 0, 0}, {0.03, 0.03, 0.2}, dt);
  s.domain.boundary[0] = s.domain.boundary[1] = {Boundary::periodic, Boundary::periodic};
  s.domain.boundary[2] = {Boundary::wall, Boundary::wall};
  s.materials[0].young = 1e7;
  s.materials[0].poisson = 0.25;
  if (hertz)
    hertz_law(s, restitution, 0.4);
  else
    linear_law(s, 2e3, 300, 1000, 150, 0.4);
  s.gravity = {0, 0, -9.81};
  s.output.energies = true;
  std::vector<Grain> grains;
  for (int k = 0; k < 250; ++k) {
    const auto q = [k](int c) { return uniform(11, static_cast<std::uint64_t>(8 * k + c)); };
    const Vec3 x{0.003 + 0.006 * (k % 5), 0.003 + 0.006 * (k / 5 % 5), 0.004 + 0.006 * (k / 25)};
    grains.push_back({x,
                      {0.4 * q(0) - 0.2, 0.4 * q(1) - 0.2, 0},
                      0.0015 + 0.0012 * q(2),
                      {40 * q(3) - 20, 40 * q(4) - 20, 40 * q(5) - 20}});
  }
  add_grains(s, grains);
  if (change) change(s);
  RunOptions o;
  o.threads = 2;
  Simulation sim(s, o);
  double worst = 0;
  for (int k = 0; k < 25; ++k) {
    sim.run(std::llround(0.01 / dt));
    worst = std::max(worst, std::fabs(sim.energies().residual));
  }
  const Energies e = sim.energies();
  dissipated = e.dissipated_damping + e.dissipated_friction;
  if (end != nullptr) *end = e;
  return worst / dissipated;
}

/// The 25 lowest grains of the bed are a shovel that shifts and lifts the others for a while and is then let go.
void shovel(Scene& s) {
  s.groups = {GroupSpec{"shovel", false, std::nullopt, std::array<ParticleId, 2>{0, 24}}};
  Event e;
  e.group = 0;
  e.action = Event::Action::drive;
  e.time = 0.05;
  e.vector = {0.2, 0.1, 0.05};
  e.spin = {3, -5, 0};
  s.events.push_back(e);
  e.action = Event::Action::release;
  e.time = 0.15;
  s.events.push_back(e);
}

TEST(PhysicsConservation, EnergyBalanceOfASettlingBedCloses) {
  for (const bool hertz : {false, true}) {
    // Hertz without dashpot, see the next test
    const std::string law = hertz ? "hertz, e 1" : "linear, damped";
    double dissipated = 0, dissipated_fine = 0;
    const double coarse = settle(hertz, 1, 4e-6, dissipated), fine = settle(hertz, 1, 2e-6, dissipated_fine);
    figure("settling bed, " + law + ": dissipated energy [J]", dissipated);
    figure("settling bed, " + law + ", dt 4e-6: largest residual / dissipated", coarse);
    figure("settling bed, " + law + ", dt 2e-6: largest residual / dissipated", fine);
    EXPECT_GT(dissipated, 1e-4);
    // the residual belongs to the step, not to the run: small, and smaller with a smaller step
    EXPECT_LT(coarse, 2e-3);
    EXPECT_LT(fine, 0.75 * coarse);
  }
}

TEST(PhysicsConservation, EnergyBalanceOfADampedHertzBedCloses) {
  // While a contact slides its spring carries what the dashpot leaves of the Coulomb limit, never less than nothing (a
  // spring loaded against the dashpot would part loaded, 1.6 % of all losses here). What is left belongs to the step.
  double dissipated = 0;
  const double residual = settle(true, 0.6, 4e-6, dissipated);
  figure("settling bed, hertz, e 0.6, dt 4e-6: largest residual / dissipated", residual);
  EXPECT_GT(dissipated, 1e-4);
  EXPECT_LT(residual, 4e-3);
}

TEST(PhysicsConservation, EnergyBalanceCountsTheWorkOnDrivenGrainsAndWhatEventsChange) {
  double dissipated = 0, none = 0;
  Energies e;
  const double coarse = settle(false, 1, 4e-6, dissipated, shovel, &e), fine = settle(false, 1, 2e-6, none, shovel);
  figure("bed on a shovel of driven grains: work / dissipated", e.wall_work / dissipated);
  figure("bed on a shovel of driven grains, dt 4e-6: largest residual / dissipated", coarse);
  figure("bed on a shovel of driven grains, dt 2e-6: largest residual / dissipated", fine);
  // Far more than the bound: without it the balance could not close. What is left is that of the settling bed above.
  EXPECT_GT(e.wall_work, 0.1 * dissipated);
  EXPECT_LT(std::max(coarse, fine), 4e-3);
  settle(false, 1, 4e-6, none, {}, &e);
  EXPECT_EQ(e.wall_work, 0.0);  // resting walls do no work
}

TEST(PhysicsConservation, EnergyBalanceCountsBackgroundDamping) {
  for (const bool local : {false, true}) {
    const auto damped = [local](Scene& s) { (local ? s.local_damping : s.viscous_damping) = local ? 0.3 : 5; };
    double dissipated = 0, none = 0;
    Energies e;
    const double coarse = settle(false, 1, 4e-6, dissipated, damped, &e), fine = settle(false, 1, 2e-6, none, damped);
    const std::string what = local ? "bed with local damping" : "bed with viscous damping";
    figure(what + ": taken by it / by contacts", e.dissipated_background / dissipated);
    figure(what + ", dt 4e-6: largest residual / dissipated by contacts", coarse);
    figure(what + ", dt 2e-6: largest residual / dissipated by contacts", fine);
    // without it the balance would be off by this much
    EXPECT_GT(e.dissipated_background, 0.1 * dissipated);
    EXPECT_LT(coarse, 4e-3);
    EXPECT_LT(fine, 0.75 * coarse);
  }
}

TEST(PhysicsConservation, EnergyBalanceClosesWithGravityAlongAPeriodicAxis) {
  // Grains that slide down a chute without end: gravity's work there is no height difference of anything.
  double dissipated = 0, none = 0;
  Energies e;
  const auto tilt = [](Scene& s) { s.gravity = {6, -1, -7.7}; };
  const double coarse = settle(false, 1, 4e-6, dissipated, tilt, &e), fine = settle(false, 1, 2e-6, none, tilt);
  figure("bed on an endless slope: potential energy at the end / dissipated", e.potential / dissipated);
  figure("bed on an endless slope, dt 4e-6: largest residual / dissipated", coarse);
  figure("bed on an endless slope, dt 2e-6: largest residual / dissipated", fine);
  EXPECT_LT(coarse, 2e-3);
  EXPECT_LT(fine, 0.75 * coarse);
}

}  // namespace
}  // namespace talus::physics
