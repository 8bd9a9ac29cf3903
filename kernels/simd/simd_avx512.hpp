// SIMD shim for AVX-512 (F, VL, DQ), eight lanes. See simd.hpp.
#pragma once

#include "kernels/simd/simd_base.hpp"

namespace talus::simd {

#if defined(__AVX512F__) && defined(__AVX512VL__) && defined(__AVX512DQ__)
struct Avx512 {
  static constexpr int W = 8;
  static constexpr bool fast = false;  ///< see simd_fast.hpp
  static constexpr const char* name = "avx512";
  using B = xsimd::batch<double, xsimd::avx512f>;
  using M = __mmask8;
  TALUS_INLINE static B set(double a) { return B(a); }
  TALUS_INLINE static B load(const double* p) { return _mm512_loadu_pd(p); }
  TALUS_INLINE static void store(double* p, B a) { _mm512_storeu_pd(p, a); }
  TALUS_INLINE static B sqrt(B a) { return _mm512_sqrt_pd(a); }
  TALUS_INLINE static B abs(B a) { return _mm512_abs_pd(a); }
  TALUS_INLINE static B copysign(B size, B sign) {
    return _mm512_castsi512_pd(_mm512_ternarylogic_epi64(_mm512_set1_epi64(INT64_MIN), _mm512_castpd_si512(sign),
                                                         _mm512_castpd_si512(size), 0xca));
  }
  TALUS_INLINE static M lt(B a, B b) { return _mm512_cmp_pd_mask(a, b, _CMP_LT_OQ); }
  TALUS_INLINE static M gt(B a, B b) { return _mm512_cmp_pd_mask(a, b, _CMP_GT_OQ); }
  TALUS_INLINE static bool any(M m) { return m != 0; }
  TALUS_INLINE static unsigned bits(M m) { return m; }
  TALUS_INLINE static B select(M m, B a, B b) { return _mm512_mask_blend_pd(m, b, a); }
  TALUS_INLINE static B subtract_where(M m, B a, B b) { return _mm512_mask_sub_pd(a, m, a, b); }
  TALUS_INLINE static void pair_rows4(const double* p, const std::int32_t* a, const std::int32_t* b, B* o) {
    const __m512d s = _mm512_castsi512_pd(_mm512_set_epi64(INT64_MIN, 0, 0, 0, INT64_MIN, 0, 0, 0));
    __m512d r[4];  // r[k] holds the rows of pairs k and k + 4
    for (int k = 0; k < 4; ++k) {
      const __m512d va = _mm512_insertf64x4(_mm512_castpd256_pd512(_mm256_load_pd(p + 4L * a[k])),
                                            _mm256_load_pd(p + 4L * a[k + 4]), 1);
      const __m512d vb = _mm512_insertf64x4(_mm512_castpd256_pd512(_mm256_load_pd(p + 4L * b[k])),
                                            _mm256_load_pd(p + 4L * b[k + 4]), 1);
      r[k] = _mm512_sub_pd(va, _mm512_xor_pd(vb, s));
    }
    const __m512d t0 = _mm512_unpacklo_pd(r[0], r[1]), t1 = _mm512_unpackhi_pd(r[0], r[1]);
    const __m512d t2 = _mm512_unpacklo_pd(r[2], r[3]), t3 = _mm512_unpackhi_pd(r[2], r[3]);
    const __m512i lo = _mm512_set_epi64(13, 12, 5, 4, 9, 8, 1, 0), hi = _mm512_set_epi64(15, 14, 7, 6, 11, 10, 3, 2);
    o[0] = _mm512_permutex2var_pd(t0, lo, t2);
    o[1] = _mm512_permutex2var_pd(t1, lo, t3);
    o[2] = _mm512_permutex2var_pd(t0, hi, t2);
    o[3] = _mm512_permutex2var_pd(t1, hi, t3);
  }
  TALUS_INLINE static void transpose(__m512d* r) {
    __m512d t[8], u[8];
    for (int k = 0; k < 8; k += 2) {
      t[k] = _mm512_unpacklo_pd(r[k], r[k + 1]);
      t[k + 1] = _mm512_unpackhi_pd(r[k], r[k + 1]);
    }
    for (int h = 0; h < 8; h += 4)
      for (int k = 0; k < 2; ++k) {
        u[h + k] = _mm512_shuffle_f64x2(t[h + k], t[h + 2 + k], 0x88);      // 128-bit lanes 0, 2 of both
        u[h + 2 + k] = _mm512_shuffle_f64x2(t[h + k], t[h + 2 + k], 0xdd);  // lanes 1, 3
      }
    for (int k = 0; k < 4; ++k) {
      r[k] = _mm512_shuffle_f64x2(u[k], u[k + 4], 0x88);
      r[k + 4] = _mm512_shuffle_f64x2(u[k], u[k + 4], 0xdd);
    }
  }
  TALUS_INLINE static void pair_rows8(const double* p, const std::int32_t* a, const std::int32_t* b, B* o) {
    const __m512d s = _mm512_castsi512_pd(_mm512_set_epi64(0, 0, 0, 0, INT64_MIN, INT64_MIN, INT64_MIN, INT64_MIN));
    __m512d r[8];
    for (int k = 0; k < 8; ++k)
      r[k] = _mm512_add_pd(_mm512_load_pd(p + 8L * a[k]), _mm512_xor_pd(_mm512_load_pd(p + 8L * b[k]), s));
    transpose(r);
    for (int k = 0; k < 8; ++k) o[k] = r[k];
  }
  TALUS_INLINE static void carry(unsigned was, unsigned is, const double* from, double* to) {
    _mm512_storeu_pd(to, _mm512_maskz_compress_pd(static_cast<__mmask8>(is),
                                                  _mm512_maskz_expandloadu_pd(static_cast<__mmask8>(was), from)));
  }
  TALUS_INLINE static void compress_index(std::int32_t* p, const std::int32_t* src, M m) {
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(p),
                        _mm256_maskz_compress_epi32(m, _mm256_loadu_si256(reinterpret_cast<const __m256i*>(src))));
  }
  TALUS_INLINE static void scatter8(double* f, const std::int32_t* a, const std::int32_t* b, const B* in,
                                    unsigned both) {
    __m512d r[8] = {in[0], in[1], in[2], in[3], in[4], in[5], in[6], in[7]};
    transpose(r);
    const __m512d s = _mm512_castsi512_pd(_mm512_set_epi64(0, 0, 0, 0, 0, INT64_MIN, INT64_MIN, INT64_MIN));
    for (int k = 0; k < 8; ++k) {
      double* fa = f + 8L * a[k];
      _mm512_store_pd(fa, _mm512_add_pd(_mm512_load_pd(fa), r[k]));
      if (((both >> k) & 1U) != 0) {
        double* fb = f + 8L * b[k];
        _mm512_store_pd(fb, _mm512_add_pd(_mm512_load_pd(fb), _mm512_xor_pd(r[k], s)));
      }
    }
  }
  TALUS_INLINE static void scatter4(double* f, const std::int32_t* a, const std::int32_t* b, const B* in,
                                    unsigned both) {
    const __m512d t0 = _mm512_unpacklo_pd(in[0], in[1]), t1 = _mm512_unpackhi_pd(in[0], in[1]);
    const __m512d t2 = _mm512_unpacklo_pd(in[2], in[3]), t3 = _mm512_unpackhi_pd(in[2], in[3]);
    const __m256d s = _mm256_castsi256_pd(_mm256_set_epi64x(0, INT64_MIN, INT64_MIN, INT64_MIN));
    const __m512i lo = _mm512_set_epi64(13, 12, 5, 4, 9, 8, 1, 0), hi = _mm512_set_epi64(15, 14, 7, 6, 11, 10, 3, 2);
    const __m512d q[4] = {_mm512_permutex2var_pd(t0, lo, t2), _mm512_permutex2var_pd(t1, lo, t3),
                          _mm512_permutex2var_pd(t0, hi, t2), _mm512_permutex2var_pd(t1, hi, t3)};
    // q[0] = rows 0 and 4, q[1] = 1 and 5, q[2] = 2 and 6, q[3] = 3 and 7
    for (int k = 0; k < 8; ++k) {
      const __m256d row = k < 4 ? _mm512_castpd512_pd256(q[k]) : _mm512_extractf64x4_pd(q[k - 4], 1);
      double* fa = f + 4L * a[k];
      _mm256_store_pd(fa, _mm256_add_pd(_mm256_load_pd(fa), row));
      if (((both >> k) & 1U) != 0) {
        double* fb = f + 4L * b[k];
        _mm256_store_pd(fb, _mm256_add_pd(_mm256_load_pd(fb), _mm256_xor_pd(row, s)));
      }
    }
  }
  using R4 = __m256d;
  using R8 = __m512d;
  TALUS_INLINE static R4 add4(R4 a, R4 b) { return _mm256_add_pd(a, b); }
  TALUS_INLINE static R4 sub4(R4 a, R4 b) { return _mm256_sub_pd(a, b); }
  TALUS_INLINE static R4 mul4(R4 a, R4 b) { return _mm256_mul_pd(a, b); }
  TALUS_INLINE static R4 load4(const double* p) { return _mm256_load_pd(p); }
  TALUS_INLINE static R4 widen4(const float* p) { return _mm256_cvtps_pd(_mm_load_ps(p)); }
  TALUS_INLINE static void store4(double* p, R4 a) { _mm256_store_pd(p, a); }
  TALUS_INLINE static void stream4(double* p, R4 a) { _mm256_stream_pd(p, a); }
  TALUS_INLINE static R4 set4(double a) { return _mm256_set1_pd(a); }
  TALUS_INLINE static bool outside4(R4 x, R4 lower, R4 upper, R4 d, R4 half) {
    // as bit masks of AVX2 form: three masks in k registers would have to be moved one by one
    const __m256d far = _mm256_cmp_pd(_mm256_andnot_pd(_mm256_set1_pd(-0.0), d), half, _CMP_NLT_UQ);
    const __m256d m = _mm256_or_pd(_mm256_cmp_pd(x, lower, _CMP_LT_OQ), _mm256_cmp_pd(x, upper, _CMP_NLT_UQ));
    return _mm256_movemask_pd(_mm256_or_pd(m, far)) != 0;
  }
  TALUS_INLINE static unsigned lt4(R4 a, R4 b) { return _mm256_cmp_pd_mask(a, b, _CMP_LT_OQ); }
  TALUS_INLINE static R4 and4(R4 a, unsigned m) { return _mm256_maskz_mov_pd(static_cast<__mmask8>(m), a); }
  TALUS_INLINE static R8 add8(R8 a, R8 b) { return _mm512_add_pd(a, b); }
  TALUS_INLINE static R8 mul8(R8 a, R8 b) { return _mm512_mul_pd(a, b); }
  TALUS_INLINE static R8 load8(const double* p) { return _mm512_load_pd(p); }
  TALUS_INLINE static void store8(double* p, R8 a) { _mm512_store_pd(p, a); }
  TALUS_INLINE static void stream8(double* p, R8 a) { _mm512_stream_pd(p, a); }
  TALUS_INLINE static R8 set8(double a) { return _mm512_set1_pd(a); }
  TALUS_INLINE static R4 low4(R8 a) { return _mm512_castpd512_pd256(a); }
  TALUS_INLINE static double norm3(R4 a) {
    const __m256d q = _mm256_mul_pd(a, a);
    const __m128d l = _mm256_castpd256_pd128(q);
    return (_mm_cvtsd_f64(l) + _mm_cvtsd_f64(_mm_unpackhi_pd(l, l))) + _mm_cvtsd_f64(_mm256_extractf128_pd(q, 1));
  }
  static constexpr int F = 16;
  using FB = __m512;
  using IB = __m512i;
  TALUS_INLINE static FB fset(float a) { return _mm512_set1_ps(a); }
  TALUS_INLINE static FB fload(const float* p) { return _mm512_loadu_ps(p); }
  TALUS_INLINE static FB fadd(FB a, FB b) { return _mm512_add_ps(a, b); }
  TALUS_INLINE static FB fsub(FB a, FB b) { return _mm512_sub_ps(a, b); }
  TALUS_INLINE static FB fmul(FB a, FB b) { return _mm512_mul_ps(a, b); }
  TALUS_INLINE static FB fmax(FB a, FB b) { return _mm512_max_ps(a, b); }
  TALUS_INLINE static unsigned flt(FB a, FB b) { return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ); }
  TALUS_INLINE static IB iset(std::int32_t a) { return _mm512_set1_epi32(a); }
  TALUS_INLINE static IB iload(const std::int32_t* p) { return _mm512_loadu_si512(p); }
  TALUS_INLINE static void istore(std::int32_t* p, IB a) { _mm512_storeu_si512(p, a); }
  TALUS_INLINE static IB iadd(IB a, IB b) { return _mm512_add_epi32(a, b); }
  TALUS_INLINE static unsigned ilt(IB a, IB b) { return _mm512_cmplt_epi32_mask(a, b); }
  TALUS_INLINE static unsigned igtu(IB a, IB b) { return _mm512_cmpgt_epu32_mask(a, b); }
  TALUS_INLINE static void keep(float* out, FB v, unsigned m) {
    _mm512_storeu_ps(out, _mm512_maskz_compress_ps(static_cast<__mmask16>(m), v));
  }
  TALUS_INLINE static void keep(std::int32_t* out, IB v, unsigned m) {
    istore(out, _mm512_maskz_compress_epi32(static_cast<__mmask16>(m), v));
  }
  static constexpr int k_sorted = 16;
  /// Exchange of one stage of a bitonic network: lanes set in `upper` keep the larger entry.
  TALUS_INLINE static __m256i exchange(__m256i v, __m256i q, unsigned upper) {
    return _mm256_mask_max_epi32(_mm256_min_epi32(v, q), static_cast<__mmask8>(upper), v, q);
  }
  TALUS_INLINE static __m512i exchange(__m512i v, __m512i q, unsigned upper) {
    return _mm512_mask_max_epi32(_mm512_min_epi32(v, q), static_cast<__mmask16>(upper), v, q);
  }
  /// Bitonic network over 8 or 16 entries; those from n on become INT32_MAX.
  TALUS_INLINE static void sort_small(std::int32_t* p, int n) {
    const __m512i top = _mm512_set1_epi32(INT32_MAX);
    __m512i v = _mm512_mask_loadu_epi32(top, static_cast<__mmask16>((1U << n) - 1U), p);
    if (n <= 8) {
      __m256i h = _mm512_castsi512_si256(v);
      h = exchange(h, _mm256_shuffle_epi32(h, 0xb1), 0x66);
      h = exchange(h, _mm256_shuffle_epi32(h, 0x4e), 0x3c);
      h = exchange(h, _mm256_shuffle_epi32(h, 0xb1), 0x5a);
      h = exchange(h, _mm256_permute4x64_epi64(h, 0x4e), 0xf0);
      h = exchange(h, _mm256_shuffle_epi32(h, 0x4e), 0xcc);
      h = exchange(h, _mm256_shuffle_epi32(h, 0xb1), 0xaa);
      istore(p, _mm512_inserti64x4(top, h, 0));
      return;
    }
    v = exchange(v, _mm512_shuffle_epi32(v, _MM_PERM_CDAB), 0x6666);
    v = exchange(v, _mm512_shuffle_epi32(v, _MM_PERM_BADC), 0x3c3c);
    v = exchange(v, _mm512_shuffle_epi32(v, _MM_PERM_CDAB), 0x5a5a);
    v = exchange(v, _mm512_shuffle_i32x4(v, v, 0xb1), 0x0ff0);
    v = exchange(v, _mm512_shuffle_epi32(v, _MM_PERM_BADC), 0x33cc);
    v = exchange(v, _mm512_shuffle_epi32(v, _MM_PERM_CDAB), 0x55aa);
    v = exchange(v, _mm512_shuffle_i32x4(v, v, 0x4e), 0xff00);
    v = exchange(v, _mm512_shuffle_i32x4(v, v, 0xb1), 0xf0f0);
    v = exchange(v, _mm512_shuffle_epi32(v, _MM_PERM_BADC), 0xcccc);
    v = exchange(v, _mm512_shuffle_epi32(v, _MM_PERM_CDAB), 0xaaaa);
    istore(p, v);
  }
};
#endif

}  // namespace talus::simd
