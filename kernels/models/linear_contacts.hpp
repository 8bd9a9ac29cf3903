// The linear law's contacts of a block, stage by stage (linear.hpp says what the law is). Who calls it: linear.hpp.
// Invariants: I4; a contact's bits depend neither on its place nor on its neighbours.
#pragma once

#include "kernels/models/contact_ends.hpp"
#include "kernels/models/coulomb.hpp"

namespace talus::kernels {

struct Linear {
  static constexpr const char* name = "linear";
  static constexpr int history = 3;
  static constexpr bool wants_reff = false;
};

/// Denominators of the centred dashpot and what else depends on the coefficients alone; loop-invariant where the scene
/// has one material pair and damping rates, because divisions and square roots are what bounds this kernel.
template <class S>
struct LinearFactors {
  typename S::B gn, gt, soft, back;                  ///< rates; 1/k_t, and over the denominator of the trial force
  typename S::B grow;                                ///< that denominator
  typename S::B relax, cap;                          ///< rho/m_eff [1/kg]; L/(k_t delta) [-]
  typename S::B spring_n, rate_n, spring_t, rate_t;  ///< stiffnesses and rates over their denominators
  TALUS_INLINE void set(typename S::B kn, typename S::B kt, typename S::B mu, typename S::B damping_n,
                        typename S::B damping_t, const LawArgs& a) {
    const auto one = S::set(1.0), zero = S::set(0.0);
    // Tangential compliance of two rolling spheres is 7/2 of the translational one (I = 2/5 m r^2, lever r).
    const auto grow_n = one + S::set(0.5 * a.dt) * damping_n, grow_t = one + S::set(0.5 * 3.5 * a.dt) * damping_t;
    const auto shrink_n = a.centred != 0 ? one / grow_n : one, shrink_t = a.centred != 0 ? one / grow_t : one;
    gn = damping_n;
    gt = damping_t;
    spring_n = kn * shrink_n;
    rate_n = gn * shrink_n;
    spring_t = kt * shrink_t;
    rate_t = gt * shrink_t;
    // no spring, or no time that it has moved: nothing to store
    soft = a.start != 0 ? zero : S::select(S::gt(kt, zero), one / kt, zero);
    grow = a.centred != 0 ? grow_t : one;
    back = soft * grow;
    relax = (gt * soft) * S::set(1 / a.dt);
    cap = mu * (kn * soft);
  }
};

/// What all contacts of a block share; local copies, which no store can alias.
template <class S, bool Friction, bool Multi>
struct LinearBlock {
  using B = typename S::B;
  static constexpr int k_mass = Friction ? 7 : 3, k_recall = Friction ? Linear::history : 0;
  LawArgs a;
  Block b;
  Coefficients<S, Multi> c;
  LinearFactors<S> shared{};
  bool constant, weighs, series, looks;  ///< looks for contacts that begin or end
  B travel, onward;    ///< how long the tangential spring moves; overlap over speed while early_slip() looks
  B closing, parting;  ///< overlap over speed of contacts that may have begun, or end

