// Implementation of superquadric.hpp.
#include "core/shapes/superquadric.hpp"

#include <fmt/format.h>

#include "core/base/det_math.hpp"
#include "core/base/error.hpp"

namespace talus::shapes {
namespace {

/// log of the Gamma function for x > 0, absolute error below 1e-14: recurrence to x >= 12, then Stirling's series.
double log_gamma(double x) {
  double product = 1;
  while (x < 12) {
    product = product * x;
    x = x + 1;
  }
  const double y = 1 / (x * x);
  constexpr double series[] = {1.0 / 12, -1.0 / 360, 1.0 / 1260, -1.0 / 1680, 1.0 / 1188, -691.0 / 360360, 1.0 / 156};
  double tail = series[6];
  for (int k = 5; k >= 0; --k) tail = series[k] + y * tail;
  constexpr double half_log_two_pi = 0.91893853320467274178;
  return ((x - 0.5) * det::log(x) - x) + half_log_two_pi + tail / x - det::log(product);
}

double beta(double a, double b) { return det::exp(log_gamma(a) + log_gamma(b) - log_gamma(a + b)); }

/// max of sqrt(x^2 + y^2) on (x/a)^n + (y/b)^n = 1.
double longest(double a, double b, double n) {
  const double large = fmax2(a, b), ratio = fmin2(a, b) / large;
  if (!(n > 2)) return large;
  const double q = 2 * n / (n - 2), tail = det::pow(ratio, q);
  return large * det::exp(det::log(1 + tail) / q);
}

double positive_power(double x, double y) { return x > 1e-300 ? power<Plain>(x, y) : 0; }

}  // namespace

void check(const Superquadric& s, const char* where) {
  double low = s.axes.x, high = s.axes.x;
  for (int k = 0; k < 3; ++k) {
    const double a = s.axes[k];
    if (!(a > 0) || !(a < 1e12))
      throw Error(ErrorCode::scene, fmt::format("semi-axis {} is {}", k + 1, a), where,
                  "semi-axes are positive lengths");
    low = fmin2(low, a);
    high = fmax2(high, a);
  }
  if (high > k_aspect_most * low)
    throw Error(ErrorCode::scene,
                fmt::format("semi-axes {} and {} differ by more than a factor of {}", low, high, k_aspect_most), where,
                "choose a less elongated shape");
  for (const double n : {s.n1, s.n2}) {
    if (!(n >= k_exponent_least && n <= k_exponent_most))
      throw Error(ErrorCode::scene, fmt::format("exponent {}", n), where,
                  fmt::format("allowed: {} to {}", k_exponent_least, k_exponent_most));
  }
}

double volume(const Superquadric& s) {
  const double e1 = 2 / s.n1, e2 = 2 / s.n2;
  return 2 * s.axes.x * s.axes.y * s.axes.z * e1 * e2 * beta(0.5 * e1 + 1, e1) * beta(0.5 * e2, 0.5 * e2);
}

Vec3 inertia(const Superquadric& s) {
  const double e1 = 2 / s.n1, e2 = 2 / s.n2;
  const double factor = 0.5 * s.axes.x * s.axes.y * s.axes.z * e1 * e2;
  const double across = beta(1.5 * e2, 0.5 * e2) * beta(0.5 * e1, 2 * e1 + 1);
  const double along = 4 * s.axes.z * s.axes.z * beta(0.5 * e2, 0.5 * e2 + 1) * beta(1.5 * e1, e1 + 1);
  const double x2 = s.axes.x * s.axes.x, y2 = s.axes.y * s.axes.y;
  return {factor * (y2 * across + along), factor * (x2 * across + along), factor * ((x2 + y2) * across)};
}

double bounding_radius(const Superquadric& s) { return longest(longest(s.axes.x, s.axes.y, s.n2), s.axes.z, s.n1); }

double smallest_radius(const Superquadric& s) {
  // A grid over one octant, dense where the axes stretch the normals; the margin covers what lies between its points.
  constexpr int k_grid = 48;
  double least = 1e300;
  for (int i = 1; i < k_grid; ++i) {
    const auto polar = det::sincos_turns(0.25 * i / k_grid);
    for (int j = 1; j < k_grid; ++j) {
      const auto turn = det::sincos_turns(0.25 * j / k_grid);
      // The grid is one of surface points of the ellipsoid with these axes, by their normals.
      Vec3 m{polar.sin * turn.cos / s.axes.x, polar.sin * turn.sin / s.axes.y, polar.cos / s.axes.z};
      m = (1 / norm(m)) * m;
      least = fmin2(least, radii_of_curvature(s, m).small);
      const Vec3 even{polar.sin * turn.cos, polar.sin * turn.sin, polar.cos};
      least = fmin2(least, radii_of_curvature(s, even).small);
    }
  }
  for (int i = 0; i <= 8 * k_grid; ++i) {
    const auto turn = det::sincos_turns(0.25 * i / (8 * k_grid));
    for (const Vec3 m : {Vec3{turn.cos, turn.sin, 0}, Vec3{turn.cos, 0, turn.sin}, Vec3{0, turn.cos, turn.sin}})
      least = fmin2(least, radii_of_curvature(s, m).small);
  }
  return 0.9 * least;
}

double inside_outside(const Superquadric& s, Vec3 x) noexcept {
  const double px = positive_power(__builtin_fabs(x.x / s.axes.x), s.n2);
  const double py = positive_power(__builtin_fabs(x.y / s.axes.y), s.n2);
  const double pz = positive_power(__builtin_fabs(x.z / s.axes.z), s.n1);
  return (positive_power(px + py, s.n1 / s.n2) + pz) - 1;
}

DualForm<Plain> dual_form(const Superquadric& s) noexcept {
  return {{s.axes.x * s.axes.x, s.axes.y * s.axes.y, s.axes.z * s.axes.z}, s.n1 / (s.n1 - 1), s.n2 / (s.n2 - 1)};
}

SupportPoint support_point(const Superquadric& s, Vec3 m) noexcept {
  const Support<Plain> p = support<Plain>(dual_form(s), {m.x, m.y, m.z}, k_eta);
  return {p.h, {p.point.x, p.point.y, p.point.z}};
}

Radii radii_of_curvature(const Superquadric& s, Vec3 m) noexcept {
  const Triple<Plain> n{m.x, m.y, m.z};
  const Support<Plain> p = support<Plain>(dual_form(s), n, k_eta);
  const Tangents<Plain> t = tangents<Plain>(n);
  const double a = radii<Plain>(p, t.u, t.u), b = radii<Plain>(p, t.u, t.v), c = radii<Plain>(p, t.v, t.v);
  const double mean = 0.5 * (a + c), diff = 0.5 * (a - c), large = mean + __builtin_sqrt(diff * diff + b * b);
  return {(a * c - b * b) / large, large};
}

double hertz_radius(Radii r, double flat) noexcept {
  const double mean = __builtin_sqrt(fmax2(r.small, 0) * fmax2(r.large, 0));
  if (!(mean > flat)) return mean;
  const double beyond = mean - flat, most = 4 * flat;
  return flat + most * (beyond / (beyond + most));
}

}  // namespace talus::shapes
