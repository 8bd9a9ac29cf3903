// What a value type of the grain solvers must offer beside + - * /: comparison, selection, roots, exp. double is here;
// a batch of lanes (lane = grain) brings the same functions in its own namespace. Who calls it: core/heat,
// core/conversion. Invariant: solvers never branch on a value, so that every lane of a batch does what one double does,
// bit for bit.
#pragma once

#include "core/base/det_math.hpp"

namespace talus::heat {

inline bool less(double a, double b) noexcept { return a < b; }
inline bool both(bool a, bool b) noexcept { return a && b; }
inline double select(bool mask, double a, double b) noexcept { return mask ? a : b; }
inline double square_root(double x) noexcept { return __builtin_sqrt(x); }
inline double cube_root(double x) noexcept { return det::cbrt(x); }
inline double exponential(double x) noexcept { return det::exp(x); }
inline double power(double x, double y) noexcept { return det::pow(x, y); }

template <class V>
V least(V a, V b) {
  return select(less(a, b), a, b);
}
template <class V>
V most(V a, V b) {
  return select(less(b, a), a, b);
}
template <class V>
V clamped(V x, V low, V high) {
  return least(most(x, low), high);
}

}  // namespace talus::heat