  TALUS_INLINE LinearBlock(const Block& block, const LawArgs& args) : a(args), b(block) {
    constant = !Multi && a.by_restitution == 0;
    weighs = a.onset != 0 && a.centred != 0;
    series = weighs && a.start == 0 && a.total == 0 && a.balanced == 0 && (Multi || a.one.gt != 0);
    // nothing to weigh where there is neither dashpot nor friction
    looks = a.recall != 0 || (weighs && (Friction || Multi || a.one.gn != 0));
    travel = S::set(a.start != 0 ? 0.0 : a.dt);
    onward = S::set(series ? -k_early_steps * a.dt : 0.0);
    closing = S::set(!weighs ? 0.0 : series ? -k_early_steps * a.dt : -k_near_steps * a.dt);
    parting = S::set(weighs ? k_near_steps * a.dt : 0.0);
    if constexpr (!Multi) {
      c.load(b, a, 0);
      shared.set(c.kn, c.kt, c.mu, c.gn, c.gt, a);
    }
  }
};

/// Which contacts may begin or end in this step, or have begun a few steps ago, by the speed before it: one branch that
/// waits for no force. One that is missed acts as one that goes on.
template <class S, bool Friction, bool Multi>
TALUS_INLINE typename S::M near_ends(const LinearBlock<S, Friction, Multi>& in, typename S::B delta, typename S::B vn,
                                     typename S::B mass, typename S::B predicted) {
  const auto since = in.closing * vn, until = in.parting * vn;
  const auto reach = S::select(S::lt(since, until), until, since);
  // one that begins has no prediction; nor have two fixed grains, which need none
  const auto fresh = S::set(1e300) * mass;
  return S::lt(delta, in.a.recall != 0 ? S::select(lacks_prediction<S>(predicted), fresh, reach) : reach);
}

/// S::W contacts from k on, stage by stage; every stage is inlined, so that all of it lives in registers. Ends:
/// contacts that have been set aside, else what may begin or end is set aside, and exerts nothing here. Trial: stops
/// before the Coulomb limit and leaves its input (Block::t); with Ends it goes on, and leaves a limit that none
/// exceeds.
template <class S, bool Friction, bool Multi, bool Energy, bool Trial, bool Ends>
struct LinearContacts {
  using B = typename S::B;
  using M = typename S::M;
  using In = LinearBlock<S, Friction, Multi>;
  const LawArgs a;  ///< local copies, as in LinearBlock
  const Block b;
  const int k;
  const bool weighs, series;
  const B one = S::set(1.0), zero = S::set(0.0), half = S::set(0.5), dt = S::set(a.dt), hdt = S::set(0.5 * a.dt);
  Coefficients<S, Multi> c;
  B v[3], n[3], inv, meff, mass, delta, vn, predicted;  ///< mass: its inverse
  M ends;
  LinearFactors<S> f;
  MidNormal<S> mid;
  B spring_force, vd, arc = zero;  ///< vd: velocity that the dashpot sees
  B slid, since, rho;  ///< time that the tangential spring moves; overlap at its middle less the present one
  B fn, next;          ///< normal force, predicted velocity
  ContactEnd<S> end{};
  ImpulseWeights<S> weights{one, one, zero};
  M parts;          ///< of the ledger: ends in this step
  B counted = one;  ///< 0: the last step has counted the contact to its end
  B t[3], h[3], trial[3], g[3], rate, press, creep, limit;

  TALUS_INLINE LinearContacts(const In& in, int first)
      : a(in.a), b(in.b), k(first), weighs(in.weighs), series(in.series), c(in.c) {
    if constexpr (Multi) c.load(b, a, k);
    const B x[3] = {S::load(b.x + k), S::load(b.y + k), S::load(b.z + k)};
    for (int p = 0; p < 3; ++p) v[p] = S::load(b.r[p] + k);
    inv = S::load(b.g[1] + k), meff = S::load(b.g[2] + k), delta = S::load(b.w + k) - S::load(b.g[0] + k);
    mass = S::load(b.r[In::k_mass] + k);
    for (int p = 0; p < 3; ++p) n[p] = x[p] * inv;
    vn = (v[0] * n[0] + v[1] * n[1]) + v[2] * n[2];
    predicted = a.recall != 0 ? S::load(b.h_in[In::k_recall] + k) : zero;
    ends = S::lt(delta, zero);
  }

  TALUS_INLINE void part_from_ends(const In& in, LateContacts*& aside, std::int32_t first) {
    if (!in.looks) return;
    ends = near_ends<S>(in, delta, vn, mass, predicted);
    if (S::any(ends)) [[unlikely]]
      set_aside<Friction, Multi>(aside, b, k, S::bits(ends), a.recall != 0, first);
  }

  /// Normal force of contacts that go on through the whole step.
  TALUS_INLINE void normal(const In& in) {
    f = in.shared;
    if (!in.constant) {
      const B root = a.by_restitution != 0 ? S::sqrt(c.kn * mass) : one;
      f.set(c.kn, c.kt, c.mu, c.gn * root, c.gt, a);  // the tangential rate stays in 1/s
    }
    if (Friction || a.recall != 0) mid.set(v, n, vn, inv, a.dt, a.synchronised);
    spring_force = c.kn * delta;
    vd = vn;
    if (a.recall != 0) {
      if constexpr (Ends) {
        if (weighs) arc = mid.arc(vn, a.dt);
        vd = dashpot_velocity<S>(vn, mid, predicted, spring_force, mass, delta, a.dt, arc);
      } else {
        vd = steady_velocity<S>(vn, mid, predicted);
      }
    }
    slid = in.travel;
    since = hdt * vn;
    rho = meff * f.relax;  // see CoulombLimit
    fn = f.spring_n * delta - f.rate_n * (meff * vd);
    next = vn + dt * (fn * mass);
  }

