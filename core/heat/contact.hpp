// Conduction between two spheres, or a sphere and a half space: through their contact, and through the gas beside it.
// Who calls it: scheduler/parts/heat*. Invariants: symmetric in the two bodies to the bit, so that what one gains the
// other loses; + - * / sqrt and det only (I4).
#pragma once

#include "core/heat/value.hpp"

namespace talus::heat {

/// R* of two radii [m]; commutes to the bit.
inline double reduced(double r1, double r2) noexcept { return r1 * r2 / (r1 + r2); }

/// Hertz: radius of the circle in which two surfaces touch, sqrt(R* delta) [m].
inline double hertz_contact_radius(double r_star, double overlap) noexcept {
  return overlap > 0 ? square_root(r_star * overlap) : 0.0;
}
/// The same from a force [N] and E* [Pa]: (3 F R* / (4 E*))^(1/3).
inline double hertz_radius_of_force(double r_star, double force, double e_star) noexcept {
  return force > 0 ? cube_root(3 * force * r_star / (4 * e_star)) : 0.0;
}
/// JKR: the radius a at which delta = a^2/R* - 4 sqrt(kappa a), kappa = pi w / (8 E*) [m]; of the stable branch.
/// Newton from above, where the function is convex.
inline double jkr_contact_radius(double r_star, double overlap, double kappa) noexcept {
  const double root = cube_root(kappa * r_star * r_star);
  double a = 3 * root + square_root(r_star * (overlap > 0 ? overlap : 0.0));
  for (int k = 0; k < 12; ++k) {
    const double s = square_root(kappa * a);
    const double f = a * a / r_star - 4 * s - overlap, slope = 2 * a / r_star - 2 * s / a;
    a = slope > 0 ? a - f / slope : a;
  }
  return a;
}

/// Batchelor and O'Brien (1977): 2 k a with k the harmonic mean of both conductivities [W/K].
inline double contact_conductance(double k1, double k2, double a) noexcept {
  const double sum = k1 + k2;
  return sum > 0 ? 4 * (k1 * k2) / sum * a : 0.0;
}

/// Of two conductances one behind the other [W/K]; 0 where one is.
inline double in_series(double a, double b) noexcept { return a > 0 && b > 0 ? 1 / (1 / a + 1 / b) : 0.0; }

/// Gas between two equal spheres of radius R whose surfaces are `gap` apart (negative: they overlap), straight lines of
/// heat parallel to the axis: 2 pi k int r dr / max(least, gap(r)) from the edge of the contact to where the layers of
/// thickness layer * R around both end [W/K]. Of two unequal ones R is twice R*, the radius with the same gap(r) near
/// the axis.
inline double gap_conductance(double k, double R, double gap, double layer, double least_gap) noexcept {
  const double d = gap + 2 * R, half = 0.5 * d, reach = R * (1 + layer);
  if (!(half < reach)) return 0;
  // u = sqrt(R^2 - r^2) along the axis; the gap at r is d - 2u
  const double r_out2 = least(reach * reach - half * half, R * R);
  const double u_out = square_root(most(R * R - r_out2, 0.0));
  const double u_in = half < R ? half : R;                              // edge of the contact, or the axis
  const double u_least = clamped(half - 0.5 * least_gap, u_out, u_in);  // nearer than this: the least gap
  const double narrow = 0.5 * (u_in * u_in - u_least * u_least) / least_gap;
  const double open = 0.5 * (u_out - u_least) + 0.25 * d * det::log((d - 2 * u_out) / (d - 2 * u_least));
  return 2 * det::k_pi * k * (narrow + most(open, 0.0));
}

/// Of a sphere at a plane: the same lines of heat, twice those between it and its mirror image.
inline double gap_conductance_to_plane(double k, double R, double gap, double layer, double least_gap) noexcept {
  return 2 * gap_conductance(k, R, 2 * gap, layer, 2 * least_gap);
}

}  // namespace talus::heat
