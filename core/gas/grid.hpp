// Regular grid over a box: cells, the faces between them, the faces of its sides. Who uses it: all of core/gas.
// Invariant: cells and faces are numbered by the grid alone, x first.
#pragma once

#include <array>
#include <vector>

#include "core/base/types.hpp"

namespace talus::gas {

/// Between cell a and cell b, which follows on the axis.
struct InnerFace {
  int a, b, axis;
};
/// Of cell `cell` on a side: low (outward normal -axis) or high.
struct OuterFace {
  int cell, axis;
  bool high;
  Vec3 middle;  ///< [m]
};

struct Grid {
  Vec3 lower, upper, h;  ///< h: edges of a cell [m]
  std::array<int, 3> n{1, 1, 1};
  std::array<bool, 3> periodic{};
  double volume = 0;             ///< of a cell [m3]
  std::array<double, 3> area{};  ///< of a face, by axis [m2]
  std::vector<InnerFace> inner;
  std::vector<OuterFace> outer;

  Grid(Vec3 lower, Vec3 upper, std::array<int, 3> n, std::array<bool, 3> periodic = {});
  int cells() const noexcept { return n[0] * n[1] * n[2]; }
  int index(int i, int j, int k) const noexcept { return (k * n[1] + j) * n[0] + i; }
  Vec3 middle(int cell) const noexcept;
  /// Cell of a point, or -1 outside.
  int cell_of(Vec3 x) const noexcept;
};

}  // namespace talus::gas
