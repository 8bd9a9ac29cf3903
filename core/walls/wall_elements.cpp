// Closest points of wall elements. Who calls it: core/walls/walls.cpp, core/walls/facet_grid.cpp. Invariants: see the
// header.
#include "core/walls/wall_elements.hpp"

#include <limits>

namespace talus {

Vec3 unit(Vec3 a) noexcept {
  // Scaling by the largest component keeps the squares in range.
  const double ax = a.x < 0 ? -a.x : a.x, ay = a.y < 0 ? -a.y : a.y, az = a.z < 0 ? -a.z : a.z;
  const double big = fmax2(ax, fmax2(ay, az));
  if (!(big > 0)) return a;
  const Vec3 s{a.x / big, a.y / big, a.z / big};
  const double len = std::sqrt(norm2(s));
  return {s.x / len, s.y / len, s.z / len};
}

Vec3 any_perpendicular(Vec3 n) noexcept {
  const double ax = n.x < 0 ? -n.x : n.x, ay = n.y < 0 ? -n.y : n.y, az = n.z < 0 ? -n.z : n.z;
  const Vec3 least = (ax <= ay && ax <= az) ? Vec3{1, 0, 0} : (ay <= az ? Vec3{0, 1, 0} : Vec3{0, 0, 1});
  return unit(least - dot(least, n) * n);
}

PlaneElement make_plane(Vec3 point, Vec3 normal) noexcept { return {point, unit(normal)}; }

FrustumElement make_frustum(Vec3 base, Vec3 axis, double length, double radius_start, double radius_end) noexcept {
  FrustumElement f;
  f.base = base;
  f.axis = unit(axis);
  f.side = any_perpendicular(f.axis);
  f.radius_start = radius_start;
  f.radius_end = radius_end;
  f.length = length;
  const double dr = radius_end - radius_start;
  const double len = std::sqrt(dr * dr + length * length);
  f.normal_rho = length / len;
  f.normal_z = -dr / len;
  return f;
}

TriangleElement make_triangle(Vec3 a, Vec3 b, Vec3 c) noexcept {
  TriangleElement t;
  t.v = {a, b, c};
  const Vec3 middle = (1.0 / 3.0) * (a + b + c);
  for (int k = 0; k < 3; ++k) t.ball_centre[static_cast<std::size_t>(k)] = static_cast<float>(middle[k]);
  const Vec3 centre{t.ball_centre[0], t.ball_centre[1], t.ball_centre[2]};
  const double far2 = fmax2(norm2(a - centre), fmax2(norm2(b - centre), norm2(c - centre)));
  t.ball_radius = static_cast<float>(std::sqrt(far2) * (1 + 1e-6));
  // The cross product of the two shortest edges loses least to cancellation: in a needle they meet at an open angle.
  const double ab = norm2(b - a), bc = norm2(c - b), ca = norm2(a - c);
  if (ab >= bc && ab >= ca) {
    t.normal = unit(cross(a - c, b - c));
    t.point = c;
  } else if (bc >= ca) {
    t.normal = unit(cross(b - a, c - a));
    t.point = a;
  } else {
    t.normal = unit(cross(c - b, a - b));
    t.point = b;
  }
  return t;
}

ElementHit closest(const PlaneElement& plane, Vec3 c) noexcept {
  const double s = dot(c - plane.point, plane.normal);
  return s < 0 ? ElementHit{-plane.normal, -s, Feature::face} : ElementHit{plane.normal, s, Feature::face};
}

ElementHit closest(const FrustumElement& f, Vec3 c) noexcept {
  const Vec3 d = c - f.base;
  const double z = dot(d, f.axis);
  const Vec3 radial = d - z * f.axis;
  const double rho = std::sqrt(norm2(radial));
  // On the axis (to rounding) every azimuth is as near as any other: take the stored one.
  const double noise = 1e-15 * ((z < 0 ? -z : z) + f.radius_start + f.radius_end);
  const Vec3 across = rho > noise ? Vec3{radial.x / rho, radial.y / rho, radial.z / rho} : f.side;

  const double dr = f.radius_end - f.radius_start;
  const double along = ((rho - f.radius_start) * dr + z * f.length) / (dr * dr + f.length * f.length);
  double n_rho = f.normal_rho, n_z = f.normal_z;
  ElementHit hit;
  if (along >= 0 && along <= 1) {
    const double s = (rho - f.radius_start) * f.normal_rho + z * f.normal_z;
    hit.distance = s < 0 ? -s : s;
    if (s < 0) n_rho = -n_rho, n_z = -n_z;
  } else {
    const double rim = along < 0 ? f.radius_start : f.radius_end;
    const double a = rho - rim, b = along < 0 ? z : z - f.length;
    hit.distance = std::sqrt(a * a + b * b);
    hit.feature = rim > 0 ? Feature::edge : Feature::vertex;
    if (hit.distance > 0) n_rho = a / hit.distance, n_z = b / hit.distance;
  }
  hit.normal = n_rho * across + n_z * f.axis;
  return hit;
}

ElementHit closest(const TriangleElement& t, Vec3 c) noexcept {
  ElementHit hit;
  closest_within(t, c, std::numeric_limits<double>::infinity(), hit);
  return hit;
}

bool closest_within(const TriangleElement& t, Vec3 c, double limit, ElementHit& hit) noexcept {
  const double away = limit + t.ball_radius;
  const Vec3 from_ball{c.x - t.ball_centre[0], c.y - t.ball_centre[1], c.z - t.ball_centre[2]};
  if (norm2(from_ball) > away * away) return false;
  const double h = plane_distance(t, c);
  const double room = limit * limit - h * h;  // of the squared distance within the plane
  if (!(room > 0)) return false;
  const Vec3 facing = h < 0 ? -t.normal : t.normal;
  hit = {facing, h < 0 ? -h : h, Feature::face};
  double best = -1;
  Vec3 to_centre;
  // The closest point of a convex polygon lies on an edge that has the centre on its outer side.
  for (int k = 0; k < 3; ++k) {
    const Vec3 a = t.v[k], b = t.v[k == 2 ? 0 : k + 1], e = b - a, d = c - a;
    const Vec3 outward = cross(e, t.normal);
    const double s = dot(outward, d), length2 = norm2(outward);
    if (!(s > 0)) continue;
    if (s * s >= room * length2) return false;
    const double u = dot(d, e), e2 = norm2(e);
    const bool inner = u > 0 && u < e2;
    const Vec3 q = inner ? d - (u / e2) * e : (u > 0 ? c - b : d);
    const double d2 = norm2(q);
    const Feature feature = inner ? Feature::edge : Feature::vertex;
    if (best < 0 || d2 < best || (d2 == best && feature < hit.feature)) {
      best = d2;
      to_centre = q;
      hit.feature = feature;
    }
  }
  if (best < 0) return true;
  hit.distance = std::sqrt(best);
  if (hit.distance > 0)
    hit.normal = {to_centre.x / hit.distance, to_centre.y / hit.distance, to_centre.z / hit.distance};
  return true;
}

}  // namespace talus
