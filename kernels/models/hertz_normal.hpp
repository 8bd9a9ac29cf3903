// The normal direction of the laws of Hertz (hertz_mindlin.hpp): spring, dashpot, first and last step, energies.
#pragma once

#include "kernels/models/jkr.hpp"

namespace talus::kernels {

/// Which law a kernel is. Adhesive: the normal force and contact radius of JKR (jkr.hpp) in place of Hertz. Slip: the
/// tangential force is that of partial_slip.hpp. recall, mass: columns of the predicted velocity and the inverse mass.
template <bool Friction, bool Multi, bool Energy, bool Adhesive, bool Slip>
struct HertzForm {
  static constexpr bool friction = Friction, multi = Multi, energy = Energy, adhesive = Adhesive, slip = Slip;
  static constexpr int recall = !Friction ? 0 : Slip ? 7 : 4, mass = Friction ? 7 : 3;
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

/// S::W contacts from k on. Its functions are called in the order in which they stand. Block and arguments are copies:
/// through references the compiler keeps all of it in memory.
template <class S, class Form>
struct HertzNormal {
  using B = typename S::B;
  const Block b;
  const LawArgs a;
  const Coefficients<S, Form::multi> c;
  const int k;
  const B one = S::set(1.0), zero = S::set(0.0), half = S::set(0.5), dt = S::set(a.dt);
  const B travel = a.start != 0 ? zero : dt;  ///< how long the tangential springs move with the spheres

  B v[3], n[3], vn;           ///< relative velocity, normal, their product
  B ms, reff, delta;          ///< inverse of the reduced mass; reduced radius; overlap
  B radius, sn, elastic, cn;  ///< of the contact area; 4/3 E* radius; force of the spring; dashpot [kg/s]
  B fn;                       ///< normal force
  MidNormal<S> mid_normal;
  B step;                            ///< |v_n| dt
  typename S::M brief;               ///< begins or ends in this step
  bool edges;                        ///< one of them does
  B weighed, counted, slid, turned;  ///< dashpot of this step; the others as in the linear law
  JkrContact<S> jkr;                 ///< with its work of adhesion [J/m2]: where adhesive
  B adhesion;

  TALUS_INLINE HertzNormal(const Block& block, const LawArgs& args, const Coefficients<S, Form::multi>& of, int first)
      : b(block), a(args), c(of), k(first) {}

  TALUS_INLINE void load() {
    for (int q = 0; q < 3; ++q) v[q] = S::load(b.r[q] + k);
    ms = S::load(b.r[Form::mass] + k);
    reff = S::load(b.reff + k);
    const B inv = S::load(b.g[1] + k);
    delta = S::load(b.w + k) - S::load(b.g[0] + k);
    n[0] = S::load(b.x + k) * inv;
    n[1] = S::load(b.y + k) * inv;
    n[2] = S::load(b.z + k) * inv;
    vn = (v[0] * n[0] + v[1] * n[1]) + v[2] * n[2];
    if (Form::friction || a.recall != 0) mid_normal.set(v, n, vn, inv, a.dt, a.synchronised);
  }

  TALUS_INLINE void spring() {
    if constexpr (Form::adhesive) {
      adhesion = adhesion_of<S, Form::multi>(b, a, k);
      jkr.set(adhesion, S::set(0.75) * c.kn, reff, delta);
      radius = jkr.a;
      sn = c.kn * radius;
      elastic = jkr.force();
    } else {
      radius = S::sqrt(reff * delta);
      sn = c.kn * radius;
      elastic = sn * delta;
    }
    cn = c.gn * S::sqrt(sn / ms);
  }

