// Spheres near a region with their periodic images. Who calls it: core/grains/insertion_fill.cpp,
// core/grains/insertion_file.cpp. Invariants: those of core/grains/overlap_grid.hpp.
#pragma once

#include "core/grains/overlap_grid.hpp"
#include "core/scene/scene.hpp"

namespace talus {

/// Into the domain through its periodic sides, at most one period off.
inline Vec3 wrapped(const Domain& d, Vec3 x) noexcept {
  for (int k = 0; k < 3; ++k) {
    if (!d.periodic(k)) continue;
    const double length = d.upper[k] - d.lower[k];
    if (x[k] < d.lower[k]) x[k] = x[k] + length;
    if (x[k] >= d.upper[k]) x[k] = x[k] - length;
    if (x[k] < d.lower[k]) x[k] = d.lower[k];
  }
  return x;
}

/// Spheres near a region, periodic images included.
class Occupied {
 public:
  /// `largest` [m]: radius of the largest sphere that will be asked for.
  Occupied(const Domain& domain, Vec3 lower, Vec3 upper, double largest)
      : domain_(domain), lower_(lower), upper_(upper), largest_(largest), grid_(largest) {}

  void add(Vec3 x, double r, std::int32_t index = 0) {
    const double margin = r + largest_;
    Vec3 shifts[3];  // per axis: 0, -L, +L; only periodic axes use the last two
    int count[3];
    for (int k = 0; k < 3; ++k) {
      const double length = domain_.upper[k] - domain_.lower[k];
      count[k] = 0;
      for (double s : {0.0, -length, length}) {
        if (s != 0 && !domain_.periodic(k)) continue;
        const double y = x[k] + s;
        if (y >= lower_[k] - margin && y <= upper_[k] + margin) shifts[count[k]++][k] = y;
      }
    }
    for (int a = 0; a < count[0]; ++a)
      for (int b = 0; b < count[1]; ++b)
        for (int c = 0; c < count[2]; ++c) grid_.add({shifts[a].x, shifts[b].y, shifts[c].z}, r, index);
  }
  /// True if a sphere at x touches nothing; `scale` < 1 forgives rounding where sites touch by construction.
  bool free(Vec3 x, double r, double scale = 1 + 1e-12) const {
    return !grid_.any(x, r, [&](const OverlapGrid::Sphere& s, double d2) {
      const double sum = (r + s.r) * scale;
      return d2 < sum * sum;
    });
  }
  const OverlapGrid& grid() const { return grid_; }
  void reserve(std::size_t n) { grid_.reserve(n); }

 private:
  const Domain& domain_;
  Vec3 lower_, upper_;
  double largest_;
  OverlapGrid grid_;
};

}  // namespace talus
