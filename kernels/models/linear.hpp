// Linear spring-dashpot with Coulomb friction and tangential history (Cundall & Strack; LAMMPS gran/hooke/history).
//   F_n = k_n delta - gamma_n m_eff v_n,   F_t = -(k_t xi + gamma_t m_eff v_t),   |F_t| <= L
// Dashpot: velocities are known at n-1/2.
// - lagged: uses them as they stand; first order.
// - pairwise: the force of step n fits the velocity at n, v_n = v(n-1/2) + F dt/(2 m_eff), solved for the pair alone:
//   both force components shrink by 1/(1 + gamma dt/2). Second order in an impact, but a contact that rests under load
//   is too soft by gamma dt/2, because there other forces cancel F.
// - centred: the same with the other forces, in normal direction, from the last step: dashpot_velocity(). Tangentially
//   the pair's own force only: a spring that rests under shear is too soft by 7/4 gamma_t dt. The feedback would make
//   it exact, but it is one step late and tangential modes are damped more than normal ones: the longest stable step of
//   a Hertz packing would fall by a third at e = 0.5 (perf/dashpot_limits.py).
// clip: F_n = max(F_n, 0); what the spring still holds when the dashpot's pull outweighs it is lost.
// Onset correction: the dashpot acts from the first instant of touch to the last, so its impulse in the step that holds
// that instant is weighed with the touching time (1/2 + delta/(|v_n| dt)) instead of 1; without it restitution has an
// error of order dt that depends on the phase. The tangential spring too starts at the instant of touch: in that step
// it moves for delta/|v_n| instead of dt, without which every sticking contact carries half a step's slip too much
// (tests/verification/order_test.cpp).
// A contact that a run starts with has not slid yet.
// Coulomb's limit L = mu k_n delta, the elastic part of the normal force. Over an impact the dashpot's part sums to
// nothing, for it is a total derivative of the overlap: gross sliding has the impulse J_t = mu J_n at every
// restitution. friction_limit = "total" is mu max(F_n, 0), which takes more than mu J_n where the dashpot pulls; also
// taken where F_n never pulls (clip).
// Sliding:
// - series: spring and dashpot side by side (Kelvin-Voigt), in series with a slider. While the trial force
//   g = -(k_t xi + gamma_t m_eff v_t) exceeds L, the force is L along g and the spring creeps towards it,
//     gamma_t m_eff xi' = -L g/|g| - k_t xi,   slip velocity v_t - xi' = (|g| - L)/(gamma_t m_eff) along -g.
//   Both parts dissipate on every path, and xi' is continuous where the contact sticks again. One step by an L-stable
//   rule of second order, rho = gamma_t m_eff/(k_t dt):
//     xi_n = (rho^2 xi_{n-1} - (rho L(n-1/2) + L/2) g/(|g| k_t))/(rho^2 + rho + 1/2)
//   Without a dashpot that is xi = -L g/(|g| k_t).
// - balanced: the spring takes the scaled force less the dashpot, as vectors, which may load it backwards (LAMMPS). It
//   does so at once at the instant of touch, where the limit is nothing: xi = -gamma_t m_eff v_t/k_t.
// History: with friction 3 columns, the tangential spring xi [m], oriented i - j; centred and damped: one more, the
// predicted velocity [m/s].
// Reads kn, kt [N/m], gn, gt [1/s] (or 2 beta [-] with by_restitution), mu.
#pragma once

#include "kernels/passes/narrow.hpp"
#include "kernels/simd/simd.hpp"
#include "kernels/views.hpp"

namespace talus::kernels {

struct Linear {
  static constexpr const char* name = "linear";
  static constexpr int history = 3;
  static constexpr bool wants_reff = false;
};

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
/// constant rate, is drawn in and sticks (VERIFICATION 3.8). 1/|c|^2 is expanded to 1 + 2 vn dt/2d, which leaves
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
};

/// Contacts that are new, or that part.
template <class S>
TALUS_INLINE auto lacks_prediction(typename S::B q) {
  return S::lt(S::abs(q), S::set(1e-300));
}

