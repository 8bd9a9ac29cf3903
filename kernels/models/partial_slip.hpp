// Partial slip of a Hertz contact (Cattaneo, Mindlin & Deresiewicz) in two rings of the contact area; an addition to
// the tangential force of hertz_mindlin.hpp.
// In the one-dimensional picture of the contact (dimensionality reduction: Jaeger; Popov & Hess) springs of stiffness
// 8 G* dx stand at all x in (0, a). Each begins to store tangential force when the growing contact reaches it, slides
// by itself where its force exceeds mu 2 E* (delta - x^2/R*), and parts when the contact shrinks below x. That is exact
// for Mindlin's theory; here the force per length is held as q(x) = A + B x^2, which is exact too while the contact
// grows at a constant ratio of slip to approach without micro-slip:
//   growth:  A and B by least squares on the larger interval; the force and its second moment are kept
//   shrink:  cut off at the new radius
//   slip:    at the two Gauss points s = x/a of the interval, the rings; each has the share of the stiffness, of the
//            dashpot and of Coulomb's limit that belongs to its point, and slides as a contact of its own (linear.hpp)
// Least squares, cutting off and sliding each take energy: no closed loop yields any. With both rings sliding the force
// is mu F_n. Spins after an impact are within 7 % of the exact theory.
// State of a contact: F = sum of the rings' forces, and D = 5 sum P2(s) force, the second Legendre coefficient of the
// force per length times a; energy (F^2 + D^2/5)/(2 S_t).
#pragma once

#include "kernels/models/linear.hpp"

namespace talus::kernels {

/// Gauss points of even polynomials on (0, 1): s^2, weight, P2(s), share of Coulomb's limit 3/2 weight (1 - s^2).
struct Rings {
  static constexpr int count = 2;
  static constexpr double weight[2] = {0.6521451548625461, 0.3478548451374538};
  static constexpr double p2[2] = {-0.3266193350044280, 0.6123336207187139};
  static constexpr double limit[2] = {0.8651483716701107, 0.1348516283298893};
};

/// One step of W contacts: radii [m], dashpot [kg/s], its compliance dt/2 7/2 / m_eff [s/kg] (0: not
/// centred), Coulomb's limit now and in the middle of the step [N].
template <class S>
struct RingStep {
  typename S::B radius, last;
  typename S::B travelled;  ///< spring force per tangential velocity [kg/s]
  typename S::B ct, half_kick;
  typename S::B limit, middle;
};

/// What the ledger needs of it [N]: forces of the rings before they moved, and the first and second Legendre part.
template <class S>
struct RingForces {
  typename S::B old[Rings::count][3], now[Rings::count][3], share[Rings::count];
};

/// Old state on the present radius. On shrinking the stored force is cut off, on growth spread: in the basis 1, P2
///   shrink, x = a/a_last < 1:  F = x (F - D/2) + x^3 D/2,  D = x^3 D
///   growth, x = a_last/a:      F = F,  D = x^2 D - 5/2 (1 - x^2) F
/// The increment of this step comes while the radius grows: share, the stiffness of a ring over its weight; 3/5 of the
/// second moment of an even one where the contact has just begun (a^2 grows linearly).
template <class S>
TALUS_INLINE void ring_history(const RingStep<S>& q, const typename S::B* f, const typename S::B* d,
                               RingForces<S>& out) {
  using B = typename S::B;
  const B one = S::set(1.0), zero = S::set(0.0), half = S::set(0.5), slope = S::set(2.5);
  const auto shrinks = S::lt(q.radius, q.last);
  const B x = S::select(shrinks, q.radius / q.last, q.last / q.radius), x2 = x * x, x3 = x * x2;
  const B ff = S::select(shrinks, x, one), fd = S::select(shrinks, half * (x3 - x), zero);
  const B df = S::select(shrinks, zero, slope * (x2 - one)), dd = S::select(shrinks, x3, x2);
  const B moment = (S::set(0.6) - S::set(0.2) * x) + S::set(0.6) * x2;
  const B tilt = S::select(shrinks, zero, slope * (one - moment));
  for (int r = 0; r < Rings::count; ++r) {
    const B p2 = S::set(Rings::p2[r]), weight = S::set(Rings::weight[r]);
    out.share[r] = weight * (one - tilt * p2);
    const B of_f = weight * (ff + p2 * df), of_d = weight * (fd + p2 * dd);
    for (int c = 0; c < 3; ++c) out.old[r][c] = of_f * f[c] + of_d * d[c];
  }
}

/// Trial forces of the rings, g = old - travelled share t - weight ct u, with u the tangential velocity at the end of
/// the step: t plus half a kick of the whole force, in which a sliding ring has its limit.
template <class S>
struct RingTrial {
  typename S::B g[Rings::count][3], size[Rings::count];
  typename S::M slides[Rings::count];

