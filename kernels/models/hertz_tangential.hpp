// The tangential direction of the laws of Hertz (hertz_mindlin.hpp): stored force, Coulomb's limit, energies.
#pragma once

#include "kernels/models/hertz_normal.hpp"
#include "kernels/models/partial_slip.hpp"

namespace talus::kernels {

/// The same contacts, with their tangential force g on i. Its functions are called after those of HertzNormal.
template <class S, class Form>
struct HertzContact : HertzNormal<S, Form> {
  using B = typename S::B;
  using Normal = HertzNormal<S, Form>;
  using Normal::a, Normal::b, Normal::c, Normal::k, Normal::one, Normal::zero, Normal::half;
  using Normal::n, Normal::ms, Normal::radius, Normal::edges, Normal::slid, Normal::at_touch;
  using Normal::Normal;
  const B hdt_t = S::set(0.5 * 3.5 * a.dt);

  B t[3], lever;       ///< tangential velocity
  B h[3], hn, last;    ///< stored force, its normal part, last contact radius
  B ct;                ///< dashpot [kg/s]
  B moved, travelled;  ///< radius that the increment belongs to; spring force per tangential velocity [kg/s]
  B press, limit;      ///< what Coulomb's limit counts; the limit
  B g[3];

  TALUS_INLINE void load_history() {
    lever = a.contact_lever != 0 ? S::load(b.g[3] + k) : one;
    const B s[3] = {lever * S::load(b.r[4] + k), lever * S::load(b.r[5] + k), lever * S::load(b.r[6] + k)};
    tangential_velocity<S>(this->v, s, this->mid_normal, t);
    last = S::load(b.h_in[3] + k);
    ct = c.gt * S::sqrt(c.kt * radius / ms);
    for (int p = 0; p < 3; ++p) h[p] = S::load(b.h_in[p] + k);
    hn = (h[0] * n[0] + h[1] * n[1]) + h[2] * n[2];
    const B mean = half * (radius + last);
    moved = S::select(S::lt(mean, radius), mean, radius);
    travelled = slid * (c.kt * moved);
  }

  TALUS_INLINE void find_limit() {
    press = this->elastic;
    if constexpr (Form::adhesive) press = press + S::set(3.0) * this->jkr.pull;
    if (a.total != 0) {
      press = this->fn;
      if constexpr (Form::adhesive) press = this->fn + S::set(3.0) * this->jkr.pull;
      press = S::select(S::gt(press, zero), press, zero);
    }
    limit = c.mu * press;
  }
  /// The limit at n-1/2, or its mean since the touch.
  TALUS_INLINE B middle_limit() const {
    if (a.total != 0) return limit;
    const B middle = limit + (S::set(0.75 * a.dt) * c.mu) * (this->sn * this->vn);
    if (edges) [[unlikely]]
      return at_touch(S::set(0.4) * limit, middle);
    return middle;
  }

  /// Partial slip.
  TALUS_INLINE void move_rings(B mid) {
    B second[3] = {S::load(b.h_in[4] + k), S::load(b.h_in[5] + k), S::load(b.h_in[6] + k)};
    const B out = (second[0] * n[0] + second[1] * n[1]) + second[2] * n[2];
    for (int p = 0; p < 3; ++p) {
      h[p] = h[p] - hn * n[p];
      second[p] = second[p] - out * n[p];
    }
    const RingStep<S> rings{radius, last, travelled, ct, a.centred != 0 ? hdt_t * ms : zero, limit, middle_limit()};
    RingForces<S> forces;
    const B unit = half / c.kt, stored = Form::energy ? unit * ring_energy<S>(h, second, last) : zero;
    partial_slip<S>(rings, t, h, second, g, forces);
    for (int p = 0; p < 3; ++p) {
      S::store(b.h[p] + k, h[p]);
      S::store(b.h[4 + p] + k, second[p]);
    }
    S::store(b.h[3] + k, radius);
    if constexpr (Form::energy) {
      const B time = edges ? at_touch(S::set(0.75) * slid, slid) : slid;
      const B now = unit * ring_energy<S>(h, second, radius);
      ring_ledger<S>(b, k, rings, forces, t, time, stored, now, this->parts(), this->counted, mid);
    }
  }

