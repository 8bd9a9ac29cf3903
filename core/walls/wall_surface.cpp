// Surfaces for output. Who calls it: core/walls/walls.cpp. Invariants: see the header.
#include "core/walls/wall_surface.hpp"

#include <cmath>
#include <map>

#include "core/base/det_math.hpp"

namespace talus {

WallSurface clipped_plane(Vec3 point, Vec3 normal, Vec3 lower, Vec3 upper) {
  // A square on the plane that covers the box, cut by the box's six half spaces one after the other.
  const Vec3 middle = 0.5 * (lower + upper);
  const Vec3 centre = middle - dot(middle - point, normal) * normal;
  const double half = std::sqrt(norm2(upper - lower));
  const Vec3 u = half * any_perpendicular(normal), v = cross(normal, u);
  std::vector<Vec3> polygon{centre - u - v, centre + u - v, centre + u + v, centre - u + v};
  for (int side = 0; side < 6; ++side) {
    const int k = side / 2;
    const double sign = side % 2 == 0 ? 1 : -1, bound = side % 2 == 0 ? lower[k] : upper[k];
    std::vector<Vec3> kept;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Vec3 a = polygon[i], b = polygon[(i + 1) % polygon.size()];
      const double da = sign * (a[k] - bound), db = sign * (b[k] - bound);
      if (da >= 0) kept.push_back(a);
      if ((da > 0 && db < 0) || (da < 0 && db > 0)) kept.push_back(a + (da / (da - db)) * (b - a));
    }
    polygon = std::move(kept);
  }
  WallSurface s;
  if (polygon.size() < 3) return s;
  s.points = std::move(polygon);
  for (std::int32_t i = 2; i < static_cast<std::int32_t>(s.points.size()); ++i) s.triangles.push_back({0, i - 1, i});
  return s;
}

WallSurface tessellated(const FrustumElement& f) {
  constexpr std::int32_t segments = 64;
  WallSurface s;
  const Vec3 across = cross(f.axis, f.side), top = f.base + f.length * f.axis;
  for (std::int32_t i = 0; i < segments; ++i) {
    const auto [sin, cos] = det::sincos_turns(static_cast<double>(i) / segments);
    const Vec3 e = cos * f.side + sin * across;
    s.points.push_back(f.base + f.radius_start * e);
    s.points.push_back(top + f.radius_end * e);
  }
  for (std::int32_t i = 0; i < segments; ++i) {
    const std::int32_t a = 2 * i, b = 2 * ((i + 1) % segments);
    if (f.radius_start > 0) s.triangles.push_back({a, b, b + 1});
    if (f.radius_end > 0) s.triangles.push_back({a, b + 1, a + 1});
  }
  return s;
}

WallSurface tessellated(std::span<const TriangleElement> facets) {
  WallSurface s;
  std::map<std::array<double, 3>, std::int32_t> index;
  for (const TriangleElement& t : facets) {
    std::array<std::int32_t, 3> f{};
    for (int k = 0; k < 3; ++k) {
      const auto [it, added] = index.try_emplace({t.v[k].x, t.v[k].y, t.v[k].z}, s.points.size());
      if (added) s.points.push_back(t.v[k]);
      f[k] = it->second;
    }
    s.triangles.push_back(f);
  }
  return s;
}

}  // namespace talus