  /// The part of the step in which contacts that begin or end are there (with Ends).
  TALUS_INLINE void weigh() {
    if (a.recall != 0)
      end.set(delta, vn, S::abs(vn) * dt, dt * next, arc, lacks_prediction<S>(predicted), a.start);
    else
      end.set(delta, vn, S::abs(vn) * dt);
    if constexpr (Friction) {  // first step: all of this began u dt ago
      const auto touch = [&](B& to, B value) { to = S::select(end.enters, value, to); };
      touch(slid, dt * end.u);
      touch(since, zero - half * delta);
      touch(rho, rho * end.inverse);
    }
    const B gn = f.gn * end.q, share = a.recall != 0 ? (half * (end.q * end.q)) * end.inverse : one;
    const B spring = a.recall != 0 ? (half * (end.q * end.q)) * (c.kn * end.way) : spring_force;
    weights.w = weights.m = end.select(share * end.counted, one);
    if (a.recall != 0) {
      weights.m = S::select(end.leaves, end.q * end.counted, weights.m);
      weights.droop = S::select(end.leaves, (half * end.u) * end.counted, zero);
    }
    fn = end.select(((spring - gn * (meff * vd)) / (one + hdt * gn)) * end.counted, fn);
    next = vn + dt * (fn * mass);
  }

  TALUS_INLINE void clip_and_predict() {
    if (a.clip != 0) {
      fn = S::select(S::gt(fn, zero), fn, zero);  // a contact that would pull exerts nothing until it parts
      next = vn + dt * (fn * mass);
    }
    if (a.recall == 0) return;
    if constexpr (Ends)
      if (weighs) next = S::select(end.leaves, zero, next);
    S::store(b.h[In::k_recall] + k, next);
  }

  /// Loss over [n-1, n] by the midpoint rule: v(n-1/2) is the mid-step velocity. The first interval counts from the
  /// instant of touch, the last one to the instant of parting.
  TALUS_INLINE void normal_ledger() {
    const B never = S::set(-1.0), step = S::abs(vn) * dt;
    parts = S::lt(delta, weighs ? never : S::select(S::gt(vn, zero), step, zero));
    B part = one;
    if (!weighs) {
      part = S::select(S::lt(delta, step), S::select(S::lt(vn, zero), delta / step, one + delta / step), one);
    } else if constexpr (Ends) {
      parts = end.leaves;
      counted = end.counted;
      part = S::select(end.enters, end.u, S::select(parts, (one + end.u) * counted, one));
    }
    S::store(b.e[0] + k, half * (c.kn * (delta * delta)));
    B loss = (dt * part) * ((f.gn * meff) * (vn * vn));
    if (a.clip != 0) {  // the spring relaxes against nothing; one that parts before the next step, to the end
      const B last = delta + dt * vn, left = S::select(parts, zero, delta);
      loss = S::select(S::gt(fn, zero), loss, half * (c.kn * (last * last - left * left)));
    }
    S::store(b.e[1] + k, loss);
    S::store(b.e[2] + k, zero);
  }

  /// Lever of the surfaces over the radii.
  TALUS_INLINE B lever() const { return a.contact_lever != 0 ? S::load(b.g[3] + k) : one; }

  /// Tangential spring and force before the Coulomb limit, and the limit.
  TALUS_INLINE void tangential_trial(const In& in) {
    if (b.slid != nullptr) S::store(b.slid + k, slid);
    const B arm = lever();
    const B s[3] = {arm * S::load(b.r[4] + k), arm * S::load(b.r[5] + k), arm * S::load(b.r[6] + k)};
    tangential_velocity<S>(v, s, mid, t);
    for (int p = 0; p < 3; ++p) h[p] = S::load(b.h_in[p] + k);
    const B hn = (h[0] * n[0] + h[1] * n[1]) + h[2] * n[2];
    rate = f.rate_t * meff;
    for (int p = 0; p < 3; ++p) {
      h[p] = trial[p] = (h[p] - hn * n[p]) + t[p] * slid;
      if constexpr (Ends)  // balanced: the spring has taken the dashpot
        if (a.balanced != 0 && a.start == 0) h[p] = S::select(end.enters, h[p] - t[p] * (f.gt * (meff * f.soft)), h[p]);
      g[p] = zero - (f.spring_t * h[p] + rate * t[p]);
    }
    press = spring_force, creep = f.cap * (half * delta + rho * (delta + since));
    if (a.total != 0) {
      press = S::select(S::gt(fn, zero), fn, zero);
      creep = (c.mu * f.soft) * (press * (half + rho));
      weights = {one, one, zero};
    }
    limit = c.mu * press;
    if (Ends && series) {  // the first steps of a contact
      const auto early = S::lt(delta, S::select(S::lt(vn, zero), in.onward * vn, zero));
      const B before = S::select(end.enters, zero, limit + (c.mu * c.kn) * (dt * vn));
      early_slip<S>(f, meff, early, slid, limit, before, t, c.kt, h, g);
    }
  }