/// Normal velocity that belongs into the centred dashpot beside the pair's own force: v(n-1/2) + a_ext dt/2, where
/// a_ext is what all other forces do to the relative velocity. The last step has stored q = v + F_n dt/m_eff, the
/// velocity that the pair alone would have now, so a_ext dt = (vn - q) - dt v_t^2/d of that step (the last term: the
/// normal has turned; v_t^2 dt/d = 2 (vn - along) - stretch). In an impact of two free spheres a_ext is 0 to rounding;
/// at rest it is -F_n/m_eff and the force is k delta. The feedback is one step late; what that costs in stability is in
/// core/rules/timestep.cpp. q = 0: a new contact. One that has just touched has no history to miss; one that starts in
/// overlap is taken for a resting one, a_ext = -k delta/m_eff.
template <class S>
TALUS_INLINE typename S::B dashpot_velocity(typename S::B vn, const MidNormal<S>& mid, typename S::B q,
                                            typename S::B spring, typename S::B inverse_mass, typename S::B delta,
                                            double dt) {
  const auto zero = S::set(0.0), half = S::set(0.5);
  auto u = mid.along + half * ((vn - q) + mid.stretch);
  const auto fresh = lacks_prediction<S>(q);
  if (S::any(fresh)) {
    const auto touched = S::lt(delta, (zero - vn) * S::set(dt));
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

/// Coulomb: the factor that brings a trial force g to the limit, and what a sliding contact's spring becomes,
/// xi = spring xi - pull g. b = (rho L(n-1/2) + L/2)/k_t, back = spring per trial force. No branch: some of eight
/// contacts slide often enough that mispredictions cost more than the arithmetic. One division serves all.
template <class S>
struct CoulombLimit {
  typename S::M slides;
  typename S::B scale, spring, pull;
  TALUS_INLINE void set(const typename S::B* g, typename S::B limit, typename S::B b, typename S::B rho,
                        typename S::B back) {
    const auto one = S::set(1.0), g2 = (g[0] * g[0] + g[1] * g[1]) + g[2] * g[2];
    const auto memory = rho * rho + rho, whole = memory + S::set(0.5);
    typename S::B size, all;  // 1/(|g| whole)
    if constexpr (S::fast) {
      const auto inv_g = S::inverse_sqrt(g2);
      size = g2 * inv_g;
      all = inv_g * S::inverse(whole);
    } else {
      size = S::sqrt(g2);
      all = one / (size * whole);
    }
    slides = S::gt(g2, limit * limit);
    scale = S::select(slides, limit * (all * whole), one);
    spring = memory * (all * size);
    pull = (b - (rho * back) * size) * all;
  }
};

/// Denominators of the centred dashpot and what else depends on the coefficients alone; loop-invariant where the scene
/// has one material pair and damping rates, because divisions and square roots are what bounds this kernel.
template <class S>
struct LinearFactors {
  typename S::B gn, gt, soft, back;                  ///< rates; 1/k_t, and over the denominator of the trial force
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
    back = a.centred != 0 ? soft * grow_t : soft;
    relax = (gt * soft) * S::set(1 / a.dt);
    cap = mu * (kn * soft);
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

/// Trial: stops before the Coulomb limit and leaves its input (Block::t). Returns 1/(k_t shrink) of one material pair.
template <class S, bool Friction, bool Multi, bool Energy, bool Trial>
double linear_force(Block& block, const LawArgs& args) {
  using B = typename S::B;
  constexpr int k_mass = Friction ? 7 : 3, k_recall = Friction ? Linear::history : 0;
  const LawArgs a = args;  // local copies: the stores below cannot alias them
  const Block b = block;
  const B one = S::set(1.0), zero = S::set(0.0), half = S::set(0.5), dt = S::set(a.dt), hdt = S::set(0.5 * a.dt);
  Coefficients<S, Multi> c;
  LinearFactors<S> shared{};
  const bool constant = !Multi && a.by_restitution == 0;
  if constexpr (!Multi) {
    c.load(b, a, 0);
    shared.set(c.kn, c.kt, c.mu, c.gn, c.gt, a);
  }
  const B travel = a.start != 0 ? zero : dt;
  for (int k = 0; k < b.n; k += S::W) {
    if constexpr (Multi) c.load(b, a, k);
    const B x[3] = {S::load(b.x + k), S::load(b.y + k), S::load(b.z + k)};
    const B v[3] = {S::load(b.r[0] + k), S::load(b.r[1] + k), S::load(b.r[2] + k)};
    const B inv = S::load(b.g[1] + k), meff = S::load(b.g[2] + k), delta = S::load(b.w + k) - S::load(b.g[0] + k);
    const B n[3] = {x[0] * inv, x[1] * inv, x[2] * inv};
    const B vn = (v[0] * n[0] + v[1] * n[1]) + v[2] * n[2];
    LinearFactors<S> f = shared;
    if (!constant) {
      const B root = a.by_restitution != 0 ? S::sqrt(c.kn * S::load(b.r[k_mass] + k)) : one;
      f.set(c.kn, c.kt, c.mu, c.gn * root, c.gt, a);  // the tangential rate stays in 1/s
    }
    MidNormal<S> mid;
    if (Friction || a.recall != 0) mid.set(v, n, vn, inv, a.dt, a.synchronised);
    const B spring_force = c.kn * delta;
    B vd = vn;  // velocity that the dashpot sees
    if (a.recall != 0)
      vd = dashpot_velocity<S>(vn, mid, S::load(b.h_in[k_recall] + k), spring_force, S::load(b.r[k_mass] + k), delta,
                               a.dt);
    const B step = S::abs(vn) * dt;
    const auto brief = S::lt(delta, step);
    B slid = travel;                 // how long the tangential spring has moved with the spheres
    B since = hdt * vn;              // overlap at the middle of that time less the present one
    B rho = meff * f.relax;          // see CoulombLimit
    B counted = one;                 // 0: the last step has counted the dashpot to the end
    [[maybe_unused]] B jump = zero;  // balanced: how long the spring has run backwards
    B fn = f.spring_n * delta - f.rate_n * (meff * vd);
    // a contact that would pull exerts nothing until it parts
    const auto clip = [&] {
      if (a.clip != 0) fn = S::select(S::gt(fn, zero), fn, zero);
    };
    const auto remember = [&](B prediction) {
      if (a.recall != 0) S::store(b.h[k_recall] + k, prediction);
    };
    if (a.centred != 0 && a.onset != 0 && S::any(brief)) {
      const B u = delta / step;
      if constexpr (Friction) {  // first step: all of this began u dt ago
        const auto touch = [&](B& to, B value) { to = S::select(brief, S::select(S::lt(vn, zero), value, to), to); };
        touch(slid, dt * u);
        touch(since, zero - half * delta);
        touch(rho, rho / u);
        if constexpr (!Trial)
          if (a.balanced != 0) touch(jump, f.gt * (meff * f.soft));
      }
      B weight = S::select(brief, half + u, one);
      const auto leaves = S::gt(vn, zero);
      if (a.recall != 0) {
        // The dashpot slows a parting pair, which may so touch once more, by less than a step; the step before, told by
        // its lack of a prediction, has counted that. Without this 0.6 dt/t_c of all phases have an error of order dt.
        const auto fresh = lacks_prediction<S>(S::load(b.h_in[k_recall] + k));
        counted = S::select(brief, S::select(leaves, S::select(fresh, zero, one), one), one);
        weight = weight * counted;
      }
      const B gn = f.gn * weight;
      // the other lanes keep their bits: how many share a vector depends on the instruction set
      fn = S::select(brief, (spring_force - gn * (meff * vd)) * (one / (one + hdt * gn)), fn);
      clip();
      const B next = vn + dt * (fn * S::load(b.r[k_mass] + k));
      remember(S::select(brief, S::select(leaves, zero, next), next));
    } else {
      clip();
      remember(vn + dt * (fn * S::load(b.r[k_mass] + k)));
    }
    B force_i[3] = {fn * n[0], fn * n[1], fn * n[2]};
    if constexpr (Energy) {
      // Loss over [n-1, n] by the midpoint rule: v(n-1/2) is the mid-step velocity. The first interval counts from the
      // instant of touch, the last one to the instant of parting.
      B part = one;
      if (S::any(brief))
        part = S::select(brief, S::select(S::lt(vn, zero), delta / step, one + delta / step), one) * counted;
      S::store(b.e[0] + k, half * (c.kn * (delta * delta)));
      B loss = (dt * part) * ((f.gn * meff) * (vn * vn));
      if (a.clip != 0) {  // the spring relaxes against nothing; one that parts before the next step, to the end
        const B last = delta + dt * vn, left = S::select(brief, S::select(S::gt(vn, zero), zero, delta), delta);
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
        if constexpr (!Trial)
          if (a.balanced != 0) h[p] = h[p] - t[p] * jump;
        g[p] = zero - (f.spring_t * h[p] + rate * t[p]);
      }
      B press = spring_force, creep = f.cap * (half * delta + rho * (delta + since));
      if (a.total != 0) {
        press = S::select(S::gt(fn, zero), fn, zero);
        creep = (c.mu * f.soft) * (press * (half + rho));
      }
      const B limit = c.mu * press;
      if constexpr (Trial) {
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
        continue;
      }
      CoulombLimit<S> coulomb;
      coulomb.set(g, limit, creep, rho, f.back);
      for (int p = 0; p < 3; ++p) {
        const B left = a.balanced == 0 ? coulomb.spring * h[p] - coulomb.pull * g[p]
                                       : zero - (g[p] * coulomb.scale + rate * t[p]) * f.back;
        h[p] = S::select(coulomb.slides, left, h[p]);
        g[p] = g[p] * coulomb.scale;
      }
      for (int p = 0; p < 3; ++p) {
        S::store(b.h[p] + k, h[p]);
        force_i[p] = force_i[p] + g[p];
      }
      if constexpr (Energy) {
        tangential_ledger<S>(
            b, k, {c.kt, c.kt, f.gt * meff, slid, S::lt(delta, S::select(S::gt(vn, zero), step, zero)), counted},
            a.balanced != 0, h, trial, t);
      }
      // T / r = -lever n x F_t, the same for both partners.
      S::store(b.r[4] + k, lever * (n[2] * g[1] - n[1] * g[2]));
      S::store(b.r[5] + k, lever * (n[0] * g[2] - n[2] * g[0]));
      S::store(b.r[6] + k, lever * (n[1] * g[0] - n[0] * g[1]));
      S::store(b.r[7] + k, press);
    }
    S::store(b.r[0] + k, force_i[0]);
    S::store(b.r[1] + k, force_i[1]);
    S::store(b.r[2] + k, force_i[2]);
    S::store(b.r[3] + k, c.kn);
  }
  if constexpr (!Trial) return 0;
  double back[S::W];
  S::store(back, shared.back);
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
