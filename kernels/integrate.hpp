// Integration of translation and rotation, fused with the displacement check of the pair list (DESIGN 2.7).
//   v(n+1/2) = v(n-1/2) + (F/m + g) dt,  r w(n+1/2) = r w(n-1/2) + 5/2 (T/r)/m dt,  x(n+1) = x(n) + v(n+1/2) dt
// Rows with 1/m = 0 (fixed, driven, removed) keep their velocity. A particle has left its list's guarantee when
// |x - x0|^2 > skin^2 (paper eq. 5 with the capped, stored skin; NaN counts as left).
// Periodic axes wrap by compare (x < 0 => x + L), a rule of the trajectory alone.
#pragma once

#include "kernels/simd.hpp"
#include "kernels/views.hpp"

namespace talus::kernels {

template <class S, bool Rotation>
void integrate(IntegrateArgs& a) {
  constexpr long rows = Rotation ? 8 : 4;
  alignas(64) double mult[8] = {a.kick, a.kick, a.kick, 0, 2.5 * a.kick, 2.5 * a.kick, 2.5 * a.kick, 0};
  alignas(64) double grav[8] = {a.kick * a.gravity[0], a.kick * a.gravity[1], a.kick * a.gravity[2], 0, 0, 0, 0, 0};
  alignas(64) double step[4] = {a.dt, a.dt, a.dt, 0};
  const auto dt = S::load4(step), upper = S::load4(a.upper), wrap = S::load4(a.wrap), half = S::load4(a.half);
  alignas(64) double minus_half_rows[4], nothing[4] = {0, 0, 0, -1e300};
  for (int c = 0; c < 4; ++c) minus_half_rows[c] = -a.half[c];
  const auto minus_half = S::load4(minus_half_rows), zero = S::load4(nothing);
  unsigned periodic = 0;
  for (int c = 0; c < 3; ++c) periodic |= (a.wrap[c] != 0 ? 1U : 0U) << c;
  a.out_count = 0;
  a.expired = 0;
  a.unstable_row = -1;
  int expired = 0;
  for (long i = a.lo; i < a.hi; ++i) {
    const double* vr = a.v + rows * i;
    const double* fr = a.f + rows * i;
    const double invm = vr[Rotation ? 7 : 3];
    const double live = invm > 0 ? 1.0 : 0.0;
    if (fr[3] * invm > a.unstable) a.unstable_row = static_cast<std::int32_t>(i);
    typename S::R4 vel;
    if (a.viscous != 0 || a.local != 0) {  // background damping: rare, scalar, uniform branch
      double f[8], out[8];
      for (int c = 0; c < rows; ++c) f[c] = fr[c];
      for (int c = 0; c < rows; ++c) {
        const double weight = (c < 3) ? a.gravity[c] * live : 0.0;
        double acc = (f[c] * invm) * (c < 3 ? 1.0 : (c >= 4 && c < 7) ? 2.5 : 0.0) + weight;
        const double v = vr[c];
        // Cundall's local damping opposes the motion with a fraction of the resultant; viscous damping is linear in v.
        const double mag = acc < 0 ? -acc : acc;
        if (a.local != 0 && v != 0) acc = acc - (v > 0 ? a.local : -a.local) * mag;
        const bool motion = c < 3 || (c >= 4 && c < 7);
        if (motion) acc = acc - (a.viscous * live) * v;
        out[c] = motion ? v + a.kick * acc : v;
      }
      for (int c = 0; c < rows; ++c) a.v2[rows * i + c] = out[c];
      vel = S::load4(a.v2 + rows * i);
    } else if constexpr (Rotation) {
      auto v = S::load8(vr);
      v = S::add8(v, S::mul8(S::mul8(S::load8(fr), S::set8(invm)), S::load8(mult)));
      v = S::add8(v, S::mul8(S::load8(grav), S::set8(live)));
      S::store8(a.v2 + rows * i, v);
      vel = S::low4(v);
    } else {
      auto v = S::load4(vr);
      v = S::add4(v, S::mul4(S::mul4(S::load4(fr), S::set4(invm)), S::load4(mult)));
      v = S::add4(v, S::mul4(S::load4(grav), S::set4(live)));
      S::store4(a.v2 + rows * i, v);
      vel = v;
    }
    auto x = S::add4(S::load4(a.p + 4 * i), S::mul4(vel, dt));
    const unsigned below = S::lt4(x, zero) & 7U, above = ~S::lt4(x, upper) & 7U;
    if (__builtin_expect((below | above) != 0, 0)) {
      if (((below | above) & periodic) != 0) {
        x = S::add4(x, S::and4(wrap, below & periodic));
        x = S::sub4(x, S::and4(wrap, above & periodic));
      }
      if (((below | above) & ~periodic) != 0 && a.p[4 * i] < 1e100) a.out[a.out_count++] = static_cast<std::int32_t>(i);
    }
    S::store4(a.p2 + 4 * i, x);
    const double* ref = a.x0 + 4 * i;
    auto d = S::sub4(x, S::load4(ref));
    const unsigned far_up = ~S::lt4(d, half) & periodic, far_down = S::lt4(d, minus_half) & periodic;
    if (__builtin_expect((far_up | far_down) != 0, 0)) {
      d = S::sub4(d, S::and4(wrap, far_up));
      d = S::add4(d, S::and4(wrap, far_down));
    }
    d = S::mul4(d, d);
    alignas(32) double q[4];
    S::store4(q, d);
    const double moved = (q[0] + q[1]) + q[2];
    expired |= !(moved <= ref[3]) ? 1 : 0;
  }
  a.expired = expired;
}

}  // namespace talus::kernels
