// Gross sliding takes the impulse J_t = mu J_n from an impact, whatever the restitution, at 50 steps per contact: the
// Coulomb limit counts the elastic part of the normal force, whose impulse is the whole one. With friction_limit =
// "total" the dashpot's pulling tail is left out of the limit and not out of J_n: more than mu J_n, by a known share.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ladder.hpp"

namespace talus::verification {
namespace {

constexpr double k_mu = 0.3;

/// Largest and smallest J_t / (mu J_n) of 40 spheres that touch a plane at different parts of a step, slipping fast.
std::pair<double, double> impulse_ratio(bool hertz, double e, FrictionLimit limit, bool clip, double steps) {
  const double r = 1, vn = 0.02, dt = 1 / steps;
  const int grains = 40;
  Scene s = open_scene({-4, 0, 0}, {8, 4.0 * grains, 6}, dt);
  s.materials[0].density = density_of(1, r);
  if (hertz) {
    const double depth = vn / 2.9432751, k = 1.25 * vn * vn / std::pow(depth, 2.5);
    s.materials[0].poisson = 0.25;
    s.materials[0].young = 0.75 * k * (1 - 0.0625);
    s.materials.push_back(s.materials[0]);
    s.materials[1].name = "rigid";
    s.materials[1].young *= 1e9;
    hertz_law(s, e, k_mu);
  } else {
    linear_restitution(s, k_pi * k_pi, e, 2.0 / 7.0 * k_pi * k_pi, k_mu);
    s.contact.tangential_damping = 1;
  }
  s.contact.friction = true;
  s.contact.friction_limit = limit;
  s.contact.clip_tension = clip;
  s.walls.push_back(plane("floor", {0, 0, 1}, {0, 0, 1}, hertz ? 1 : 0));
  std::vector<Grain> all;
  const double vt = 12 * k_mu * vn;
  for (int k = 0; k < grains; ++k)
    all.push_back({{0, 4.0 * k + 2, 2 + vn * dt * (1 + (k + 0.5) / grains)}, {vt, 0, -vn}, r});
  add_grains(s, all);
  Simulation sim(s, options());
  sim.run(std::llround(3 * steps));
  const Frame f = sim.frame({.contacts = true});
  EXPECT_TRUE(f.contacts.empty());
  std::pair<double, double> out{0, 1e300};
  for (std::size_t k = 0; k < static_cast<std::size_t>(grains); ++k) {
    const double ratio = (vt - f.v[k].x) / (f.v[k].z + vn) / k_mu;
    out = {std::max(out.first, ratio), std::min(out.second, ratio)};
  }
  return out;
}

TEST(SlidingImpulse, IsMuTimesTheNormalOneForEveryRestitution) {
  for (const bool hertz : {false, true})
    for (const double e : {1.0, 0.8, 0.5, 0.3}) {
      const auto [high, low] = impulse_ratio(hertz, e, FrictionLimit::elastic, false, 50);
      const double worst = std::max(high - 1, 1 - low);
      figure(std::string("sliding impulse, ") + (hertz ? "Hertz" : "linear") + ", e " + std::to_string(e).substr(0, 3) +
                 ", N = 50: largest |J_t/(mu J_n) - 1|",
             worst);
      EXPECT_LT(worst, 1e-3) << hertz << e;
    }
}

TEST(SlidingImpulse, IsMuTimesTheNormalOneWhereTheForceNeverPulls) {
  for (const bool hertz : {false, true}) {
    const auto [high, low] = impulse_ratio(hertz, 0.5, FrictionLimit::elastic, true, 50);
    EXPECT_LT(std::max(high - 1, 1 - low), 1e-3) << hertz;
  }
}

TEST(SlidingImpulse, WithTheTotalForceExceedsItByTheRepulsiveShare) {
  for (const bool hertz : {false, true})
    for (const double e : {0.8, 0.5, 0.3}) {
      const double share = hertz ? repulsive_share_hertz(e) : repulsive_share_linear(e);
      const auto [high, low] = impulse_ratio(hertz, e, FrictionLimit::total, false, 1000);
      figure(std::string("sliding impulse, total, ") + (hertz ? "Hertz" : "linear") + ", e " +
                 std::to_string(e).substr(0, 3) + ": J_t/(mu J_n)",
             high, "closed form " + std::to_string(share));
      EXPECT_NEAR(high, share, 1e-3) << hertz << e;
      EXPECT_NEAR(low, share, 1e-3) << hertz << e;
      EXPECT_GT(share, 1.001);
    }
}

}  // namespace
}  // namespace talus::verification
