// Uniform grid over the facets of one mesh in its body frame: one cell lookup yields every facet that can be within
// reach of a point. Who calls it: core/walls/walls.cpp. Invariants: I1 (a facet is listed in every cell that holds a
// point within `reach` of it), ascending facet ids in every cell, memory bounded whatever the facets' sizes.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/walls/wall_elements.hpp"

namespace talus {

class FacetGrid {
 public:
  FacetGrid() = default;
  /// `reach` [m]: largest distance that near() must cover; `slack` [m]: how far a facet may be off its shared plane.
  FacetGrid(std::span<const TriangleElement> facets, double reach, double slack);

  double reach() const noexcept { return reach_; }
  /// Ascending ids of (at least) all facets within reach() of c; empty far from the mesh.
  std::span<const std::int32_t> near(Vec3 c) const noexcept;
  std::size_t bytes() const noexcept { return (first_.size() + facets_.size()) * sizeof(std::int32_t); }
  std::size_t entries() const noexcept { return facets_.size(); }

 private:
  bool fill(std::span<const TriangleElement> facets, double padded, double edge, std::size_t limit);

  double reach_ = 0;
  Vec3 lower_, upper_;
  double inverse_edge_ = 0;
  std::array<int, 3> cells_{0, 0, 0};
  std::vector<std::int32_t> first_;   ///< start of each cell's list, one more than cells
  std::vector<std::int32_t> facets_;  ///< lists of all cells
};

}  // namespace talus
