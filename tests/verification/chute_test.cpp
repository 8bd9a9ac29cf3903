// Steady flow down a rough incline (Silbert et al. 2001): volume fraction constant over the depth, and Bagnold's
// velocity profile u(z) = A (h^(3/2) - (h - z)^(3/2)). CI runs 10 d x 10 d of about 17 d depth with springs ten times
// softer than Silbert's k_n = 2e5 m g/d (overlaps stay below 1e-3 d), TALUS_FULL=1 his 20 d x 10 d with a depth of 25
// d.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ladder.hpp"

namespace talus::verification {
namespace {

struct Flow {
  std::vector<double> height, fraction, speed;  ///< of the layers, from the base up
  double depth = 0, change = 0;                 ///< of the flow [d]; mean speed second over first half of the record
};

Flow chute(double lx, double ly, int layers, double degrees, double kn, double settle_time, double record_time) {
  const double r = 0.5, theta = degrees * k_pi / 180, dt = k_pi * std::sqrt(0.5 / kn) / 15;
  Scene s = open_scene({0, 0, 0}, {lx, ly, layers + 12.0}, dt);
  s.domain.boundary[0] = s.domain.boundary[1] = {Boundary::periodic, Boundary::periodic};
  s.materials[0].density = density_of(1, r);
  linear_restitution(s, kn, 0.88, 2.0 / 7.0 * kn, 0.5);
  s.gravity = {std::sin(theta), 0, -std::cos(theta)};
  s.sort_every = 2000;
  std::vector<Grain> grains;
  // base: fixed grains on a square grid, shifted at random by up to a quarter of a diameter also in height
  for (int i = 0; i < static_cast<int>(lx); ++i)
    for (int j = 0; j < static_cast<int>(ly); ++j) {
      const auto q = static_cast<std::uint64_t>(3 * (i * 64 + j));
      Grain g{{i + 0.5 + 0.5 * (uniform(21, q) - 0.5), j + 0.5 + 0.5 * (uniform(21, q + 1) - 0.5),
               0.6 + 0.5 * uniform(21, q + 2)},
              {0, 0, 0},
              r};
      g.x.x = std::clamp(g.x.x, 0.01, lx - 0.01);
      g.fixed = true;
      grains.push_back(g);
    }
  // flowing grains: a loose grid above it, thrown about so that it forgets the grid, already on its way with a linear
  // profile
  const double pitch = 1.1;
  const int nx = static_cast<int>(lx / pitch), ny = static_cast<int>(ly / pitch);
  for (int k = 0; k < nx * ny * layers; ++k) {
    const auto q = static_cast<std::uint64_t>(3 * k);
    const Vec3 jitter{0.5 * gauss(22, q), 0.5 * gauss(22, q + 1), 0.5 * gauss(22, q + 2)};
    const int level = k / (nx * ny);
    grains.push_back({{lx / nx * (k % nx + 0.5), ly / ny * (k / nx % ny + 0.5), 2.2 + 1.05 * level},
                      jitter + Vec3{0.35 * level, 0, 0},
                      r});
  }
  s.allow_initial_overlap = true;  // base grains overlap each other; they are fixed
  s.max_overlap = 1;
  const std::size_t fixed = static_cast<std::size_t>(lx) * static_cast<std::size_t>(ly);
  add_grains(s, grains);
  Simulation sim(s, options());
  sim.run(std::llround(settle_time / dt));
  // layers of one diameter; grains are spread over the layers that they reach into
  const double layer = 1;
  const int bins = layers + 12;
  std::vector<double> volume(static_cast<std::size_t>(bins)), momentum(volume);
  double half[2] = {0, 0}, centre = 0;
  const int samples = 200;
  for (int k = 0; k < samples; ++k) {
    sim.run(std::llround(record_time / samples / dt));
    const Frame f = sim.frame();
    for (std::size_t g = 0; g < f.x.size(); ++g) {
      const bool base = f.id[g] < static_cast<ParticleId>(fixed);
      for (int b = std::max(0, static_cast<int>(f.x[g].z - r));
           b <= std::min<int>(bins - 1, static_cast<int>(f.x[g].z + r)); ++b) {
        const double lo = std::clamp(b * layer - f.x[g].z, -r, r), hi = std::clamp((b + 1) * layer - f.x[g].z, -r, r);
        const double slice = k_pi * (r * r * (hi - lo) - (hi * hi * hi - lo * lo * lo) / 3);
        volume[static_cast<std::size_t>(b)] += slice;
        momentum[static_cast<std::size_t>(b)] += slice * (base ? 0 : f.v[g].x);
      }
      if (!base) half[2 * k / samples] += f.v[g].x;
      if (!base) centre += f.x[g].z;
    }
  }
  Flow out;
  for (int b = 0; b < bins; ++b) {
    const double v = volume[static_cast<std::size_t>(b)];
    out.height.push_back((b + 0.5) * layer);
    out.fraction.push_back(v / (samples * layer * lx * ly));
    out.speed.push_back(v > 0 ? momentum[static_cast<std::size_t>(b)] / v : 0);
  }
  out.change = half[1] / half[0] - 1;
  return out;
}

/// Exponent p, no-slip height z0 and amplitude of u = A (H^p - (H - (z - z0))^p) with H = top - z0 that fit best over
/// the layers [from, to): least squares, p and z0 by search, A in closed form.
struct Bagnold {
  double exponent = 0, base = 0, residual = 0;
  double at_three_halves = 0;      ///< residual of the best fit with p = 3/2
  double least = 0, greatest = 0;  ///< exponents whose residual is below twice the smallest
};

Bagnold fit_bagnold(const Flow& f, double top, std::size_t from, std::size_t to) {
  Bagnold best;
  best.residual = best.at_three_halves = 1e300;
  std::vector<std::pair<double, double>> valley;  // exponent, smallest residual over z0
  for (int step = 0; step <= 240; ++step) {
    const double p = 1 + 0.005 * step;
    valley.emplace_back(p, 1e300);
    for (double z0 = 0; z0 < 3; z0 += 0.02) {
      double uu = 0, us = 0, ss = 0;
      for (std::size_t k = from; k < to; ++k) {
        const double shape = std::pow(top - z0, p) - std::pow(top - f.height[k], p);
        uu += f.speed[k] * f.speed[k];
        us += f.speed[k] * shape;
        ss += shape * shape;
      }
      const double rest = std::sqrt(std::max(0.0, 1 - us * us / (ss * uu)));
      valley.back().second = std::min(valley.back().second, rest);
      if (rest < best.residual) {
        best.exponent = p;
        best.base = z0;
        best.residual = rest;
      }
    }
    if (step == 100) best.at_three_halves = valley.back().second;
  }
  best.least = best.greatest = best.exponent;
  for (const auto& [p, rest] : valley) {
    if (rest > 2 * best.residual) continue;
    best.least = std::min(best.least, p);
    best.greatest = std::max(best.greatest, p);
  }
  return best;
}

TEST(Chute, DensityIsConstantOverDepthAndTheProfileIsBagnolds) {
  const bool large = full();
  const Flow f = large ? chute(20, 10, 30, 24, 1e4, 500, 200) : chute(10, 10, 20, 24, 1e4, 300, 200);
  // free surface: where the volume fraction has fallen to half of the bulk's
  double bulk = 0;
  for (std::size_t k = 5; k < 12; ++k) bulk += f.fraction[k] / 7;
  std::size_t top_layer = 5;
  while (f.fraction[top_layer] > 0.5 * bulk) ++top_layer;
  const double a = f.fraction[top_layer - 1], b = f.fraction[top_layer];
  const double top = f.height[top_layer - 1] + (a - 0.5 * bulk) / (a - b);
  // core: three layers off the base and four off the surface, where layering and saltation live
  const std::size_t from = 4, to = top_layer - 3;
  double low = 1, high = 0;
  for (std::size_t k = from; k < to; ++k) {
    low = std::min(low, f.fraction[k]);
    high = std::max(high, f.fraction[k]);
  }
  for (std::size_t k = 0; k <= top_layer; ++k)
    figure("chute layer at z = " + std::to_string(f.height[k]).substr(0, 4) + ": speed", f.speed[k],
           "volume fraction " + std::to_string(f.fraction[k]));
  const Bagnold q = fit_bagnold(f, top, from, to);
  figure("chute 24 deg: height of the free surface [d]", top);
  figure("chute 24 deg: volume fraction of the core", 0.5 * (low + high),
         std::to_string(low) + " ... " + std::to_string(high));
  figure("chute 24 deg: exponent of the profile", q.exponent,
         "fitted over layers z = " + std::to_string(f.height[from]) + " ... " + std::to_string(f.height[to - 1]) +
             ", no-slip height " + std::to_string(q.base) + ", relative residual " + std::to_string(q.residual));
  figure(
      "chute 24 deg: residual of the best profile with exponent 3/2", q.at_three_halves,
      "twice the smallest residual allows exponents " + std::to_string(q.least) + " ... " + std::to_string(q.greatest));
  figure("chute 24 deg: mean speed, second over first half of the record - 1", f.change);
  EXPECT_GT(low, 0.54);
  EXPECT_LT(high, 0.60);
  EXPECT_LT(high - low, 0.02);
  // 9 layers leave the exponent open by 0.15 (printed above); shear is faster than Bagnold's next to the surface and
  // slower next to the base in flows this thin. A linear or a plug profile is far off.
  EXPECT_NEAR(q.exponent, 1.5, 0.25);
  EXPECT_LT(q.at_three_halves, 0.015);
  EXPECT_GT(q.least, 1.2);
  EXPECT_LT(std::fabs(f.change), 0.05);  // steady
}

}  // namespace
}  // namespace talus::verification
