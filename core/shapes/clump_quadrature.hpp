// Moments of a union of spheres by columns. Who calls it: clump.cpp. Invariants: I4; sums in a fixed order.
#pragma once

#include <array>
#include <span>

#include "core/shapes/clump.hpp"

namespace talus::shapes {

/// Integrals over a body of 1, (x, y, z) and xx, yy, zz, xy, xz, yz.
struct Moments {
  double v = 0;
  Vec3 first;
  std::array<double, 6> second{};
};
/// About the centre of mass.
MassProperties properties(const Moments& m) noexcept;

/// Midpoint rule over a square grid of lines along z, on each of which the union is a set of intervals, integrated
/// exactly. 768 lines a side; the stated error is the difference to 384.
MassProperties column_quadrature(std::span<const SubSphere> spheres);

}  // namespace talus::shapes
