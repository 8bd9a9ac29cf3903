// Integration of translation and rotation, fused with the displacement check of the pair list (DESIGN 2.7).
//   v(n+1/2) = v(n-1/2) + (F/m + g) dt,  r w(n+1/2) = r w(n-1/2) + 5/2 (T/r)/m dt,  x(n+1) = x(n) + v(n+1/2) dt
// Rows with 1/m = 0 (fixed, driven, removed) keep their velocity. A particle has left its list's guarantee when
// |x - x0|^2 > skin^2 (paper eq. 5 with the capped, stored skin; NaN counts as left).
// Policies with a drift velocity u: |x - x0 - u t|^2 instead, its minimum image by rounding, since u t may run over
// several periods.
// Periodic axes wrap by compare (x < 0 => x + L), a rule of the trajectory alone.
#pragma once

#include "kernels/simd/simd.hpp"
#include "kernels/views.hpp"

namespace talus::kernels {

/// v(n+1/2) of one row with background damping; rare, so scalar. Cundall's local damping opposes the motion with a
/// fraction of the resultant; viscous damping is linear in v.
template <class S, bool Rotation>
inline void damped_row(const IntegrateArgs& a, const double* v, const double* f, double* out, double* loss) {
  constexpr int rows = Rotation ? 8 : 4;
  const double invm = v[rows - 1], live = invm > 0 ? 1.0 : 0.0;
  double lost = 0;  // per mass
  for (int c = 0; c < rows; ++c) {
    if (!(c < 3 || (c >= 4 && c < 7))) {
      out[c] = v[c];
      continue;
    }
    double acc = (f[c] * invm) * (c < 3 ? 1.0 : 2.5) + (c < 3 ? a.gravity[c] * live : 0.0);
    const double size = acc < 0 ? -acc : acc;
    const double drag = a.local != 0 && v[c] != 0 ? (v[c] > 0 ? a.local : -a.local) * size : 0.0;
    acc = acc - drag - (a.viscous * live) * v[c];
    out[c] = v[c] + a.kick * acc;
    // the velocity at n, as the drag of v(n-1/2) there; 1/2 I w^2 = 1/5 m (r w)^2
    lost = lost + (c < 3 ? 1.0 : 0.4) * (drag * (0.5 * (v[c] + out[c])));
  }
  if (loss != nullptr && live != 0) *loss = a.dt * (lost / invm);
}

inline constexpr long k_rows_ahead = 24;

/// Constants of a block of rows as vectors; `a`: a copy, which no store through p2 and v2 can alias.
template <class S, bool Rotation>
struct Integration {
  using R4 = typename S::R4;
  static constexpr long rows = Rotation ? 8 : 4;
  const IntegrateArgs a;
  alignas(64) double mult_rows[8], grav_rows[8];
  R4 dt, upper, wrap, half, minus_half, zero, periods, time;
  unsigned periodic = 0;

  TALUS_INLINE explicit Integration(const IntegrateArgs& args)
      : a(args),
        mult_rows{a.kick, a.kick, a.kick, 0, 2.5 * a.kick, 2.5 * a.kick, 2.5 * a.kick, 0},
        grav_rows{a.kick * a.gravity[0], a.kick * a.gravity[1], a.kick * a.gravity[2], 0, 0, 0, 0, 0} {
    alignas(32) const double step[4] = {a.dt, a.dt, a.dt, 0}, nothing[4] = {0, 0, 0, -1e300};
    alignas(32) const double down[4] = {-a.half[0], -a.half[1], -a.half[2], -a.half[3]};
    alignas(32) double to_periods[4] = {};
    for (int c = 0; c < 3; ++c) to_periods[c] = a.wrap[c] != 0 ? 1 / a.wrap[c] : 0;
    dt = S::load4(step), upper = S::load4(a.upper), wrap = S::load4(a.wrap), half = S::load4(a.half);
    minus_half = S::load4(down), zero = S::load4(nothing);
    periods = S::load4(to_periods), time = S::set4(a.drift_time);
    for (unsigned c = 0; c < 3; ++c)
      if (a.wrap[c] != 0) periodic |= 1U << c;  // as one expression GCC 12 miscompiles it below UBSan
  }

  /// Out of cache 12 -> 9 ns per row at 128k grains, in cache nothing.
  template <bool Stream, bool Drift>
  TALUS_INLINE void prefetch(long i) const {
    __builtin_prefetch(a.v + rows * i);
    __builtin_prefetch(a.p + 4 * i);
    __builtin_prefetch(a.x0 + 4 * i);
    if constexpr (Drift) __builtin_prefetch(a.drift + a.drift_stride * i);
    if constexpr (!Stream) {
      __builtin_prefetch(a.v2 + rows * i, 1);
      __builtin_prefetch(a.p2 + 4 * i, 1);
    }
  }

