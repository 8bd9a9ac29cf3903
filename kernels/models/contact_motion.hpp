// What the force laws need of the motion of a pair: coefficients, the normal to which velocities belong, the velocity
// that a centred dashpot sees, tangential velocity.
#pragma once

#include "kernels/passes/narrow.hpp"
#include "kernels/simd/simd.hpp"
#include "kernels/views.hpp"

namespace talus::kernels {

/// Loads of one material pair's coefficients for W contacts.
template <class S, bool Multi>
struct Coefficients {
  typename S::B kn, kt, gn, gt, mu;
  TALUS_INLINE void load(const Block& b, const LawArgs& a, int k) {
    if constexpr (Multi) {
      double t[5][S::W];
      for (int q = 0; q < S::W; ++q) {
        const PairParameters& p = a.table[b.pair[k + q]];
        t[0][q] = p.kn;
        t[1][q] = p.kt;
        t[2][q] = p.gn;
        t[3][q] = p.gt;
        t[4][q] = p.mu;
      }
      kn = S::load(t[0]);
      kt = S::load(t[1]);
      gn = S::load(t[2]);
      gt = S::load(t[3]);
      mu = S::load(t[4]);
    } else {
      kn = S::set(a.one.kn);
      kt = S::set(a.one.kt);
      gn = S::set(a.one.gn);
      gt = S::set(a.one.gt);
      mu = S::set(a.one.mu);
    }
  }
};

/// The normal to which velocity and spin belong. synchronised: they are those of n-1/2, so it is the normal of that
/// instant, c = (x(n) - v dt/2)/d, unnormalised. With the normal at n the spin's part of the tangential velocity is off
/// by s x (v_t dt/2d): a grain that rolls around another one then winds its spring up along the normal plane at a
/// constant rate, is drawn in and sticks. 1/|c|^2 is expanded to 1 + 2 vn dt/2d, which leaves
/// (v dt/2d)^2 of the normal velocity, along c.
template <class S>
struct MidNormal {
  typename S::B c[3], along, stretch;  ///< along = v.c, stretch = along (1/|c|^2 - 1)
  TALUS_INLINE void set(const typename S::B* v, const typename S::B* n, typename S::B vn, typename S::B inv, double dt,
                        int synchronised) {
    for (int k = 0; k < 3; ++k) c[k] = n[k];
    along = vn;
    stretch = S::set(0.0);
    if (synchronised != 0) {
      const auto tilt = S::set(0.5 * dt) * inv;
      for (int k = 0; k < 3; ++k) c[k] = n[k] - tilt * v[k];
      along = (v[0] * c[0] + v[1] * c[1]) + v[2] * c[2];
      stretch = (along * vn) * (tilt + tilt);
    }
  }
  /// What the distance grows by in a step because the pair moves past each other, v_t^2 dt^2/(2 d) [m]. Small, but
  /// where a whole overlap closes or opens in one step it decides in which step a contact begins or ends.
  TALUS_INLINE typename S::B arc(typename S::B vn, double dt) const {
    const auto lag = vn - along;
    return S::set(0.5 * dt) * ((lag + lag) - stretch);
  }
};

inline constexpr double k_no_prediction = 1e-300;  ///< below it: none [m/s]

/// Contacts that are new, or that part.
template <class S>
TALUS_INLINE auto lacks_prediction(typename S::B q) {
  return S::lt(S::abs(q), S::set(k_no_prediction));
}

/// dashpot_velocity() of a contact with a prediction.
template <class S>
TALUS_INLINE typename S::B steady_velocity(typename S::B vn, const MidNormal<S>& mid, typename S::B q) {
  return mid.along + S::set(0.5) * ((vn - q) + mid.stretch);
}

/// Normal velocity that belongs into the centred dashpot beside the pair's own force: v(n-1/2) + a_ext dt/2, where
/// a_ext is what all other forces do to the relative velocity. The last step has stored q = v + F_n dt/m_eff, the
/// velocity that the pair alone would have now, so a_ext dt = (vn - q) - dt v_t^2/d of that step (the last term: the
/// normal has turned; v_t^2 dt/d = 2 (vn - along) - stretch). In an impact of two free spheres a_ext is 0 to rounding;
/// at rest it is -F_n/m_eff and the force is k delta. The feedback is one step late; what that costs in stability is in
/// core/rules/timestep.cpp. q = 0: a new contact. One that has just touched has no history to miss; one that starts in
/// overlap is taken for a resting one, a_ext = -k delta/m_eff. arc: see MidNormal::arc, or 0.
template <class S>
TALUS_INLINE typename S::B dashpot_velocity(typename S::B vn, const MidNormal<S>& mid, typename S::B q,
                                            typename S::B spring, typename S::B inverse_mass, typename S::B delta,
                                            double dt, typename S::B arc = S::set(0.0)) {
  const auto zero = S::set(0.0);
  auto u = steady_velocity<S>(vn, mid, q);
  const auto fresh = lacks_prediction<S>(q);
  if (S::any(fresh)) {
    const auto touched = S::lt(delta, (zero - vn) * S::set(dt) + arc);
    u = S::select(fresh, S::select(touched, vn, vn - S::set(0.5 * dt) * (spring * inverse_mass)), u);
  }
  return u;
}

/// Tangential displacement rate of the contact point, v_t = v - (v.c) c/|c|^2 - s x c, s = lever (r_i w_i + r_j w_j).
template <class S>
TALUS_INLINE void tangential_velocity(const typename S::B* v, const typename S::B* s, const MidNormal<S>& mid,
                                      typename S::B* t) {
  const auto* c = mid.c;
  const auto q = mid.along + mid.stretch;
  t[0] = (v[0] - q * c[0]) - (s[1] * c[2] - s[2] * c[1]);
  t[1] = (v[1] - q * c[1]) - (s[2] * c[0] - s[0] * c[2]);
  t[2] = (v[2] - q * c[2]) - (s[0] * c[1] - s[1] * c[0]);
}

/// a / sqrt(b)
template <class S>
TALUS_INLINE typename S::B over_root(typename S::B a, typename S::B b) {
  if constexpr (S::fast)
    return a * S::inverse_sqrt(b);
  else
    return a / S::sqrt(b);
}

}  // namespace talus::kernels
