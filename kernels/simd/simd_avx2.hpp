// SIMD shim for AVX2, four lanes, without FMA. See simd.hpp.
#pragma once

#include "kernels/simd/simd_base.hpp"

namespace talus::simd {

#ifdef __AVX2__
/// Lanes to keep for each mask of eight: byte k holds the lane of the k-th set bit.
struct LaneTable {
  std::uint64_t lanes[256];
};
constexpr LaneTable make_lane_table() {
  LaneTable t{};
  for (unsigned m = 0; m < 256; ++m) {
    int n = 0;
    for (unsigned k = 0; k < 8; ++k)
      if ((m >> k) & 1U) t.lanes[m] |= static_cast<std::uint64_t>(k) << (8 * n++);
  }
  return t;
}
/// Byte shuffles that move the 32-bit lanes chosen by a four-bit mask to the front.
alignas(16) inline constexpr std::int8_t k_compress4[16][16] = {
    {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3},       {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3},
    {4, 5, 6, 7, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3},       {0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3, 0, 1, 2, 3},
    {8, 9, 10, 11, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3},     {0, 1, 2, 3, 8, 9, 10, 11, 0, 1, 2, 3, 0, 1, 2, 3},
    {4, 5, 6, 7, 8, 9, 10, 11, 0, 1, 2, 3, 0, 1, 2, 3},     {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 0, 1, 2, 3},
    {12, 13, 14, 15, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3},   {0, 1, 2, 3, 12, 13, 14, 15, 0, 1, 2, 3, 0, 1, 2, 3},
    {4, 5, 6, 7, 12, 13, 14, 15, 0, 1, 2, 3, 0, 1, 2, 3},   {0, 1, 2, 3, 4, 5, 6, 7, 12, 13, 14, 15, 0, 1, 2, 3},
    {8, 9, 10, 11, 12, 13, 14, 15, 0, 1, 2, 3, 0, 1, 2, 3}, {0, 1, 2, 3, 8, 9, 10, 11, 12, 13, 14, 15, 0, 1, 2, 3},
    {4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 0, 1, 2, 3}, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15},
};