  /// What the first and the last step of a contact count.
  TALUS_INLINE void find_edges() {
    step = S::abs(vn) * dt;
    brief = S::lt(delta, step);
    edges = !Form::adhesive && a.centred != 0 && a.onset != 0 && S::any(brief);
    weighed = cn;
    counted = one;
    slid = turned = travel;
    if (!edges) [[likely]]
      return;
    const B u = delta / step, q = half + u;
    if (a.recall != 0) {
      const auto fresh = lacks_prediction<S>(S::load(b.h_in[Form::recall] + k));
      counted = S::select(brief, S::select(fresh, S::select(S::gt(vn, zero), zero, one), one), one);
    }
    weighed = S::select(brief, cn * ((S::set(0.8) * (q * S::sqrt(S::sqrt(q / u)))) * counted), cn);
    // the radius has grown as the root of the time since touch: 2/3 of it on average, not the half of a contact's mean
    turned = at_touch(dt * u, travel);
    slid = at_touch((dt * u) * S::set(4.0 / 3.0), travel);
  }
  /// first in the first step of a contact.
  TALUS_INLINE B at_touch(B first, B other) const {
    return S::select(brief, S::select(S::lt(vn, zero), first, other), other);
  }
  /// Parts before the next step; an adhesive neck holds down to three units below the touch.
  TALUS_INLINE auto parts() const {
    B left = delta;
    if constexpr (Form::adhesive) left = delta + S::set(3.0) * jkr.unit;
    return S::lt(left, S::select(S::gt(vn, zero), step, zero));
  }

  /// Force, and the velocity that the next step is told.
  TALUS_INLINE void damp() {
    B vd = vn;
    if (a.recall != 0)
      vd = dashpot_velocity<S>(vn, mid_normal, S::load(b.h_in[Form::recall] + k), elastic, ms, delta, a.dt);
    fn = elastic - weighed * vd;
    if (a.centred != 0) fn = fn / (one + S::set(0.5 * a.dt) * (weighed * ms));
    if (!Form::adhesive && a.clip != 0) fn = S::select(S::gt(fn, zero), fn, zero);  // as in the linear law
    if (a.recall == 0) return;
    const B next = vn + dt * (fn * ms);
    S::store(b.h[Form::recall] + k, next);
    if (edges) [[unlikely]]
      S::store(b.h[Form::recall] + k, S::select(brief, S::select(S::gt(vn, zero), zero, next), next));
  }

  /// Loss over [n-1, n] by the midpoint rule: v(n-1/2) with the dashpot of the overlap at n-1/2. Returns that dashpot
  /// over the one at n.
  TALUS_INLINE B normal_ledger() const {
    const B two_fifths = S::set(0.4), middle = delta + S::set(0.5 * a.dt) * vn;
    B mid = S::sqrt(S::sqrt(S::select(S::gt(middle, zero), middle, zero) / delta));
    S::store(b.e[0] + k, two_fifths * (sn * (delta * delta)));
    B loss = dt * ((cn * mid) * (vn * vn));
    if (edges) {  // from the instant of touch, and to that of parting
      const B edge = (S::set(0.8) * (delta / S::abs(vn))) * (cn * (vn * vn));
      loss = S::select(brief, (S::select(S::lt(vn, zero), zero, loss) + edge) * counted, loss);
      mid = at_touch(S::set(0.8), mid);
    }
    if (a.clip != 0) {
      const B last = delta + dt * vn, before = c.kn * (S::sqrt(reff * S::select(S::gt(last, zero), last, zero)));
      loss = S::select(S::gt(fn, zero), loss, two_fifths * (before * (last * last) - sn * (delta * delta)));
    }
    S::store(b.e[1] + k, loss);
    return mid;
  }
  TALUS_INLINE B adhesive_ledger() const {
    const B last = delta + dt * vn;
    JkrContact<S> before, middle;
    before.set(adhesion, S::set(0.75) * c.kn, reff, last);
    middle.set(adhesion, S::set(0.75) * c.kn, reff, half * (last + delta));
    const B mid = S::sqrt(middle.a / radius);
    const B now = jkr.energy(), stored = S::select(S::gt(delta, zero), now, zero);
    const B neck = now - stored, neck_before = S::select(S::gt(last, zero), zero, before.energy());
    S::store(b.e[0] + k, stored);
    S::store(b.e[1] + k, dt * ((cn * mid) * (vn * vn)) + (neck - neck_before));
    return mid;
  }
};

}  // namespace talus::kernels
