// Rolling and twisting resistance on top of any law, which has left its force and stiffness k_n: adds a moment M on i,
// -M on j. Called by scheduler/nodes/add_ons.cpp. With w = w_i - w_j, N the force that presses the surfaces together as
// Coulomb's limit counts it (the elastic part; JKR: plus 3 pi w_a R*), R* the reduced radius (a wall: r):
//   constant directional torque ("cdt"):  M = -mu_r R* N w_r/|w_r|,  w_r = w - (w.n) n, but no more than stops the
//     spin of the free pair within the step: the sign of a rounding error must not steer the full moment
//   elastic-plastic spring-dashpot ("epsd", Ai et al. 2011, model C):  dM = -k_r w_r dt,  k_r = 9/4 k_n mu_r^2 R*^2,
//     |M| <= mu_r R* N;  below that limit the dashpot -2 eta_r sqrt(I_r k_r) w_r acts as well, at the limit it does
//     not; 1/I_r = 1/(7/5 m_i r_i^2) + 1/(7/5 m_j r_j^2)
//   twisting:  the same spring, slider and dashpot about the normal:  dM = -k_t (w.n) dt,  k_t = 9/4 k_n mu_t^2 R*^2,
//     |M| <= mu_t R* N, dashpot -2 eta_t sqrt(I_t k_t) (w.n),  1/I_t = 1/(2/5 m_i r_i^2) + 1/(2/5 m_j r_j^2)
// k_n: of the spring, or the tangent stiffness 2 E* a of Hertz. Stored moments shrink with it and do not grow with it
// (no closed loop yields energy); increments come at its mean over the step while it grows (second order). Springs turn
// and dashpots act from the instant of touch on (Block::slid).
// History: rolling moment [N m] (3 columns, oriented i - j; epsd), twisting moment about the own normal (1 column, the
// same for both orientations), last stiffness (1 column; rescale), in this order.
#pragma once

#include "kernels/models/linear.hpp"

namespace talus::kernels {

/// a b in a rounding of its own. Where the compiler contracts, a b - c d is not odd in the exchange of both products,
/// and a pair whose grains belong to two chunks is computed from either side.
template <class S>
TALUS_INLINE double product(double a, double b) {
  double c = a * b;
  if constexpr (requires { S::contracts; }) asm("" : "+x"(c));
  return c;
}

/// Relative spins; divisions per contact, so the loop is scalar: the same on every instruction set.
template <class S>
void spin(const SpinArgs& a) {
  for (int k = 0; k < a.n; ++k) {
    const double *vi = a.v + 8L * a.i[k], *vj = a.v + 8L * a.j[k];
    const double ri = 1 / a.p[4L * a.i[k] + 3], rj = 1 / a.p[4L * a.j[k] + 3];
    for (int q = 0; q < 3; ++q) a.s[q][k] = product<S>(vi[4 + q], ri) - product<S>(vj[4 + q], rj);
    a.s[3][k] = (5.0 / 7.0) * (product<S>(vi[7], ri * ri) + product<S>(vj[7], rj * rj));
  }
  for (int k = a.n; k < (a.n + 7) / 8 * 8; ++k) {  // padding lanes: finite
    for (int q = 0; q < 3; ++q) a.s[q][k] = 0;
    a.s[3][k] = 1;
  }
}

/// Coefficients of W contacts.
template <class S>
struct MomentCoefficients {
  typename S::B rolling, viscous, twisting, torsion;
  TALUS_INLINE void load(const MomentBlock& b, const MomentArgs& a, int k) {
    if (a.table == nullptr) {
      rolling = S::set(a.one.rolling);
      viscous = S::set(a.one.viscous);
      twisting = S::set(a.one.twisting);
      torsion = S::set(a.one.torsion);
      return;
    }
    double t[4][S::W];
    for (int q = 0; q < S::W; ++q) {
      const AddOnParameters& p = a.table[b.pair[k + q]];
      t[0][q] = p.rolling;
      t[1][q] = p.viscous;
      t[2][q] = p.twisting;
      t[3][q] = p.torsion;
    }
    rolling = S::load(t[0]);
    viscous = S::load(t[1]);
    twisting = S::load(t[2]);
    torsion = S::load(t[3]);
  }
};

/// S::W contacts from k on: what both resistances share, and what they add. All of it lives in registers: every
/// function is inlined.
template <class S>
struct Moments {
  using B = typename S::B;
  const MomentArgs& a;
  MomentBlock& b;
  const int k;
  const B one = S::set(1.0), zero = S::set(0.0), half = S::set(0.5), dt = S::set(a.dt);
  MomentCoefficients<S> c;
  B n[3], roll[3], turn, roll2;  ///< normal; relative spin across it and along it, over radii [1/s]
  B arm, turned;                 ///< lever times force [N m]; how long the springs have turned with the grains [s]
  B shrink = one, kept = one;    ///< of the stored moments, and of their energy
  B spring_unit, moving_unit;    ///< stiffness of a spring over mu^2; the same on average while it turned
  B onset = one;                 ///< weight of the dashpots, see the laws
  B m[3] = {zero, zero, zero}, elastic = zero, damped = zero, rubbed = zero;

