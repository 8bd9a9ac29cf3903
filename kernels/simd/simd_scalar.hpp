// SIMD shim, one lane: the architecture every other one must agree with bit for bit. See simd.hpp.
#pragma once

#include "kernels/simd/simd_base.hpp"

namespace talus::simd {

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
  TALUS_INLINE static B subtract_where(M m, B a, B b) { return m ? a - b : a; }
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
  TALUS_INLINE static R4 widen4(const float* p) {
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
    for (unsigned k = 0; k < 4; ++k)
      if (a.v[k] < b.v[k]) m |= 1U << k;
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
  // Pair search: groups of F float candidates and their tags (see kernels/passes/search.hpp).
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

}  // namespace talus::simd
