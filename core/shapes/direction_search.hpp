// The safe method: least overlap over all directions by branch and bound. Who calls it: pair_contact.cpp, where
// Newton's method fails or may have found a minimum that is not the least. Invariants: I4; never fails.
#pragma once

#include <cstdint>

#include "core/shapes/pair_newton.hpp"

namespace talus::shapes {

struct Direction {
  Triple<Plain> n;
  double overlap = 0;  ///< at n [m]
  double width = 0;    ///< of the cell that n stands for [rad]
  std::int64_t evaluations = 0;
};

/// Cells are spherical triangles. The support points at a direction give a plane below the overlap (support functions
/// are convex), so a cell whose bound exceeds the best value by more than `tolerance` [m] cannot hold the minimum.
/// Cells are halved until they are smaller than `width` [rad], or too many to go on; the best direction is returned.
Direction search_directions(const PairForm<Plain>& p, double tolerance, double width) noexcept;

}  // namespace talus::shapes
