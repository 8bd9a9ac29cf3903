// The value type on which the geometry of shapes is written: a struct S with a number B, a mask M and the operations
// below. `Plain` is one double; kernels/bodies has the same for SIMD batches, where a lane is a pair of grains.
// Invariants: every operation is a correctly rounded IEEE one or moves bits, so that all S agree bit for bit (DESIGN
// I4).
#pragma once

#include <bit>
#include <cstdint>

#define TALUS_SHAPES_INLINE inline __attribute__((always_inline))

namespace talus::shapes {

/// x = mantissa * 2^exponent with mantissa in [1, 2); x > 0 and normal.
template <class B>
struct Split {
  B mantissa, exponent;
};

/// One number: the S of set-up code, of the safe method and of tests.
struct Plain {
  static constexpr int W = 1;
  using B = double;
  using M = bool;
  static B set(double a) { return a; }
  static B load(const double* p) { return *p; }
  static void store(double* p, B a) { *p = a; }
  static B sqrt(B a) { return __builtin_sqrt(a); }
  static B abs(B a) { return __builtin_fabs(a); }
  static B copysign(B size, B sign) { return __builtin_copysign(size, sign); }
  static M lt(B a, B b) { return a < b; }
  static M gt(B a, B b) { return a > b; }
  static bool any(M m) { return m; }
  static B select(M m, B a, B b) { return m ? a : b; }
  static B least(B a, B b) { return a < b ? a : b; }  ///< the second where they do not compare
  static B most(B a, B b) { return a > b ? a : b; }
  static Split<B> split(B x) {
    const std::uint64_t bits = std::bit_cast<std::uint64_t>(x);
    const double e = std::bit_cast<double>((bits >> 52) | 0x4330000000000000ULL) - (0x1p52 + 1023);
    return {std::bit_cast<double>((bits & 0x000fffffffffffffULL) | 0x3ff0000000000000ULL), e};
  }
  /// 2^k for a whole number k in [-1022, 1023]; the sum with 1.5 * 2^52 has k in its low bits.
  static B power_of_two(B k) {
    const std::uint64_t bits = std::bit_cast<std::uint64_t>(k + 0x1.8p52);
    return std::bit_cast<double>((bits << 52) + 0x3ff0000000000000ULL);
  }
};

}  // namespace talus::shapes
