// Linear spring-dashpot with Coulomb friction and tangential history (Cundall & Strack; LAMMPS gran/hooke/history).
//   F_n = k_n delta - gamma_n m_eff v_n,   F_t = -(k_t xi + gamma_t m_eff v_t),   |F_t| <= L = mu k_n delta
// What the dashpot sees, what the first and last step of a contact count, and how the spring creeps while the contact
// slides is derived in LINEAR.md.
// History: with friction 3 columns, the tangential spring xi [m], oriented i - j; centred and with ends or damped:
// one more, the predicted velocity [m/s].
// Reads kn, kt [N/m], gn, gt [1/s] (or 2 beta [-] with by_restitution), mu.
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

/// Forces of S::W contacts from k on. Ends: of those that have been set aside, else what may begin or end is set aside,
/// and exerts nothing here. Trial: stops before the Coulomb limit and leaves its input (Block::t); with Ends it goes
/// on, and leaves a limit that none exceeds.
template <class S, bool Friction, bool Multi, bool Energy, bool Trial, bool Ends>
TALUS_INLINE void linear_contacts(const LinearBlock<S, Friction, Multi>& in, int k, LateContacts*& aside,
                                  std::int32_t first) {
  using B = typename S::B;
  using In = LinearBlock<S, Friction, Multi>;
  const LawArgs a = in.a;
  const Block b = in.b;
  const B one = S::set(1.0), zero = S::set(0.0), half = S::set(0.5), dt = S::set(a.dt), hdt = S::set(0.5 * a.dt);
  Coefficients<S, Multi> c = in.c;
  if constexpr (Multi) c.load(b, a, k);
  const B x[3] = {S::load(b.x + k), S::load(b.y + k), S::load(b.z + k)};
  const B v[3] = {S::load(b.r[0] + k), S::load(b.r[1] + k), S::load(b.r[2] + k)};
  const B inv = S::load(b.g[1] + k), meff = S::load(b.g[2] + k), delta = S::load(b.w + k) - S::load(b.g[0] + k);
  const B mass = S::load(b.r[In::k_mass] + k);  // its inverse
  const B n[3] = {x[0] * inv, x[1] * inv, x[2] * inv};
  const B vn = (v[0] * n[0] + v[1] * n[1]) + v[2] * n[2];
  const B predicted = a.recall != 0 ? S::load(b.h_in[In::k_recall] + k) : zero;
  [[maybe_unused]] auto ends = S::lt(delta, zero);
  if constexpr (!Ends) {
    if (in.looks) {
      ends = near_ends<S>(in, delta, vn, mass, predicted);
      if (S::any(ends)) [[unlikely]]
        set_aside<Friction, Multi>(aside, b, k, S::bits(ends), a.recall != 0, first);
    }
  }
  LinearFactors<S> f = in.shared;
  if (!in.constant) {
    const B root = a.by_restitution != 0 ? S::sqrt(c.kn * mass) : one;
    f.set(c.kn, c.kt, c.mu, c.gn * root, c.gt, a);  // the tangential rate stays in 1/s
  }
  MidNormal<S> mid;
  if (Friction || a.recall != 0) mid.set(v, n, vn, inv, a.dt, a.synchronised);
  const B spring_force = c.kn * delta;
  B vd = vn, arc = zero;  // vd: velocity that the dashpot sees
  if (a.recall != 0) {
    if constexpr (Ends) {
      if (in.weighs) arc = mid.arc(vn, a.dt);
      vd = dashpot_velocity<S>(vn, mid, predicted, spring_force, mass, delta, a.dt, arc);
    } else {
      vd = steady_velocity<S>(vn, mid, predicted);
    }
  }
  B slid = in.travel;      // how long the tangential spring has moved with the spheres
  B since = hdt * vn;      // overlap at the middle of that time less the present one
  B rho = meff * f.relax;  // see CoulombLimit
  B fn = f.spring_n * delta - f.rate_n * (meff * vd), next = vn + dt * (fn * mass);
  [[maybe_unused]] ContactEnd<S> end{};
  [[maybe_unused]] ImpulseWeights<S> weights{one, one, zero};
  if (Ends && in.weighs) {
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
  if (a.clip != 0) {
    fn = S::select(S::gt(fn, zero), fn, zero);  // a contact that would pull exerts nothing until it parts
    next = vn + dt * (fn * mass);
  }
  if (a.recall != 0) {
    if constexpr (Ends)
      if (in.weighs) next = S::select(end.leaves, zero, next);
    S::store(b.h[In::k_recall] + k, next);
  }
  B force_i[3] = {fn * n[0], fn * n[1], fn * n[2]};
  const B never = S::set(-1.0), step = S::abs(vn) * dt;
  auto parts = S::lt(delta, in.weighs ? never : S::select(S::gt(vn, zero), step, zero));
  B counted = one;  // 0: the last step has counted the contact to its end
  if constexpr (Energy) {
    // Loss over [n-1, n] by the midpoint rule: v(n-1/2) is the mid-step velocity. The first interval counts from the
    // instant of touch, the last one to the instant of parting.
    B part = one;
    if (!in.weighs) {
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
  if constexpr (Friction) {
    if (b.slid != nullptr) S::store(b.slid + k, slid);
    const B lever = a.contact_lever != 0 ? S::load(b.g[3] + k) : one;
    const B s[3] = {lever * S::load(b.r[4] + k), lever * S::load(b.r[5] + k), lever * S::load(b.r[6] + k)};
    B t[3];
    tangential_velocity<S>(v, s, mid, t);
    B h[3] = {S::load(b.h_in[0] + k), S::load(b.h_in[1] + k), S::load(b.h_in[2] + k)};
    const B hn = (h[0] * n[0] + h[1] * n[1]) + h[2] * n[2];
    const B rate = f.rate_t * meff;
    B g[3], trial[3];
    for (int p = 0; p < 3; ++p) {
      h[p] = trial[p] = (h[p] - hn * n[p]) + t[p] * slid;
      if constexpr (Ends)  // balanced: the spring has taken the dashpot
        if (a.balanced != 0 && a.start == 0) h[p] = S::select(end.enters, h[p] - t[p] * (f.gt * (meff * f.soft)), h[p]);
      g[p] = zero - (f.spring_t * h[p] + rate * t[p]);
    }
    B press = spring_force, creep = f.cap * (half * delta + rho * (delta + since));
    if (a.total != 0) {
      press = S::select(S::gt(fn, zero), fn, zero);
      creep = (c.mu * f.soft) * (press * (half + rho));
      weights = {one, one, zero};
    }
    const B limit = c.mu * press;
    if (Ends && in.series) {  // the first steps of a contact
      const auto early = S::lt(delta, S::select(S::lt(vn, zero), in.onward * vn, zero));
      const B before = S::select(end.enters, zero, limit + (c.mu * c.kn) * (dt * vn));
      early_slip<S>(f, meff, early, slid, limit, before, t, c.kt, h, g);
    }
    if constexpr (Trial && !Ends) {
      if (S::any(ends)) [[unlikely]] {
        for (B& force : g) force = S::select(ends, zero, force);
        fn = S::select(ends, zero, fn);
        c.kn = S::select(ends, zero, c.kn);
      }
      for (int p = 0; p < 3; ++p) {
        S::store(b.h[p] + k, h[p]);
        S::store(b.r[p] + k, g[p]);
        S::store(b.r[4 + p] + k, n[p]);
      }
      S::store(b.r[3] + k, c.kn);
      S::store(b.r[7] + k, fn);
      S::store(b.t[0] + k, limit);
      S::store(b.t[1] + k, creep);
      S::store(b.t[2] + k, rho);
      return;
    }
    CoulombLimit<S> coulomb;
    coulomb.set(g, limit, creep, rho, f.back);
    if constexpr (Ends) coulomb.weigh(limit, weights);
    for (int p = 0; p < 3; ++p) {
      const B left = a.balanced == 0 ? coulomb.spring * h[p] - coulomb.pull * g[p]
                                     : zero - (g[p] * coulomb.plain + rate * t[p]) * f.back;
      h[p] = S::select(coulomb.slides, left, h[p]);
      g[p] = g[p] * coulomb.scale;
    }
    for (int p = 0; p < 3; ++p) {
      S::store(b.h[p] + k, h[p]);
      force_i[p] = force_i[p] + g[p];
    }
    if constexpr (Trial) {
      for (int p = 0; p < 3; ++p) {
        S::store(b.r[p] + k, g[p]);
        S::store(b.r[4 + p] + k, n[p]);
      }
      S::store(b.r[3] + k, c.kn);
      S::store(b.r[7] + k, fn);
      S::store(b.t[0] + k, S::set(1e150));
      S::store(b.t[1] + k, zero);
      S::store(b.t[2] + k, zero);
      return;
    }
    if constexpr (Energy)
      tangential_ledger<S>(b, k, {c.kt, c.kt, f.gt * meff, slid, parts, counted}, a.balanced != 0, h, trial, t);
    // T / r = -lever n x F_t, the same for both partners.
    S::store(b.r[4] + k, lever * (n[2] * g[1] - n[1] * g[2]));
    S::store(b.r[5] + k, lever * (n[0] * g[2] - n[2] * g[0]));
    S::store(b.r[6] + k, lever * (n[1] * g[0] - n[0] * g[1]));
    S::store(b.r[7] + k, Ends ? press * weights.w : press);
  }
  S::store(b.r[0] + k, force_i[0]);
  S::store(b.r[1] + k, force_i[1]);
  S::store(b.r[2] + k, force_i[2]);
  S::store(b.r[3] + k, c.kn);
}

/// What has been set aside. Not inlined: its registers would be taken from the other contacts.
template <class S, bool Friction, bool Multi, bool Energy, bool Trial>
[[gnu::noinline]] double linear_ends(LateContacts& of, const LawArgs& a) {
  const LinearBlock<S, Friction, Multi> in(late_block<S>(of), a);
  LateContacts* none = nullptr;
  for (int k = 0; k < of.n; k += S::W) linear_contacts<S, Friction, Multi, Energy, Trial, true>(in, k, none, 0);
  double back[S::W];
  S::store(back, in.shared.back);
  return back[0];
}

/// Returns 1/(k_t shrink) of one material pair.
template <class S, bool Friction, bool Multi, bool Energy, bool Trial>
double linear_force(const Block& b, const LawArgs& a) {
  const LinearBlock<S, Friction, Multi> in(b, a);
  LateContacts own;  // its columns are written as far as they are read
  own.n = 0;
  const bool leaves = Trial && b.late != nullptr;
  LateContacts* aside = leaves ? b.late : &own;
  const std::int32_t first = leaves ? b.first : 0;
  for (int k = 0; k < in.b.n; k += S::W) linear_contacts<S, Friction, Multi, Energy, Trial, false>(in, k, aside, first);
  if (own.n > 0) {
    linear_ends<S, Friction, Multi, Energy, Trial>(own, a);
    put_back<Friction, Energy, Trial>(own, b, a.recall != 0);
  }
  if constexpr (!Trial) return 0;
  double back[S::W];
  S::store(back, in.shared.back);
  return back[0];
}

template <class S, bool Friction, bool Multi, bool Energy>
void force(Linear, Block& b, const LawArgs& a) {
  linear_force<S, Friction, Multi, Energy, false>(b, a);
}

/// KernelTable::trial: friction, one material pair, no energies.
template <class S>
double linear_trial(Block& b, const LawArgs& a) {
  return linear_force<S, true, false, false, true>(b, a);
}

/// KernelTable::late.
template <class S>
double linear_late(LateContacts& of, const LawArgs& a) {
  return linear_ends<S, true, false, false, true>(of, a);
}

/// KernelTable::scatter_limited.
template <class S>
void scatter_limited(const LimitArgs& args) {
  using B = typename S::B;
  const LimitArgs a = args;
  const B zero = S::set(0.0), one = S::set(1.0), back = S::set(a.back);
  for (int k = 0; k < a.to.n; k += S::W) {
    const B g[3] = {S::load(a.to.r[0] + k), S::load(a.to.r[1] + k), S::load(a.to.r[2] + k)};
    const B n[3] = {S::load(a.to.r[4] + k), S::load(a.to.r[5] + k), S::load(a.to.r[6] + k)};
    const B fn = S::load(a.to.r[7] + k), lever = a.lever != nullptr ? S::load(a.lever + k) : one;
    CoulombLimit<S> coulomb;
    coulomb.set(g, S::load(a.t[0] + k), S::load(a.t[1] + k), S::load(a.t[2] + k), back);
    B r[8], f[3];
    for (int p = 0; p < 3; ++p) {
      const B h = S::load(a.h[p] + k);
      S::store(a.h[p] + k, S::select(coulomb.slides, coulomb.spring * h - coulomb.pull * g[p], h));
      f[p] = g[p] * coulomb.scale;
      r[p] = fn * n[p] + f[p];
    }
    r[3] = S::load(a.to.r[3] + k);
    r[4] = lever * (n[2] * f[1] - n[1] * f[2]);
    r[5] = lever * (n[0] * f[2] - n[2] * f[0]);
    r[6] = lever * (n[1] * f[0] - n[0] * f[1]);
    r[7] = zero;
    scatter_group<S, true>(a.to, k, r);
  }
}

}  // namespace talus::kernels
