// Is there a wall without a gap between two places of it? Tells two supports of a long body from one surface. Who calls
// it: core/shapes/body_walls.cpp. Invariants: I4; a function of the pieces and the places alone, in whatever order.
#pragma once

#include <vector>

#include "core/walls/walls.hpp"

namespace talus::shapes {

/// Planes and triangles cover the way from `from` to `to`, seen along the unit normal `into` (into the wall): those
/// count that lie no farther behind the plane through `from` than `to` or `depth`, and no farther before it than
/// `slack` [m]. Gaps of `slack` count as none. Cylinders cover nothing: two rollers are two supports.
bool covered_way(const std::vector<WallPiece>& pieces, Vec3 from, Vec3 into, Vec3 to, double depth, double slack);

}  // namespace talus::shapes
