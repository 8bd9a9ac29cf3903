// SIMD shim: what the kernels need beyond xsimd 8.1 (row loads with transposition, compress, expand, bit masks), one
// struct per architecture. Included only by kernel headers, which only isa_*.cpp instantiate, so that no function
// compiled for a newer instruction set can be linked into a path for an older one (everything is a template on or a
// static member of the architecture struct). All lanes compute the same IEEE operations on every architecture.
#pragma once

#include <immintrin.h>

#include <cstdint>
#include <xsimd/xsimd.hpp>

namespace talus::simd {

#define TALUS_INLINE inline __attribute__((always_inline))

/// Scalar "batch" of one lane: the architecture every other one must agree with bit for bit.
struct One {
  double v;
};
TALUS_INLINE One operator+(One a, One b) { return {a.v + b.v}; }
TALUS_INLINE One operator-(One a, One b) { return {a.v - b.v}; }
TALUS_INLINE One operator*(One a, One b) { return {a.v * b.v}; }
TALUS_INLINE One operator/(One a, One b) { return {a.v / b.v}; }

/// Portable implementation on arrays of one lane.
struct Scalar {
  static constexpr int W = 1;
  static constexpr bool fast = false;  ///< IEEE division and root; see simd_fast.hpp
  static constexpr const char* name = "scalar";
  using B = One;
  using M = bool;
  TALUS_INLINE static B set(double a) { return {a}; }
  TALUS_INLINE static B load(const double* p) { return {*p}; }
  TALUS_INLINE static void store(double* p, B a) { *p = a.v; }
  TALUS_INLINE static B sqrt(B a) { return {__builtin_sqrt(a.v)}; }
  TALUS_INLINE static B abs(B a) { return {__builtin_fabs(a.v)}; }
  TALUS_INLINE static B copysign(B size, B sign) { return {__builtin_copysign(size.v, sign.v)}; }
  TALUS_INLINE static M lt(B a, B b) { return a.v < b.v; }
  TALUS_INLINE static M gt(B a, B b) { return a.v > b.v; }
  TALUS_INLINE static bool any(M m) { return m; }
  TALUS_INLINE static unsigned bits(M m) { return m ? 1U : 0U; }
  TALUS_INLINE static B select(M m, B a, B b) { return m ? a : b; }
  /// Differences (x, y, z) and sum (r) of position rows a - b, one lane per pair.
  TALUS_INLINE static void pair_rows4(const double* p, const std::int32_t* a, const std::int32_t* b, B* o) {
    const double *ra = p + 4L * a[0], *rb = p + 4L * b[0];
    for (int k = 0; k < 3; ++k) o[k] = {ra[k] - rb[k]};
    o[3] = {ra[3] + rb[3]};
  }
  /// Rows of 8: lanes 0..3 are differences, 4..7 sums.
  TALUS_INLINE static void pair_rows8(const double* p, const std::int32_t* a, const std::int32_t* b, B* o) {
    const double *ra = p + 8L * a[0], *rb = p + 8L * b[0];
    for (int k = 0; k < 4; ++k) o[k] = {ra[k] - rb[k]};
    for (int k = 4; k < 8; ++k) o[k] = {ra[k] + rb[k]};
  }
  TALUS_INLINE static void compress_index(std::int32_t* p, const std::int32_t* src, M m) {
    if (m) *p = *src;
  }
  /// Adds W force rows of 8 (or 4) lanes to rows of f; bit k of `both`: contact k acts on its partner, too.
  TALUS_INLINE static void scatter8(double* f, const std::int32_t* a, const std::int32_t* b, const B* r,
                                    unsigned both) {
    double* fa = f + 8L * a[0];
    for (int k = 0; k < 8; ++k) fa[k] = fa[k] + r[k].v;
    if ((both & 1U) != 0) {
      double* fb = f + 8L * b[0];
      for (int k = 0; k < 3; ++k) fb[k] = fb[k] - r[k].v;
      for (int k = 3; k < 8; ++k) fb[k] = fb[k] + r[k].v;
    }
  }
  TALUS_INLINE static void scatter4(double* f, const std::int32_t* a, const std::int32_t* b, const B* r,
                                    unsigned both) {
    double* fa = f + 4L * a[0];
    for (int k = 0; k < 4; ++k) fa[k] = fa[k] + r[k].v;
    if ((both & 1U) != 0) {
      double* fb = f + 4L * b[0];
      for (int k = 0; k < 3; ++k) fb[k] = fb[k] - r[k].v;
      fb[3] = fb[3] + r[3].v;
    }
  }
  // Rows for the integrator: 4 and 8 doubles as a unit.
  struct R4 {
    double v[4];
  };
  struct R8 {
    double v[8];
  };
  TALUS_INLINE static R4 add4(const R4& a, const R4& b) {
    R4 c;
    for (int k = 0; k < 4; ++k) c.v[k] = a.v[k] + b.v[k];
    return c;
  }
  TALUS_INLINE static R4 sub4(const R4& a, const R4& b) {
    R4 c;
    for (int k = 0; k < 4; ++k) c.v[k] = a.v[k] - b.v[k];
    return c;
  }
  TALUS_INLINE static R4 mul4(const R4& a, const R4& b) {
    R4 c;
    for (int k = 0; k < 4; ++k) c.v[k] = a.v[k] * b.v[k];
    return c;
  }
  TALUS_INLINE static R4 load4(const double* p) {
    R4 c;
    for (int k = 0; k < 4; ++k) c.v[k] = p[k];
    return c;
  }
  TALUS_INLINE static void store4(double* p, const R4& a) {
    for (int k = 0; k < 4; ++k) p[k] = a.v[k];
  }
  /// Stores around the caches, where the instruction set can.
  TALUS_INLINE static void stream4(double* p, const R4& a) { store4(p, a); }
  TALUS_INLINE static R4 set4(double a) { return {{a, a, a, a}}; }
  /// Whether in any lane x < lower, not x < upper, or not |d| < half (true for NaN).
  TALUS_INLINE static bool outside4(const R4& x, const R4& lower, const R4& upper, const R4& d, const R4& half) {
    bool out = false;
    for (int k = 0; k < 4; ++k)
      out = out || x.v[k] < lower.v[k] || !(x.v[k] < upper.v[k]) || !(__builtin_fabs(d.v[k]) < half.v[k]);
    return out;
  }
  TALUS_INLINE static unsigned lt4(const R4& a, const R4& b) {
    unsigned m = 0;
    for (int k = 0; k < 4; ++k) m |= (a.v[k] < b.v[k] ? 1U : 0U) << k;
    return m;
  }
  TALUS_INLINE static R4 and4(const R4& a, unsigned m) {
    R4 c;
    for (int k = 0; k < 4; ++k) c.v[k] = (m >> k) & 1U ? a.v[k] : 0.0;
    return c;
  }
  TALUS_INLINE static R8 add8(const R8& a, const R8& b) {
    R8 c;
    for (int k = 0; k < 8; ++k) c.v[k] = a.v[k] + b.v[k];
    return c;
  }
  TALUS_INLINE static R8 mul8(const R8& a, const R8& b) {
    R8 c;
    for (int k = 0; k < 8; ++k) c.v[k] = a.v[k] * b.v[k];
    return c;
  }
  TALUS_INLINE static R8 load8(const double* p) {
    R8 c;
    for (int k = 0; k < 8; ++k) c.v[k] = p[k];
    return c;
  }
  TALUS_INLINE static void store8(double* p, const R8& a) {
    for (int k = 0; k < 8; ++k) p[k] = a.v[k];
  }
  TALUS_INLINE static void stream8(double* p, const R8& a) { store8(p, a); }
  TALUS_INLINE static R8 set8(double a) {
    R8 c;
    for (int k = 0; k < 8; ++k) c.v[k] = a;
    return c;
  }
  TALUS_INLINE static R4 low4(const R8& a) { return {{a.v[0], a.v[1], a.v[2], a.v[3]}}; }
  /// (x*x + y*y) + z*z of lanes 0..2.
  TALUS_INLINE static double norm3(const R4& a) { return (a.v[0] * a.v[0] + a.v[1] * a.v[1]) + a.v[2] * a.v[2]; }
  // Pair search: groups of F float candidates and their tags (see kernels/search.hpp).
  static constexpr int F = 1;  ///< float lanes
  using FB = float;
  using IB = std::int32_t;
  TALUS_INLINE static FB fset(float a) { return a; }
  TALUS_INLINE static FB fload(const float* p) { return *p; }
  TALUS_INLINE static FB fadd(FB a, FB b) { return a + b; }
  TALUS_INLINE static FB fsub(FB a, FB b) { return a - b; }
  TALUS_INLINE static FB fmul(FB a, FB b) { return a * b; }
  TALUS_INLINE static FB fmax(FB a, FB b) { return a > b ? a : b; }
  TALUS_INLINE static unsigned flt(FB a, FB b) { return a < b ? 1U : 0U; }
  TALUS_INLINE static IB iset(std::int32_t a) { return a; }
  TALUS_INLINE static IB iload(const std::int32_t* p) { return *p; }
  TALUS_INLINE static void istore(std::int32_t* p, IB a) { *p = a; }
  TALUS_INLINE static IB iadd(IB a, IB b) { return a + b; }
  TALUS_INLINE static unsigned ilt(IB a, IB b) { return a < b ? 1U : 0U; }
  /// As unsigned numbers.
  TALUS_INLINE static unsigned igtu(IB a, IB b) {
    return static_cast<std::uint32_t>(a) > static_cast<std::uint32_t>(b) ? 1U : 0U;
  }
  /// Stores the lanes set in m next to each other; up to F lanes behind them may be overwritten.
  TALUS_INLINE static void keep(float* out, FB v, unsigned m) { *out = v; }
  TALUS_INLINE static void keep(std::int32_t* out, IB v, unsigned m) { *out = v; }
  static constexpr int k_sorted = 1;  ///< entries that sort_small() can sort
  TALUS_INLINE static void sort_small(std::int32_t*, int) {}
};

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
