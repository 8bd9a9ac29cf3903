// Architectures of precision = "fast": the units that include them contract a * b + c into one rounding, and AVX-512
// forms reciprocals and reciprocal roots from the 14-bit estimates by two Newton steps. Results are still a function of
// the scene and the instruction set alone: every operation is odd in the direction of a pair, so K, list policy, chunks
// and threads leave no trace. AVX2 keeps IEEE division: its estimates differ between vendors.
#pragma once

#include "kernels/simd/simd.hpp"

namespace talus::simd {

#if defined(__AVX2__) && defined(__FMA__)
struct Avx2Fast : Avx2 {
  static constexpr bool contracts = true;
  static constexpr const char* name = "avx2 fast";
};
#endif

#if defined(__AVX512F__) && defined(__AVX512VL__) && defined(__AVX512DQ__)
struct Avx512Fast : Avx512 {
  static constexpr bool contracts = true;
  static constexpr const char* name = "avx512 fast";
  static constexpr bool fast = true;
  /// 1/sqrt(a): 14 -> 28 -> 53 bits, up to 2 ulp off. 0 gives infinity times 0.
  TALUS_INLINE static B inverse_sqrt(B a) {
    const B half = set(0.5) * a, c = set(1.5);
    B y = _mm512_rsqrt14_pd(a);
    y = y * (c - (half * y) * y);
    return y * (c - (half * y) * y);
  }
  /// 1/a, up to 2 ulp off.
  TALUS_INLINE static B inverse(B a) {
    const B two = set(2.0);
    B y = _mm512_rcp14_pd(a);
    y = y * (two - a * y);
    return y * (two - a * y);
  }
};
#endif

}  // namespace talus::simd
