// Adhesion (JKR) and cohesion (SJKR) against closed forms: pull-off, overlap under load, the work of a loop of contact
// and rupture, sticking speed, equilibrium, grains far lighter than their adhesion, necks on walls, energy balance.
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.hpp"
#include "core/rules/adhesion.hpp"
#include "core/rules/timestep.hpp"
#include "physics_support.hpp"

namespace talus::physics {
namespace {

constexpr double k_young = 1e7, k_poisson = 0.25, k_radius = 1e-3;

double e_star_of(const Scene& s) {
  return 0.5 * s.materials[0].young / (1 - s.materials[0].poisson * s.materials[0].poisson);
}

Scene jkr_scene(double w, double e, double mu, double dt) {
  Scene s = open_scene({0, 0, 0}, {0.1, 0.1, 0.1}, dt);
  s.materials[0].young = k_young;
  s.materials[0].poisson = k_poisson;
  hertz_law(s, e, mu);
  s.contact.model = ContactModel::jkr;
  for (PairCoefficients& p : s.pairs) p.work_of_adhesion = w;
  return s;
}

/// Force on grain 0 [N] along x from the contacts of the present state; 0 where there is none.
double pull(const Simulation& sim) {
  double f = 0;
  for (const ContactRecord& c : sim.frame({.contacts = true}).contacts) {
    const double n = c.normal_force.x + c.tangential_force.x;
    f += c.a == 0 ? n : -n;
  }
  return f;
}

/// Grain 0 is driven along x into grain 1, which is too heavy to move, and back.
struct Separation {
  double strongest = 0, at_zero = 0, rupture_gap = 0, work = 0;
};

Separation separate(double w, double r0, double r1) {
  Scene s = jkr_scene(w, 1, 0, 1e-6);
  const double overlap = 2e-3 * r0, speed = 1e-3 * r0 / 1e-3, lead = 1e-4 * r0;
  s.materials.push_back(s.materials[0]);
  s.materials[1].name = "heavy";
  s.materials[1].density *= 1e15;
  s.pairs.assign(4, s.pairs[0]);
  s.groups = {GroupSpec{"driven", false, std::nullopt, std::array<ParticleId, 2>{0, 0}}};
  const auto drive = [&](double time, double v) {
    Event e;
    e.action = Event::Action::drive;
    e.group = 0;
    e.time = time;
    e.vector = {v, 0, 0};
    return e;
  };
  const double turn = (overlap + lead) / speed;
  s.events = {drive(0, speed), drive(std::round(turn / s.dt) * s.dt, -speed)};
  add_grains(
      s, {{{0.05 - (r0 + r1) - lead, 0.05, 0.05}, {0, 0, 0}, r0}, {{0.05, 0.05, 0.05}, {0, 0, 0}, r1, {0, 0, 0}, 1}});
  Simulation sim(s, options());
  Separation out;
  double force = 0, last_gap = lead;
  bool attached = false;
  for (int k = 0; k < 40000; ++k) {
    sim.run(1);
    const Frame f = sim.frame();
    const double gap = f.x[1].x - f.x[0].x - (r0 + r1), now = pull(sim);
    out.work += 0.5 * (force + now) * (gap - last_gap);  // the pull on 0 is along +x, its path -gap: work put in
    out.strongest = std::max(out.strongest, now);
    if (gap >= 0 && last_gap < 0 && attached) out.at_zero = now;
    if (now != 0) {
      attached = true;
      out.rupture_gap = gap;
    } else if (attached) {
      break;
    }
    force = now;
    last_gap = gap;
  }
  return out;
}

TEST(PhysicsJkr, PullOffRuptureAndWorkOfTheLoopAreThoseOfTheTheory) {
  const double w = 0.2;
  for (const double ratio : {1.0, 3.0}) {
    const double r0 = k_radius, r1 = ratio * k_radius, reff = r0 * r1 / (r0 + r1);
    const double e_star = e_star_of(jkr_scene(w, 1, 0, 1e-6));
    const Separation q = separate(w, r0, r1);
    const double po = 1.5 * k_pi * w * reff, kappa = k_pi * w / (8 * e_star);
    const double gap = 3 * std::cbrt(kappa * kappa * reff);
    // Johnson & Pollock 1994: 7.09 (w^5 R^4 / E*^2)^(1/3)
    const double loop = 7.09 * std::cbrt(std::pow(w, 5) * std::pow(reff, 4) / (e_star * e_star));
    figure("jkr: pull-off / (3/2 pi w R*)", q.strongest / po);
    figure("jkr: force at zero overlap / (4/3 pi w R*)", q.at_zero / (4.0 / 3.0 * k_pi * w * reff));
    figure("jkr: rupture gap / theory", q.rupture_gap / gap);
    figure("jkr: work of approach and separation / theory", q.work / loop);
    EXPECT_NEAR(q.strongest / po, 1, 1e-5);
    EXPECT_NEAR(q.at_zero / (4.0 / 3.0 * k_pi * w * reff), 1, 2e-3) << "within a step of zero";
    EXPECT_NEAR(q.rupture_gap / gap, 1, 2e-3) << "within a step of rupture";
    EXPECT_NEAR(q.work / loop, 1, 3e-3);
  }
}

/// sigma V = l f: tension counts as tension though the force that pulls points along the branch.
TEST(PhysicsJkr, StressOfAnAttractingPairIsTension) {
  for (const double overlap : {1e-7, 8e-5}) {  // the neck pulls at zero overlap; pressed together it pushes
    Scene s = jkr_scene(0.05, 0.3, 0, 1e-9);
    s.output.stress = true;
    s.allow_initial_overlap = true;
    add_grains(s, {{{0.05, 0.05, 0.05}, {}, k_radius}, {{0.05 + 2 * k_radius - overlap, 0.05, 0.05}, {}, k_radius}});
    Simulation sim(s, options());
    sim.run(1);
    const Frame f = sim.frame({.contacts = true, .stress = true});
    ASSERT_EQ(f.contacts.size(), 1U);
    const double pull = f.contacts[0].normal_force.x;  // on the left one: > 0 pulls
    EXPECT_EQ(pull > 0, overlap < 1e-6) << pull;
    const double arm = k_radius - 0.5 * f.contacts[0].overlap, volume = 4.0 / 3.0 * k_pi * std::pow(k_radius, 3);
    for (const auto& sigma : f.stress) EXPECT_NEAR(sigma[0] / (arm * pull / volume), 1, 1e-12);
  }
}

TEST(PhysicsJkr, OverlapAtRestUnderLoadSolvesThePapersEquations) {
  // A grain hangs below a ceiling's neck or is pressed onto the floor by its weight times `g / 9.81`.
  const double w = 0.05;
  for (const double g : {-400.0, -9.81, 15.0}) {  // < 0: onto the floor
    Scene s = jkr_scene(w, 0.3, 0, 1e-6);
    s.domain.boundary[2] = {Boundary::wall, Boundary::open};
    s.gravity = {0, 0, g};
    s.viscous_damping = 300;
    add_grains(s, {{{0.05, 0.05, k_radius * (1 - 1e-4)}, {0, 0, 0}, k_radius}});
    Simulation sim(s, options());
    sim.run(60000);
    const double load = -g * sphere_mass(2500, k_radius), e_star = e_star_of(s), p = 3 * k_pi * w * k_radius;
    // a^3 = 3 R / (4 E*) (F + 3 pi w R + sqrt(6 pi w R F + (3 pi w R)^2)), delta = a^2/R - sqrt(2 pi w a / E*)
    ASSERT_GT(load, -0.5 * p) << "below pull-off";
    const double a = std::cbrt(0.75 * k_radius / e_star * (load + p + std::sqrt(2 * p * load + p * p)));
    const double delta = a * a / k_radius - std::sqrt(2 * k_pi * w * a / e_star);
    const double found = k_radius - sim.frame().x[0].z;
    figure("jkr: overlap at rest / theory, load / pull-off " + std::to_string(load / (0.5 * p)), found / delta);
    EXPECT_NEAR(found / delta, 1, 1e-6);
  }
}

TEST(PhysicsJkr, ImpactsStickBelowTheClosedFormSpeedAndReboundAboveIt) {
  // e = 1: all that is lost is the loop's work, v_s^2 = 14.18 / m* (w^5 R*^4 / E*^2)^(1/3), v'^2 = v^2 - v_s^2
  const double w = 0.1, reff = 0.5 * k_radius, m = 0.5 * sphere_mass(2500, k_radius);
  const double e_star = e_star_of(jkr_scene(w, 1, 0, 1e-6));
  const double stick = std::sqrt(14.18 / m * std::cbrt(std::pow(w, 5) * std::pow(reff, 4) / (e_star * e_star)));
  for (const double share : {0.95, 1.1, 2.0}) {
    Scene s = jkr_scene(w, 1, 0, 2e-7);
    const double v = share * stick;
    add_grains(s, {{{0.05 - k_radius - 1e-7, 0.05, 0.05}, {0.5 * v, 0, 0}, k_radius},
                   {{0.05 + k_radius + 1e-7, 0.05, 0.05}, {-0.5 * v, 0, 0}, k_radius}});
    Simulation sim(s, options());
    sim.run(40000);
    const Frame f = sim.frame({.contacts = true});
    if (share < 1) {
      EXPECT_EQ(f.contacts.size(), 1U) << "must stick";
    } else {
      ASSERT_EQ(f.contacts.size(), 0U);
      const double rebound = (f.v[1].x - f.v[0].x) / v, expect = std::sqrt(1 - 1 / (share * share));
      figure("jkr: rebound / speed at " + std::to_string(share) + " v_s, minus theory", rebound - expect);
      EXPECT_NEAR(rebound, expect, 1e-2);
    }
  }
}

// An oblique impact whose neck is drawn out while it slides: what the tangential spring stores is lost once, when the
// neck breaks, however many steps that takes.
TEST(PhysicsJkr, EnergyBalanceOfANeckThatIsDrawnOutClosesWithTheStep) {
  double worst[3] = {};
  const double steps[3] = {4e-7, 1e-7, 2.5e-8};
  for (int k = 0; k < 3; ++k) {
    Scene s = jkr_scene(0.3, 1, 5, steps[k]);
    s.output.energies = true;
    add_grains(s, {{{0.004, 0.05, 0.05}, {0.3, 0, 0}, k_radius}, {{0.0062, 0.0506, 0.05}, {-0.3, 0, 0}, k_radius}});
    Simulation sim(s, options());
    bool met = false;
    for (int q = 0; q < 4000; ++q) {
      sim.run(static_cast<std::int64_t>(4e-6 / steps[k] + 0.5));
      const bool touches = sim.counters().contacts > 0;
      met = met || touches;
      const Energies e = sim.energies();
      worst[k] = std::max(worst[k], std::fabs(e.residual) / e.kinetic_translation);
      if (met && !touches) break;
    }
    ASSERT_TRUE(met && sim.counters().contacts == 0);
    figure("jkr: residual of an oblique impact at dt " + std::to_string(1e9 * steps[k]) + " ns", worst[k]);
  }
  EXPECT_LT(worst[1], 0.4 * worst[0]);
  EXPECT_LT(worst[2], 0.4 * worst[1]);
  EXPECT_LT(worst[2], 1e-3);
}

TEST(PhysicsJkr, StepLimitFollowsTheContactThatAdhesionPullsOpen) {
  const Scene weak = jkr_scene(1e-6, 0.5, 0.3, 1e-6), strong = jkr_scene(1, 0.5, 0.3, 1e-6);
  Scene hertz = weak;
  hertz.contact.model = ContactModel::hertz_mindlin;
  const double slow = 0.01, none = time_step_limits(hertz, k_radius, k_radius, slow).isolated_pair.seconds;
  EXPECT_NEAR(time_step_limits(weak, k_radius, k_radius, slow).isolated_pair.seconds / none, 1, 0.05);
  EXPECT_LT(time_step_limits(strong, k_radius, k_radius, slow).isolated_pair.seconds / none, 0.7);
}

TEST(PhysicsSjkr, GrainsRestWhereAttractionAndSpringBalance) {
  // Hertz: 4/3 E* sqrt(R*) d^(3/2) = c A(d); the area to first order is 2 pi R* d
  Scene s = open_scene({0, 0, 0}, {0.1, 0.1, 0.1}, 1e-6);
  s.materials[0].young = k_young;
  s.materials[0].poisson = k_poisson;
  hertz_law(s, 0.2, 0);
  s.contact.cohesion = Cohesion::sjkr;
  const double c = 2e5, e_star = e_star_of(s);
  s.pairs[0].cohesion_energy = c;
  const double r[2] = {k_radius, 2 * k_radius}, reff = r[0] * r[1] / (r[0] + r[1]);
  double delta = std::pow(1.5 * k_pi * c / e_star, 2) * reff;
  add_grains(
      s, {{{0.05, 0.05, 0.05}, {0, 0, 0}, r[0]}, {{0.05 + r[0] + r[1] - 0.5 * delta, 0.05, 0.05}, {0, 0, 0}, r[1]}});
  Simulation sim(s, options());
  sim.run(40000);
  for (int k = 0; k < 50; ++k) {  // the exact area
    const double d = r[0] + r[1] - delta, g = r[0] - r[1];
    const double area = k_pi / 4 * (r[0] + r[1] - d) * (r[0] + r[1] + d) * (d * d - g * g) / (d * d);
    delta = std::pow(c * area / (4.0 / 3.0 * e_star * std::sqrt(reff)), 2.0 / 3.0);
  }
  const Frame f = sim.frame();
  const double found = r[0] + r[1] - (f.x[1].x - f.x[0].x);
  figure("sjkr: overlap at rest / theory", found / delta);
  EXPECT_NEAR(found / delta, 1, 1e-6);
}

TEST(PhysicsCohesion, StrongAdhesionWithSizesOneToAHundredComesToRestAtTheForceBalance) {
  // Scenario 17: pull-off 200 times the weight of the fines, which hang all around the coarse grain (rolling resistance
  // keeps them from rolling down) and stay within the overlap of the theory.
  const double w = 2e-3, fine = 2e-5, coarse = 2e-3;
  Scene s = jkr_scene(w, 0.3, 0.5, 1e-7);
  s.gravity = {0, 0, -9.81};
  s.viscous_damping = 8000;
  s.contact.rolling = Rolling::epsd;
  s.pairs[0].rolling_friction = 0.1;
  s.pairs[0].rolling_damping = 0.3;
  std::vector<Grain> grains = {{{0.05, 0.05, 0.05}, {0, 0, 0}, coarse, {0, 0, 0}, 0, true}};
  for (int k = 0; k < 60; ++k) {
    const double t = 2 * k_pi * k / 60;
    const Vec3 dir{std::cos(t), 0, std::sin(t)};
    grains.push_back({Vec3{0.05, 0.05, 0.05} + (coarse + fine * (1 - 1e-3)) * dir, {0, 0, 0}, fine});
  }
  add_grains(s, grains);
  RunOptions o = options();
  o.audit = true;
  Simulation sim(s, o);
  sim.run(20000);
  const double reff = fine * coarse / (fine + coarse), e_star = e_star_of(s), p = 3 * k_pi * w * reff;
  const double weight = 9.81 * sphere_mass(2500, fine);
  EXPECT_GT(0.5 * p / weight, 100);
  const Frame f = sim.frame();
  double worst = 0;
  for (std::size_t k = 1; k < f.id.size(); ++k) {
    const Vec3 d = f.x[k] - f.x[0];
    const double load = weight * d.z / norm(d);  // the part of the weight that presses; friction carries the rest
    const double a = std::cbrt(0.75 * reff / e_star * (load + p + std::sqrt(2 * p * load + p * p)));
    const double delta = a * a / reff - std::sqrt(2 * k_pi * w * a / e_star);
    worst = std::max(worst, std::fabs((coarse + fine - norm(d)) / delta - 1));
  }
  figure("scenario 17: largest error of the overlap at rest", worst);
  EXPECT_LT(worst, 1e-3);
  EXPECT_EQ(sim.counters().missed_contacts, 0);
  EXPECT_LT(std::sqrt(sim.kinetic_energy() / (0.5 * 60 * sphere_mass(2500, fine))), 1e-5) << "at rest";
}

TEST(PhysicsCohesion, NecksOnWallsHoldAndTheRunIsTheSameForEveryList) {
  // A shaken box of adhesive grains: necks form and break between grains, on planes and across periodic sides; the
  // audit finds no pair within reach that the list lacks.
  std::uint64_t hash = 0;
  for (const double k : {0.0, 50.0, 400.0}) {
    Scene s = jkr_scene(0.05, 0.5, 0.4, 2e-6);
    s.domain.upper = {0.012, 0.012, 0.02};
    s.domain.boundary[0] = {Boundary::periodic, Boundary::periodic};
    s.domain.boundary[1] = {Boundary::wall, Boundary::wall};
    s.domain.boundary[2] = {Boundary::wall, Boundary::wall};
    s.gravity = {0, 0, -9.81};
    s.list.verlet_k = k;
    s.list.automatic = false;
    if (k == 0) s.list.policy = ListPolicy::always;
    std::vector<Grain> grains;
    for (int q = 0; q < 100; ++q)
      grains.push_back(
          {{0.0015 + 0.0023 * (q % 5), 0.0013 + 0.0023 * (q / 5 % 5), 0.0015 + 0.0024 * (q / 25)},
           {0.6 * uniform(3, 3 * q) - 0.3, 0.6 * uniform(3, 3 * q + 1) - 0.3, -0.6 * uniform(3, 3 * q + 2)},
           0.0008 + 0.0003 * uniform(4, q)});
    add_grains(s, grains);
    RunOptions o = options();
    o.audit = k == 400;
    Simulation sim(s, o);
    std::int64_t necks = 0;
    for (int part = 0; part < 10; ++part) {
      sim.run(400);
      for (const ContactRecord& c : sim.frame({.contacts = true}).contacts) necks += c.overlap < 0 ? 1 : 0;
    }
    EXPECT_EQ(sim.counters().missed_contacts, 0);
    EXPECT_GT(necks, 0) << "some contacts must be seen beyond touch";
    if (hash == 0) hash = sim.state_hash();
    EXPECT_EQ(sim.state_hash(), hash) << "K " << k;
  }
}

TEST(PhysicsCohesion, EnergyBalanceClosesWithCohesionAndAdhesion) {
  for (const bool jkr : {false, true}) {
    double residual[2];
    for (const int fine : {0, 1}) {
      Scene s = jkr_scene(0.02, 0.6, 0.4, fine != 0 ? 5e-7 : 1e-6);
      if (!jkr) {
        s.contact.model = ContactModel::hertz_mindlin;
        s.contact.cohesion = Cohesion::sjkr;
        s.pairs[0].work_of_adhesion = 0;
        s.pairs[0].cohesion_energy = 1e5;
      }
      s.output.energies = true;
      std::vector<Grain> grains;
      for (int q = 0; q < 64; ++q) {
        const Vec3 x{0.0024 * (q % 4 - 1.5), 0.0024 * (q / 4 % 4 - 1.5), 0.0024 * (q / 16 - 1.5)};
        const auto u = [q](int c) { return uniform(6, static_cast<std::uint64_t>(8 * q + c)) - 0.5; };
        grains.push_back({Vec3{0.05, 0.05, 0.05} + x,
                          -60.0 * x + 0.1 * Vec3{u(0), u(1), u(2)},
                          0.001 + 0.0003 * u(3),
                          {40 * u(4), 40 * u(5), 40 * u(6)}});
      }
      add_grains(s, grains);
      Simulation sim(s, options());
      sim.run(fine != 0 ? 20000 : 10000);
      const Energies e = sim.energies();
      residual[fine] = std::fabs(e.residual) / (e.dissipated_damping + e.dissipated_friction);
    }
    figure(std::string(jkr ? "jkr" : "sjkr") + ": residual / dissipated, dt 1e-6", residual[0]);
    figure(std::string(jkr ? "jkr" : "sjkr") + ": residual / dissipated, dt 5e-7", residual[1]);
    EXPECT_LT(residual[0], 1e-2);
    EXPECT_LT(residual[1], 5e-3);
  }
}

TEST(PhysicsCohesion, RefusesAttractionThatNoContactCanBalance) {
  Scene s = open_scene({0, 0, 0}, {0.1, 0.1, 0.1}, 1e-6);
  linear_law(s, 1e3, 0);
  s.contact.cohesion = Cohesion::sjkr;
  const double most = 1e3 / (2 * k_pi * k_radius);
  s.pairs[0].cohesion_energy = 1.01 * most;
  EXPECT_THROW(check_attraction(s, k_radius, k_radius), Error);
  s.pairs[0].cohesion_energy = 0.99 * most;
  EXPECT_NO_THROW(check_attraction(s, k_radius, k_radius));
  Scene j = jkr_scene(1e5, 0.5, 0, 1e-6);
  EXPECT_THROW(check_attraction(j, k_radius, k_radius), Error);
}

}  // namespace
}  // namespace talus::physics
