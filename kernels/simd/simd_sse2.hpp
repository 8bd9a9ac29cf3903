// SIMD shim for SSE2, two lanes. See simd.hpp.
#pragma once

#include "kernels/simd/simd_base.hpp"

namespace talus::simd {

#ifdef __SSE2__
struct Sse2 {
  static constexpr int W = 2;
  static constexpr bool fast = false;  ///< see simd_fast.hpp
  static constexpr const char* name = "sse2";
  using B = xsimd::batch<double, xsimd::sse2>;
  using M = __m128d;
  TALUS_INLINE static B set(double a) { return B(a); }
  TALUS_INLINE static B load(const double* p) { return _mm_loadu_pd(p); }
  TALUS_INLINE static void store(double* p, B a) { _mm_storeu_pd(p, a); }
  TALUS_INLINE static B sqrt(B a) { return _mm_sqrt_pd(a); }
  TALUS_INLINE static B abs(B a) { return _mm_andnot_pd(_mm_set1_pd(-0.0), a); }
  TALUS_INLINE static B copysign(B size, B sign) {
    const __m128d bit = _mm_set1_pd(-0.0);
    return _mm_or_pd(_mm_andnot_pd(bit, size), _mm_and_pd(bit, sign));
  }
  TALUS_INLINE static M lt(B a, B b) { return _mm_cmplt_pd(a, b); }
  TALUS_INLINE static M gt(B a, B b) { return _mm_cmpgt_pd(a, b); }
  TALUS_INLINE static bool any(M m) { return _mm_movemask_pd(m) != 0; }
  TALUS_INLINE static unsigned bits(M m) { return static_cast<unsigned>(_mm_movemask_pd(m)); }
  TALUS_INLINE static B select(M m, B a, B b) { return _mm_or_pd(_mm_and_pd(m, a), _mm_andnot_pd(m, b)); }
  TALUS_INLINE static B subtract_where(M m, B a, B b) { return _mm_sub_pd(a, _mm_and_pd(m, b)); }
  TALUS_INLINE static void two(__m128d r0, __m128d r1, B* o) {
    o[0] = _mm_unpacklo_pd(r0, r1);
    o[1] = _mm_unpackhi_pd(r0, r1);
  }
  TALUS_INLINE static void pair_rows4(const double* p, const std::int32_t* a, const std::int32_t* b, B* o) {
    const double *a0 = p + 4L * a[0], *a1 = p + 4L * a[1], *b0 = p + 4L * b[0], *b1 = p + 4L * b[1];
    const __m128d s = _mm_set_pd(-0.0, 0.0);
    two(_mm_sub_pd(_mm_load_pd(a0), _mm_load_pd(b0)), _mm_sub_pd(_mm_load_pd(a1), _mm_load_pd(b1)), o);
    two(_mm_sub_pd(_mm_load_pd(a0 + 2), _mm_xor_pd(_mm_load_pd(b0 + 2), s)),
        _mm_sub_pd(_mm_load_pd(a1 + 2), _mm_xor_pd(_mm_load_pd(b1 + 2), s)), o + 2);
  }
  TALUS_INLINE static void pair_rows8(const double* p, const std::int32_t* a, const std::int32_t* b, B* o) {
    const double *a0 = p + 8L * a[0], *a1 = p + 8L * a[1], *b0 = p + 8L * b[0], *b1 = p + 8L * b[1];
    for (int k = 0; k < 4; k += 2)
      two(_mm_sub_pd(_mm_load_pd(a0 + k), _mm_load_pd(b0 + k)), _mm_sub_pd(_mm_load_pd(a1 + k), _mm_load_pd(b1 + k)),
          o + k);
    for (int k = 4; k < 8; k += 2)
      two(_mm_add_pd(_mm_load_pd(a0 + k), _mm_load_pd(b0 + k)), _mm_add_pd(_mm_load_pd(a1 + k), _mm_load_pd(b1 + k)),
          o + k);
  }
  TALUS_INLINE static void compress_index(std::int32_t* p, const std::int32_t* src, M m) {
    const unsigned k = bits(m);
    if (k & 1U) *p++ = src[0];
    if (k & 2U) *p = src[1];
  }
  TALUS_INLINE static void add_row(double* f, const __m128d* r, int n, bool minus) {
    const __m128d s01 = _mm_set1_pd(-0.0), s2 = _mm_set_pd(0.0, -0.0);
    for (int k = 0; k < n; ++k) {
      __m128d v = r[k];
      if (minus && k == 0) v = _mm_xor_pd(v, s01);
      if (minus && k == 1) v = _mm_xor_pd(v, s2);
      _mm_store_pd(f + 2 * k, _mm_add_pd(_mm_load_pd(f + 2 * k), v));
    }
  }
  template <int N>
  TALUS_INLINE static void scatter(double* f, const std::int32_t* a, const std::int32_t* b, const B* r, unsigned both) {
    __m128d row0[N / 2], row1[N / 2];
    for (int k = 0; k < N / 2; ++k) {
      row0[k] = _mm_unpacklo_pd(r[2 * k], r[2 * k + 1]);
      row1[k] = _mm_unpackhi_pd(r[2 * k], r[2 * k + 1]);
    }
    add_row(f + static_cast<long>(N) * a[0], row0, N / 2, false);
    if ((both & 1U) != 0) add_row(f + static_cast<long>(N) * b[0], row0, N / 2, true);
    add_row(f + static_cast<long>(N) * a[1], row1, N / 2, false);
    if (((both >> 1) & 1U) != 0) add_row(f + static_cast<long>(N) * b[1], row1, N / 2, true);
  }
  TALUS_INLINE static void scatter8(double* f, const std::int32_t* a, const std::int32_t* b, const B* r,
                                    unsigned both) {
    scatter<8>(f, a, b, r, both);
  }
  TALUS_INLINE static void scatter4(double* f, const std::int32_t* a, const std::int32_t* b, const B* r,
                                    unsigned both) {
    scatter<4>(f, a, b, r, both);
  }
  struct R4 {
    __m128d v[2];
  };
  struct R8 {
    __m128d v[4];
  };
  TALUS_INLINE static R4 add4(const R4& a, const R4& b) {
    return {{_mm_add_pd(a.v[0], b.v[0]), _mm_add_pd(a.v[1], b.v[1])}};
  }
  TALUS_INLINE static R4 sub4(const R4& a, const R4& b) {
    return {{_mm_sub_pd(a.v[0], b.v[0]), _mm_sub_pd(a.v[1], b.v[1])}};
  }
  TALUS_INLINE static R4 mul4(const R4& a, const R4& b) {
    return {{_mm_mul_pd(a.v[0], b.v[0]), _mm_mul_pd(a.v[1], b.v[1])}};
  }
  TALUS_INLINE static R4 load4(const double* p) { return {{_mm_load_pd(p), _mm_load_pd(p + 2)}}; }
  TALUS_INLINE static R4 widen4(const float* p) {
    const __m128 a = _mm_load_ps(p);
    return {{_mm_cvtps_pd(a), _mm_cvtps_pd(_mm_movehl_ps(a, a))}};
  }
  TALUS_INLINE static void store4(double* p, const R4& a) {
    _mm_store_pd(p, a.v[0]);
    _mm_store_pd(p + 2, a.v[1]);
  }
  TALUS_INLINE static void stream4(double* p, const R4& a) {
    _mm_stream_pd(p, a.v[0]);
    _mm_stream_pd(p + 2, a.v[1]);
  }
  TALUS_INLINE static R4 set4(double a) { return {{_mm_set1_pd(a), _mm_set1_pd(a)}}; }
  TALUS_INLINE static bool outside4(const R4& x, const R4& lower, const R4& upper, const R4& d, const R4& half) {
    const __m128d sign = _mm_set1_pd(-0.0);
    __m128d m = _mm_setzero_pd();
    for (int k = 0; k < 2; ++k)
      m = _mm_or_pd(m, _mm_or_pd(_mm_or_pd(_mm_cmplt_pd(x.v[k], lower.v[k]), _mm_cmpnlt_pd(x.v[k], upper.v[k])),
                                 _mm_cmpnlt_pd(_mm_andnot_pd(sign, d.v[k]), half.v[k])));
    return _mm_movemask_pd(m) != 0;
  }
  TALUS_INLINE static unsigned lt4(const R4& a, const R4& b) {
    return static_cast<unsigned>(_mm_movemask_pd(_mm_cmplt_pd(a.v[0], b.v[0])) |
                                 _mm_movemask_pd(_mm_cmplt_pd(a.v[1], b.v[1])) << 2);
  }
  TALUS_INLINE static R4 and4(const R4& a, unsigned m) {
    alignas(16) double t[4];
    store4(t, a);
    for (int k = 0; k < 4; ++k)
      if (!((m >> k) & 1U)) t[k] = 0.0;
    return load4(t);
  }
  TALUS_INLINE static R8 add8(const R8& a, const R8& b) {
    R8 c;
    for (int k = 0; k < 4; ++k) c.v[k] = _mm_add_pd(a.v[k], b.v[k]);
    return c;
  }
  TALUS_INLINE static R8 mul8(const R8& a, const R8& b) {
    R8 c;
    for (int k = 0; k < 4; ++k) c.v[k] = _mm_mul_pd(a.v[k], b.v[k]);
    return c;
  }
  TALUS_INLINE static R8 load8(const double* p) {
    R8 c;
    for (int k = 0; k < 4; ++k) c.v[k] = _mm_load_pd(p + 2 * k);
    return c;
  }
  TALUS_INLINE static void store8(double* p, const R8& a) {
    for (int k = 0; k < 4; ++k) _mm_store_pd(p + 2 * k, a.v[k]);
  }
  TALUS_INLINE static void stream8(double* p, const R8& a) {
    for (int k = 0; k < 4; ++k) _mm_stream_pd(p + 2 * k, a.v[k]);
  }
  TALUS_INLINE static R8 set8(double a) {
    R8 c;
    for (int k = 0; k < 4; ++k) c.v[k] = _mm_set1_pd(a);
    return c;
  }
  TALUS_INLINE static R4 low4(const R8& a) { return {{a.v[0], a.v[1]}}; }
  TALUS_INLINE static double norm3(const R4& a) {
    const __m128d q = _mm_mul_pd(a.v[0], a.v[0]);
    return (_mm_cvtsd_f64(q) + _mm_cvtsd_f64(_mm_unpackhi_pd(q, q))) + _mm_cvtsd_f64(_mm_mul_sd(a.v[1], a.v[1]));
  }
  static constexpr int F = 4;
  using FB = __m128;
  using IB = __m128i;
  TALUS_INLINE static FB fset(float a) { return _mm_set1_ps(a); }
  TALUS_INLINE static FB fload(const float* p) { return _mm_loadu_ps(p); }
  TALUS_INLINE static FB fadd(FB a, FB b) { return _mm_add_ps(a, b); }
  TALUS_INLINE static FB fsub(FB a, FB b) { return _mm_sub_ps(a, b); }
  TALUS_INLINE static FB fmul(FB a, FB b) { return _mm_mul_ps(a, b); }
  TALUS_INLINE static FB fmax(FB a, FB b) { return _mm_max_ps(a, b); }
  TALUS_INLINE static unsigned flt(FB a, FB b) { return static_cast<unsigned>(_mm_movemask_ps(_mm_cmplt_ps(a, b))); }
  TALUS_INLINE static IB iset(std::int32_t a) { return _mm_set1_epi32(a); }
  TALUS_INLINE static IB iload(const std::int32_t* p) { return _mm_loadu_si128(reinterpret_cast<const __m128i*>(p)); }
  TALUS_INLINE static void istore(std::int32_t* p, IB a) { _mm_storeu_si128(reinterpret_cast<__m128i*>(p), a); }
  TALUS_INLINE static IB iadd(IB a, IB b) { return _mm_add_epi32(a, b); }
  TALUS_INLINE static unsigned ilt(IB a, IB b) {
    return static_cast<unsigned>(_mm_movemask_ps(_mm_castsi128_ps(_mm_cmplt_epi32(a, b))));
  }
  TALUS_INLINE static unsigned igtu(IB a, IB b) {
    const __m128i s = _mm_set1_epi32(INT32_MIN);
    return ilt(_mm_xor_si128(b, s), _mm_xor_si128(a, s));
  }
  TALUS_INLINE static void keep(std::int32_t* out, IB v, unsigned m) {
    alignas(16) std::int32_t t[4];
    _mm_store_si128(reinterpret_cast<__m128i*>(t), v);
    for (; m != 0; m &= m - 1) *out++ = t[__builtin_ctz(m)];
  }
  TALUS_INLINE static void keep(float* out, FB v, unsigned m) {
    alignas(16) float t[4];
    _mm_store_ps(t, v);
    for (; m != 0; m &= m - 1) *out++ = t[__builtin_ctz(m)];
  }
  static constexpr int k_sorted = 1;
  TALUS_INLINE static void sort_small(std::int32_t*, int) {}
};
#endif

}  // namespace talus::simd