  TALUS_INLINE void at(const RingStep<S>& q, const RingForces<S>& f, const typename S::B* t, const typename S::B* u) {
    for (int r = 0; r < Rings::count; ++r) {
      const auto weight = S::set(Rings::weight[r]);
      for (int c = 0; c < 3; ++c) g[r][c] = (f.old[r][c] - (q.travelled * f.share[r]) * t[c]) - (weight * q.ct) * u[c];
      measure(q, r);
    }
  }
  /// Weights of the rings that do not slide.
  TALUS_INLINE typename S::B stuck() const {
    const auto zero = S::set(0.0);
    return S::select(slides[0], zero, S::set(Rings::weight[0])) + S::select(slides[1], zero, S::set(Rings::weight[1]));
  }
  TALUS_INLINE void measure(const RingStep<S>& q, int r) {
    size[r] = S::sqrt((g[r][0] * g[r][0] + g[r][1] * g[r][1]) + g[r][2] * g[r][2]);
    slides[r] = S::gt(size[r], q.limit * S::set(Rings::limit[r]));
  }
};

/// Velocity at the end of a step in which nothing slides.
template <class S>
TALUS_INLINE void ring_velocity(const RingStep<S>& q, const RingForces<S>& f, const typename S::B* t,
                                typename S::B* u) {
  const auto grow = S::set(1.0) / (S::set(1.0) + q.half_kick * q.ct);
  for (int c = 0; c < 3; ++c) u[c] = (t[c] + q.half_kick * ((f.old[0][c] + f.old[1][c]) - q.travelled * t[c])) * grow;
}

/// The same where rings slide: their forces are the limit along their trial forces, and their dashpots do not act.
template <class S>
TALUS_INLINE void ring_velocity(const RingStep<S>& q, const RingForces<S>& f, const RingTrial<S>& trial,
                                const typename S::B* t, typename S::B* u) {
  using B = typename S::B;
  const B one = S::set(1.0), zero = S::set(0.0);
  B sum[3] = {zero, zero, zero};
  for (int r = 0; r < Rings::count; ++r) {
    const B scale = (q.limit * S::set(Rings::limit[r])) / trial.size[r];
    for (int c = 0; c < 3; ++c)
      sum[c] =
          sum[c] + S::select(trial.slides[r], scale * trial.g[r][c], f.old[r][c] - (q.travelled * f.share[r]) * t[c]);
  }
  const B shrink = one / (one + q.half_kick * (trial.stuck() * q.ct));
  for (int c = 0; c < 3; ++c) u[c] = (t[c] + q.half_kick * sum[c]) * shrink;
}

/// The spring of a sliding ring: creep of the linear law (linear.hpp) with the ring's share of everything.
template <class S>
TALUS_INLINE void ring_slides(const RingStep<S>& q, int r, RingForces<S>& f, RingTrial<S>& trial) {
  using B = typename S::B;
  const B half = S::set(0.5), share = S::set(Rings::limit[r]), limit = q.limit * share, middle = q.middle * share;
  const B ct = q.ct * S::set(Rings::weight[r]), travelled = q.travelled * f.share[r];
  const B whole = ct * (ct + travelled) + half * (travelled * travelled), all = S::set(1.0) / (trial.size[r] * whole);
  const B keep = (ct * ct) * (all * trial.size[r]), scale = limit * (all * whole);
  const B pull = (travelled * all) * (ct * middle + half * (travelled * limit));
  for (int c = 0; c < 3; ++c) {
    f.now[r][c] = S::select(trial.slides[r], keep * f.old[r][c] + pull * trial.g[r][c], f.now[r][c]);
    trial.g[r][c] = S::select(trial.slides[r], scale * trial.g[r][c], trial.g[r][c]);
  }
}

/// Moves the springs of the rings by the tangential velocity t and limits them; g: tangential force on i [N]. f, d:
/// state before, normal parts taken off, and after.
template <class S>
TALUS_INLINE void partial_slip(const RingStep<S>& q, const typename S::B* t, typename S::B* f, typename S::B* d,
                               typename S::B* g, RingForces<S>& forces) {
  using B = typename S::B;
  ring_history<S>(q, f, d, forces);
  B u[3];
  ring_velocity<S>(q, forces, t, u);
  RingTrial<S> trial;
  trial.at(q, forces, t, u);
  for (int r = 0; r < Rings::count; ++r)
    for (int c = 0; c < 3; ++c) forces.now[r][c] = forces.old[r][c] - (q.travelled * forces.share[r]) * t[c];
  if (S::any(trial.slides[0]) || S::any(trial.slides[1])) {
    // A stuck ring beside a sliding one feels another velocity, which may make it slide too. Contacts without a sliding
    // ring keep their bits: which ones share a vector depends on the instruction set.
    ring_velocity<S>(q, forces, trial, t, u);
    RingTrial<S> again;
    again.at(q, forces, t, u);
    const auto still = S::gt(trial.stuck(), S::set(0.99));
    for (int r = 0; r < Rings::count; ++r) {
      for (int c = 0; c < 3; ++c)
        trial.g[r][c] = S::select(trial.slides[r], trial.g[r][c], S::select(still, trial.g[r][c], again.g[r][c]));
      trial.measure(q, r);
      ring_slides<S>(q, r, forces, trial);
    }
  }
  for (int c = 0; c < 3; ++c) {
    g[c] = trial.g[0][c] + trial.g[1][c];
    f[c] = forces.now[0][c] + forces.now[1][c];
    d[c] = S::set(5 * Rings::p2[0]) * forces.now[0][c] + S::set(5 * Rings::p2[1]) * forces.now[1][c];
  }
}

/// Energy of a state over 1/(2 * 8 G*) [N2/m].
template <class S>
TALUS_INLINE typename S::B ring_energy(const typename S::B* f, const typename S::B* d, typename S::B radius) {
  const auto f2 = (f[0] * f[0] + f[1] * f[1]) + f[2] * f[2], d2 = (d[0] * d[0] + d[1] * d[1]) + d[2] * d[2];
  const auto zero = S::set(0.0);
  return S::select(S::gt(radius, zero), (f2 + S::set(0.2) * d2) / radius, zero);
}

/// Ledger of a step, by the midpoint rule: what the springs have moved heats the dashpots; friction has taken what is
/// left of the work, and what the state of before has lost to the change of radius. `parts`, `counted`: see
/// TangentialStep. before: energy [J] of the last step; slid: how long the springs have moved [s].
template <class S>
TALUS_INLINE void ring_ledger(const Block& b, int k, const RingStep<S>& q, const RingForces<S>& forces,
                              const typename S::B* t, typename S::B slid, typename S::B before, typename S::B now,
                              typename S::M parts, typename S::B counted, typename S::B mid) {
  using B = typename S::B;
  const B zero = S::set(0.0), one = S::set(1.0), half = S::set(0.5);
  const auto moves = S::gt(q.travelled, zero);
  const B soft = S::select(moves, slid / q.travelled, zero), inverse = S::select(S::gt(slid, zero), one / slid, zero);
  B heat = zero, work = zero;
  for (int r = 0; r < Rings::count; ++r) {
    const B give = soft / forces.share[r], rate = (mid * q.ct) * (S::set(Rings::weight[r]) * inverse);
    for (int c = 0; c < 3; ++c) {
      const B way = slid * t[c], moved = (forces.old[r][c] - forces.now[r][c]) * give;
      heat = heat + rate * (moved * moved);
      work = work + (rate * moved - half * (forces.old[r][c] + forces.now[r][c])) * way;
    }
  }
  const B freed = S::select(parts, now, zero);
  S::store(b.e[0] + k, S::load(b.e[0] + k) + (now - freed));
  S::store(b.e[1] + k, S::load(b.e[1] + k) + (heat + freed * counted));
  S::store(b.e[2] + k, ((work - heat) - now) + before);
}

}  // namespace talus::kernels
