// Narrow phase: exact touch test of candidate pairs, compaction of the touching ones, where their history is.
// Instantiated by isa_*.cpp. Invariants: I3 (contacts keep the order of the candidates), I5 (history of a pair that
// does not touch is dropped here).
#pragma once

#include "kernels/simd/simd.hpp"
#include "kernels/views.hpp"

namespace talus::kernels {

/// Minimum image by compare and select (DESIGN I4: no rounding functions), on the periodic axes only. A difference
/// within half a period keeps its bits, so the result is that of a scene without the period.
template <class S, bool Periodic = true>
struct MinimumImage {
  typename S::B half[3], period[3];
  bool wraps[3];
  TALUS_INLINE MinimumImage(const double* h, const double* p) {
    if constexpr (Periodic)
      for (int c = 0; c < 3; ++c) {
        half[c] = S::set(h[c]);
        period[c] = S::set(p[c]);
        wraps[c] = p[c] != 0;
      }
  }
  TALUS_INLINE void apply(typename S::B* d) const {
    if constexpr (Periodic)
      for (int c = 0; c < 3; ++c)
        if (wraps[c]) d[c] = S::subtract_where(S::gt(S::abs(d[c]), half[c]), d[c], S::copysign(period[c], d[c]));
  }
};

/// History of eight slots whose touching set changed: kept entries move, new contacts start at zero.
template <class S>
TALUS_INLINE void carry_changed(unsigned old_bits, unsigned new_bits, const double* from, double* to) {
  if constexpr (S::W == 8) {
    S::carry(old_bits, new_bits, from, to);
  } else {
    int o = 0, n = 0;
    for (int k = 0; k < 8; ++k) {
      const unsigned was = (old_bits >> k) & 1U, is = (new_bits >> k) & 1U;
      if (is != 0) to[n++] = was != 0 ? from[o] : 0.0;
      o += static_cast<int>(was);
    }
  }
}

/// Where contacts find their history of the last step, as runs: most groups of eight slots keep their touching set, so
/// the order of the entries changes seldom. The laws read the old columns through it and write new ones; a scene at
/// rest has no run and keeps its columns.
struct RunList {
  HistoryRun* runs;
  std::int32_t count = 0, from = 0, to = 0;  ///< entries before the present slot, of the last step and of this one
  bool fresh = false;                        ///< the last run is one of new contacts

