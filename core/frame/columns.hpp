// Named columns of values: what a frame looks like to every writer and reader of files. Who uses it: core/frame
// (quantities), core/io.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "core/base/types.hpp"

namespace talus {

/// rows * components, row by row
using ColumnValues =
    std::variant<std::vector<double>, std::vector<std::int64_t>, std::vector<std::int32_t>, std::vector<std::uint8_t>>;

struct PolyColumn {
  std::string name;
  int components = 1;
  ColumnValues values;
};

struct PolyData {
  std::vector<Vec3> points;                            ///< [m]
  bool vertices = false;                               ///< one vertex cell per point, so that viewers show points
  std::vector<std::array<std::int32_t, 3>> triangles;  ///< polygon cells
  std::vector<PolyColumn> point_data, cell_data;       ///< cell_data: rows follow vertices, then triangles
  std::size_t cells() const noexcept { return (vertices ? points.size() : 0) + triangles.size(); }
};

/// Regular grid of cells with columns per cell (x fastest).
struct GridData {
  Vec3 lower, spacing;  ///< [m]
  std::array<int, 3> cells{1, 1, 1};
  std::vector<PolyColumn> cell_data;
};

}  // namespace talus
