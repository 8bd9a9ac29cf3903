// Random shapes, poses and contacts with a known answer for the tests of core/shapes.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string_view>

#include "core/base/rng.hpp"
#include "core/shapes/pair_contact.hpp"

namespace talus::shapes::testing {

/// TALUS_FULL=1: the long variants.
inline bool full_requested() {
  const char* word = std::getenv("TALUS_FULL");
  return word != nullptr && std::string_view(word) == "1";
}

struct Draw {
  CounterRng rng;
  std::uint64_t n = 0;
  explicit Draw(std::uint64_t seed) : rng(seed, 1) {}
  double uniform(double low = 0, double high = 1) { return rng.uniform(n++, low, high); }
  Vec3 direction() {
    const double z = uniform(-1, 1), phi = 2 * M_PI * uniform(), s = std::sqrt(1 - z * z);
    return {s * std::cos(phi), s * std::sin(phi), z};
  }
  Quaternion turn() {
    for (;;) {
      const Quaternion q{uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
      const double s = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
      if (s < 1 && s > 0.01) return normalised(q);
    }
  }
  /// Semi-axes in [1 / aspect, 1], log-uniform.
  Superquadric shape(double least_n, double most_n, double aspect) {
    Superquadric s;
    for (int k = 0; k < 3; ++k) s.axes[k] = std::exp(-std::log(aspect) * uniform());
    s.n1 = uniform(least_n, most_n);
    s.n2 = uniform(least_n, most_n);
    return s;
  }
};

inline double least_axis(const Superquadric& s) { return std::min({s.axes.x, s.axes.y, s.axes.z}); }

/// Homogeneous of degree 1, and 1 on the surface; written with the C library, apart from the code under test.
inline double gauge(const Superquadric& s, Vec3 x) {
  const double xy = std::pow(std::fabs(x.x / s.axes.x), s.n2) + std::pow(std::fabs(x.y / s.axes.y), s.n2);
  return std::pow(std::pow(xy, s.n1 / s.n2) + std::pow(std::fabs(x.z / s.axes.z), s.n1), 1 / s.n1);
}

/// Unit normal whose support point is drawn evenly over the faces, not over the directions: flat parts are met as often
/// as their area says.
inline Vec3 normal_of_random_point(const Superquadric& s, Draw& draw) {
  Vec3 u = draw.direction();
  const double g = gauge(s, {u.x * s.axes.x, u.y * s.axes.y, u.z * s.axes.z});
  u = (1 / g) * u;  // on the surface of unit axes
  const double inner = std::pow(std::fabs(u.x), s.n2) + std::pow(std::fabs(u.y), s.n2);
  const double f = inner > 0 ? std::pow(inner, s.n1 / s.n2 - 1) : 0;
  const Vec3 m{f * std::copysign(std::pow(std::fabs(u.x), s.n2 - 1), u.x) / s.axes.x,
               f * std::copysign(std::pow(std::fabs(u.y), s.n2 - 1), u.y) / s.axes.y,
               std::copysign(std::pow(std::fabs(u.z), s.n1 - 1), u.z) / s.axes.z};
  return (1 / norm(m)) * m;
}

/// Two bodies that touch with a normal and an overlap that are chosen first.
struct KnownContact {
  Superquadric si, sj;
  Body i, j;
  Vec3 normal;
  double overlap;
};
/// kind 0: any normal (edges and corners, mostly); 1, 2: a random place on the surface of i, of j; 3: the two bodies
/// turned alike.
inline KnownContact known_contact(Draw& draw, int kind, double least_n, double most_n, double aspect, double depth) {
  KnownContact c;
  c.si = draw.shape(least_n, most_n, aspect);
  c.sj = draw.shape(least_n, most_n, aspect);
  const Quaternion qi = draw.turn(), qj = kind == 3 ? qi : draw.turn();
  c.i = make_body(c.si, 1e9, {}, qi);
  c.j = make_body(c.sj, 1e9, {}, qj);
  c.normal = draw.direction();
  if (kind == 1) c.normal = to_space(c.i.turn, normal_of_random_point(c.si, draw));
  if (kind == 2) c.normal = -1.0 * to_space(c.j.turn, normal_of_random_point(c.sj, draw));
  c.overlap = depth * draw.uniform() * std::min(least_axis(c.si), least_axis(c.sj));
  const Vec3 xi = to_space(c.i.turn, support_point(c.si, to_body(c.i.turn, c.normal)).point);
  const Vec3 xj = to_space(c.j.turn, support_point(c.sj, to_body(c.j.turn, -c.normal)).point);
  c.j.centre = (xi - xj) - c.overlap * c.normal;
  return c;
}

}  // namespace talus::shapes::testing
