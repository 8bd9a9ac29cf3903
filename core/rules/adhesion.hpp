// Reach and strength of adhesion and cohesion. Who calls it: scheduler/lists/skin.hpp (R_C includes the range, I1),
// scheduler/ (narrow phase, construction), core/rules/timestep.cpp. Formulae: kernels/models/jkr.hpp and cohesion.hpp.
#pragma once

#include "core/scene/scene.hpp"

namespace talus {

/// kappa = pi w/(8 E*) of a material pair [m]: a_c^3 = kappa R*^2, rupture where -delta = 3 kappa^(2/3) R*^(1/3).
/// 0 unless the model is jkr.
double adhesion_length(const Scene& scene, int a, int b);

/// c in R_C = r + c r^(1/3) [m^(2/3)] for the strongest pair: R* <= min(r_i, r_j) gives R*^(1/3) <= (r_i^(1/3) +
/// r_j^(1/3))/2, so that the sum of two reaches covers every rupture distance; with a wall (R* = r) it is 2 c r^(1/3).
double adhesion_reach(const Scene& scene);

/// Refuses attraction that no contact can balance below checks.max_overlap: Error{scene} names the pair, the overlap at
/// rest and the largest coefficient that is allowed. Radii in [m].
void check_attraction(const Scene& scene, double r_min, double r_max);

}  // namespace talus
