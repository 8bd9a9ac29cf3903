// The body of grain_batch.hpp for one value type: rows of grains are transposed into [place][lane], advanced and put
// back. Included by kernels/isa/grains_*.cpp only.
#pragma once

#include "core/conversion/bed_step.hpp"
#include "kernels/bodies/lanes.hpp"
#include "kernels/conversion/grain_batch.hpp"

namespace talus::kernels {

/// Lanes whose loads and stores are of doubles alone: those of the instruction sets may alias everything, so that every
/// pointer and count would be read again behind every store.
template <class A>
struct GrainLanes : Lanes<A> {
  using B = typename A::B;
  using Register = typename B::register_type;
  using Numbers [[gnu::vector_size(sizeof(double) * A::W), gnu::aligned(alignof(double))]] = double;
  TALUS_INLINE static B load(const double* p) { return B((Register)(*reinterpret_cast<const Numbers*>(p))); }
  TALUS_INLINE static void store(double* p, B a) {
    *reinterpret_cast<Numbers*>(p) = (Numbers) static_cast<Register>(a);
  }
};
template <>
struct GrainLanes<simd::Scalar> : Lanes<simd::Scalar> {};

/// S::W numbers of each of S::W rows, as columns; and back.
template <class A>
struct Transpose;

template <>
struct Transpose<simd::Scalar> {
  TALUS_INLINE static void in(const double* const* row, long at, double* to) { *to = row[0][at]; }
  TALUS_INLINE static void out(const double* from, double* const* row, long at) { row[0][at] = *from; }
};
#ifdef __SSE2__
template <>
struct Transpose<simd::Sse2> {
  TALUS_INLINE static void in(const double* const* row, long at, double* to) {
    const __m128d a = _mm_loadu_pd(row[0] + at), b = _mm_loadu_pd(row[1] + at);
    _mm_storeu_pd(to, _mm_unpacklo_pd(a, b));
    _mm_storeu_pd(to + 2, _mm_unpackhi_pd(a, b));
  }
  TALUS_INLINE static void out(const double* from, double* const* row, long at) {
    const __m128d a = _mm_loadu_pd(from), b = _mm_loadu_pd(from + 2);
    _mm_storeu_pd(row[0] + at, _mm_unpacklo_pd(a, b));
    _mm_storeu_pd(row[1] + at, _mm_unpackhi_pd(a, b));
  }
};
#endif
#ifdef __AVX2__
template <>
struct Transpose<simd::Avx2> {
  TALUS_INLINE static void in(const double* const* row, long at, double* to) {
    __m256d r[4];
    for (int k = 0; k < 4; ++k) r[k] = _mm256_loadu_pd(row[k] + at);
    simd::Avx2::transpose(r[0], r[1], r[2], r[3]);
    for (int k = 0; k < 4; ++k) _mm256_storeu_pd(to + 4 * k, r[k]);
  }
  TALUS_INLINE static void out(const double* from, double* const* row, long at) {
    __m256d r[4];
    for (int k = 0; k < 4; ++k) r[k] = _mm256_loadu_pd(from + 4 * k);
    simd::Avx2::transpose(r[0], r[1], r[2], r[3]);
    for (int k = 0; k < 4; ++k) _mm256_storeu_pd(row[k] + at, r[k]);
  }
};
#endif
#if defined(__AVX512F__) && defined(__AVX512VL__) && defined(__AVX512DQ__)
template <>
struct Transpose<simd::Avx512> {
  TALUS_INLINE static void in(const double* const* row, long at, double* to) {
    __m512d r[8];
    for (int k = 0; k < 8; ++k) r[k] = _mm512_loadu_pd(row[k] + at);
    simd::Avx512::transpose(r);
    for (int k = 0; k < 8; ++k) _mm512_storeu_pd(to + 8 * k, r[k]);
  }
  TALUS_INLINE static void out(const double* from, double* const* row, long at) {
    __m512d r[8];
    for (int k = 0; k < 8; ++k) r[k] = _mm512_loadu_pd(from + 8 * k);
    simd::Avx512::transpose(r);
    for (int k = 0; k < 8; ++k) _mm512_storeu_pd(row[k] + at, r[k]);
  }
};
#endif

/// Lanes behind the last grain repeat it; nothing of them is kept.
template <class A>
void advance_grains(const conversion::BedMatter& matter, const conversion::GrainBatch& batch) {
  using S = GrainLanes<A>;
  constexpr int W = S::W;
  const long size = conversion::bed_row(matter).size;
  double* lanes = batch.scratch + W * conversion::bed_work(matter);
  conversion::bed::Step<S> step(matter, batch);
  for (long at = 0; at < batch.grains; at += W) {
    const long here = batch.grains - at < W ? batch.grains - at : W;
    double *row[W], spare[W * conversion::k_bed_in];
    for (long k = 0; k < W; ++k) row[k] = batch.row[at + (k < here ? k : here - 1)];
    for (long p = 0; p < size; p += W) Transpose<A>::in(row, p, lanes + W * p);
    const double* in = batch.in + at;
    long stride = batch.stride;
    if (here < W) {
      for (long c = 0; c < conversion::k_bed_in; ++c)
        for (long k = 0; k < W; ++k) spare[c * W + k] = in[c * stride + (k < here ? k : here - 1)];
      in = spare;
      stride = W;
    }
    step.advance(lanes, in, stride, batch.out + at, batch.stride);
    if (here == W) {
      for (long p = 0; p < size; p += W) Transpose<A>::out(lanes + W * p, row, p);
    } else {
      for (long k = 0; k < here; ++k)
        for (long p = 0; p < size; ++p) row[k][p] = lanes[W * p + k];
    }
  }
}

}  // namespace talus::kernels