  /// Velocities of row i half a step on, stored; the translation is returned.
  template <bool Damped, bool Stream>
  TALUS_INLINE R4 kicked(long i, const double* vr, const double* fr, double invm) const {
    const double live = invm > 0 ? 1.0 : 0.0;
    if constexpr (Damped) {
      damped_row<S, Rotation>(a, vr, fr, a.v2 + rows * i, a.loss != nullptr ? a.loss + 4 * i + 3 : nullptr);
      const R4 vel = S::load4(a.v2 + rows * i);
      return Rotation ? vel : S::and4(vel, 7U);
    } else if constexpr (Rotation) {
      auto v = S::load8(vr);
      v = S::add8(v, S::mul8(S::mul8(S::load8(fr), S::set8(invm)), S::load8(mult_rows)));
      v = S::add8(v, S::mul8(S::load8(grav_rows), S::set8(live)));
      if constexpr (Stream)
        S::stream8(a.v2 + rows * i, v);
      else
        S::store8(a.v2 + rows * i, v);
      return S::low4(v);
    } else {
      auto v = S::load4(vr);
      v = S::add4(v, S::mul4(S::mul4(S::load4(fr), S::set4(invm)), S::load4(mult_rows)));
      v = S::add4(v, S::mul4(S::load4(grav_rows), S::set4(live)));
      if constexpr (Stream)
        S::stream4(a.v2 + rows * i, v);
      else
        S::store4(a.v2 + rows * i, v);
      return v;
    }
  }

  /// Row i at x is beyond a side, or a period from where its list was made: wraps both, tells who has left.
  template <bool Drift>
  TALUS_INLINE void cross(long i, R4& x, R4& d, R4 ref, R4 drift, std::int32_t& out_count) const {
    const auto rounding = S::set4(0x1.8p52);  // adding and taking it away rounds to the nearest integer
    const unsigned below = S::lt4(x, zero) & 7U, above = ~S::lt4(x, upper) & 7U;
    if (((below | above) & periodic) != 0) {
      x = S::add4(x, S::and4(wrap, below & periodic));
      x = S::sub4(x, S::and4(wrap, above & periodic));
      d = S::sub4(x, ref);
    }
    if (((below | above) & ~periodic) != 0 && a.p[4 * i] < 1e100) a.out[out_count++] = static_cast<std::int32_t>(i);
    if constexpr (Drift) {
      d = S::sub4(S::sub4(x, ref), drift);
      d = S::sub4(d, S::mul4(S::sub4(S::add4(S::mul4(d, periods), rounding), rounding), wrap));
    } else {
      const unsigned far_up = ~S::lt4(d, half) & periodic, far_down = S::lt4(d, minus_half) & periodic;
      d = S::sub4(d, S::and4(wrap, far_up));
      d = S::add4(d, S::and4(wrap, far_down));
    }
  }
};

template <class S, bool Rotation, bool Damped, bool Stream, bool Drift>
void integrate_rows(IntegrateArgs& args) {
  const Integration<S, Rotation> all(args);
  const IntegrateArgs& a = all.a;
  constexpr long rows = Rotation ? 8 : 4;
  const auto no_force = S::set8(0.0);
  int expired = 0;
  std::int32_t out_count = 0, unstable_row = -1;
  for (long i = a.lo; i < a.hi; ++i) {
    const double* vr = a.v + rows * i;
    double* fr = a.f + rows * i;
    all.template prefetch<Stream, Drift>(i + k_rows_ahead);
    const double invm = vr[rows - 1];
    if (__builtin_expect(fr[3] * invm > a.unstable, 0)) unstable_row = static_cast<std::int32_t>(i);
    const typename S::R4 vel = all.template kicked<Damped, Stream>(i, vr, fr, invm);
    if constexpr (Rotation)
      S::store8(fr, no_force);
    else
      S::store4(fr, S::low4(no_force));
    auto x = S::add4(S::load4(a.p + 4 * i), S::mul4(vel, all.dt));
    const double* ref = a.x0 + 4 * i;
    auto d = S::sub4(x, S::load4(ref));
    typename S::R4 drift = d;
    if constexpr (Drift) {
      drift = S::mul4(S::widen4(a.drift + a.drift_stride * i), all.time);
      d = S::sub4(d, drift);
    }
    if (__builtin_expect(S::outside4(x, all.zero, all.upper, d, all.half), 0))
      all.template cross<Drift>(i, x, d, S::load4(ref), drift, out_count);
    if constexpr (Stream)
      S::stream4(a.p2 + 4 * i, x);
    else
      S::store4(a.p2 + 4 * i, x);
    expired |= !(S::norm3(d) <= ref[3]) ? 1 : 0;
  }
  args.out_count = out_count;
  args.expired = expired;
  args.unstable_row = unstable_row;
}

template <class S, bool Rotation, bool Drift>
void integrate_checked(IntegrateArgs& a) {
  if (a.viscous != 0 || a.local != 0) return integrate_rows<S, Rotation, true, false, Drift>(a);
  if (a.stream == 0) return integrate_rows<S, Rotation, false, false, Drift>(a);
  integrate_rows<S, Rotation, false, true, Drift>(a);
  __builtin_ia32_sfence();  // other threads read these rows in the next step
}

template <class S, bool Rotation>
void integrate(IntegrateArgs& a) {
  a.drift == nullptr ? integrate_checked<S, Rotation, false>(a) : integrate_checked<S, Rotation, true>(a);
}

}  // namespace talus::kernels
