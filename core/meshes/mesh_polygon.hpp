// Polygons into triangles. Who calls it: core/meshes/mesh_polygon.cpp's add_polygons (mesh_text.hpp) and tests.
// Invariant: the triangles returned cover the polygon once; all are wound like it.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/types.hpp"

namespace talus::mesh_io {

/// Corners that all polygons of one file may visit: the work can grow with the cube of their corners.
inline constexpr std::int64_t k_budget = 1'000'000'000;

/// Cuts a polygon, which may be concave and need not be flat, by clipping ears, seen along its mean normal (Newell).
/// A convex polygon becomes a fan about its first corner. `out` gets corner numbers. False where no triangulation
/// without overlap exists: the polygon crosses itself; or where `budget`, lowered by the work, falls below 0. A polygon
/// without area yields triangles without area.
bool triangulate(std::span<const Vec3> corners, std::vector<std::array<std::int32_t, 3>>& out, std::int64_t& budget);

}  // namespace talus::mesh_io
