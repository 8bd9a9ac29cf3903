// Bodies of initial files by their true surfaces: which rows belong together, how deep two of them overlap. Who calls
// it: core/grains/insertion_file.cpp. Invariants: I4; spheres alone cost nothing.
#pragma once

#include <cstdint>
#include <vector>

#include "core/grains/insertion.hpp"
#include "core/shapes/pair_contact.hpp"

namespace talus {

class FileBodies {
 public:
  FileBodies(const Scene& scene, const NewParticles& p);
  bool any() const noexcept { return !owner_.empty(); }
  /// False: particles i at x and j at y (an image, perhaps) are of one body or apart. Of superquadrics depth [m] and
  /// its share of the thinner one become those of the surfaces.
  bool meet(std::int32_t i, Vec3 x, std::int32_t j, Vec3 y, double& depth, double& share) const;
  /// The particle as a superquadric with its centre at x; null where it is a sphere.
  const shapes::Body* surface(std::int32_t i, Vec3 x) const;
  double thickness(std::int32_t i) const;  ///< radius of the sphere within [m]

 private:
  const QuadricShape* quadric(std::int32_t i) const;
  shapes::Body body(std::int32_t i, Vec3 x) const;

  const Scene& scene_;
  const NewParticles& p_;
  std::vector<std::int32_t> owner_;  ///< of each particle: index of its body or -1; empty: there are none
  mutable shapes::Body body_;
};

}  // namespace talus
