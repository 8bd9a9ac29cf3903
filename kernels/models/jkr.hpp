// JKR adhesion (Johnson, Kendall & Roberts 1971) on top of the Hertz-Mindlin law: model "jkr". The force of the normal
// direction is here; damping, tangential force and history are those of hertz_mindlin.hpp with the contact radius of
// JKR. w is the work of adhesion of the pair [J/m2] (w = 2 gamma for like surfaces of surface energy gamma).
//   delta = a^2/R* - sqrt(2 pi w a/E*),   F = 4 E* a^3/(3 R*) - sqrt(8 pi w E* a^3)
// in units of the radius at pull-off under fixed displacement, a = a_c s^2 with a_c^3 = pi w R*^2/(8 E*):
//   delta = (a_c^2/R*) (s^4 - 4 s),   F = pi w R* (s^6/6 - s^3),   U = pi w a_c^2 (s^10/15 - 2/3 s^7 + s^4) + const
// Pull-off force 3/2 pi w R* (s^3 = 3), force at delta = 0: -4/3 pi w R*, overlap without load 2 6^(1/3) a_c^2/R*,
// rupture at delta = -3 a_c^2/R* (s = 1) with -5/6 pi w R*. A pair attaches at delta = 0 and holds until rupture
// (kernels/ narrow_adhesive.hpp); the work of that loop, 7.09 (w^5 R*^4/E*^2)^(1/3), is lost. Coulomb's limit is mu
// (F_n + 3 pi w R*), the force that presses the surfaces together in JKR theory (Thornton 1991). Ledger: U = 0 at delta
// = 0, stored for delta > 0; what is done on the neck below zero overlap counts as lost until it is given back, so that
// nothing is missing when the neck breaks.
#pragma once

#include "kernels/models/linear.hpp"

namespace talus::kernels {

/// Cube root of z > 0: z^(1/4 + 1/16 + 1/64) by square roots leaves z^(1/192) = at most a factor 0.6 or 1.7 for z in
/// 1e-40 ... 1e40; four steps of Halley's iteration (cubic) then reach the last bits.
template <class S>
TALUS_INLINE typename S::B cube_root(typename S::B z) {
  const auto q = S::sqrt(S::sqrt(z)), s = S::sqrt(S::sqrt(q)), t = S::sqrt(S::sqrt(s));
  auto y = (q * s) * t;
  for (int k = 0; k < 4; ++k) {
    const auto y3 = (y * y) * y;
    y = y * ((y3 + (z + z)) / ((y3 + y3) + z));
  }
  return y;
}

/// Root s >= 1 of s^4 - 4 s = D for excess = D + 3 >= 0. With s = 1 + u: u sqrt(u^2 + 4 u + 6) = sqrt(excess), whose
/// left side is convex and has slope sqrt(6) at 0: Newton from the upper bound min(sqrt(E/6), E^(1/4)) descends without
/// crossing the root, also at pull-off where the quartic has a double root. Six steps reach the last bits.
template <class S>
TALUS_INLINE typename S::B jkr_root(typename S::B excess) {
  const auto two = S::set(2.0), four = S::set(4.0), six = S::set(6.0);
  const auto target = S::sqrt(excess), wide = S::sqrt(target), flat = target * S::set(0.40824829046386301637);
  auto u = S::select(S::lt(flat, wide), flat, wide);
  for (int k = 0; k < 6; ++k) {
    const auto root = S::sqrt((u * u + four * u) + six);
    // u - (u root - target) / slope, slope = (2 u^2 + 6 u + 6) / root
    u = u - ((u * root - target) * root) / ((two * (u * u) + six * u) + six);
  }
  return S::set(1.0) + u;
}

/// What JKR theory gives for W contacts.
template <class S>
struct JkrContact {
  typename S::B s, a, unit, pull;  ///< a: contact radius [m]; unit = a_c^2/R* [m]; pull = pi w R* [N]
  TALUS_INLINE void set(typename S::B w, typename S::B e_star, typename S::B reff, typename S::B delta) {
    // a pair without adhesion: so little that it is far below the rounding of any force
    const auto least = S::set(1e-20) * (e_star * reff);
    w = S::select(S::lt(w, least), least, w);
    const auto pi = S::set(3.14159265358979323846);
    const auto cube = (pi * w) * ((reff * reff) / (S::set(8.0) * e_star)), ac = cube_root<S>(cube);
    unit = (ac * ac) / reff;
    pull = (pi * w) * reff;
    const auto excess = delta / unit + S::set(3.0), zero = S::set(0.0);
    s = jkr_root<S>(S::select(S::gt(excess, zero), excess, zero));
    a = ac * (s * s);
  }
  TALUS_INLINE typename S::B force() const {
    const auto s3 = (s * s) * s;
    return pull * (s3 * (s3 * S::set(1.0 / 6.0) - S::set(1.0)));
  }
  /// Energy above that at delta = 0 [J]; s = 4^(1/3) there, and 12/5 4^(1/3) the constant.
  TALUS_INLINE typename S::B energy() const {
    const auto s3 = (s * s) * s, s4 = s3 * s;
    return (pull * unit) *
           (s4 * ((s3 * s3) * S::set(1.0 / 15.0) - s3 * S::set(2.0 / 3.0) + S::set(1.0)) + S::set(3.8097625247236784));
  }
};

}  // namespace talus::kernels