  /// For scatter_limited(): forces before the limit, and what sets it.
  TALUS_INLINE void leave_trial(B most, B creeps, B relaxes) const {
    for (int p = 0; p < 3; ++p) {
      S::store(b.r[p] + k, g[p]);
      S::store(b.r[4 + p] + k, n[p]);
    }
    S::store(b.r[3] + k, c.kn);
    S::store(b.r[7] + k, fn);
    S::store(b.t[0] + k, most);
    S::store(b.t[1] + k, creeps);
    S::store(b.t[2] + k, relaxes);
  }

  TALUS_INLINE void leave_steady_trial() {
    if (S::any(ends)) [[unlikely]] {
      for (B& force : g) force = S::select(ends, zero, force);
      fn = S::select(ends, zero, fn);
      c.kn = S::select(ends, zero, c.kn);
    }
    for (int p = 0; p < 3; ++p) S::store(b.h[p] + k, h[p]);
    leave_trial(limit, creep, rho);
  }

  /// Coulomb's limit of spring and force.
  TALUS_INLINE void slide() {
    CoulombLimit<S> coulomb;
    coulomb.set(g, limit, creep, rho, f.back);
    if constexpr (Ends) coulomb.weigh(limit, weights);
    for (int p = 0; p < 3; ++p) {
      const B left = a.balanced == 0 ? coulomb.spring * h[p] - coulomb.pull * g[p]
                                     : zero - (g[p] * coulomb.plain + rate * t[p]) * f.back;
      h[p] = S::select(coulomb.slides, left, h[p]);
      g[p] = g[p] * coulomb.scale;
      S::store(b.h[p] + k, h[p]);
    }
  }

  /// T / r = -lever n x F_t, the same for both partners.
  TALUS_INLINE void leave_torque() const {
    const B arm = lever();
    S::store(b.r[4] + k, arm * (n[2] * g[1] - n[1] * g[2]));
    S::store(b.r[5] + k, arm * (n[0] * g[2] - n[2] * g[0]));
    S::store(b.r[6] + k, arm * (n[1] * g[0] - n[0] * g[1]));
    S::store(b.r[7] + k, Ends ? press * weights.w : press);
  }
};

template <class S, bool Friction, bool Multi, bool Energy, bool Trial, bool Ends>
TALUS_INLINE void linear_contacts(const LinearBlock<S, Friction, Multi>& in, int k, LateContacts*& aside,
                                  std::int32_t first) {
  using B = typename S::B;
  LinearContacts<S, Friction, Multi, Energy, Trial, Ends> of(in, k);
  if constexpr (!Ends) of.part_from_ends(in, aside, first);
  of.normal(in);
  if constexpr (Ends)
    if (in.weighs) of.weigh();
  of.clip_and_predict();
  if constexpr (Energy) of.normal_ledger();
  B force[3] = {of.fn * of.n[0], of.fn * of.n[1], of.fn * of.n[2]};
  if constexpr (Friction) {
    of.tangential_trial(in);
    if constexpr (Trial && !Ends) return of.leave_steady_trial();
    of.slide();
    if constexpr (Trial) return of.leave_trial(S::set(1e150), S::set(0.0), S::set(0.0));
    for (int p = 0; p < 3; ++p) force[p] = force[p] + of.g[p];
    if constexpr (Energy)
      tangential_ledger<S>(of.b, k, {of.c.kt, of.c.kt, of.f.gt * of.meff, of.slid, of.parts, of.counted},
                           of.a.balanced != 0, of.h, of.trial, of.t);
    of.leave_torque();
  }
  for (int p = 0; p < 3; ++p) S::store(of.b.r[p] + k, force[p]);
  S::store(of.b.r[3] + k, of.c.kn);
}

}  // namespace talus::kernels