struct Avx2 {
  static constexpr int W = 4;
  static constexpr bool fast = false;  ///< see simd_fast.hpp
  static constexpr const char* name = "avx2";
  using B = xsimd::batch<double, xsimd::avx2>;
  using M = __m256d;
  TALUS_INLINE static B set(double a) { return B(a); }
  TALUS_INLINE static B load(const double* p) { return _mm256_loadu_pd(p); }
  TALUS_INLINE static void store(double* p, B a) { _mm256_storeu_pd(p, a); }
  TALUS_INLINE static B sqrt(B a) { return _mm256_sqrt_pd(a); }
  TALUS_INLINE static B abs(B a) { return _mm256_andnot_pd(_mm256_set1_pd(-0.0), a); }
  TALUS_INLINE static B copysign(B size, B sign) {
    const __m256d bit = _mm256_set1_pd(-0.0);
    return _mm256_or_pd(_mm256_andnot_pd(bit, size), _mm256_and_pd(bit, sign));
  }
  TALUS_INLINE static M lt(B a, B b) { return _mm256_cmp_pd(a, b, _CMP_LT_OQ); }
  TALUS_INLINE static M gt(B a, B b) { return _mm256_cmp_pd(a, b, _CMP_GT_OQ); }
  TALUS_INLINE static bool any(M m) { return _mm256_movemask_pd(m) != 0; }
  TALUS_INLINE static unsigned bits(M m) { return static_cast<unsigned>(_mm256_movemask_pd(m)); }
  TALUS_INLINE static B select(M m, B a, B b) { return _mm256_blendv_pd(b, a, m); }
  TALUS_INLINE static B subtract_where(M m, B a, B b) { return _mm256_sub_pd(a, _mm256_and_pd(m, b)); }
  TALUS_INLINE static void transpose(__m256d& a, __m256d& b, __m256d& c, __m256d& d) {
    const __m256d t0 = _mm256_unpacklo_pd(a, b), t1 = _mm256_unpackhi_pd(a, b);
    const __m256d t2 = _mm256_unpacklo_pd(c, d), t3 = _mm256_unpackhi_pd(c, d);
    a = _mm256_permute2f128_pd(t0, t2, 0x20);
    b = _mm256_permute2f128_pd(t1, t3, 0x20);
    c = _mm256_permute2f128_pd(t0, t2, 0x31);
    d = _mm256_permute2f128_pd(t1, t3, 0x31);
  }
  TALUS_INLINE static void pair_rows4(const double* p, const std::int32_t* a, const std::int32_t* b, B* o) {
    const __m256d s = _mm256_set_pd(-0.0, 0.0, 0.0, 0.0);
    __m256d r[4];
    for (int k = 0; k < 4; ++k)
      r[k] = _mm256_sub_pd(_mm256_load_pd(p + 4L * a[k]), _mm256_xor_pd(_mm256_load_pd(p + 4L * b[k]), s));
    transpose(r[0], r[1], r[2], r[3]);
    for (int k = 0; k < 4; ++k) o[k] = r[k];
  }
  TALUS_INLINE static void pair_rows8(const double* p, const std::int32_t* a, const std::int32_t* b, B* o) {
    __m256d r[4], q[4];
    for (int k = 0; k < 4; ++k) {
      const double *ra = p + 8L * a[k], *rb = p + 8L * b[k];
      r[k] = _mm256_sub_pd(_mm256_load_pd(ra), _mm256_load_pd(rb));
      q[k] = _mm256_add_pd(_mm256_load_pd(ra + 4), _mm256_load_pd(rb + 4));
    }
    transpose(r[0], r[1], r[2], r[3]);
    transpose(q[0], q[1], q[2], q[3]);
    for (int k = 0; k < 4; ++k) {
      o[k] = r[k];
      o[k + 4] = q[k];
    }
  }
  /// Reads and writes four indices whatever the mask says; the padding allows it.
  TALUS_INLINE static void compress_index(std::int32_t* p, const std::int32_t* src, M m) {
    const __m128i v = _mm_loadu_si128(reinterpret_cast<const __m128i*>(src));
    const __m128i order = _mm_load_si128(reinterpret_cast<const __m128i*>(k_compress4[bits(m)]));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(p), _mm_shuffle_epi8(v, order));
  }
  TALUS_INLINE static void scatter8(double* f, const std::int32_t* a, const std::int32_t* b, const B* r,
                                    unsigned both) {
    __m256d p[4] = {r[0], r[1], r[2], r[3]}, q[4] = {r[4], r[5], r[6], r[7]};
    transpose(p[0], p[1], p[2], p[3]);
    transpose(q[0], q[1], q[2], q[3]);
    const __m256d s = _mm256_set_pd(0.0, -0.0, -0.0, -0.0);
    for (int k = 0; k < 4; ++k) {
      double* fa = f + 8L * a[k];
      _mm256_store_pd(fa, _mm256_add_pd(_mm256_load_pd(fa), p[k]));
      _mm256_store_pd(fa + 4, _mm256_add_pd(_mm256_load_pd(fa + 4), q[k]));
      if (((both >> k) & 1U) != 0) {
        double* fb = f + 8L * b[k];
        _mm256_store_pd(fb, _mm256_add_pd(_mm256_load_pd(fb), _mm256_xor_pd(p[k], s)));
        _mm256_store_pd(fb + 4, _mm256_add_pd(_mm256_load_pd(fb + 4), q[k]));
      }
    }
  }
  TALUS_INLINE static void scatter4(double* f, const std::int32_t* a, const std::int32_t* b, const B* r,
                                    unsigned both) {
    __m256d p[4] = {r[0], r[1], r[2], r[3]};
    transpose(p[0], p[1], p[2], p[3]);
    const __m256d s = _mm256_set_pd(0.0, -0.0, -0.0, -0.0);
    for (int k = 0; k < 4; ++k) {
      double* fa = f + 4L * a[k];
      _mm256_store_pd(fa, _mm256_add_pd(_mm256_load_pd(fa), p[k]));
      if (((both >> k) & 1U) != 0) {
        double* fb = f + 4L * b[k];
        _mm256_store_pd(fb, _mm256_add_pd(_mm256_load_pd(fb), _mm256_xor_pd(p[k], s)));
      }
    }
  }
  using R4 = __m256d;
  struct R8 {
    __m256d v[2];
  };
  TALUS_INLINE static R4 add4(R4 a, R4 b) { return _mm256_add_pd(a, b); }
  TALUS_INLINE static R4 sub4(R4 a, R4 b) { return _mm256_sub_pd(a, b); }
  TALUS_INLINE static R4 mul4(R4 a, R4 b) { return _mm256_mul_pd(a, b); }
  TALUS_INLINE static R4 load4(const double* p) { return _mm256_load_pd(p); }
  TALUS_INLINE static R4 widen4(const float* p) { return _mm256_cvtps_pd(_mm_load_ps(p)); }
  TALUS_INLINE static void store4(double* p, R4 a) { _mm256_store_pd(p, a); }
  TALUS_INLINE static void stream4(double* p, R4 a) { _mm256_stream_pd(p, a); }
  TALUS_INLINE static R4 set4(double a) { return _mm256_set1_pd(a); }
  TALUS_INLINE static bool outside4(R4 x, R4 lower, R4 upper, R4 d, R4 half) {
    const __m256d far = _mm256_cmp_pd(_mm256_andnot_pd(_mm256_set1_pd(-0.0), d), half, _CMP_NLT_UQ);
    const __m256d m = _mm256_or_pd(_mm256_cmp_pd(x, lower, _CMP_LT_OQ), _mm256_cmp_pd(x, upper, _CMP_NLT_UQ));
    return _mm256_movemask_pd(_mm256_or_pd(m, far)) != 0;
  }
  TALUS_INLINE static unsigned lt4(R4 a, R4 b) {
    return static_cast<unsigned>(_mm256_movemask_pd(_mm256_cmp_pd(a, b, _CMP_LT_OQ)));
  }
  TALUS_INLINE static R4 and4(R4 a, unsigned m) {
    const __m256i sel = _mm256_sllv_epi64(_mm256_set1_epi64x(m), _mm256_set_epi64x(60, 61, 62, 63));
    return _mm256_blendv_pd(_mm256_setzero_pd(), a, _mm256_castsi256_pd(sel));
  }
  TALUS_INLINE static R8 add8(R8 a, R8 b) { return {{_mm256_add_pd(a.v[0], b.v[0]), _mm256_add_pd(a.v[1], b.v[1])}}; }
  TALUS_INLINE static R8 mul8(R8 a, R8 b) { return {{_mm256_mul_pd(a.v[0], b.v[0]), _mm256_mul_pd(a.v[1], b.v[1])}}; }
  TALUS_INLINE static R8 load8(const double* p) { return {{_mm256_load_pd(p), _mm256_load_pd(p + 4)}}; }
  TALUS_INLINE static void store8(double* p, R8 a) {
    _mm256_store_pd(p, a.v[0]);
    _mm256_store_pd(p + 4, a.v[1]);
  }
  TALUS_INLINE static void stream8(double* p, R8 a) {
    _mm256_stream_pd(p, a.v[0]);
    _mm256_stream_pd(p + 4, a.v[1]);
  }
  TALUS_INLINE static R8 set8(double a) { return {{_mm256_set1_pd(a), _mm256_set1_pd(a)}}; }
  TALUS_INLINE static R4 low4(R8 a) { return a.v[0]; }
  TALUS_INLINE static double norm3(R4 a) {
    const __m256d q = _mm256_mul_pd(a, a);
    const __m128d l = _mm256_castpd256_pd128(q);
    return (_mm_cvtsd_f64(l) + _mm_cvtsd_f64(_mm_unpackhi_pd(l, l))) + _mm_cvtsd_f64(_mm256_extractf128_pd(q, 1));
  }
  static constexpr int F = 8;
  using FB = __m256;
  using IB = __m256i;
  TALUS_INLINE static FB fset(float a) { return _mm256_set1_ps(a); }
  TALUS_INLINE static FB fload(const float* p) { return _mm256_loadu_ps(p); }
  TALUS_INLINE static FB fadd(FB a, FB b) { return _mm256_add_ps(a, b); }
  TALUS_INLINE static FB fsub(FB a, FB b) { return _mm256_sub_ps(a, b); }
  TALUS_INLINE static FB fmul(FB a, FB b) { return _mm256_mul_ps(a, b); }
  TALUS_INLINE static FB fmax(FB a, FB b) { return _mm256_max_ps(a, b); }
  TALUS_INLINE static unsigned flt(FB a, FB b) {
    return static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(a, b, _CMP_LT_OQ)));
  }
  TALUS_INLINE static IB iset(std::int32_t a) { return _mm256_set1_epi32(a); }
  TALUS_INLINE static IB iload(const std::int32_t* p) {
    return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p));
  }
  TALUS_INLINE static void istore(std::int32_t* p, IB a) { _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), a); }
  TALUS_INLINE static IB iadd(IB a, IB b) { return _mm256_add_epi32(a, b); }
  TALUS_INLINE static unsigned ilt(IB a, IB b) {
    return static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpgt_epi32(b, a))));
  }
  TALUS_INLINE static unsigned igtu(IB a, IB b) {
    const __m256i s = _mm256_set1_epi32(INT32_MIN);
    return ilt(_mm256_xor_si256(b, s), _mm256_xor_si256(a, s));
  }
  static constexpr LaneTable lane_table = make_lane_table();
  TALUS_INLINE static __m256i packing(unsigned m) {
    return _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(lane_table.lanes + m)));
  }
  TALUS_INLINE static void keep(float* out, FB v, unsigned m) {
    _mm256_storeu_ps(out, _mm256_permutevar8x32_ps(v, packing(m)));
  }
  TALUS_INLINE static void keep(std::int32_t* out, IB v, unsigned m) {
    istore(out, _mm256_permutevar8x32_epi32(v, packing(m)));
  }
  static constexpr int k_sorted = 8;
  /// Bitonic network over 8 entries; those from n on become INT32_MAX.
  TALUS_INLINE static void sort_small(std::int32_t* p, int n) {
    const __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    __m256i v = _mm256_blendv_epi8(_mm256_set1_epi32(INT32_MAX), iload(p), _mm256_cmpgt_epi32(iset(n), lane));
    __m256i q = _mm256_shuffle_epi32(v, 0xb1);
    v = _mm256_blend_epi32(_mm256_min_epi32(v, q), _mm256_max_epi32(v, q), 0x66);
    q = _mm256_shuffle_epi32(v, 0x4e);
    v = _mm256_blend_epi32(_mm256_min_epi32(v, q), _mm256_max_epi32(v, q), 0x3c);
    q = _mm256_shuffle_epi32(v, 0xb1);
    v = _mm256_blend_epi32(_mm256_min_epi32(v, q), _mm256_max_epi32(v, q), 0x5a);
    q = _mm256_permute4x64_epi64(v, 0x4e);
    v = _mm256_blend_epi32(_mm256_min_epi32(v, q), _mm256_max_epi32(v, q), 0xf0);
    q = _mm256_shuffle_epi32(v, 0x4e);
    v = _mm256_blend_epi32(_mm256_min_epi32(v, q), _mm256_max_epi32(v, q), 0xcc);
    q = _mm256_shuffle_epi32(v, 0xb1);
    v = _mm256_blend_epi32(_mm256_min_epi32(v, q), _mm256_max_epi32(v, q), 0xaa);
    istore(p, v);
  }
};
#endif

}  // namespace talus::simd
