// See frustum.hpp.
#include "core/walls/shapes/frustum.hpp"

#include <cmath>

#include "core/base/det_math.hpp"
#include "core/walls/wall_surface.hpp"

namespace talus {
namespace {

/// True if a rotation about the motion's axis leaves the surface of revolution where it is.
bool turns_in_place(const FrustumElement& f, const WallMotion& m) {
  if (m.rotation_rate == 0) return true;
  const double size =
      std::sqrt(norm2(f.base)) + std::sqrt(norm2(m.rotation_origin)) + f.length + f.radius_start + f.radius_end;
  return norm2(cross(unit(m.rotation_axis), f.axis)) <= 1e-26 &&
         norm2(cross(f.base - m.rotation_origin, f.axis)) <= 1e-26 * size * size;
}

/// Points of both ends, 360 on each, outside by what lies between them.
std::vector<Vec3> rims(const FrustumElement& f) {
  std::vector<Vec3> points;
  const Vec3 other = cross(f.axis, f.side);
  for (int end = 0; end < 2; ++end) {
    const Vec3 centre = f.base + (end * f.length) * f.axis;
    const double r = (end == 0 ? f.radius_start : f.radius_end) * 1.00004;  // 1 / cos(1/2 degree)
    for (int k = 0; k < 360; ++k) {
      const auto [s, c] = det::sincos_turns(k / 360.0);
      points.push_back(centre + (r * c) * f.side + (r * s) * other);
    }
  }
  return points;
}

}  // namespace

Frustum::Frustum(const WallSpec& spec, double radius_end)
    : frustum_(make_frustum(spec.point, spec.axis, spec.length, spec.radius, radius_end)),
      turns_in_place_(turns_in_place(frustum_, spec.motion)) {
  const Vec3 top = frustum_.base + frustum_.length * frustum_.axis;
  const double r = fmax2(spec.radius, radius_end);
  Vec3 lo, hi;
  for (int k = 0; k < 3; ++k) {
    const double a = frustum_.axis[(k + 1) % 3], b = frustum_.axis[(k + 2) % 3], across = r * std::sqrt(a * a + b * b);
    lo[k] = fmin2(frustum_.base[k], top[k]) - across, hi[k] = fmax2(frustum_.base[k], top[k]) + across;
  }
  corners = box_corners(lo, hi);
}

WallSurface Frustum::surface(const WallPose& pose, Vec3, Vec3) const {
  WallSurface s = tessellated(frustum_);
  for (Vec3& p : s.points) p = to_world(pose, p);
  return s;
}

double Frustum::travelled(const WallPose& from, const WallPose& to, const std::array<Vec3, 8>& domain) const {
  if (turns_in_place_) return std::sqrt(norm2(to.translation - from.translation));
  return Shape::travelled(from, to, domain);
}

double Frustum::speed(const WallPose& pose, const std::array<Vec3, 8>& domain) const {
  if (turns_in_place_) return std::sqrt(norm2(pose.velocity));
  return Shape::speed(pose, domain);
}

WallPiece Frustum::piece(std::int32_t) const {
  WallPiece p;
  if (frustum_.radius_start != frustum_.radius_end) return p;
  p.kind = WallPiece::Kind::cylinder;
  p.corner[0] = frustum_.base;
  p.normal = frustum_.axis;
  p.radius = frustum_.radius_start;
  return p;
}

double side_of_tube(const WallSpec& spec, double radius_end, Vec3 x) {
  const FrustumElement f = make_frustum(spec.point, spec.axis, spec.length, spec.radius, radius_end);
  const Vec3 d = x - f.base;
  const double z = dot(d, f.axis);
  if (!(f.length > 0) || z < 0 || z > f.length) return 0;
  const double rho = norm(d - z * f.axis), radius = f.radius_start + (radius_end - f.radius_start) * (z / f.length);
  return (rho - radius) * f.normal_rho;
}

double away_of_tube(const Domain& domain, const WallSpec& spec, double radius_end) {
  const Vec3 axis = unit(spec.axis), end = spec.point + spec.length * axis;
  const double r = fmax2(spec.radius, radius_end);
  Vec3 lower, upper;
  for (int k = 0; k < 3; ++k) {
    const double across = r * std::sqrt(fmax2(0.0, 1 - axis[k] * axis[k]));
    lower[k] = fmin2(spec.point[k], end[k]) - across;
    upper[k] = fmax2(spec.point[k], end[k]) + across;
  }
  return away_from(domain, lower, upper);
}

double Frustum::arm(const WallMotion& m) const {
  return farthest_from_axis(m.rotation_origin, m.rotation_axis, rims(frustum_));
}

}  // namespace talus
