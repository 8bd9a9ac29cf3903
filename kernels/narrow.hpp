// Narrow phase: exact touch test of candidate pairs, compaction of the touching ones, history carry-over.
// Instantiated by isa_*.cpp. Invariants: I3 (contacts keep the order of the candidates), I5 (history of a pair that
// does not touch is dropped here).
#pragma once

#include "kernels/simd.hpp"
#include "kernels/views.hpp"

namespace talus::kernels {

/// Minimum image by compare and select (DESIGN I4: no rounding functions).
template <class S>
TALUS_INLINE void minimum_image(typename S::B& x, double half, double period) {
  const auto zero = S::set(0.0), l = S::set(period);
  const auto d = x;
  x = d - S::select(S::gt(d, S::set(half)), l, zero) + S::select(S::lt(d, S::set(-half)), l, zero);
}

/// History of eight slots whose touching set changed; kept out of line, or the compiler prepares it for every group.
template <class S>
__attribute__((noinline)) void carry_changed(unsigned old_bits, unsigned new_bits, const double* from, double* to) {
  int o = 0, n = 0;
  for (int k = 0; k < 8; ++k) {
    const unsigned was = (old_bits >> k) & 1U, is = (new_bits >> k) & 1U;
    if (is != 0) to[n++] = was != 0 ? from[o] : 0.0;
    o += static_cast<int>(was);
  }
}

/// Carries one history column of eight slots from the old compact order to the new one; slots that did not touch start
/// at zero. Reads and writes up to eight entries, the padding allows it.
template <class S>
TALUS_INLINE void carry_history(unsigned old_bits, unsigned new_bits, const double* from, double* to) {
  if constexpr (S::W == 8) {
    S::carry(old_bits, new_bits, from, to);
  } else if (old_bits == new_bits) {  // the usual case in dense beds
    for (int k = 0; k < 8; k += S::W) S::store(to + k, S::load(from + k));
  } else {
    carry_changed<S>(old_bits, new_bits, from, to);
  }
}

template <class S, int History, bool Periodic>
void narrow_slots(NarrowArgs& args) {
  using B = typename S::B;
  const NarrowArgs a = args;  // a local copy: the stores below cannot alias it
  std::int32_t *ci = a.ci, *cj = a.cj;
  const double* from[History + 1];
  double* to[History + 1];
  for (int k = 0; k < History; ++k) {
    from[k] = a.h_old[k];
    to[k] = a.h_new[k];
  }
  std::int64_t deep_slot = -1;
  const B deep = S::set(a.deep * a.deep);
  std::int64_t s = 0;
  for (int section = 0; section < 3; ++section) {
    for (; s < a.end[section]; s += 8) {
      unsigned bits = 0;
      for (int k = 0; k < 8; k += S::W) {
        B d[4];
        S::pair_rows4(a.p, a.pi + s + k, a.pj + s + k, d);
        if constexpr (Periodic)
          for (int c = 0; c < 3; ++c) minimum_image<S>(d[c], a.half[c], a.period[c]);
        const B d2 = (d[0] * d[0] + d[1] * d[1]) + d[2] * d[2], w2 = d[3] * d[3];
        const auto m = S::lt(d2, w2);
        if (__builtin_expect(S::any(S::lt(d2, w2 * deep)), 0)) deep_slot = s + k;
        S::compress_index(ci, a.pi + s + k, m);
        S::compress_index(cj, a.pj + s + k, m);
        const unsigned b = S::bits(m);
        const int n = __builtin_popcount(b);
        ci += n;
        cj += n;
        bits |= b << k;
      }
      const unsigned was = a.mask[s >> 3];
      a.mask[s >> 3] = static_cast<std::uint8_t>(bits);
      const int no = __builtin_popcount(was), nn = __builtin_popcount(bits);
      for (int k = 0; k < History; ++k) {
        carry_history<S>(was, bits, from[k], to[k]);
        from[k] += no;
        to[k] += nn;
      }
    }
    args.contact_end[section] = ci - a.ci;
  }
  args.deep_slot = deep_slot;
}

template <class S, bool Periodic>
void narrow_history(NarrowArgs& a) {
  switch (a.history) {
    case 0:
      return narrow_slots<S, 0, Periodic>(a);
    case 3:
      return narrow_slots<S, 3, Periodic>(a);
    default:
      return narrow_slots<S, 4, Periodic>(a);
  }
}

template <class S>
void narrow(NarrowArgs& a) {
  if (a.periodic != 0)
    narrow_history<S, true>(a);
  else
    narrow_history<S, false>(a);
}

/// Relative position and velocity of a block's contacts (and R*, material pair where asked for). Positions are formed
/// again here: storing them compacted in the narrow phase costs more (unaligned 64-byte stores) than two more row
/// loads.
template <class S, bool Rotation>
void gather(const GatherArgs& a) {
  using B = typename S::B;
  constexpr int rows = Rotation ? 8 : 4;
  for (int k = 0; k < a.n; k += S::W) {
    B d[4], r[rows];
    for (int q = k; q < k + S::W && q < a.next_n; ++q) {
      __builtin_prefetch(a.v + static_cast<long>(rows) * a.next_j[q]);
      __builtin_prefetch(a.p + 4L * a.next_j[q]);
    }
    S::pair_rows4(a.p, a.i + k, a.j + k, d);
    if (a.periodic != 0)
      for (int c = 0; c < 3; ++c) minimum_image<S>(d[c], a.half[c], a.period[c]);
    for (int c = 0; c < 4; ++c) S::store(a.x[c] + k, d[c]);
    if constexpr (Rotation)
      S::pair_rows8(a.v, a.i + k, a.j + k, r);
    else
      S::pair_rows4(a.v, a.i + k, a.j + k, r);
    for (int c = 0; c < rows; ++c) S::store(a.r[c] + k, r[c]);
  }
  for (int k = a.n; k < (a.n + 7) / 8 * 8; ++k) {  // padding lanes: a harmless distant pair
    a.x[0][k] = a.x[3][k] = 1;
    a.x[1][k] = a.x[2][k] = 0;
  }
  if (a.reff != nullptr)
    for (int k = 0; k < a.n; ++k) {
      const double ri = a.p[4L * a.i[k] + 3], rj = a.p[4L * a.j[k] + 3];
      a.reff[k] = (ri * rj) / (ri + rj);
    }
  if (a.pair != nullptr)
    for (int k = 0; k < a.n; ++k) a.pair[k] = a.material[a.i[k]] * a.materials + a.material[a.j[k]];
}

/// Adds the block's force rows to the particles, contact by contact in list order (I3).
template <class S, bool Rotation>
void scatter(const ScatterArgs& a) {
  using B = typename S::B;
  constexpr int rows = Rotation ? 8 : 4;
  int k = 0;
  for (; k + S::W <= a.n; k += S::W) {
    B r[rows];
    for (int c = 0; c < rows; ++c) r[c] = S::load(a.r[c] + k);
    bool both[S::W];
    for (int q = 0; q < S::W; ++q) both[q] = k + q >= a.both_from && k + q < a.both_to;
    if constexpr (Rotation)
      S::scatter8(a.f, a.i + k, a.j + k, r, both);
    else
      S::scatter4(a.f, a.i + k, a.j + k, r, both);
  }
  for (; k < a.n; ++k) {
    double* fa = a.f + static_cast<long>(rows) * a.i[k];
    for (int c = 0; c < rows; ++c) fa[c] = fa[c] + a.r[c][k];
    if (k >= a.both_from && k < a.both_to) {
      double* fb = a.f + static_cast<long>(rows) * a.j[k];
      for (int c = 0; c < 3; ++c) fb[c] = fb[c] - a.r[c][k];
      for (int c = 3; c < rows; ++c) fb[c] = fb[c] + a.r[c][k];
    }
  }
}

}  // namespace talus::kernels
