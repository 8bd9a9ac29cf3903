// Hertz-Mindlin with the exact restitution damping (Antypov & Elliott 2011; VERIFICATION 3.1).
//   S_n = 4/3 E* a, S_t = 8 G* a, a = sqrt(R* delta)
//   F_n = S_n delta - alpha sqrt(m_eff S_n) v_n,  alpha = -sqrt(5) ln e / sqrt(pi^2 + ln^2 e)
//   F_t: stored force, dF = -S_t v_t dt, rescaled by a/a_prev when the contact radius shrinks (no energy from closed
//   loops); S_t is that of the mean of a_prev and a while the radius grows, which makes the integral second order, and
//   that of a while it shrinks (of the mean, rescaled from there to a: the same); dashpot gamma_t v_t, gamma_t =
//   sqrt(2/3) alpha sqrt(m_eff S_t); |F_t| <= mu S_n delta (JKR: F + 3 pi w R* in place of S_n delta). Coulomb's limit
//   and sliding ("series") as in the linear law (linear.hpp), with gamma_t m_eff -> gamma_t and k_t -> S_t; the dashpot
//   of this law is a total derivative of the overlap, too.
// Onset correction: with delta = u |v_n| dt in the first step and in the last, the dashpot, which starts as
// delta^(1/4), has the weight (1/2 + u)^(5/4)/(5/4 u^(1/4)): its impulse between the touch and n+1/2. hertz_tsuji
// differs only in alpha (the polynomial of Tsuji et al.), chosen at set-up. History: with friction 4 columns, the
// elastic tangential force on i [N] and the last contact radius [m]; with partial slip three more, see
// partial_slip.hpp; centred and damped: one more, see dashpot_velocity() of the linear law. Reads kn = 4/3 E* [Pa],
// kt = 8 G* [Pa], gn = alpha [-], gt = sqrt(2/3) alpha [-], mu; wants R*.
#pragma once

#include "kernels/models/jkr.hpp"
#include "kernels/models/partial_slip.hpp"

