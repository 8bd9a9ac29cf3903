// Janssen: in a narrow silo the wall carries the weight beyond a depth of a few radii,
//   L(h) = c lambda (1 - exp(-h/lambda)), c the weight per depth, lambda = D/(4 mu_w K), K = sigma_r/sigma_z,
// mu_w the friction that the wall contacts really carry.
// It has to point upwards everywhere: after filling, the floor sinks slowly.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ladder.hpp"

namespace talus::verification {
namespace {

struct Silo {
  std::vector<double> depth, load;  ///< below the top [d]; weight not carried by the wall above [m g]
  double weight = 0, floor = 0, wall = 0, mobilised = 0, stress_ratio = 0, height = 0;
};

Silo fill(int levels, double diameter, double mu) {
  const double r = 0.5, kn = 1e4, dt = k_pi * std::sqrt(0.5 / kn) / 15, inside = 0.5 * diameter, sink = 0.02;
  const double filled = 45, mobile = 75, end = 105;
  Scene s = open_scene({-inside - 1, -inside - 1, -4}, {inside + 1, inside + 1, 1.06 * levels + 6}, dt);
  s.materials[0].density = density_of(1, r);
  linear_restitution(s, kn, 0.5, 2.0 / 7.0 * kn, mu);
  s.gravity = {0, 0, -1};
  WallSpec floor = plane("floor", {0, 0, 0}, {0, 0, 1}), tube;
  floor.motion.velocity = {0, 0, -sink};
  floor.motion.start = filled;
  tube.name = "tube";
  tube.shape = WallShape::cylinder;
  tube.point = {0, 0, -3.5};
  tube.length = 1.06 * levels + 9;
  tube.radius = inside;
  s.walls = {floor, tube};
  std::vector<Grain> grains;
  const int side = static_cast<int>(diameter);
  for (int k = 0; k < levels; ++k)
    for (int i = -side; i <= side; ++i)
      for (int j = -side; j <= side; ++j) {
        const double x = 1.04 * (i + 0.25 * (k % 3)), y = 1.04 * (j + 0.25 * (k % 2));
        if (std::hypot(x, y) > inside - 0.55) continue;
        const auto q = static_cast<std::uint64_t>(3 * grains.size());
        grains.push_back({{x, y, 0.6 + 1.06 * k}, {0.5 * gauss(31, q), 0.5 * gauss(31, q + 1), 0}, r});
      }
  add_grains(s, grains);
  Simulation sim(s, options());
  sim.run(std::llround(mobile / dt));
  const auto n = static_cast<double>(sim.particles());
  EXPECT_EQ(n, static_cast<double>(grains.size())) << "grains got out";
  Silo out;
  out.weight = n;
  const int samples = 60, bins = 20;
  double pressed = 0, rubbed = 0, radial = 0, axial = 0;
  std::vector<double> above(bins + 1), carried(bins + 1);
  for (int k = 0; k < samples; ++k) {
    sim.run(std::llround((end - mobile) / samples / dt));
    const Frame f = sim.frame({.contacts = true});
    std::vector<double> z;
    for (const Vec3& x : f.x) z.push_back(x.z);
    // the top is where 99 % of the grains are below; loose grains above it weigh nothing here
    const double top = quantile(z, 0.99) + 0.5, base = -sink * (sim.time() - filled), step = (top - base) / bins;
    out.height += (top - base) / samples;
    double side_press = 0;
    for (int b = 0; b <= bins; ++b) {
      const double level = top - b * step;
      above[static_cast<std::size_t>(b)] +=
          static_cast<double>(std::count_if(z.begin(), z.end(), [&](double q) { return q > level; }));
      for (const ContactRecord& c : f.contacts)
        if (c.b == -2 && c.point.z > level)
          carried[static_cast<std::size_t>(b)] += (c.normal_force + c.tangential_force).z;
    }
    for (const ContactRecord& c : f.contacts) {
      if (c.b == -1) out.floor += (c.normal_force + c.tangential_force).z / samples;
      if (c.b != -2) continue;
      out.wall += (c.normal_force + c.tangential_force).z / samples;
      pressed += norm(c.normal_force);
      rubbed += c.tangential_force.z;
      // stress ratio from the lower half, where sigma_z has saturated
      if (c.point.z < 0.5 * (top + base)) side_press += norm(c.normal_force);
    }
    radial += side_press / (k_pi * diameter * 0.5 * (top - base)) / samples;
  }
  for (int b = 1; b <= bins; ++b) {
    const auto q = static_cast<std::size_t>(b);
    out.depth.push_back(out.height * b / bins);
    out.load.push_back((above[q] - carried[q]) / samples);
  }
  for (int b = bins / 2; b < bins; ++b) axial += out.load[static_cast<std::size_t>(b)] / (bins - bins / 2);
  axial /= 0.25 * k_pi * diameter * diameter;
  out.mobilised = rubbed / pressed / mu;
  out.stress_ratio = radial / axial;
  return out;
}

TEST(Janssen, WallCarriesTheWeightBeyondAFewDiameters) {
  const double mu = 0.5, diameter = 8;
  const Silo q = fill(full() ? 120 : 70, diameter, mu);
  // one parameter: lambda by search; c is the mean weight per depth
  const double c = q.weight / q.height;
  double lambda = 0, best = 1e300;
  for (double l = 1; l < 60; l += 0.01) {
    double rest = 0;
    for (std::size_t k = 0; k < q.depth.size(); ++k)
      rest += std::pow(q.load[k] - c * l * (1 - std::exp(-q.depth[k] / l)), 2);
    if (rest < best) {
      best = rest;
      lambda = l;
    }
  }
  const double residual = std::sqrt(best / static_cast<double>(q.depth.size())) / (c * lambda);
  for (std::size_t k = 0; k < q.depth.size(); k += 2)
    figure("janssen: load at depth " + std::to_string(q.depth[k]).substr(0, 4) + " d / weight above",
           q.load[k] / (c * q.depth[k]), "load " + std::to_string(q.load[k]) + " m g");
  const double from_stresses = diameter / (4 * mu * q.mobilised * q.stress_ratio);
  const auto mean_of = [&](std::size_t from, std::size_t to) {  // in quarters of the depth; single loads scatter by 10 %
    const std::size_t n = q.load.size() / 4;
    double sum = 0;
    for (std::size_t k = from * n; k < to * n; ++k) sum += q.load[k];
    return sum / static_cast<double>((to - from) * n);
  };
  const double saturated = mean_of(3, 4) / mean_of(2, 3);
  figure("janssen: filled height [d]", q.height, std::to_string(std::lround(q.weight)) + " grains");
  figure("janssen: (floor + wall force) / weight - 1", (q.floor + q.wall) / q.weight - 1);
  figure("janssen: share of the weight that the wall carries", q.wall / q.weight);
  figure("janssen: mobilised share of wall friction", q.mobilised);
  figure("janssen: lambda / D, fitted", lambda / diameter, "relative residual " + std::to_string(residual));
  figure("janssen: K = sigma_r / sigma_z in the lower half", q.stress_ratio);
  figure("janssen: lambda from K and mobilised friction / fitted lambda", from_stresses / lambda);
  figure("janssen: mean load in the lowest quarter / in the one above", saturated);
  EXPECT_NEAR((q.floor + q.wall) / q.weight, 1, 0.02);  // the floor sinks steadily
  EXPECT_GT(q.wall / q.weight, 0.6);
  // grains roll down a smooth wall as the floor sinks, so that friction there stays well below mu
  EXPECT_GT(q.mobilised, 0.3);
  EXPECT_LE(q.mobilised, 1);
  EXPECT_LT(residual, 0.08);
  EXPECT_NEAR(from_stresses / lambda, 1, 0.2);
  EXPECT_NEAR(saturated, 1, 0.1);  // hydrostatic would be 1.4
}

}  // namespace
}  // namespace talus::verification
