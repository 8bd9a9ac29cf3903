// Inside of a triangulated surface without holes. Who calls it: core/grains/region.cpp (regions given by a mesh),
// core/grains/source_walls.cpp (closed walls). Invariants: I4 (+ - * / and comparisons decide what is inside, sqrt
// enters distances only); the answer does not depend on the winding of the facets nor on the order in which they are
// visited.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/types.hpp"
#include "core/meshes/mesh_file.hpp"
#include "core/walls/wall_elements.hpp"

namespace talus {

/// A point is inside where an upward ray from it meets the surface an odd number of times: a shell within a shell
/// bounds a hollow. The ray is moved aside by an infinitesimal amount (Edelsbrunner and Muecke 1990, "simulation of
/// simplicity") and sides of edges are decided exactly, so that a ray through an edge or a vertex counts right. Points
/// nearer to the surface than the rounding of its coordinates may be counted to either side.
class ClosedSurface {
 public:
  /// Error{scene} naming the file where an edge has an odd number of facets: then nothing is enclosed.
  explicit ClosedSurface(const Mesh& mesh);

  bool inside(Vec3 x) const noexcept { return crossings(x, -1) % 2 == 1; }
  /// Distance of x to the surface, or `within` where it is farther [m].
  double distance(Vec3 x, double within) const noexcept;
  double volume() const noexcept { return volume_; }  ///< enclosed [m3]
  Vec3 lower() const noexcept { return nodes_[0].lower; }
  Vec3 upper() const noexcept { return nodes_[0].upper; }
  const std::vector<TriangleElement>& facets() const noexcept { return facets_; }

 private:
  /// Box around facets [first, first + count) of a leaf, or around two child nodes from `first` on (count 0).
  struct Node {
    Vec3 lower, upper;
    std::int32_t first = 0, count = 0;
  };
  void build();
  void split(std::int32_t node, std::int32_t first, std::int32_t last);
  /// Facets above x, without the facet `skip`.
  int crossings(Vec3 x, std::int32_t skip) const noexcept;
  double enclosed() const noexcept;

  std::vector<TriangleElement> facets_;
  std::vector<Node> nodes_;
  double volume_ = 0;
};

}  // namespace talus
