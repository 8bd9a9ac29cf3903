// Coulomb's limit on the tangential force of the linear law (LINEAR.md), and what spring, dashpot and slider do with
// the energy.
#pragma once

#include "kernels/simd/simd.hpp"
#include "kernels/views.hpp"

namespace talus::kernels {

/// Impulse of a step over that of its force, in tangential direction: w where Coulomb's limit binds, m where it does
/// not. A spring that keeps its force F until the limit has fallen to it: m = 1/2 + u - droop F/L with droop = u/2, as
/// long as F is below the limit half a step before, L (1 + 1/(2 u)).
template <class S>
struct ImpulseWeights {
  typename S::B w, m, droop;
};

/// Coulomb: the factor that brings a trial force g to the limit, and what a sliding contact's spring becomes,
/// xi = spring xi - pull g. b = (rho L(n-1/2) + L/2)/k_t, back = spring per trial force. No branch: some of eight
/// contacts slide often enough that mispredictions cost more than the arithmetic. One division serves all.
template <class S>
struct CoulombLimit {
  typename S::M slides;
  typename S::B plain, scale, spring, pull, ratio, size;
  TALUS_INLINE void set(const typename S::B* g, typename S::B limit, typename S::B b, typename S::B rho,
                        typename S::B back) {
    const auto one = S::set(1.0), g2 = (g[0] * g[0] + g[1] * g[1]) + g[2] * g[2];
    const auto memory = rho * rho + rho, whole = memory + S::set(0.5);
    typename S::B all;  // 1/(|g| whole)
    if constexpr (S::fast) {
      const auto inv_g = S::inverse_sqrt(g2);
      size = S::select(S::gt(g2, S::set(1e-300)), g2 * inv_g, S::set(0.0));  // not 0 times infinity
      all = inv_g * S::inverse(whole);
    } else {
      size = S::sqrt(g2);
      all = one / (size * whole);
    }
    slides = S::gt(g2, limit * limit);
    ratio = limit * (all * whole);
    scale = plain = S::select(slides, ratio, one);
    spring = memory * (all * size);
    pull = (b - (rho * back) * size) * all;
  }
  /// The first and the last step of a contact; the other lanes keep their bits.
  TALUS_INLINE void weigh(typename S::B limit, const ImpulseWeights<S>& q) {
    const auto one = S::set(1.0), least = S::set(1e-300), zero = S::set(0.0);
    const auto r = size / S::select(S::gt(limit, least), limit, least);
    const auto knee = one + S::select(S::gt(q.droop, zero), S::set(0.25) / q.droop, zero);
    const auto weighed = S::select(S::lt(r, knee), q.m - q.droop * r, q.w * ratio);
    scale = S::select(S::gt(S::abs(q.m - one) + q.droop, zero), weighed, scale);
  }
};

/// Stiffness over the step and at its end [N/m], dashpot [kg/s], how long the spring has moved [s]; a contact that
/// parts before the next step, and whether the step before has counted that (0).
template <class S>
struct TangentialStep {
  typename S::B kt, last, ct, slid;
  typename S::M parts;
  typename S::B counted;
};

/// Energy of the tangential spring, added to that of the normal one, and what the step has lost, by the midpoint rule:
/// what the spring has moved heats the dashpot; what it has not, the slider, against the force of spring and dashpot.
/// What a parting contact still stores nobody gets back: its dashpot relaxes the spring.
template <class S>
TALUS_INLINE void tangential_ledger(const Block& b, int k, const TangentialStep<S>& q, bool balanced,
                                    const typename S::B* h, const typename S::B* trial, const typename S::B* t) {
  using B = typename S::B;
  const B zero = S::set(0.0), half = S::set(0.5);
  const B rate = q.ct * S::select(S::gt(q.slid, zero), S::set(1.0) / q.slid, zero);
  B stored = zero, heat = zero, rubbed = zero;
  for (int p = 0; p < 3; ++p) {
    const B way = t[p] * q.slid, rest = trial[p] - h[p], moved = balanced ? way : way - rest;
    const B spring = (half * q.kt) * ((trial[p] - way) + h[p]);
    stored = stored + (half * q.last) * (h[p] * h[p]);
    heat = heat + rate * (moved * moved);
    rubbed = rubbed + (balanced ? spring : spring + rate * moved) * rest;
  }
  const B freed = S::select(q.parts, stored, zero);
  S::store(b.e[0] + k, S::load(b.e[0] + k) + (stored - freed));
  S::store(b.e[1] + k, S::load(b.e[1] + k) + (heat + freed * q.counted));
  S::store(b.e[2] + k, rubbed);
}

}  // namespace talus::kernels