  TALUS_INLINE explicit RunList(HistoryRun* r) : runs(r) {}
  TALUS_INLINE void begin(std::int32_t source) {
    if (count > 0 && runs[count - 1].to == to) --count;  // nothing has followed that one
    runs[count++] = {to, source};
    fresh = source < 0;
  }
  __attribute__((noinline)) void changed(unsigned was, unsigned is) {
    std::int32_t shift = from - to;
    for (unsigned left = was | is; left != 0; left &= left - 1) {
      const unsigned bit = left & (0U - left);
      if ((is & bit) == 0) {
        ++from;
      } else if ((was & bit) == 0) {
        if (!fresh) begin(-1);
        ++to;
      } else {
        if (fresh || from - to != shift) begin(from);
        shift = from - to;
        ++from;
        ++to;
      }
    }
    if (fresh || from - to != shift) begin(from);
  }
  TALUS_INLINE void group(unsigned was, unsigned is) {
    if (__builtin_expect(was == is, 1)) {
      const int n = __builtin_popcount(is);
      from += n;
      to += n;
    } else {
      changed(was, is);
    }
  }
  /// Number of runs; 0 where nothing has moved.
  TALUS_INLINE std::int32_t finish() const { return count > 0 && runs[count - 1].to == to ? count - 1 : count; }
};

inline constexpr std::int64_t k_near = 96,
                              k_far = 512;  ///< slots ahead for rows and for lists (measured at 128k grains)

template <class S, bool History, bool Periodic>
TALUS_INLINE std::int32_t* narrow_section(const NarrowArgs& a, RunList& history, std::int64_t s, std::int64_t end,
                                          std::int32_t* ci, std::int32_t* cj) {
  using B = typename S::B;
  const MinimumImage<S, Periodic> image(a.half, a.period);
  for (; s < end; s += 8) {
    unsigned bits = 0;
    // Partners come in no order a hardware prefetcher knows, and lists are walked in pieces that it loses at page ends.
    __builtin_prefetch(a.pi + s + k_far);
    __builtin_prefetch(a.pj + s + k_far);
    if (s + k_near + 8 <= end)
      for (int k = 0; k < 8; ++k) __builtin_prefetch(a.p + 4L * a.pj[s + k_near + k]);
    for (int k = 0; k < 8; k += S::W) {
      B d[4];
      S::pair_rows4(a.p, a.pi + s + k, a.pj + s + k, d);
      image.apply(d);
      const B d2 = (d[0] * d[0] + d[1] * d[1]) + d[2] * d[2];
      const auto m = S::lt(d2, d[3] * d[3]);
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
    if constexpr (History) history.group(was, bits);
  }
  return ci;
}

template <class S, bool History>
void narrow_slots(NarrowArgs& args) {
  const NarrowArgs a = args;  // a local copy: the stores below cannot alias it
  RunList history(a.runs);
  std::int32_t* ci = a.ci;
  std::int64_t s = 0;
  for (int section = 0; section < 3; ++section) {
    std::int32_t* cj = a.cj + (ci - a.ci);
    if (a.periodic != 0)
      ci = narrow_section<S, History, true>(a, history, s, a.end[section], ci, cj);
    else
      ci = narrow_section<S, History, false>(a, history, s, a.end[section], ci, cj);
    s = a.end[section];
    args.contact_end[section] = ci - a.ci;
  }
  args.run_count = History ? history.finish() : 0;
}

template <class S>
void narrow(NarrowArgs& a) {
  if (a.runs != nullptr)
    narrow_slots<S, true>(a);
  else
    narrow_slots<S, false>(a);
}

/// What every law needs of a contact's geometry, from the centre difference x, the sum of radii w and the sum of
/// inverse masses ms: distance, its inverse, effective mass and the lever d/w, with a single division.
template <class S>
TALUS_INLINE typename S::B store_geometry(const typename S::B* x, typename S::B w, typename S::B ms,
                                          double (*g)[k_block + k_pad], int k) {
  using B = typename S::B;
  const B d2 = (x[0] * x[0] + x[1] * x[1]) + x[2] * x[2];
  B d, inverse, meff, lever;
  if constexpr (S::fast) {
    inverse = S::inverse_sqrt(d2);
    const B rounded = d2 * inverse;
    d = S::select(S::lt(rounded, w), rounded, w);  // a touching pair has no negative overlap
    meff = S::inverse(ms);
    lever = d * S::inverse(w);
  } else {
    d = S::sqrt(d2);
    const B dw = d * w, q = S::set(1.0) / (dw * ms);
    inverse = q * (w * ms);
    meff = q * dw;
    lever = (d * d) * (q * ms);
  }
  S::store(g[0] + k, d);
  S::store(g[1] + k, inverse);
  S::store(g[2] + k, meff);
  S::store(g[3] + k, lever);
  return d;
}

/// Geometry of contacts whose x, w and ms are already in columns (walls).
template <class S>
void geometry(const GeometryArgs& a) {
  for (int k = 0; k < a.n; k += S::W) {
    const typename S::B x[3] = {S::load(a.x + k), S::load(a.y + k), S::load(a.z + k)};
    store_geometry<S>(x, S::load(a.w + k), S::load(a.ms + k), a.g, k);
  }
}

/// Relative position and velocity of a block's contacts and their geometry (and R*, material pair where asked for).
/// Positions are formed again here: storing them compacted in the narrow phase costs more (unaligned 64-byte stores)
/// than two more row loads. Square root and division belong here because this pass is bound by loads and shuffles; in
/// the law they would be what bounds it.
template <class S, bool Rotation, bool Periodic>
void gather_block(GatherArgs& a) {
  using B = typename S::B;
  constexpr int rows = Rotation ? 8 : 4;
  const B deep = S::set(a.deep);
  int touched_deep = 0;
  const MinimumImage<S, Periodic> image(a.half, a.period);
  for (int k = 0; k < a.n; k += S::W) {
    B d[4], r[rows];
    if (k + S::W <= a.next_n) {
      for (int q = k; q < k + S::W; ++q) __builtin_prefetch(a.v + static_cast<long>(rows) * a.next_j[q]);
      if (a.next_i != nullptr)
        for (int q = k; q < k + S::W; q += 4) __builtin_prefetch(a.v + static_cast<long>(rows) * a.next_i[q]);
      if (k % 8 == 0)
        for (int q = 0; q < a.next_columns; ++q) __builtin_prefetch(a.next_h[q] + k, 1);
    }
    S::pair_rows4(a.p, a.i + k, a.j + k, d);
    image.apply(d);
    if constexpr (Rotation)
      S::pair_rows8(a.v, a.i + k, a.j + k, r);
    else
      S::pair_rows4(a.v, a.i + k, a.j + k, r);
    for (int c = 0; c < 4; ++c) S::store(a.x[c] + k, d[c]);
    for (int c = 0; c < rows; ++c) S::store(a.r[c] + k, r[c]);
    const B dist = store_geometry<S>(d, d[3], r[rows - 1], a.g, k);
    touched_deep |= S::any(S::lt(dist, d[3] * deep)) ? 1 : 0;
  }
  a.deep_found |= touched_deep;
  if (a.reff != nullptr)
    for (int k = 0; k < a.n; ++k) {
      const double ri = a.p[4L * a.i[k] + 3], rj = a.p[4L * a.j[k] + 3];
      a.reff[k] = (ri * rj) / (ri + rj);
    }
  if (a.pair != nullptr)
    for (int k = 0; k < a.n; ++k) a.pair[k] = a.material[a.i[k]] * a.materials + a.material[a.j[k]];
}

template <class S, bool Rotation>
void gather(GatherArgs& a) {
  if (a.periodic != 0)
    gather_block<S, Rotation, true>(a);
  else
    gather_block<S, Rotation, false>(a);
}

template <class S, bool Rotation>
TALUS_INLINE void scatter_rows(const ScatterArgs& a, int k, const typename S::B* r, unsigned both) {
  if constexpr (Rotation)
    S::scatter8(a.f, a.i + k, a.j + k, r, both);
  else
    S::scatter4(a.f, a.i + k, a.j + k, r, both);
}

/// Adds the force rows r of contacts k .. k + W to the particles, contact by contact in list order (I3); those from
/// a.n on are padding.
template <class S, bool Rotation>
TALUS_INLINE void scatter_group(const ScatterArgs& a, int k, const typename S::B* r) {
  constexpr int rows = Rotation ? 8 : 4;
  if (k + S::W <= a.n) {
    // constants in the usual cases: the tests per contact vanish
    if (k >= a.both_from && k + S::W <= a.both_to) {
      scatter_rows<S, Rotation>(a, k, r, (1U << S::W) - 1U);
    } else if (k + S::W <= a.both_from || k >= a.both_to) {
      scatter_rows<S, Rotation>(a, k, r, 0U);
    } else {
      unsigned both = 0;
      for (int q = 0; q < S::W; ++q) both |= (k + q >= a.both_from && k + q < a.both_to ? 1U : 0U) << q;
      scatter_rows<S, Rotation>(a, k, r, both);
    }
    return;
  }
  double row[rows][S::W];
  for (int c = 0; c < rows; ++c) S::store(row[c], r[c]);
  for (int q = 0; k + q < a.n; ++q) {
    double* fa = a.f + static_cast<long>(rows) * a.i[k + q];
    for (int c = 0; c < rows; ++c) fa[c] = fa[c] + row[c][q];
    if (k + q >= a.both_from && k + q < a.both_to) {
      double* fb = a.f + static_cast<long>(rows) * a.j[k + q];
      for (int c = 0; c < 3; ++c) fb[c] = fb[c] - row[c][q];
      for (int c = 3; c < rows; ++c) fb[c] = fb[c] + row[c][q];
    }
  }
}

/// Adds the block's force rows to the particles.
template <class S, bool Rotation>
void scatter(const ScatterArgs& a) {
  constexpr int rows = Rotation ? 8 : 4;
  for (int k = 0; k < a.n; k += S::W) {
    typename S::B r[rows];
    for (int c = 0; c < rows; ++c) r[c] = S::load(a.r[c] + k);
    scatter_group<S, Rotation>(a, k, r);
  }
}

}  // namespace talus::kernels
