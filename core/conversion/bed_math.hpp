// exp, log and pow of core/base/det_math for any value type of core/shapes/lane.hpp, with the same bits. Who calls it:
// bed_step.hpp, tests. Invariant: the operations of det_math.cpp in the same order; + - * / and moves of bits only.
#pragma once

#include "core/shapes/lane.hpp"

namespace talus::conversion::bed {

template <class S, class B = typename S::B>
TALUS_SHAPES_INLINE B least(B a, B b) {
  return S::least(a, b);
}
template <class S, class B = typename S::B>
TALUS_SHAPES_INLINE B most(B a, B b) {
  return S::most(a, b);
}
template <class S, class B = typename S::B>
TALUS_SHAPES_INLINE B clamped(B x, B low, B high) {
  return least<S>(most<S>(x, low), high);
}

/// det::exp(x) for |x| <= 700, bit for bit; beyond, that of the nearer end.
template <class S>
TALUS_SHAPES_INLINE typename S::B exponential(typename S::B x) {
  using B = typename S::B;
  constexpr double ln2_hi = 0x1.62e42fee00000p-1, ln2_lo = 1.90821492927058770002e-10;
  x = S::least(S::set(700), S::most(S::set(-700), x));
  const B magic = S::set(0x1.8p52);
  const B k = (x * S::set(1.44269504088896340736) + magic) - magic;
  const B r = (x - k * S::set(ln2_hi)) - k * S::set(ln2_lo);
  B tail = S::set(1.0 / 6227020800.0);
  constexpr double inverse_factorial[] = {1.0 / 2,       1.0 / 6,        1.0 / 24,       1.0 / 120,
                                          1.0 / 720,     1.0 / 5040,     1.0 / 40320,    1.0 / 362880,
                                          1.0 / 3628800, 1.0 / 39916800, 1.0 / 479001600};
#pragma GCC unroll 11
  for (int i = 10; i >= 0; --i) tail = S::set(inverse_factorial[i]) + r * tail;
  const B value = S::set(1) + (r + r * r * tail);
  return value * S::power_of_two(k);
}

/// 2^x = scale + more for x <= 1000, below -1000 as there: scale is a power of two and |more| < scale / 2, so that
/// (1 - scale) - more does not cancel. Relative error of `more` 6e-12, far below that of any rate law: a third of the
/// operations of exponential().
template <class S>
struct PowerOfTwo {
  typename S::B scale, more;
};
template <class S>
TALUS_SHAPES_INLINE PowerOfTwo<S> power_of_two(typename S::B x) {
  using B = typename S::B;
  x = S::most(S::set(-1000), x);
  const B magic = S::set(0x1.8p52), k = (x + magic) - magic, f = x - k;  // |f| <= 1/2
  // (2^f - 1) / f through the Chebyshev points
  constexpr double power[] = {0.6931471805568324,    0.24022650695888503,    0.055504109063258665,  0.00961812913523614,
                              0.0013333478473685416, 0.00015403475186530786, 1.5303700711365693e-05};
  B q = S::set(1.325080551750225e-06);
#pragma GCC unroll 7
  for (int i = 6; i >= 0; --i) q = q * f + S::set(power[i]);
  const B scale = S::power_of_two(k);
  return {scale, scale * (q * f)};
}
inline constexpr double k_per_ln2 = 1.44269504088896340736;

/// det::log(x) for normal x > 0, bit for bit.
template <class S>
TALUS_SHAPES_INLINE typename S::B logarithm(typename S::B x) {
  using B = typename S::B;
  constexpr double ln2_hi = 0x1.62e42fee00000p-1, ln2_lo = 1.90821492927058770002e-10;
  const auto parts = S::split(x);
  const auto high = S::gt(parts.mantissa, S::set(1.41421356237309504880));
  const B m = S::select(high, parts.mantissa * S::set(0.5), parts.mantissa);
  const B e = S::select(high, parts.exponent + S::set(1), parts.exponent);
  const B f = m - S::set(1);
  const B s = f / (S::set(2) + f);
  const B z = s * s;
  B tail = S::set(2.0 / 25);
#pragma GCC unroll 11
  for (int k = 23; k >= 3; k -= 2) tail = S::set(2.0 / k) + z * tail;
  const B r = z * tail;
  const B h = S::set(0.5) * f * f;
  return e * S::set(ln2_hi) - ((h - (s * (h + r) + e * S::set(ln2_lo))) - f);
}

/// det::pow(x, y) for normal x > 0 and y not 0.
template <class S>
TALUS_SHAPES_INLINE typename S::B power(typename S::B x, double y) {
  return exponential<S>(S::set(y) * logarithm<S>(x));
}

}  // namespace talus::conversion::bed
