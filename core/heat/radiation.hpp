// Radiation between grey spheres. Who calls it: scheduler/parts/heat*. Invariant: exchange areas are the same seen from
// both bodies to the bit, so that what one gains the other loses.
#pragma once

#include "core/heat/surface.hpp"

namespace talus::heat {

/// (T1^2 + T2^2)(T1 + T2): times sigma, area and (T1 - T2) the exchange of two black bodies; commutes to the bit.
inline double radiant_slope(double t1, double t2) noexcept { return (t1 * t1 + t2 * t2) * (t1 + t2); }

/// Share of the space around the middle of a sphere that another of radius r at distance d fills.
inline double share_of_view(double r, double d) noexcept {
  const double s = r / d;
  return s < 1 ? 0.5 * (1 - square_root(1 - s * s)) : 0.5;
}

/// Area of exchange A_1 F_12 = A_2 F_21 of two black spheres [m2]: the mean of what the solid angles from both middles
/// give, which are exact far away. Equal spheres that touch: F = 0.067 (exactly 0.076).
inline double exchange_area(double r1, double r2, double d) noexcept {
  return 2 * det::k_pi * (r1 * r1 * share_of_view(r2, d) + r2 * r2 * share_of_view(r1, d));
}

/// The same for a plane at distance d of which a disc of radius `reach` is in sight.
inline double share_of_plane(double d, double reach) noexcept {
  return 0.5 * (1 - d / square_root(d * d + reach * reach));
}

/// Factor on it of grey surfaces that see little of each other's reflections: that of parallel plates.
inline double grey_factor(double e1, double e2) noexcept {
  const double product = e1 * e2;
  return product > 0 ? product / (e1 + e2 - product) : 0.0;
}

/// Temperature of the surface of a layer of conductance `layer` before a wall of temperature `beyond`, towards a body
/// of temperature T that takes g (T_s - T) + black (T_s^4 - T^4) from it [K]. Newton from above, where the function is
/// convex: from there it only falls.
inline double layer_surface(double layer, double g, double black, double T, double beyond) noexcept {
  const double T2 = T * T;
  double at = most(T, beyond);
  for (int k = 0; k < 60; ++k) {
    const double cube = at * at * at;
    const double f = g * (at - T) + black * (cube * at - T2 * T2) - layer * (beyond - at);
    const double next = at - f / (g + 4 * black * cube + layer);
    if (!(next < at)) break;
    at = next;
  }
  return at;
}

}  // namespace talus::heat
