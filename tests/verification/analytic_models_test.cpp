// Closed forms of one and two particles that tests/physics leaves out: MFiX DEM01 and DEM05, and the analytic models
// that LAMMPS checks its granular styles with (hertz_normal_impact, oblique_impact_pair, spin_impact, incline_rolling,
// stack_energy, terminal_velocity_linear, energy_dissipation).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ladder.hpp"

namespace talus::verification {
namespace {

TEST(AnalyticModel, BouncingGrainFollowsItsThreeStages) {
  // MFiX DEM01: free fall, damped harmonic contact under the weight, rebound; every step of y(t) and v(t).
  const double r = 0.1, h0 = 0.5, g = 9.81, m = sphere_mass(2500, r), kn = 1e6;
  for (const double e : {1.0, 0.9, 0.6}) {
    const double w0 = std::sqrt(kn / m), z = damping_ratio(e), w = w0 * std::sqrt(1 - z * z);
    const double dt = k_pi / w / 1000;
    Scene s = open_scene({-1, -1, -1}, {1, 1, 2}, dt);
    linear_restitution(s, kn, e);
    s.gravity = {0, 0, -g};
    s.walls.push_back(plane("floor", {0, 0, 0}, {0, 0, 1}));
    add_grains(s, {{{0, 0, h0}, {0, 0, 0}, r}});
    Simulation sim(s, options());
    const double t1 = std::sqrt(2 * (h0 - r) / g), v1 = -g * t1, sag = m * g / kn;
    // contact: u = y - r, u'' + 2 z w0 u' + w0^2 u = -g from u = 0, u' = v1
    const double b = (v1 + z * w0 * sag) / w;
    const auto height = [&](double t) {
      return r - sag + std::exp(-z * w0 * t) * (sag * std::cos(w * t) + b * std::sin(w * t));
    };
    const auto speed = [&](double t) {
      return std::exp(-z * w0 * t) *
             ((b * w - z * w0 * sag) * std::cos(w * t) - (sag * w + z * w0 * b) * std::sin(w * t));
    };
    double lo = 0.5 * k_pi / w, hi = 1.2 * k_pi / w;  // the contact ends where the overlap vanishes
    for (int k = 0; k < 100; ++k) (height(0.5 * (lo + hi)) < r ? lo : hi) = 0.5 * (lo + hi);
    const double t2 = lo, v2 = speed(t2);
    double worst_y = 0, worst_v = 0;
    while (sim.time() < t1 + t2 + 1.5 * v2 / g) {
      sim.run(7);
      const Frame f = sim.frame();
      const auto at = [&](double t) -> std::pair<double, double> {
        if (t < t1) return {h0 - 0.5 * g * t * t, -g * t};
        if (t < t1 + t2) return {height(t - t1), speed(t - t1)};
        const double q = t - t1 - t2;
        return {r + v2 * q - 0.5 * g * q * q, v2 - g * q};
      };
      worst_y = std::max(worst_y, std::fabs(f.x[0].z - at(sim.time()).first));
      // the last kick of a contact holds all of it that is left, up to a step
      if (std::fabs(sim.time() - 0.5 * dt - (t1 + t2)) > 1.5 * dt)
        worst_v = std::max(worst_v, std::fabs(f.v[0].z - at(sim.time() - 0.5 * dt).second));
    }
    const std::string name = "MFiX DEM01, e " + std::to_string(e).substr(0, 3);
    figure(name + ": largest error of height / drop", worst_y / (h0 - r));
    figure(name + ": largest error of speed / impact speed", worst_v / -v1);
    // second order in w dt = 3e-3: (w dt)^2/24 = 4e-7 of the phase, and as much from the step that holds the touch
    EXPECT_LT(worst_y / (h0 - r), 1e-5);
    EXPECT_LT(worst_v / -v1, 1e-5);
  }
}

struct Impact {
  double vn, vt, w;  ///< after the impact, of a sphere of R = 1 on a plane; w about the axis that rolling needs
};

/// Linear law, elastic contact time 1; towards the wall with vn, along it with vt, spin w about +y.
Impact linear_impact(double e, double stiffness_ratio, double mu, double vn, double vt, double w,
                     double steps_per_contact = 1000, double rate_t = 0) {
  const double r = 1, dt = 1 / steps_per_contact;
  Scene s = open_scene({-5, -5, 0}, {5, 5, 6}, dt);
  s.materials[0].density = density_of(1, r);
  linear_restitution(s, k_pi * k_pi, e, stiffness_ratio * k_pi * k_pi, mu);
  s.contact.tangential_damping = rate_t;
  s.contact.lever = Lever::radius;  // closed forms are those of rigid spheres
  s.walls.push_back(plane("floor", {0, 0, 1}, {0, 0, 1}));
  add_grains(s, {{{0, 0, 2 + 1.5 * dt * vn}, {vt, 0, -vn}, r, {0, w, 0}}});
  Simulation sim(s, options());
  sim.run(std::llround(1.6 * steps_per_contact) + 10);
  EXPECT_TRUE(sim.frame({.contacts = true}).contacts.empty());
  const Frame f = sim.frame();
  return {f.v[0].z, f.v[0].x, f.w[0].y};
}

TEST(AnalyticModel, HertzImpactStoresTwoFifthsOfForceTimesDepth) {
  // hertz_normal_impact: 1/2 m* v^2 = 2/5 F depth at the deepest point, two spheres of different size and material.
  const Material a{"a", 2500, 5e9, 0.2}, b{"b", 7800, 2e10, 0.3};
  const double ra = 0.01, rb = 0.004, v = 0.5;
  const Hertz h = hertz_contact(a, ra, b, rb, 1);
  const double dt = h.contact(v) / 1000;
  Scene s = open_scene({-1, -1, -1}, {1, 1, 1}, dt);
  s.materials = {a, b};
  hertz_law(s, 1, 0);
  Grain other{{ra + rb + 1.5 * v * dt, 0, 0}, {-v, 0, 0}, rb};
  other.material = 1;
  add_grains(s, {{{0, 0, 0}, {0, 0, 0}, ra}, other});
  Simulation sim(s, options());
  double depth = 0, force = 0;
  for (int n = 0; n < 1010; ++n) {
    sim.run(1);
    for (const ContactRecord& c : sim.frame({.contacts = true}).contacts) {
      if (c.overlap > depth) force = norm(c.normal_force);
      depth = std::max(depth, c.overlap);
    }
  }
  const double energy = 0.5 * h.m * v * v;
  figure("hertz_normal_impact: (2/5 F depth) / (1/2 m v^2) - 1", 0.4 * force * depth / energy - 1);
  figure("hertz_normal_impact: depth / closed form - 1", depth / h.depth(v) - 1);
  EXPECT_NEAR(0.4 * force * depth / energy, 1, 1e-5);  // peak sampled within half a step: (pi/2000)^2
  EXPECT_NEAR(depth / h.depth(v), 1, 5e-6);
}

TEST(AnalyticModel, SlidingImpactOfAPairFollowsTheClosedForm) {
  // oblique_impact_pair: equal spheres, v_t > 7/2 mu (1+e) v_n; each loses mu (1+e) v_n/2 of its tangential speed and
  // both spin the same way with 5/2 of it. Elastic, so that the whole normal impulse is repulsive.
  const double r = 1, vn = 0.002, mu = 0.3, vt = 4.5 * mu * 2 * vn, dt = 1e-3;
  for (const bool contact_lever : {false, true}) {
    Scene s = open_scene({-10, -10, -10}, {10, 10, 10}, dt);
    s.materials[0].density = density_of(2, r);  // m_eff = 1
    linear_restitution(s, k_pi * k_pi, 1, 2.0 / 7.0 * k_pi * k_pi, mu);
    s.contact.lever = contact_lever ? Lever::contact : Lever::radius;
    const double gap = 1.5 * dt * vn, offset = 0.5 * vt * (gap / vn + 0.5);  // line of centres at mid-contact
    add_grains(s, {{{-r - 0.5 * gap, -offset, 0}, {0.5 * vn, 0.5 * vt, 0}, r},
                   {{r + 0.5 * gap, offset, 0}, {-0.5 * vn, -0.5 * vt, 0}, r}});
    Simulation sim(s, options());
    sim.run(1100);
    ASSERT_TRUE(sim.frame({.contacts = true}).contacts.empty());
    const Frame f = sim.frame();
    const double change = 0.5 * mu * 2 * vn;
    const double error_v = std::fabs((0.5 * vt - f.v[0].y) / change - 1), spin = 2.5 * change / r;
    const double error_w = std::max(std::fabs(-f.w[0].z / spin - 1), std::fabs(-f.w[1].z / spin - 1));
    const std::string name = std::string("oblique_impact_pair, lever ") + (contact_lever ? "contact" : "radius");
    figure(name + ": relative error of the tangential change", error_v);
    figure(name + ": relative error of the spin", error_w);
    // the line of centres turns by vt/(2R) = 3e-3 in the impact, which shifts v_n; depth/(2R) = 3e-4 off the lever
    EXPECT_LT(error_v, 2e-3);
    EXPECT_LT(error_w, 2e-3);
    EXPECT_EQ(f.v[0].z, 0.0);
  }
}

TEST(AnalyticModel, SpinningImpactGainsSpeedFromFriction) {
  // spin_impact: v_x' = mu J/m, w' = w0 - 5/2 mu J/(m r), J = m (1 + e) v_n.
  const double mu = 0.2, vn = 0.02, w0 = -1;
  for (const double e : {1.0, 0.8, 0.5}) {
    const Impact q = linear_impact(e, 2.0 / 7.0, mu, vn, 0, w0, 4000);
    const double change = mu * (1 + e) * vn;
    // friction needs the spring's slip k_t s = mu F_n first, s/v_s of the contact time; slip before that is elastic
    const double error = std::fabs(-q.vt / change - 1), spin = std::fabs((q.w - w0) / (2.5 * change) - 1);
    const std::string name = "spin_impact, e " + std::to_string(e).substr(0, 3);
    figure(name + ": relative error of v_x'", error);
    figure(name + ": relative error of the change of spin", spin);
    EXPECT_LT(error, e == 1 ? 1e-5 : 2e-3);
    EXPECT_LT(spin, e == 1 ? 1e-5 : 2e-3);
  }
}

TEST(AnalyticModel, ObliqueReboundsLieOnTheHardSphereMap) {
  // MFiX DEM05 and the map of Foerster et al. (1994), elastic: sliding psi2 = psi1 - 7 mu; sticking from first to last
  // touch psi2 = -beta0 psi1. For a linear spring the slip swings as cos(W t) with W^2 = 7/2 k_t/m during pi/omega_n,
  // so beta0 = -cos(pi sqrt(7/2 k_t/k_n)): 1 for k_t/k_n = 2/7, 0 for 1/14.
  const double vn = 0.02;
  double slide = 0, stick = 0;
  for (const double mu : {0.05, 0.1, 0.4})
    for (const double psi : {7.5 * mu, 12 * mu, 40 * mu}) {
      const Impact q = linear_impact(1, 2.0 / 7.0, mu, vn, psi * vn, 0);
      slide = std::max(slide, std::fabs(((q.vt - q.w) / q.vn - (psi - 7 * mu)) / mu));
    }
  for (const double ratio : {1.0 / 14.0, 1.0 / 7.0, 2.0 / 7.0, 0.5})
    for (const double psi : {0.2, 1.0}) {
      // Coulomb's limit closes within the last F_t/(mu F_n) of the contact, here 1e-6 of it
      const Impact q = linear_impact(1, ratio, 1e6, vn, psi * vn, 0, 4000);
      const double beta = -((q.vt - q.w) / q.vn) / psi;
      stick = std::max(stick, std::fabs(beta + std::cos(k_pi * std::sqrt(3.5 * ratio))));
    }
  figure("MFiX DEM05 / hard-sphere map, sliding: largest error of psi2 / mu", slide);
  figure("MFiX DEM05 / hard-sphere map, sticking: largest error of beta0", stick);
  EXPECT_LT(slide, 1e-8);  // the Coulomb force is mu times the normal one at every step: no error of its own
  EXPECT_LT(stick, 1e-6);  // second order at t_c/dt = 4000
}

TEST(AnalyticModel, GrainOnAnInclineRollsOrSlides) {
  // incline_rolling without rolling resistance: a = 5/7 g sin(theta) if mu >= 2/7 tan(theta), else it slides with
  // a = g (sin - mu cos), and spins up with 5/2 mu g cos/r.
  const double r = 0.01, g = 9.81, m = sphere_mass(2500, r), theta = 0.5, kn = m * g / (1e-5 * r), dt = 4e-6;
  for (const double mu : {0.5, 0.05}) {
    Scene s = open_scene({-9, -9, -9}, {9, 9, 9}, dt);
    linear_law(s, kn, 500, 2.0 / 7.0 * kn, 2000, mu);
    s.gravity = {g * std::sin(theta), 0, -g * std::cos(theta)};
    s.allow_initial_overlap = true;
    s.walls.push_back(plane("floor", {0, 0, 0}, {0, 0, 1}));
    add_grains(s, {{{0, 0, r - m * g * std::cos(theta) / kn}, {0, 0, 0}, r}});
    Simulation sim(s, options());
    sim.run(50000);
    const Frame f = sim.frame();
    const double t = sim.time() - 0.5 * dt;
    const bool rolls = mu >= 2.0 / 7.0 * std::tan(theta);
    const double a = rolls ? 5.0 / 7.0 * g * std::sin(theta) : g * (std::sin(theta) - mu * std::cos(theta));
    const double spin = rolls ? a / r : 2.5 * mu * g * std::cos(theta) / r;
    const std::string name = std::string("incline_rolling, ") + (rolls ? "rolls" : "slides");
    figure(name + ": v / (a t) - 1", f.v[0].x / (a * t) - 1);
    figure(name + ": w / (w' t) - 1", f.w[0].y / (spin * t) - 1);
    // lever R - depth: 1e-5; the tangential spring's first swing: 1e-4 of 0.2 s
    EXPECT_NEAR(f.v[0].x / (a * t), 1, 5e-5);
    EXPECT_NEAR(f.w[0].y / (spin * t), 1, 2e-4);
  }
}

TEST(AnalyticModel, UndampedStackKeepsItsEnergy) {
  // stack_energy: two grains bounce on each other and on the floor for 40 contact times of the pair, in contact and out
  // of it. Leapfrog's energy oscillates by (omega dt)^2/4 of the stored part and does not drift.
  for (const bool hertz : {false, true}) {
    const double r = 0.01, m = sphere_mass(2500, r), g = 9.81, kn = 2e4, dt = 2e-6;
    Scene s = open_scene({-1, -1, 0}, {1, 1, 1}, dt);
    s.materials[0].young = 1e8;
    s.materials[0].poisson = 0.25;
    if (hertz)
      hertz_law(s, 1, 0);
    else
      linear_law(s, kn, 0);
    s.gravity = {0, 0, -g};
    s.output.energies = true;
    s.walls.push_back(plane("floor", {0, 0, 0}, {0, 0, 1}));
    add_grains(s, {{{0, 0, 1.2 * r}, {0, 0, 0}, r}, {{0, 0, 3.5 * r}, {0, 0, 0}, r}});
    Simulation sim(s, options());
    double worst = 0, stored = 0;
    for (int k = 0; k < 2000; ++k) {
      sim.run(50);
      const Energies e = sim.energies();
      worst = std::max(worst, std::fabs(e.residual));
      stored = std::max(stored, e.elastic);
    }
    const double scale = m * g * 3 * r;
    const std::string name = std::string("stack_energy, ") + (hertz ? "Hertz" : "linear");
    figure(name + ": largest elastic energy / (m g 3 r)", stored / scale);
    figure(name + ": largest energy error / (m g 3 r)", worst / scale);
    EXPECT_GT(stored / scale, 0.05);
    EXPECT_LT(worst / scale, 1e-4);
  }
}

TEST(AnalyticModel, DragGivesTheTerminalVelocity) {
  // terminal_velocity_linear: v(t) = g/c (1 - exp(-c t)).
  const double g = 9.81, c = 8;
  std::vector<double> dt, error;
  for (const double n : {1000.0, 2000.0, 4000.0}) {
    Scene s = open_scene({-10, -10, -30}, {10, 10, 10}, 1 / n);
    linear_law(s, 1e3, 0);
    s.gravity = {0, 0, -g};
    s.viscous_damping = c;
    add_grains(s, {{{0, 0, 0}, {0, 0, 0}, 0.01}});
    Simulation sim(s, options());
    sim.run(std::llround(0.2 * n));
    const double early = -sim.frame().v[0].z, t = sim.time() - 0.5 / n;
    dt.push_back(1 / n);
    error.push_back(std::fabs(early / (g / c * (1 - std::exp(-c * t))) - 1));
    sim.run(std::llround(3.8 * n));
    EXPECT_NEAR(-sim.frame().v[0].z / (g / c), 1, 1e-12);
  }
  figure("terminal velocity: relative error at t = 1.6/c, dt 1e-3", error[0]);
  figure("terminal velocity: order of the transient", log_slope(dt, error), "explicit drag, first order");
  EXPECT_LT(error[0], 5e-3);
  EXPECT_GT(log_slope(dt, error), 0.95);
}

TEST(AnalyticModel, NoImpactGainsEnergy) {
  // energy_dissipation, which guards against an old grazing-impact gain: E' <= E for angles from head on to grazing,
  // spins either way, friction from none to sticky, elastic and damped.
  double worst = -1, lost = 0;
  for (const double e : {1.0, 0.7})
    for (const double mu : {0.1, 0.5, 10.0})
      for (const double degrees : {1.0, 20.0, 45.0, 70.0, 85.0, 89.0})
        for (const double spin : {-1.0, 0.0, 0.5, 2.0}) {
          const double v = 0.02, a = degrees * k_pi / 180, vn = v * std::cos(a), vt = v * std::sin(a), w = spin * v;
          const Impact q = linear_impact(e, 2.0 / 7.0, mu, vn, vt, w);
          const double before = v * v + 0.4 * w * w, after = q.vn * q.vn + q.vt * q.vt + 0.4 * q.w * q.w;
          worst = std::max(worst, after / before - 1);
          lost = std::max(lost, 1 - after / before);
        }
  figure("energy_dissipation: largest relative gain of 144 impacts", worst, "t_c/dt = 1000");
  figure("energy_dissipation: largest loss", lost);
  EXPECT_LT(worst, 1e-9);
  EXPECT_GT(lost, 0.3);
}

}  // namespace
}  // namespace talus::verification
