// Implementation of wall_contact.hpp.
#include "core/shapes/wall_contact.hpp"

#include <tuple>
#include <utility>

#include "core/base/det_math.hpp"

namespace talus::shapes {
namespace {

/// Support of the body along a unit direction of space: value and point relative to the centre.
SupportPoint reach(const Body& b, Vec3 n) noexcept {
  const Vec3 m = to_body(b.turn, n);
  const Support<Plain> s = support<Plain>(b.form, {m.x, m.y, m.z}, k_eta);
  return {s.h, to_space(b.turn, {s.point.x, s.point.y, s.point.z})};
}

/// The segment from a to b as the thinnest of bodies: half its length along x, next to nothing across.
Body segment(Vec3 a, Vec3 b) noexcept {
  const Vec3 half = 0.5 * (b - a);
  const double length = norm(half), thin = 1e-12 * length;
  const Vec3 e = (1 / length) * half;
  const Tangents<Plain> t = tangents<Plain>({e.x, e.y, e.z});
  Body s;
  s.form = {{length * length, thin * thin, thin * thin}, 2, 2};
  s.size = length;
  s.roundness = 0;
  s.centre = 0.5 * (a + b);
  s.turn = {{{e.x, t.u.x, t.v.x}, {e.y, t.u.y, t.v.y}, {e.z, t.u.z, t.v.z}}};
  return s;
}

bool inside(const Vec3 (&v)[3], Vec3 normal, Vec3 x) noexcept {
  for (int k = 0; k < 3; ++k)
    if (dot(cross(v[(k + 1) % 3] - v[k], x - v[k]), normal) < 0) return false;
  return true;
}

/// What the turn phi about the axis of a wall makes of a body: h(n) + n . (centre - apex) - reach.
struct Turned {
  const Body& body;
  const ConeWall& wall;
  Vec3 u, v;
  Turned(const Body& b, const ConeWall& w) : body(b), wall(w) {
    const Tangents<Plain> t = tangents<Plain>({w.axis.x, w.axis.y, w.axis.z});
    u = {t.u.x, t.u.y, t.u.z};
    v = {t.v.x, t.v.y, t.v.z};
  }
  Vec3 radial(double turns) const noexcept {
    const auto s = det::sincos_turns(turns);
    return s.cos * u + s.sin * v;
  }
  Vec3 normal(double turns) const noexcept { return wall.cosine * radial(turns) + wall.sine * wall.axis; }
  double value(double turns) const noexcept {
    const Vec3 n = normal(turns);
    return (reach(body, n).h + dot(n, body.centre - wall.apex)) - wall.reach;
  }
  /// Derivative by the angle, but for a positive factor.
  double slope(double turns) const noexcept {
    const Vec3 side = cross(wall.axis, radial(turns));
    return dot(side, reach(body, normal(turns)).point + (body.centre - wall.apex));
  }
};

/// Zero of f between a (f > 0) and b (f <= 0): bisection, so that kinks do no harm.
template <class F>
double falling_zero(F f, double a, double b) noexcept {
  for (int k = 0; k < 46; ++k) {
    const double m = 0.5 * (a + b);
    (f(m) > 0 ? a : b) = m;
  }
  return 0.5 * (a + b);
}

}  // namespace

WallContact plane_contact(const Body& body, Vec3 on, Vec3 out) noexcept {
  const SupportPoint p = reach(body, -out);
  WallContact c;
  c.normal = -out;
  c.overlap = p.h - dot(body.centre - on, out);
  c.point = body.centre + (p.point - (0.5 * c.overlap) * c.normal);
  return c;
}

WallContact edge_contact(const Body& body, Vec3 a, Vec3 b, PairCount& count) noexcept {
  PairMemory none;
  const PairContact e = solve_pair(body, segment(a, b), none, count);
  return {e.normal, e.overlap, e.point};
}

bool freed_by_face(const Body& body, const Vec3 (&corner)[3], const WallContact& c, PairCount& count) noexcept {
  const Vec3 deepest = c.point + (0.5 * c.overlap) * c.normal, way = deepest - body.centre;
  const double height = dot(way, c.normal);
  // where the line from the centre to the deepest point meets the plane, the body does
  const Vec3 area = cross(corner[1] - corner[0], corner[2] - corner[0]);
  if (height > 0 && inside(corner, area, body.centre + ((height - c.overlap) / height) * way)) return true;
  bool met = false;
  for (int k = 0; k < 3; ++k) {
    Vec3 a = corner[k], b = corner[(k + 1) % 3];
    if (std::tie(b.x, b.y, b.z) < std::tie(a.x, a.y, a.z)) std::swap(a, b);
    const WallContact e = edge_contact(body, a, b, count);
    if (!(e.overlap > 0)) continue;
    met = true;
    const Vec3 foot = e.point - (0.5 * e.overlap) * e.normal;
    bool all_behind = true;
    for (const Vec3& x : corner) all_behind = all_behind && dot(x - foot, e.normal) >= -1e-9 * norm(b - a);
    if (all_behind && e.overlap < c.overlap) return false;
  }
  return met;  // a convex section that holds no border of the facet and a point out of it holds none of the facet
}

WallContact triangle_contact(const Body& body, const Vec3 (&corner)[3], PairMemory (&memory)[3],
                             PairCount& count) noexcept {
  const Vec3 area = cross(corner[1] - corner[0], corner[2] - corner[0]);
  const Vec3 normal = (1 / norm(area)) * area;
  const double side = dot(body.centre - corner[0], normal) < 0 ? -1 : 1;
  WallContact best = plane_contact(body, corner[0], side * normal);
  if (!(best.overlap > 0)) return best;  // the plane parts them
  if (inside(corner, normal, best.point) && freed_by_face(body, corner, best, count)) return best;
  best.overlap = -1e300;
  for (int k = 0; k < 3; ++k) {
    const PairContact e = solve_pair(body, segment(corner[k], corner[(k + 1) % 3]), memory[k], count);
    if (e.overlap > best.overlap) best = {e.normal, e.overlap, e.point};
  }
  return best;
}

int cone_contacts_inside(const Body& body, const ConeWall& wall, WallContact (&contact)[2]) noexcept {
  const Turned t(body, wall);
  constexpr int k_directions = 48;
  double slope[k_directions + 1];
  for (int k = 0; k <= k_directions; ++k) slope[k] = t.slope(static_cast<double>(k % k_directions) / k_directions);
  int found = 0;
  for (int k = 0; k < k_directions; ++k) {
    if (!(slope[k] > 0 && slope[k + 1] <= 0)) continue;  // a maximum lies between
    const double phi = falling_zero([&](double p) { return t.slope(p); }, static_cast<double>(k) / k_directions,
                                    static_cast<double>(k + 1) / k_directions);
    WallContact c;
    c.normal = t.normal(phi);
    c.overlap = t.value(phi);
    if (!(c.overlap > 0)) continue;
    c.point = body.centre + (reach(body, c.normal).point - (0.5 * c.overlap) * c.normal);
    if (found == 0 || c.overlap > contact[0].overlap) {
      if (found > 0) contact[1] = contact[0];
      contact[0] = c;
    } else if (found == 1 || c.overlap > contact[1].overlap) {
      contact[1] = c;
    }
    found = found < 2 ? found + 1 : 2;
  }
  return found;
}

WallContact cylinder_contact_outside(const Body& body, const ConeWall& wall) noexcept {
  const Turned t(body, wall);
  // n points from the body to the wall; the overlap is h(n) + reach + n . (centre - axis), least over n.
  constexpr int k_directions = 48;
  double low = 1e300;
  int where = 0;
  for (int k = 0; k < k_directions; ++k) {
    const double v = t.value(static_cast<double>(k) / k_directions);
    if (v < low) low = v, where = k;
  }
  const double phi = falling_zero([&](double p) { return -t.slope(p); }, static_cast<double>(where - 1) / k_directions,
                                  static_cast<double>(where + 1) / k_directions);
  WallContact c;
  c.normal = t.normal(phi);
  c.overlap = t.value(phi) + 2 * wall.reach;
  c.point = body.centre + (reach(body, c.normal).point - (0.5 * c.overlap) * c.normal);
  return c;
}

}  // namespace talus::shapes