  /// One spring for the whole contact.
  TALUS_INLINE void move_spring(B mid) {
    const B rescale = S::select(S::lt(radius, last), radius / last, one);
    const B grow = a.centred != 0 ? one + hdt_t * (ct * ms) : one, shrink = one / grow;
    [[maybe_unused]] const B before =
        S::select(S::gt(last, zero), ((h[0] * h[0] + h[1] * h[1]) + h[2] * h[2]) / last, zero);
    B trial[3];
    for (int p = 0; p < 3; ++p) {
      h[p] = trial[p] = (h[p] - hn * n[p]) * rescale - travelled * t[p];
      g[p] = (h[p] - ct * t[p]) * shrink;
    }
    slide(grow);
    for (int p = 0; p < 3; ++p) S::store(b.h[p] + k, h[p]);
    S::store(b.h[3] + k, radius);
    if constexpr (Form::energy) spring_ledger(mid, rescale, before, trial);
  }
  /// As in the linear law, with rho = ct / travelled.
  TALUS_INLINE void slide(B grow) {
    const B g2 = (g[0] * g[0] + g[1] * g[1]) + g[2] * g[2];
    const auto slides = S::gt(g2, limit * limit);
    if (!S::any(slides)) return;
    const B middle = middle_limit();
    const B memory = ct * (ct + travelled), whole = memory + half * (travelled * travelled);
    const B size = S::fast ? g2 * over_root<S>(one, g2) : S::sqrt(g2), all = one / (size * whole);
    const B keep = memory * (all * size), scale = S::select(slides, limit * (all * whole), one);
    const B creep = ct * middle + half * (travelled * limit);
    const B pull = (travelled * all) * (creep - ct * (size * grow));
    for (int p = 0; p < 3; ++p) {
      h[p] = S::select(slides, keep * h[p] + pull * g[p], h[p]);
      g[p] = g[p] * scale;
    }
  }
  /// A change of the contact radius changes F^2 / S_t by the ratio of the smaller to the larger one (F is rescaled on
  /// unloading; on loading S_t grows at constant F, to that of the mean radius before the increment and to that of the
  /// present one after it); neither partner gets that energy, it counts as friction.
  TALUS_INLINE void spring_ledger(B mid, B rescale, B before, const B* trial) {
    B reach = moved, time = slid;
    if (edges) {
      time = at_touch(S::set(0.75) * slid, time);
      reach = at_touch(S::set(4.0 / 3.0) * moved, reach);
    }
    const B stiffness = c.kt * reach, soft = zero - one / stiffness;
    B way[3], most[3], h2 = zero;
    for (int p = 0; p < 3; ++p) {
      h2 = h2 + h[p] * h[p];
      way[p] = soft * h[p];
      most[p] = soft * trial[p];
    }
    tangential_ledger<S>(b, k, {stiffness, stiffness * (reach / radius), mid * ct, time, this->parts(), this->counted},
                         false, way, most, t);
    const B kept = S::select(S::lt(radius, last), rescale, last / reach);
    const B released = half * (before * (one - kept) + h2 * (one / reach - one / radius)) / c.kt;
    S::store(b.e[2] + k, S::load(b.e[2] + k) + released);
  }

  /// T / r = -lever n x F_t, the same for both partners, and what presses.
  TALUS_INLINE void store_tangential() const {
    S::store(b.r[4] + k, lever * (n[2] * g[1] - n[1] * g[2]));
    S::store(b.r[5] + k, lever * (n[0] * g[2] - n[2] * g[0]));
    S::store(b.r[6] + k, lever * (n[1] * g[0] - n[0] * g[1]));
    S::store(b.r[7] + k, press);
  }
};

}  // namespace talus::kernels
