// Implementation of clump_quadrature.hpp.
#include "core/shapes/clump_quadrature.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace talus::shapes {
namespace {

Moments columns(std::span<const SubSphere> spheres, Vec3 lower, Vec3 upper, int n) {
  const double hx = (upper.x - lower.x) / n, hy = (upper.y - lower.y) / n;
  Moments m;
  std::vector<std::pair<double, double>> pieces;
  std::vector<SubSphere> near;
  for (int i = 0; i < n; ++i) {
    const double x = lower.x + (i + 0.5) * hx;
    near.clear();
    for (const SubSphere& s : spheres)
      if (__builtin_fabs(x - s.x.x) < s.r) near.push_back(s);
    for (int j = 0; j < n; ++j) {
      const double y = lower.y + (j + 0.5) * hy;
      pieces.clear();
      for (const SubSphere& s : near) {
        const double w = (s.r * s.r - (x - s.x.x) * (x - s.x.x)) - (y - s.x.y) * (y - s.x.y);
        if (!(w > 0)) continue;
        const double half = __builtin_sqrt(w);
        pieces.emplace_back(s.x.z - half, s.x.z + half);
      }
      std::sort(pieces.begin(), pieces.end());
      double top = -1e300;
      for (const auto& [from, to] : pieces) {
        const double a = fmax2(from, top);
        top = fmax2(top, to);
        if (!(to > a)) continue;
        const double length = to - a, z1 = 0.5 * (to * to - a * a), z2 = (to * to * to - a * a * a) / 3;
        m.v = m.v + length;
        m.first = m.first + Vec3{x * length, y * length, z1};
        m.second[0] = m.second[0] + x * x * length;
        m.second[1] = m.second[1] + y * y * length;
        m.second[2] = m.second[2] + z2;
        m.second[3] = m.second[3] + x * y * length;
        m.second[4] = m.second[4] + x * z1;
        m.second[5] = m.second[5] + y * z1;
      }
    }
  }
  const double cell = hx * hy;
  m.v = cell * m.v;
  m.first = cell * m.first;
  for (double& s : m.second) s = cell * s;
  return m;
}

}  // namespace

MassProperties properties(const Moments& m) noexcept {
  MassProperties p;
  p.volume = m.v;
  p.centre = (1 / m.v) * m.first;
  const Vec3 c = p.centre;
  const double xx = m.second[0] - m.v * c.x * c.x, yy = m.second[1] - m.v * c.y * c.y,
               zz = m.second[2] - m.v * c.z * c.z;
  p.inertia = {yy + zz,
               xx + zz,
               xx + yy,
               m.v * c.x * c.y - m.second[3],
               m.v * c.x * c.z - m.second[4],
               m.v * c.y * c.z - m.second[5]};
  return p;
}

MassProperties column_quadrature(std::span<const SubSphere> spheres) {
  // About the middle of the box, so that moments of a clump far from the origin keep their digits.
  Vec3 lower{1e300, 1e300, 1e300}, upper{-1e300, -1e300, -1e300};
  for (const SubSphere& s : spheres)
    for (int k = 0; k < 3; ++k) {
      lower[k] = fmin2(lower[k], s.x[k] - s.r);
      upper[k] = fmax2(upper[k], s.x[k] + s.r);
    }
  const Vec3 middle = 0.5 * (lower + upper);
  std::vector<SubSphere> moved(spheres.begin(), spheres.end());
  for (SubSphere& s : moved) s.x = s.x - middle;
  constexpr int k_columns = 768;
  MassProperties fine = properties(columns(moved, lower - middle, upper - middle, k_columns));
  const MassProperties coarse = properties(columns(moved, lower - middle, upper - middle, k_columns / 2));
  fine.volume_error = __builtin_fabs(fine.volume - coarse.volume) / fine.volume;
  const double largest = fmax2(fine.inertia[0], fmax2(fine.inertia[1], fine.inertia[2]));
  for (int k = 0; k < 6; ++k) {
    const auto e = static_cast<std::size_t>(k);
    fine.inertia_error = fmax2(fine.inertia_error, __builtin_fabs(fine.inertia[e] - coarse.inertia[e]) / largest);
  }
  fine.centre = fine.centre + middle;
  return fine;
}

}  // namespace talus::shapes
