// Concentric shells of a plate, cylinder or sphere: faces, areas and layers from shell volumes. Who calls it: the grain
// solvers. Invariant: faces follow from the sum of volumes, from the centre outwards, so that a grain whose shells
// shrink stays without gaps.
#pragma once

#include <vector>

#include "core/heat/value.hpp"

namespace talus::heat {

enum class Shape { plate, cylinder, sphere };

inline constexpr double k_shape_exponent[] = {0, 1, 2};

/// Extent of a grain beside its radius: area of both faces of a plate [m2], length of a cylinder [m]; 1 for a sphere.
/// Volume within r is shape_factor r^(n+1).
inline double shape_factor(Shape shape, double extent) {
  switch (shape) {
    case Shape::plate:
      return extent;
    case Shape::cylinder:
      return det::k_pi * extent;
    case Shape::sphere:
      return 4.0 / 3.0 * det::k_pi;
  }
  return 0;
}

/// Distance from the centre (half thickness of a plate) that holds `volume`.
template <class V>
V radius_of(Shape shape, V volume, double factor) {
  const V x = volume / V(factor);
  return shape == Shape::plate ? x : shape == Shape::cylinder ? square_root(x) : cube_root(x);
}
template <class V>
V area_of(Shape shape, V r, double factor) {
  return shape == Shape::plate      ? V(factor) + r * V(0)
         : shape == Shape::cylinder ? V(2 * factor) * r
                                    : V(3 * factor) * r * r;
}
template <class V>
V volume_of(Shape shape, V r, double factor) {
  return shape == Shape::plate ? V(factor) * r : shape == Shape::cylinder ? V(factor) * r * r : V(factor) * r * r * r;
}

/// face[i] and face[i+1] bound shell i; face[0] is the centre.
template <class V>
struct Shells {
  Shape shape = Shape::sphere;
  double factor = 1;
  std::vector<V> face, area;  ///< [m], [m2]; one more than shells

  void resize(std::size_t shells) {
    face.assign(shells + 1, V(0));
    area.assign(shells + 1, V(0));
  }
  std::size_t size() const { return face.size() - 1; }
  V thickness(std::size_t i) const { return face[i + 1] - face[i]; }
  V middle(std::size_t i) const { return V(0.5) * (face[i + 1] + face[i]); }
  V radius() const { return face.back(); }

  void set(const std::vector<V>& volume) {
    V sum = V(0);
    face[0] = V(0);
    area[0] = shape == Shape::plate ? V(factor) : V(0);
    for (std::size_t i = 0; i < volume.size(); ++i) {
      sum = sum + volume[i];
      face[i + 1] = radius_of(shape, sum, factor);
      area[i + 1] = area_of(shape, face[i + 1], factor);
    }
  }
};

/// Volumes of shells of equal thickness.
template <class V>
std::vector<V> equal_shells(Shape shape, double factor, V radius, std::size_t shells) {
  std::vector<V> volume(shells, V(0));
  V below = V(0);
  for (std::size_t i = 0; i < shells; ++i) {
    const V r = radius * V(static_cast<double>(i + 1) / static_cast<double>(shells));
    const V within = volume_of(shape, r, factor);
    volume[i] = within - below;
    below = within;
  }
  return volume;
}

}  // namespace talus::heat
