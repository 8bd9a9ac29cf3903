// See overlap.hpp. The solid is bounded by three planes and the sphere: its volume is a third of (area on the sphere -
// distance times area on each plane), by the divergence theorem; the area on the sphere is that of a polygon of circles
// (Gauss-Bonnet), those on the planes are sectors less triangles.
#include "core/gas/overlap.hpp"

#include "core/base/det_math.hpp"

namespace talus::gas {

namespace {

constexpr double k_half_pi = 0.5 * det::k_pi;

/// Plane x = a cuts {y >= b, z >= c} out of its disc; wb, wc: half chords on which y = b and z = c meet the sphere.
struct Face {
  double arc;  ///< angle of the circle [rad]
  double area;
  Face(double a, double b, double c, double wb, double wc)
      : arc(k_half_pi - det::atan(b / wb) - det::atan(c / wc)),
        area(0.5 * ((1 - a * a) * arc - b * (wb - c) - c * (wc - b))) {}
};

/// For a, b, c >= 0 with the corner inside of the ball.
double corner_volume(double a, double b, double c) {
  const double ab = __builtin_sqrt(1 - a * a - b * b), ac = __builtin_sqrt(1 - a * a - c * c),
               bc = __builtin_sqrt(1 - b * b - c * c);
  const Face fa(a, b, c, ab, ac), fb(b, a, c, ab, bc), fc(c, a, b, ac, bc);
  const double turns = det::atan(a * b / ab) + det::atan(a * c / ac) + det::atan(b * c / bc);
  const double sphere = k_half_pi - turns - (a * fa.arc + b * fb.arc + c * fc.arc);
  return fmax2(0, (sphere - (a * fa.area + b * fb.area + c * fc.area)) / 3);
}

double cap_volume(double c) { return c >= 1 ? 0 : det::k_pi * (1 - c) * (1 - c) * (2 + c) / 3; }

}  // namespace

double ball_beyond(double a, double b, double c) noexcept {
  // What lies beyond a negative plane is what lies beyond the middle twice, less the mirror image of the rest.
  if (a >= 1 || b >= 1 || c >= 1) return 0;
  if (a < 0) return 2 * ball_beyond(0, b, c) - ball_beyond(-a, b, c);
  if (b < 0) return 2 * ball_beyond(a, 0, c) - ball_beyond(a, -b, c);
  if (c < 0) return 2 * ball_beyond(a, b, 0) - ball_beyond(a, b, -c);
  if (a == 0 && b == 0) return 0.25 * cap_volume(c);
  if (a == 0 && c == 0) return 0.25 * cap_volume(b);
  if (b == 0 && c == 0) return 0.25 * cap_volume(a);
  return (a * a + b * b) + c * c >= 1 ? 0 : corner_volume(a, b, c);
}

double ball_in_box(Vec3 centre, double r, Vec3 lower, Vec3 upper) noexcept {
  double at[3][2];
  for (int k = 0; k < 3; ++k) {
    at[k][0] = fmax2(-1, (lower[k] - centre[k]) / r);
    at[k][1] = fmin2(1, (upper[k] - centre[k]) / r);
    if (at[k][0] >= at[k][1]) return 0;
  }
  double sum = 0;
  for (int q = 0; q < 8; ++q) {
    const int i = q & 1, j = (q >> 1) & 1, k = q >> 2;
    const double part = ball_beyond(at[0][i], at[1][j], at[2][k]);
    sum += (i + j + k) % 2 == 0 ? part : -part;
  }
  return fmax2(0, sum) * (r * r * r);
}

}  // namespace talus::gas
