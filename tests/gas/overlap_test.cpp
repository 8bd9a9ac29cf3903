// Overlap of balls and boxes: against closed forms, and as shares of a grid.
#include "core/gas/overlap.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/base/det_math.hpp"
#include "core/base/rng.hpp"
#include "core/gas/exchange.hpp"

namespace talus::gas {
namespace {

constexpr double k_ball = 4 * std::numbers::pi / 3;

TEST(Overlap, ArcTangentAgreesWithTheLibrary) {
  for (double x = 1e-8; x < 1e8; x *= 1.37) {
    EXPECT_NEAR(det::atan(x) / std::atan(x), 1, 1e-15) << x;
    EXPECT_EQ(det::atan(-x), -det::atan(x));
  }
  EXPECT_EQ(det::atan(0), 0);
}

TEST(Overlap, CapsWedgesAndOctantsHaveTheirClosedForms) {
  for (double c = -0.95; c < 1; c += 0.19) {
    const double cap = std::numbers::pi * (1 - c) * (1 - c) * (2 + c) / 3;
    EXPECT_NEAR(ball_beyond(-1, -1, c), cap, 1e-12);
    EXPECT_NEAR(ball_beyond(c, -1, -1), cap, 1e-12);
    EXPECT_NEAR(ball_beyond(-1, c, -1), cap, 1e-12);
    EXPECT_NEAR(ball_beyond(0, -1, c), cap / 2, 1e-12);
    EXPECT_NEAR(ball_beyond(0, 0, c), cap / 4, 1e-12);
  }
  EXPECT_NEAR(ball_beyond(-1, -1, -1), k_ball, 1e-12);
  EXPECT_NEAR(ball_beyond(0, 0, 0), k_ball / 8, 1e-12);
  // the cube within the ball and the ball within the cube
  EXPECT_NEAR(ball_in_box({1, 2, 3}, 1, {0.5, 1.5, 2.5}, {1.5, 2.5, 3.5}), 1, 1e-12);
  EXPECT_NEAR(ball_in_box({1, 2, 3}, 0.5, {0, 1, 2}, {2, 3, 4}), k_ball / 8, 1e-12);
  EXPECT_EQ(ball_in_box({1, 2, 3}, 0.5, {2, 1, 2}, {3, 3, 4}), 0);
  // a thin slab: pi (h - integral of z^2)
  EXPECT_NEAR(ball_in_box({0, 0, 0}, 1, {-2, -2, 0.3}, {2, 2, 0.31}),
              std::numbers::pi * (0.01 - (0.31 * 0.31 * 0.31 - 0.3 * 0.3 * 0.3) / 3), 1e-12);
}

TEST(Overlap, WedgeAgreesWithAQuadrature) {
  // {x >= a, y >= b}: integral over z of circular segments' quadrants, by Simpson's rule in an angle
  for (const auto& [a, b] : {std::pair{0.3, 0.5}, {0.1, 0.8}, {-0.4, 0.2}, {-0.3, -0.6}}) {
    const auto area = [&, a = a, b = b](double z) {
      const double rho2 = 1 - z * z, rho = std::sqrt(std::fmax(rho2, 0));
      // integral over y from max(b, -rho) to rho of (min(rho, sqrt(rho2 - y2)) - max(a, -sqrt))
      double sum = 0;
      const int n = 4000;
      const double from = std::fmax(b, -rho);
      if (from >= rho) return 0.0;
      // y = rho sin t
      const double t0 = std::asin(std::fmax(-1, from / rho)), t1 = std::numbers::pi / 2;
      for (int k = 0; k < n; ++k) {
        const double t = t0 + (t1 - t0) * (k + 0.5) / n, half = rho * std::cos(t);
        sum += std::fmax(0, half - std::fmax(a, -half)) * rho * std::cos(t) * (t1 - t0) / n;
      }
      return sum;
    };
    double v = 0;
    const int n = 400;
    for (int k = 0; k < n; ++k) {
      const double t = std::numbers::pi * (k + 0.5) / n;
      v += area(std::cos(t)) * std::sin(t) * std::numbers::pi / n;
    }
    EXPECT_NEAR(ball_beyond(a, b, -1), v, 3e-5) << a << " " << b;
  }
}

TEST(Overlap, CornersAgreeWithCountedPoints) {
  const CounterRng random(7, 1);
  int in[4] = {};
  const double corner[4][3] = {{0.2, 0.3, 0.1}, {-0.2, 0.5, 0.3}, {-0.5, -0.4, 0.2}, {-0.3, -0.2, -0.4}};
  const int n = 2000000;
  for (int k = 0; k < n; ++k) {
    const auto at = static_cast<std::uint64_t>(3 * k);
    const double x = random.uniform(at, -1, 1), y = random.uniform(at + 1, -1, 1), z = random.uniform(at + 2, -1, 1);
    if (x * x + y * y + z * z > 1) continue;
    for (int q = 0; q < 4; ++q) in[q] += x >= corner[q][0] && y >= corner[q][1] && z >= corner[q][2] ? 1 : 0;
  }
  for (int q = 0; q < 4; ++q) EXPECT_NEAR(ball_beyond(corner[q][0], corner[q][1], corner[q][2]), 8.0 * in[q] / n, 0.01);
}

TEST(Overlap, SharesOfAGridSumToTheBallAndToWhatEachBoxHolds) {
  const CounterRng random(3, 1);
  const Grid g({0, 0, 0}, {1, 0.8, 0.6}, {10, 8, 6}, {true, true, true});
  std::vector<std::pair<int, double>> parts;
  for (int k = 0; k < 300; ++k) {
    const auto at = static_cast<std::uint64_t>(4 * k);
    const Vec3 x{random.uniform(at), random.uniform(at + 1, 0, 0.8), random.uniform(at + 2, 0, 0.6)};
    const double r = random.uniform(at + 3, 0.01, 0.26);
    share(g, x, r, parts);
    double sum = 0;
    for (const auto& [cell, v] : parts) sum += v;
    EXPECT_NEAR(sum / (k_ball * r * r * r), 1, 1e-12);
    if (x.x - r < 0 || x.x + r > 1 || x.y - r < 0 || x.y + r > 0.8 || x.z - r < 0 || x.z + r > 0.6) continue;
    for (const auto& [cell, v] : parts) {
      const Vec3 m = g.middle(cell), h = 0.5 * g.h;
      EXPECT_NEAR(v, ball_in_box(x, r, m - h, m + h), 1e-12 * r * r * r);
      EXPECT_LE(v, g.volume * (1 + 1e-12));
    }
  }
}

TEST(Overlap, OnlyWhatLiesInTheGridCounts) {
  const Grid g({0, 0, 0}, {1, 1, 1}, {4, 4, 4});
  std::vector<std::pair<int, double>> parts;
  share(g, {0, 0.5, 0.5}, 0.1, parts);
  double sum = 0;
  for (const auto& [cell, v] : parts) sum += v;
  EXPECT_NEAR(sum, 0.5 * k_ball * 1e-3, 1e-14);
  share(g, {-0.2, 0.5, 0.5}, 0.1, parts);
  EXPECT_TRUE(parts.empty());
}

}  // namespace
}  // namespace talus::gas