  TALUS_INLINE Moments(MomentBlock& block, const MomentArgs& args, int first, int last_column)
      : a(args), b(block), k(first) {
    c.load(b, a, k);
    const B x[3] = {S::load(b.x + k), S::load(b.y + k), S::load(b.z + k)};
    const B inv = one / S::sqrt((x[0] * x[0] + x[1] * x[1]) + x[2] * x[2]);
    for (int q = 0; q < 3; ++q) n[q] = x[q] * inv;
    const B s[3] = {S::load(b.s[0] + k), S::load(b.s[1] + k), S::load(b.s[2] + k)};
    turn = (s[0] * n[0] + s[1] * n[1]) + s[2] * n[2];
    for (int q = 0; q < 3; ++q) roll[q] = s[q] - turn * n[q];
    const B reff = S::load(b.reff + k), stiffness = S::load(b.r[3] + k);
    arm = reff * S::load(b.r[7] + k);
    roll2 = (roll[0] * roll[0] + roll[1] * roll[1]) + roll[2] * roll[2];
    turned = S::load(b.slid + k);
    B reach = stiffness;  // while the springs turned
    if (a.rescale != 0) {
      // it has grown as the root of the time since touch: 2/3 of it on average
      const B last = S::load(b.h[last_column] + k), mean = half * (stiffness + last);
      shrink = S::select(S::lt(stiffness, last), stiffness / last, one);
      reach = S::select(S::gt(last, zero), S::select(S::lt(mean, stiffness), mean, stiffness),
                        S::set(2.0 / 3.0) * stiffness);
      kept = S::select(S::gt(last, zero), S::select(S::lt(stiffness, last), shrink, last / reach), one);
      S::store(b.h[last_column] + k, stiffness);
    }
    spring_unit = (S::set(2.25) * stiffness) * (reff * reff);  // times mu^2
    moving_unit = (S::set(2.25) * reach) * (reff * reff);
    const auto touched = S::lt(turned, S::select(S::gt(turned, zero), dt, zero));
    if (a.centred != 0 && S::any(touched)) {
      const B u = turned / dt, q = half + u;
      onset = S::select(touched, a.rescale != 0 ? S::set(0.8) * (q * S::sqrt(S::sqrt(q / u))) : q, one);
    }
  }

  /// A torque against the rolling, but no more than stops it.
  TALUS_INLINE void directional() {
    const B speed = S::sqrt(roll2), full = c.rolling * arm;
    const B stop = speed / (dt * (S::set(3.5) * S::load(b.s[3] + k)));
    const B limit = S::select(S::lt(stop, full), stop, full);
    const B scale = S::select(S::gt(speed, zero), limit / speed, zero);
    for (int q = 0; q < 3; ++q) m[q] = zero - scale * roll[q];
    rubbed = dt * (limit * speed);
  }

  /// Coefficient of the dashpot in a centred step.
  TALUS_INLINE B damping(B rate, B compliance) const {
    const B damp = rate * onset;
    return a.centred != 0 ? damp / (one + (half * dt) * (damp * compliance)) : damp;
  }

