// Exact overlap of a ball and boxes: how the volume of a grain is shared among the cells of a grid. Who calls it:
// core/gas/share.hpp. Invariant (I4): + - * / sqrt alone; the parts of a ball over all cells of a grid add up to the
// ball.
#pragma once

#include "core/base/types.hpp"

namespace talus::gas {

/// Volume of {x >= a, y >= b, z >= c} within the unit ball [-].
double ball_beyond(double a, double b, double c) noexcept;

/// Volume of the ball of radius `r` about `centre` within the box [lower, upper] [m3], error below 1e-14 r^3.
double ball_in_box(Vec3 centre, double r, Vec3 lower, Vec3 upper) noexcept;

}  // namespace talus::gas