namespace talus::kernels {

struct HertzMindlin {
  static constexpr const char* name = "hertz_mindlin";
  static constexpr int history = 4;
  static constexpr bool wants_reff = true;
};

/// Work of adhesion of W contacts [J/m2].
template <class S, bool Multi>
TALUS_INLINE typename S::B adhesion_of(const Block& b, const LawArgs& a, int k) {
  if constexpr (Multi) {
    double t[S::W];
    for (int q = 0; q < S::W; ++q) t[q] = a.table[b.pair[k + q]].w;
    return S::load(t);
  } else {
    return S::set(a.one.w);
  }
}

struct PartialSlip {
  static constexpr const char* name = "partial_slip";
  static constexpr int history = 7;
  static constexpr bool wants_reff = true;
};

/// Adhesive: the normal force and contact radius of JKR (kernels/models/jkr.hpp) in place of Hertz. Slip: the
/// tangential force is that of partial_slip.hpp.
template <class S, bool Friction, bool Multi, bool Energy, bool Adhesive, bool Slip = false>
void hertz_force(Block& block, const LawArgs& args) {
  using B = typename S::B;
  constexpr int k_recall = !Friction ? 0 : Slip ? PartialSlip::history : HertzMindlin::history;
  const LawArgs a = args;  // local copies: the stores below cannot alias them
  const Block b = block;
  const B one = S::set(1.0), zero = S::set(0.0), half = S::set(0.5), dt = S::set(a.dt), hdt = S::set(0.5 * a.dt);
  const B hdt_t = S::set(0.5 * 3.5 * a.dt), two_fifths = S::set(0.4);
  const B travel = a.start != 0 ? zero : dt;  // how long the tangential springs have moved with the spheres
  const bool onset = !Adhesive && a.centred != 0 && a.onset != 0;
  Coefficients<S, Multi> c;
  if constexpr (!Multi) c.load(b, a, 0);
  for (int k = 0; k < b.n; k += S::W) {
    if constexpr (Multi) c.load(b, a, k);
    const B x[3] = {S::load(b.x + k), S::load(b.y + k), S::load(b.z + k)};
    const B v[3] = {S::load(b.r[0] + k), S::load(b.r[1] + k), S::load(b.r[2] + k)};
    const B ms = S::load(b.r[Friction ? 7 : 3] + k), w = S::load(b.w + k), reff = S::load(b.reff + k);
    const B d = S::load(b.g[0] + k), inv = S::load(b.g[1] + k), delta = w - d;
    const B n[3] = {x[0] * inv, x[1] * inv, x[2] * inv};
    const B vn = (v[0] * n[0] + v[1] * n[1]) + v[2] * n[2];
    B radius, sn, fn;
    [[maybe_unused]] JkrContact<S> jkr;
    [[maybe_unused]] B work_of_adhesion;
    if constexpr (Adhesive) {
      work_of_adhesion = adhesion_of<S, Multi>(b, a, k);
      jkr.set(work_of_adhesion, S::set(0.75) * c.kn, reff, delta);
      radius = jkr.a;
      sn = c.kn * radius;
      fn = jkr.force();
    } else {
      radius = S::sqrt(reff * delta);
      sn = c.kn * radius;
      fn = sn * delta;
    }
    const B cn = c.gn * S::sqrt(sn / ms);  // [kg/s]
    MidNormal<S> mid_normal;
    if (Friction || a.recall != 0) mid_normal.set(v, n, vn, inv, a.dt, a.synchronised);
    B vd = vn;
    if (a.recall != 0) vd = dashpot_velocity<S>(vn, mid_normal, S::load(b.h_in[k_recall] + k), fn, ms, delta, a.dt);
    const B elastic = fn, step = S::abs(vn) * dt;
    const auto brief = S::lt(delta, step);
    const bool edges = onset && S::any(brief);
    B cw = cn, counted = one, slid = travel, moved_for = travel;  // as in the linear law
    if (edges) [[unlikely]] {
      const B u = delta / step, q = half + u;
      if (a.recall != 0) {
        const auto fresh = lacks_prediction<S>(S::load(b.h_in[k_recall] + k));
        counted = S::select(brief, S::select(fresh, S::select(S::gt(vn, zero), zero, one), one), one);
      }
      cw = S::select(brief, cn * ((S::set(0.8) * (q * S::sqrt(S::sqrt(q / u)))) * counted), cn);
      // the radius has grown as the root of the time since touch: 2/3 of it on average, not the half of below
      moved_for = S::select(brief, S::select(S::lt(vn, zero), dt * u, travel), travel);
      slid = S::select(brief, S::select(S::lt(vn, zero), (dt * u) * S::set(4.0 / 3.0), slid), slid);
    }
    fn = fn - cw * vd;
    if (a.centred != 0) fn = fn / (one + hdt * (cw * ms));
    if (!Adhesive && a.clip != 0) fn = S::select(S::gt(fn, zero), fn, zero);  // as in the linear law
    if (a.recall != 0) {
      const B next = vn + dt * (fn * ms);
      S::store(b.h[k_recall] + k, next);
      if (edges) [[unlikely]]
        S::store(b.h[k_recall] + k, S::select(brief, S::select(S::gt(vn, zero), zero, next), next));
    }
    B f[3] = {fn * n[0], fn * n[1], fn * n[2]};
    B mid = one;  // dashpot at n-1/2 over that at n
    if constexpr (Energy) {
      // Loss over [n-1, n] by the midpoint rule: v(n-1/2) with the dashpot of the overlap at n-1/2.
      if constexpr (Adhesive) {
        const B last = delta + dt * vn;
        JkrContact<S> before, middle;
        before.set(work_of_adhesion, S::set(0.75) * c.kn, reff, last);
        middle.set(work_of_adhesion, S::set(0.75) * c.kn, reff, half * (last + delta));
        mid = S::sqrt(middle.a / radius);
        const B now = jkr.energy(), stored = S::select(S::gt(delta, zero), now, zero);
        const B neck = now - stored, neck_before = S::select(S::gt(last, zero), zero, before.energy());
        S::store(b.e[0] + k, stored);
        S::store(b.e[1] + k, dt * ((cn * mid) * (vn * vn)) + (neck - neck_before));
      } else {
        const B middle = delta + hdt * vn;
        mid = S::sqrt(S::sqrt(S::select(S::gt(middle, zero), middle, zero) / delta));
        S::store(b.e[0] + k, two_fifths * (sn * (delta * delta)));
        B loss = dt * ((cn * mid) * (vn * vn));
        if (edges) {  // from the instant of touch, and to that of parting
          const B edge = (S::set(0.8) * (delta / S::abs(vn))) * (cn * (vn * vn));
          loss = S::select(brief, (S::select(S::lt(vn, zero), zero, loss) + edge) * counted, loss);
          mid = S::select(brief, S::select(S::lt(vn, zero), S::set(0.8), mid), mid);
        }
        if (a.clip != 0) {
          const B last = delta + dt * vn, before = c.kn * (S::sqrt(reff * S::select(S::gt(last, zero), last, zero)));
          loss = S::select(S::gt(fn, zero), loss, two_fifths * (before * (last * last) - sn * (delta * delta)));
        }
        S::store(b.e[1] + k, loss);
      }
      S::store(b.e[2] + k, zero);
    }
    if constexpr (Friction) {
      if (b.slid != nullptr) S::store(b.slid + k, moved_for);
      const B lever = a.contact_lever != 0 ? S::load(b.g[3] + k) : one;
      const B s[3] = {lever * S::load(b.r[4] + k), lever * S::load(b.r[5] + k), lever * S::load(b.r[6] + k)};
      B t[3];
      tangential_velocity<S>(v, s, mid_normal, t);
      const B last = S::load(b.h_in[3] + k), st = c.kt * radius, ct = c.gt * S::sqrt(st / ms);
      B h[3] = {S::load(b.h_in[0] + k), S::load(b.h_in[1] + k), S::load(b.h_in[2] + k)};
      const B hn = (h[0] * n[0] + h[1] * n[1]) + h[2] * n[2];
      const B before = S::select(S::gt(last, zero), ((h[0] * h[0] + h[1] * h[1]) + h[2] * h[2]) / last, zero);
      const B rescale = S::select(S::lt(radius, last), radius / last, one);
      const B grow = a.centred != 0 ? one + hdt_t * (ct * ms) : one, shrink = one / grow;
      const B mean = half * (radius + last), moved = S::select(S::lt(mean, radius), mean, radius);
      const B travelled = slid * (c.kt * moved);
      B press = elastic;
      if constexpr (Adhesive) press = press + S::set(3.0) * jkr.pull;
      if (a.total != 0) {
        press = fn;
        if constexpr (Adhesive) press = fn + S::set(3.0) * jkr.pull;
        press = S::select(S::gt(press, zero), press, zero);
      }
      const B limit = c.mu * press;
      // the limit at n-1/2, or its mean since the touch
      const auto middle_limit = [&] {
        B middle = limit;
        if (a.total == 0) {
          middle = limit + (S::set(0.75 * a.dt) * c.mu) * (sn * vn);
          if (edges) [[unlikely]]
            middle = S::select(brief, S::select(S::lt(vn, zero), two_fifths * limit, middle), middle);
        }
        return middle;
      };
      B g[3];
      if constexpr (Slip) {
        B second[3] = {S::load(b.h_in[4] + k), S::load(b.h_in[5] + k), S::load(b.h_in[6] + k)};
        const B out = (second[0] * n[0] + second[1] * n[1]) + second[2] * n[2];
        for (int q = 0; q < 3; ++q) {
          h[q] = h[q] - hn * n[q];
          second[q] = second[q] - out * n[q];
        }
        const RingStep<S> rings{radius, last, travelled, ct, a.centred != 0 ? hdt_t * ms : zero, limit, middle_limit()};
        RingForces<S> forces;
        const B unit = half / c.kt, stored = Energy ? unit * ring_energy<S>(h, second, last) : zero;
        partial_slip<S>(rings, t, h, second, g, forces);
        for (int q = 0; q < 3; ++q) {
          S::store(b.h[q] + k, h[q]);
          S::store(b.h[4 + q] + k, second[q]);
          f[q] = f[q] + g[q];
        }
        S::store(b.h[3] + k, radius);
        if constexpr (Energy) {
          B time = slid;
          if (edges) time = S::select(brief, S::select(S::lt(vn, zero), S::set(0.75) * slid, slid), slid);
          const B now = unit * ring_energy<S>(h, second, radius);
          const auto parts = S::lt(delta, S::select(S::gt(vn, zero), step, zero));
          ring_ledger<S>(b, k, rings, forces, t, time, stored, now, parts, counted, mid);
        }
      } else {
        B trial[3];
        for (int q = 0; q < 3; ++q) {
          h[q] = trial[q] = (h[q] - hn * n[q]) * rescale - travelled * t[q];
          g[q] = (h[q] - ct * t[q]) * shrink;
        }
        const B g2 = (g[0] * g[0] + g[1] * g[1]) + g[2] * g[2];
        const auto slides = S::gt(g2, limit * limit);
        if (S::any(slides)) {
          // as in the linear law, with rho = ct / travelled; the limit at n-1/2, or its mean since the touch
          const B middle = middle_limit();
          const B memory = ct * (ct + travelled), whole = memory + half * (travelled * travelled);
          const B size = S::fast ? g2 * over_root<S>(one, g2) : S::sqrt(g2), all = one / (size * whole);
          const B keep = memory * (all * size), scale = S::select(slides, limit * (all * whole), one);
          const B creep = ct * middle + half * (travelled * limit);
          const B pull = (travelled * all) * (creep - ct * (size * grow));
          for (int q = 0; q < 3; ++q) {
            h[q] = S::select(slides, keep * h[q] + pull * g[q], h[q]);
            g[q] = g[q] * scale;
          }
        }
        for (int q = 0; q < 3; ++q) {
          S::store(b.h[q] + k, h[q]);
          f[q] = f[q] + g[q];
        }
        S::store(b.h[3] + k, radius);
        if constexpr (Energy) {
          // A change of the contact radius changes F^2 / S_t by the ratio of the smaller to the larger one (F is
          // rescaled on unloading; on loading S_t grows at constant F, to that of the mean radius before the increment
          // and to that of the present one after it); neither partner gets that energy, it counts as friction.
          B reach = moved, time = slid;
          if (edges) {
            const auto touch = [&](B& to, B value) {
              to = S::select(brief, S::select(S::lt(vn, zero), value, to), to);
            };
            touch(time, S::set(0.75) * slid);
            touch(reach, S::set(4.0 / 3.0) * moved);
          }
          const B stiffness = c.kt * reach, soft = zero - one / stiffness;
          B way[3], most[3], h2 = zero;
          for (int q = 0; q < 3; ++q) {
            h2 = h2 + h[q] * h[q];
            way[q] = soft * h[q];
            most[q] = soft * trial[q];
          }
          const auto parts = S::lt(delta, S::select(S::gt(vn, zero), step, zero));
          tangential_ledger<S>(b, k, {stiffness, stiffness * (reach / radius), mid * ct, time, parts, counted}, false,
                               way, most, t);
          const B kept = S::select(S::lt(radius, last), rescale, last / reach);
          const B released = half * (before * (one - kept) + h2 * (one / reach - one / radius)) / c.kt;
          S::store(b.e[2] + k, S::load(b.e[2] + k) + released);
        }
      }
      S::store(b.r[4] + k, lever * (n[2] * g[1] - n[1] * g[2]));
      S::store(b.r[5] + k, lever * (n[0] * g[2] - n[2] * g[0]));
      S::store(b.r[6] + k, lever * (n[1] * g[0] - n[0] * g[1]));
      S::store(b.r[7] + k, press);
    }
    S::store(b.r[0] + k, f[0]);
    S::store(b.r[1] + k, f[1]);
    S::store(b.r[2] + k, f[2]);
    S::store(b.r[3] + k, S::set(1.5) * sn);
  }
}

template <class S, bool Friction, bool Multi, bool Energy>
void force(HertzMindlin, Block& b, const LawArgs& a) {
  hertz_force<S, Friction, Multi, Energy, false>(b, a);
}

template <class S, bool Friction, bool Multi, bool Energy>
void force(PartialSlip, Block& b, const LawArgs& a) {
  hertz_force<S, Friction, Multi, Energy, false, true>(b, a);
}

struct Jkr {
  static constexpr const char* name = "jkr";
  static constexpr int history = 4;
  static constexpr bool wants_reff = true;
};

template <class S, bool Friction, bool Multi, bool Energy>
void force(Jkr, Block& b, const LawArgs& a) {
  hertz_force<S, Friction, Multi, Energy, true>(b, a);
}

}  // namespace talus::kernels