  TALUS_INLINE void rolling_spring() {
    const B square = c.rolling * c.rolling, kr = spring_unit * square, limit = c.rolling * arm;
    const B moving = moving_unit * square;
    const B before[3] = {S::load(b.h[0] + k), S::load(b.h[1] + k), S::load(b.h[2] + k)};
    const B along = (before[0] * n[0] + before[1] * n[1]) + before[2] * n[2];
    B h[3], old[3], trial[3];
    for (int q = 0; q < 3; ++q) {
      old[q] = (before[q] - along * n[q]) * shrink;
      h[q] = trial[q] = old[q] - moving * (roll[q] * turned);
    }
    const B h2 = (h[0] * h[0] + h[1] * h[1]) + h[2] * h[2];
    const auto slides = S::gt(h2, limit * limit);
    const B inertia = one / S::load(b.s[3] + k);
    const B rate = (c.viscous + c.viscous) * S::sqrt(inertia * kr);
    const B scale = S::select(slides, limit / S::sqrt(h2), one);
    const B damp = S::select(slides, zero, damping(rate, S::load(b.s[3] + k)));
    for (int q = 0; q < 3; ++q) {
      h[q] = h[q] * scale;
      m[q] = h[q] - damp * roll[q];
      S::store(b.h[q] + k, h[q]);
    }
    if (b.e == nullptr) return;
    // as the tangential spring: the slider turns by (trial - h) / k_r against the mean of the moments before and
    // after; a pair without rolling friction (k_r = 0) has nothing to store
    const B soft = S::select(S::gt(kr, zero), one / kr, zero);
    const B give = S::select(S::gt(kr, zero), one / moving, zero);
    const B m2 = (h[0] * h[0] + h[1] * h[1]) + h[2] * h[2], o2 = (old[0] * old[0] + old[1] * old[1]) + old[2] * old[2];
    B slip = zero;
    for (int q = 0; q < 3; ++q) slip = slip + (half * (old[q] + h[q])) * (trial[q] - h[q]);
    elastic = half * (m2 * soft);
    damped = S::select(slides, zero, turned * (rate * roll2));
    // M^2 / (2 k) falls when k shrinks (M with it) and when k grows (M stays); neither partner gets that energy
    rubbed = slip * give + (half * ((o2 / kept) * give) * (one - kept) + half * (m2 * (give - soft)));
  }

  TALUS_INLINE void twisting_spring(int column) {
    const B square = c.twisting * c.twisting, kt = spring_unit * square, limit = c.twisting * arm;
    const B moving = moving_unit * square;
    const B old = S::load(b.h[column] + k) * shrink, trial = old - moving * (turn * turned);
    B h = S::select(S::gt(trial, limit), limit, trial);
    h = S::select(S::lt(h, zero - limit), zero - limit, h);
    S::store(b.h[column] + k, h);
    const auto slides = S::gt(S::abs(trial), limit);
    const B compliance = S::set(3.5) * S::load(b.s[3] + k);
    const B rate = (c.torsion + c.torsion) * S::sqrt(kt / compliance);
    const B total = h - S::select(slides, zero, damping(rate, compliance)) * turn;
    for (int q = 0; q < 3; ++q) m[q] = m[q] + total * n[q];
    if (b.e == nullptr) return;
    const B soft = S::select(S::gt(kt, zero), one / kt, zero);
    const B give = S::select(S::gt(kt, zero), one / moving, zero);
    elastic = elastic + half * ((h * h) * soft);
    damped = damped + S::select(slides, zero, turned * (rate * (turn * turn)));
    rubbed = rubbed + ((half * (old + h)) * ((trial - h) * give) +
                       (half * (((old * old) / kept) * give) * (one - kept) + half * ((h * h) * (give - soft))));
  }

  TALUS_INLINE void store() const {
    for (int q = 0; q < 3; ++q) S::store(b.s[q] + k, m[q]);
    S::store(b.s[3] + k, zero);
    if (b.e == nullptr) return;
    S::store(b.e[0] + k, S::load(b.e[0] + k) + elastic);
    S::store(b.e[1] + k, S::load(b.e[1] + k) + damped);
    S::store(b.e[2] + k, S::load(b.e[2] + k) + rubbed);
  }
};

template <class S>
void moments(MomentBlock& b, const MomentArgs& args) {
  const MomentArgs a = args;
  const bool epsd = a.rolling == 2;
  const int twist_column = epsd ? 3 : 0, last_column = twist_column + a.twisting;
  for (int k = 0; k < b.n; k += S::W) {
    Moments<S> of(b, a, k, last_column);
    if (a.rolling == 1) of.directional();
    if (epsd) of.rolling_spring();
    if (a.twisting != 0) of.twisting_spring(twist_column);
    of.store();
  }
}

}  // namespace talus::kernels
