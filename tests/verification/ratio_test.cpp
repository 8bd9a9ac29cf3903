// Extreme stiffness and mass ratios with closed forms: the time step must follow the stiffest pair that can meet, and
// the soft or the heavy partner must still behave as its own formula says.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "core/rules/timestep.hpp"
#include "ladder.hpp"

namespace talus::verification {
namespace {

/// Head-on impact along x of a (left, at rest) and b (from the right with speed v).
struct Outcome {
  double va, vb, depth, duration;
};

Outcome head_on(Scene s, double ra, double rb, int material_b, double v) {
  Grain b{{ra + rb + 1.5 * v * s.dt, 0, 0}, {-v, 0, 0}, rb};
  b.material = material_b;
  add_grains(s, {{{0, 0, 0}, {0, 0, 0}, ra}, b});
  Simulation sim(s, options());
  Outcome out{};
  Frame old = sim.frame();
  double begin = -1, end = -1;
  while (end < 0 && sim.step() < 20000000) {
    sim.run(1);
    const Frame now = sim.frame();
    const double g0 = old.x[1].x - old.x[0].x - ra - rb, g1 = now.x[1].x - now.x[0].x - ra - rb;
    const double at = sim.time() - s.dt * (1 - g0 / (g0 - g1));
    if (g0 >= 0 && g1 < 0) begin = at;
    if (g0 < 0 && g1 >= 0) end = at;
    out.depth = std::max(out.depth, -g1);
    old = now;
  }
  sim.run(3);
  const Frame f = sim.frame();
  out.va = f.v[0].x;
  out.vb = f.v[1].x;
  out.duration = end - begin;
  return out;
}

TEST(Ratio, StiffnessRatioOfAMillionKeepsBothClosedForms) {
  // Soft grain on soft grain beside hard on hard in one scene: 1/E* adds, so soft-hard is as soft as soft on a rigid
  // partner. The step comes from the hard pair and is accepted; a step that suits the soft pair only is refused.
  const Material soft{"soft", 2500, 1e5, 0.3}, hard{"hard", 2500, 1e11, 0.3};
  const double r = 0.01, v = 0.05;
  const Hertz hh = hertz_contact(hard, r, hard, r, 1), sh = hertz_contact(soft, r, hard, r, 1);
  const double dt = hh.contact(v) / 40;
  Scene s = open_scene({-1, -1, -1}, {1, 1, 1}, dt);
  s.materials = {soft, hard};
  hertz_law(s, 1, 0);
  const Outcome mixed = head_on(s, r, r, 1, v);
  figure("stiffness 1:1e6, soft on hard: relative error of depth", mixed.depth / sh.depth(v) - 1,
         std::to_string(std::lround(sh.contact(v) / dt)) + " steps per contact");
  figure("stiffness 1:1e6, soft on hard: relative error of duration", mixed.duration / sh.contact(v) - 1);
  EXPECT_NEAR(mixed.depth / sh.depth(v), 1, 1e-6);
  EXPECT_NEAR(mixed.duration / sh.contact(v), 1, 1e-6);
  EXPECT_NEAR(mixed.va / v, -1, 1e-6);
  s.materials = {hard, hard};
  s.materials[1].name = "hard too";
  const Outcome stiff = head_on(s, r, r, 1, v);
  figure("stiffness 1:1e6, hard on hard: relative error of depth", stiff.depth / hh.depth(v) - 1,
         "40 steps per contact");
  // 40 steps: (pi/40)^2/24 in the phase, the deepest point sampled within half a step
  EXPECT_NEAR(stiff.depth / hh.depth(v), 1, 2e-3);
  EXPECT_NEAR(stiff.va / v, -1, 1e-5);
  s.materials = {soft, hard};
  EXPECT_NO_THROW(time_step_limits(s, r, r, v));
  s.dt = sh.contact(v) / 40;
  EXPECT_THROW(time_step_limits(s, r, r, v), Error);
}

TEST(Ratio, MassRatioOfAMillionKeepsMomentumAndSpeeds) {
  // R 1:100, equal density. Elastic: v_a = (m_a - m_b) ... of the textbook, for the light one hitting and being hit.
  const double ra = 0.5, rb = 50, v = 0.02, kn = 1e3;
  for (const bool light_moves : {false, true}) {
    const double r1 = light_moves ? rb : ra, r2 = light_moves ? ra : rb;
    const double m1 = sphere_mass(1, r1), m2 = sphere_mass(1, r2), m = m1 * m2 / (m1 + m2);
    const double contact = k_pi * std::sqrt(m / kn);
    Scene s = open_scene({-120, -120, -120}, {120, 120, 120}, contact / 1000);
    s.materials[0].density = 1;
    linear_law(s, kn, 0);
    s.max_overlap = 1;
    const Outcome o = head_on(s, r1, r2, 0, v);
    const double v1 = -2 * m2 / (m1 + m2) * v, v2 = -(m2 - m1) / (m1 + m2) * v;
    const std::string name = std::string("mass 1:1e6, ") + (light_moves ? "light hits heavy" : "heavy hits light");
    figure(name + ": relative error of duration", o.duration / contact - 1);
    figure(name + ": largest error of the speeds / v", std::max(std::fabs(o.va - v1), std::fabs(o.vb - v2)) / v);
    figure(name + ": relative error of momentum", (m1 * o.va + m2 * o.vb) / (-m2 * v) - 1);
    EXPECT_NEAR(o.duration / contact, 1, 1e-5);
    EXPECT_NEAR(o.va / v, v1 / v, 1e-5);
    EXPECT_NEAR(o.vb / v, v2 / v, 1e-5);
    EXPECT_NEAR((m1 * o.va + m2 * o.vb) / (-m2 * v), 1, 1e-9);
  }
}

TEST(Ratio, LightGrainBetweenHeavyOneAndWallSetsTheStep) {
  // Mass ratio 1e6 again, but squeezed: the light grain (m) rests between floor and heavy grain, two springs in
  // parallel, omega^2 = 2 k/m. It carries the heavy weight: overlap M g/k at the top, (M+m) g/k at the floor.
  // Disturbed, it swings with that omega; at the largest step that the command line accepts it stays bounded.
  const double ra = 0.5, rb = 50, density = density_of(1, ra), big = sphere_mass(density, rb), kn = 1e9, g = 1;
  const double pair = 2 * std::sqrt(0.5 / kn), dt = 0.39 * pair;  // two light ones, m = 1; beyond 0.5 it is refused
  Scene s = open_scene({-60, -60, 0}, {60, 60, 120}, dt);
  s.materials[0].density = density;
  linear_law(s, kn, 0);
  s.gravity = {0, 0, -g};
  s.allow_initial_overlap = s.allow_unstable_step = true;
  s.walls.push_back(plane("floor", {0, 0, 0}, {0, 0, 1}));
  const double low = (big + 1) * g / kn, top = big * g / kn, kick = 1e-3;
  add_grains(s, {{{0, 0, ra - low}, {0, 0, kick}, ra}, {{0, 0, 2 * ra + rb - low - top}, {0, 0, 0}, rb}});
  Simulation sim(s, options());
  double largest = 0, crossings = 0, first = -1, last = -1;
  double old = 0;
  for (int n = 0; n < 20000; ++n) {
    sim.run(1);
    const Frame f = sim.frame();
    const double u = f.x[0].z - (ra - low);
    largest = std::max(largest, std::fabs(u));
    if (n > 0 && old < 0 && u >= 0) {
      const double at = sim.time() - dt * u / (u - old);
      if (first < 0)
        first = at;
      else
        crossings += 1;
      last = at;
    }
    old = u;
  }
  // leapfrog: sin(W dt/2) = omega dt/2
  const double omega = std::sqrt(2 * kn), discrete = 2 / dt * std::asin(0.5 * omega * dt);
  const double measured = 2 * k_pi * crossings / (last - first);
  figure("light between heavy and wall: overlap at the floor / R", low / ra);
  figure("light between heavy and wall: omega / leapfrog's omega - 1", measured / discrete - 1,
         "leapfrog's is " + std::to_string(discrete / omega) + " of sqrt(2k/m)");
  figure("light between heavy and wall: amplitude / (v0/omega)", largest / (kick / omega));
  EXPECT_LT(low / ra, 0.01);
  EXPECT_NEAR(measured / discrete, 1, 1e-5);
  // leapfrog's ellipse: 1/sqrt(1 - (omega dt)^2/4), seen at its steps only
  EXPECT_NEAR(largest / (kick / omega), 1 / std::sqrt(1 - std::pow(0.5 * omega * dt, 2)), 0.01);
  s.allow_unstable_step = false;
  s.contact.normal_damping = 1e-9;  // many grains without any damping are asked for eight steps per contact
  EXPECT_NO_THROW(time_step_limits(s, ra, rb));
  s.dt = 0.51 * pair;
  EXPECT_THROW(time_step_limits(s, ra, rb), Error);
}

}  // namespace
}  // namespace talus::verification
