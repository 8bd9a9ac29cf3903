// Elementary functions that give the same bits on every machine: built from + - * / sqrt and integer operations only,
// because the C library picks other code paths when FMA is masked off (DESIGN I4).
// Who calls it: set-up code that feeds the trajectory (damping from restitution, wall motion, random sizes).
// Invariants: no libm except sqrt, no FMA contraction; results within 1e-15 relative where the docstring says so.
#pragma once

#include <cstdint>

namespace talus::det {

inline constexpr double k_pi = 3.14159265358979323846;
inline constexpr double k_ln2 = 0.69314718055994530942;

/// Natural logarithm [-], within 1e-15 relative (absolute next to x = 1: within 1 ulp of the result's own size).
/// x = 0: -infinity; x < 0 or NaN: NaN; +infinity: +infinity. Subnormal arguments are exact.
double log(double x) noexcept;

/// Exponential [-], within 1e-15 relative; overflows to +infinity, underflows gradually to 0.
double exp(double x) noexcept;

struct SinCos {
  double sin, cos;
};
/// Sine and cosine of a phase given in turns (one turn = 2 pi). The reduction to an eighth of a turn is exact for every
/// finite argument, so that quarter turns give exactly 0 and +-1; within 1e-15 relative. Non-finite: NaN.
SinCos sincos_turns(double turns) noexcept;

/// Arc tangent in (-pi/2, pi/2) [rad], within 1e-15 relative; odd in x.
double atan(double x) noexcept;

/// Fractional part in [0, 1), exact: turns - floor(turns), for wall phases that grow with the step number.
double fraction(double turns) noexcept;

/// Cube root, within 1e-15 relative; odd in x; non-finite values pass through.
double cbrt(double x) noexcept;

/// x^y for x >= 0 as exp(y log x): relative error about 1e-16 * (1 + |y log x|). 0^0 = 1. x < 0: NaN.
double pow(double x, double y) noexcept;

/// Nearest integer, halves away from zero (|x| >= 2^62 is clamped; NaN gives 0). Used for round(time / step).
std::int64_t nearest(double x) noexcept;
/// Largest integer <= x with the same clamp.
std::int64_t floor_int(double x) noexcept;

}  // namespace talus::det
