// SIMD value types for the geometry of shapes (core/shapes/lane.hpp): the shims of kernels/simd and the moves of bits
// that powers need. Included only by units of kernels/isa. Invariant: lane by lane the bits of shapes::Plain.
#pragma once

#include "core/shapes/lane.hpp"
#include "kernels/simd/simd.hpp"

namespace talus::kernels {

/// Bit moves of a shim; specialised per instruction set.
template <class A>
struct LaneBits;

template <>
struct LaneBits<simd::Scalar> {
  using B = simd::One;
  TALUS_INLINE static shapes::Split<B> split(B x) {
    const auto s = shapes::Plain::split(x.v);
    return {{s.mantissa}, {s.exponent}};
  }
  TALUS_INLINE static B power_of_two(B k) { return {shapes::Plain::power_of_two(k.v)}; }
  TALUS_INLINE static B least(B a, B b) { return a.v < b.v ? a : b; }
  TALUS_INLINE static B most(B a, B b) { return a.v > b.v ? a : b; }
};

#ifdef __SSE2__
template <>
struct LaneBits<simd::Sse2> {
  using B = simd::Sse2::B;
  TALUS_INLINE static shapes::Split<B> split(B x) {
    const __m128i bits = _mm_castpd_si128(x);
    const __m128i e = _mm_or_si128(_mm_srli_epi64(bits, 52), _mm_set1_epi64x(0x4330000000000000LL));
    const __m128i m =
        _mm_or_si128(_mm_and_si128(bits, _mm_set1_epi64x(0x000fffffffffffffLL)), _mm_set1_epi64x(0x3ff0000000000000LL));
    return {B(_mm_castsi128_pd(m)), B(_mm_sub_pd(_mm_castsi128_pd(e), _mm_set1_pd(0x1p52 + 1023)))};
  }
  TALUS_INLINE static B power_of_two(B k) {
    const __m128i bits = _mm_castpd_si128(_mm_add_pd(k, _mm_set1_pd(0x1.8p52)));
    return B(_mm_castsi128_pd(_mm_add_epi64(_mm_slli_epi64(bits, 52), _mm_set1_epi64x(0x3ff0000000000000LL))));
  }
  TALUS_INLINE static B least(B a, B b) { return B(_mm_min_pd(a, b)); }
  TALUS_INLINE static B most(B a, B b) { return B(_mm_max_pd(a, b)); }
};
#endif

#ifdef __AVX2__
template <>
struct LaneBits<simd::Avx2> {
  using B = simd::Avx2::B;
  TALUS_INLINE static shapes::Split<B> split(B x) {
    const __m256i bits = _mm256_castpd_si256(x);
    const __m256i e = _mm256_or_si256(_mm256_srli_epi64(bits, 52), _mm256_set1_epi64x(0x4330000000000000LL));
    const __m256i m = _mm256_or_si256(_mm256_and_si256(bits, _mm256_set1_epi64x(0x000fffffffffffffLL)),
                                      _mm256_set1_epi64x(0x3ff0000000000000LL));
    return {B(_mm256_castsi256_pd(m)), B(_mm256_sub_pd(_mm256_castsi256_pd(e), _mm256_set1_pd(0x1p52 + 1023)))};
  }
  TALUS_INLINE static B power_of_two(B k) {
    const __m256i bits = _mm256_castpd_si256(_mm256_add_pd(k, _mm256_set1_pd(0x1.8p52)));
    return B(
        _mm256_castsi256_pd(_mm256_add_epi64(_mm256_slli_epi64(bits, 52), _mm256_set1_epi64x(0x3ff0000000000000LL))));
  }
  TALUS_INLINE static B least(B a, B b) { return B(_mm256_min_pd(a, b)); }
  TALUS_INLINE static B most(B a, B b) { return B(_mm256_max_pd(a, b)); }
};
#endif

#if defined(__AVX512F__) && defined(__AVX512VL__) && defined(__AVX512DQ__)
template <>
struct LaneBits<simd::Avx512> {
  using B = simd::Avx512::B;
  TALUS_INLINE static shapes::Split<B> split(B x) {
    const __m512i bits = _mm512_castpd_si512(x);
    const __m512i e = _mm512_or_si512(_mm512_srli_epi64(bits, 52), _mm512_set1_epi64(0x4330000000000000LL));
    const __m512i m = _mm512_or_si512(_mm512_and_si512(bits, _mm512_set1_epi64(0x000fffffffffffffLL)),
                                      _mm512_set1_epi64(0x3ff0000000000000LL));
    return {B(_mm512_castsi512_pd(m)), B(_mm512_sub_pd(_mm512_castsi512_pd(e), _mm512_set1_pd(0x1p52 + 1023)))};
  }
  TALUS_INLINE static B power_of_two(B k) {
    const __m512i bits = _mm512_castpd_si512(_mm512_add_pd(k, _mm512_set1_pd(0x1.8p52)));
    return B(
        _mm512_castsi512_pd(_mm512_add_epi64(_mm512_slli_epi64(bits, 52), _mm512_set1_epi64(0x3ff0000000000000LL))));
  }
  TALUS_INLINE static B least(B a, B b) { return B(_mm512_min_pd(a, b)); }
  TALUS_INLINE static B most(B a, B b) { return B(_mm512_max_pd(a, b)); }
};
#endif

/// The shim A as a value type of core/shapes.
template <class A>
struct Lanes : A, LaneBits<A> {
  using B = typename A::B;
  using M = typename A::M;
};

}  // namespace talus::kernels
