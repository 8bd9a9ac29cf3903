// Powers with the same bits on every instruction set, for any value type of lane.hpp. Who calls it: support.hpp.
// Invariants: + - * / and bit moves only; relative error of power() about 2e-16 (1 + |y log x|).
#pragma once

#include "core/shapes/lane.hpp"

namespace talus::shapes {

/// Natural logarithm of a normal x > 0. See core/base/det_math.cpp for the rounding of the leading term.
template <class S>
TALUS_SHAPES_INLINE typename S::B lane_log(typename S::B x) {
  using B = typename S::B;
  auto [m, e] = S::split(x);
  const auto high = S::gt(m, S::set(1.41421356237309504880));
  m = S::select(high, m * S::set(0.5), m);
  e = S::select(high, e + S::set(1), e);
  const B f = m - S::set(1);
  const B s = f / (f + S::set(2));
  const B z = s * s;
  constexpr double tail[] = {2.0 / 3,  2.0 / 5,  2.0 / 7,  2.0 / 9,  2.0 / 11,
                             2.0 / 13, 2.0 / 15, 2.0 / 17, 2.0 / 19, 2.0 / 21};
  B r = S::set(tail[9]);
  for (int k = 8; k >= 0; --k) r = S::set(tail[k]) + z * r;
  r = z * r;
  const B h = S::set(0.5) * f * f;
  return e * S::set(0x1.62e42fee00000p-1) - ((h - (s * (h + r) + e * S::set(1.90821492927058770002e-10))) - f);
}

/// e^x for x in [-700, 700]; outside it is the value at the border.
template <class S>
TALUS_SHAPES_INLINE typename S::B lane_exp(typename S::B x) {
  using B = typename S::B;
  x = S::select(S::lt(x, S::set(-700)), S::set(-700), x);
  x = S::select(S::gt(x, S::set(700)), S::set(700), x);
  const B magic = S::set(0x1.8p52);
  const B k = (x * S::set(1.44269504088896340736) + magic) - magic;
  const B r = (x - k * S::set(0x1.62e42fee00000p-1)) - k * S::set(1.90821492927058770002e-10);
  constexpr double factorial[] = {1.0 / 2,       1.0 / 6,        1.0 / 24,          1.0 / 120,
                                  1.0 / 720,     1.0 / 5040,     1.0 / 40320,       1.0 / 362880,
                                  1.0 / 3628800, 1.0 / 39916800, 1.0 / 479001600.0, 1.0 / 6227020800.0};
  B t = S::set(factorial[11]);
  for (int i = 10; i >= 0; --i) t = S::set(factorial[i]) + r * t;
  return (S::set(1) + (r + r * r * t)) * S::power_of_two(k);
}

/// x^y for a normal x > 0 and |y log x| < 700. y = 1 gives x itself and y = 1/2 the rounded root: spheres and
/// ellipsoids carry no error of a logarithm, and where all lanes are such, none is computed.
template <class S>
TALUS_SHAPES_INLINE typename S::B power(typename S::B x, typename S::B y) {
  const auto is = [&](double v) { return S::lt(S::abs(y - S::set(v)), S::set(1e-300)); };
  const auto whole = is(1), root = is(0.5);
  const auto simple = S::select(whole, x, S::sqrt(x));
  const auto others = S::select(whole, S::set(0), S::select(root, S::set(0), S::set(1)));
  if (!S::any(S::gt(others, S::set(0.5)))) return simple;
  return S::select(S::gt(others, S::set(0.5)), lane_exp<S>(y * lane_log<S>(x)), simple);
}

}  // namespace talus::shapes
