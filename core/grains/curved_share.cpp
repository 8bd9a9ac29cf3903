// See curved_share.hpp.
#include "core/grains/curved_share.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/det_math.hpp"
#include "core/base/types.hpp"

namespace talus {
namespace {

double arc_cosine(double x) noexcept {
  if (x >= 1) return 0;
  return x <= -1 ? det::k_pi : 2 * det::atan(std::sqrt((1 - x) / (1 + x)));
}

/// Common area of two circles.
double lens(double a, double b, double distance) noexcept {
  const double small = fmin2(a, b), large = fmax2(a, b), d = distance;
  if (d >= a + b) return 0;
  if (d <= large - small) return det::k_pi * (small * small);
  const double u = (d * d + small * small - large * large) / (2 * d * small),
               v = (d * d + large * large - small * small) / (2 * d * large);
  const double q = (small + large - d) * (d + small - large) * (d - small + large) * (d + small + large);
  return small * small * arc_cosine(u) + large * large * arc_cosine(v) - 0.5 * std::sqrt(fmax2(q, 0.0));
}

constexpr int k_points = 16;
/// Fejer's first rule on [-1, 1]: points that crowd at both ends, where the areas begin like roots.
struct Points {
  std::array<double, k_points> x, weight;
};
Points make_points() noexcept {
  Points p;
  for (int k = 0; k < k_points; ++k) {
    double sum = 0;
    for (int j = 1; j <= k_points / 2; ++j) sum += det::sincos_turns(j * (k + 0.5) / k_points).cos / (4.0 * j * j - 1);
    p.x[static_cast<std::size_t>(k)] = det::sincos_turns((k + 0.5) / (2 * k_points)).cos;
    p.weight[static_cast<std::size_t>(k)] = 2.0 / k_points * (1 - 2 * sum);
  }
  return p;
}

}  // namespace

double share_in_ball(double R, double distance, double r) noexcept {
  const double d = distance, sum = R + r, difference = R - r;
  if (d >= sum) return 0;
  if (d <= difference) return 1;
  if (d <= -difference) return (R / r) * (R / r) * (R / r);
  return (sum - d) * (sum - d) * (d * d + 2 * d * sum - 3 * difference * difference) / (16 * d * (r * r * r));
}

double share_in_bar(double R, double low, double high, double off, double r) noexcept {
  static const Points points = make_points();
  const double from = fmax2(low, -r), to = fmin2(high, r);
  if (!(from < to) || off >= R + r) return 0;
  // where the circles in which the planes across the axis cut the sphere begin to reach the surface, and to hold it
  std::array<double, 6> end{from, to, from, from, from, from};
  std::size_t n = 2;
  for (const double s : {R - off, R + off}) {
    if (!(s * s < r * r)) continue;
    const double a = std::sqrt(r * r - s * s);
    end[n++] = std::clamp(-a, from, to);
    end[n++] = std::clamp(a, from, to);
  }
  std::sort(end.begin(), end.end());
  double volume = 0;
  for (std::size_t k = 0; k + 1 < end.size(); ++k) {
    const double middle = 0.5 * (end[k] + end[k + 1]), half = 0.5 * (end[k + 1] - end[k]);
    if (!(half > 0)) continue;
    for (std::size_t q = 0; q < k_points; ++q) {
      const double a = middle + half * points.x[q];
      volume += half * points.weight[q] * lens(std::sqrt(fmax2(r * r - a * a, 0.0)), R, off);
    }
  }
  return volume / (4.0 / 3.0 * det::k_pi * (r * r * r));
}

}  // namespace talus
