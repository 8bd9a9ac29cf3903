// Broad phase: candidate pairs of one chunk's rows from the hierarchical cell grid. Called per chunk by the rebuild.
// Rows are taken in groups that follow each other in storage and lie close together (storage is Morton sorted): the
// cells around a group's box are read once, what is out of the box's reach or belongs to the other half of an interior
// pair is dropped, the rest is packed into L1 and tested by all rows of the group, F lanes at a time. Rows leave in
// storage order, their partners sorted by storage index (I3), split at the chunk's borders into three sections (I8).
// Every row looks through all levels, so a pair is found from both sides and each owner emits its own side.
// The reaches are inflated by the caller by a bound of all roundings, and every float operation here is monotonic: the
// box never loses a pair that the row's own test would find (I1).
#pragma once

#include "kernels/simd/simd.hpp"
#include "kernels/views.hpp"

namespace talus::kernels {

inline constexpr int k_group = 32;  ///< rows searched together

/// Consecutive rows and their bounding box.
struct RowGroup {
  int size = 0;
  std::int32_t end = 0;  ///< first row behind the group
  std::int32_t row[k_group];
  float x[k_group], y[k_group], z[k_group], r[k_group];
  double lower[3], upper[3];
  float least = 0, most = 0;  ///< reaches
};

/// Takes rows from `from` on while they stay close together.
TALUS_INLINE void take_group(const SearchArgs& a, std::int32_t from, RowGroup& g) {
  g.size = 0;
  g.end = a.hi;
  for (std::int32_t i = from; i < a.hi; ++i) {
    const double* x = a.p + 4L * i;
    if (!(x[0] < 1e100)) continue;  // removed
    const float r = a.reach[i];
    if (g.size == 0) {
      for (int k = 0; k < 3; ++k) g.lower[k] = g.upper[k] = x[k];
      g.least = g.most = r;
    } else {
      double lower[3], upper[3];
      bool fits = g.size < k_group;
      const double limit = static_cast<double>(a.group_extent) * g.most;
      for (int k = 0; k < 3; ++k) {
        lower[k] = x[k] < g.lower[k] ? x[k] : g.lower[k];
        upper[k] = x[k] > g.upper[k] ? x[k] : g.upper[k];
        fits = fits & (upper[k] - lower[k] <= limit);
      }
      const float least = r < g.least ? r : g.least, most = r > g.most ? r : g.most;
      fits = fits & (most <= a.group_ratio * least);
      if (!fits) {
        g.end = i;
        return;
      }
      for (int k = 0; k < 3; ++k) {
        g.lower[k] = lower[k];
        g.upper[k] = upper[k];
      }
      g.least = least;
      g.most = most;
    }
    g.row[g.size] = i;
    g.x[g.size] = static_cast<float>(x[0]);
    g.y[g.size] = static_cast<float>(x[1]);
    g.z[g.size] = static_cast<float>(x[2]);
    g.r[g.size++] = r;
  }
}

/// Cell of a coordinate in cells, clamped to [lowest, highest].
TALUS_INLINE std::int32_t clamp_cell(double c, std::int32_t lowest, std::int32_t highest) {
  if (!(c > lowest)) return lowest;
  if (c >= highest) return highest;
  const auto t = static_cast<std::int32_t>(c);
  return t > c ? t - 1 : t;  // floor, also below zero
}

/// Box of a group and its filter in registers.
template <class S>
struct BoxFilter {
  typename S::FB lower[3], upper[3], reach, zero;
  typename S::IB first, minus_lo;
};

/// Packs the candidates of sorted positions [from, to), moved by `shift`, behind the m present ones.
template <class S>
TALUS_INLINE int pack_range(const SearchArgs& a, const BoxFilter<S>& f, std::int32_t from, std::int32_t to,
                            typename S::FB ox, typename S::FB oy, typename S::FB oz, int m) {
  for (std::int32_t k = from; k < to; k += S::F) {
    const auto x = S::fadd(S::fload(a.x + k), ox), y = S::fadd(S::fload(a.y + k), oy),
               z = S::fadd(S::fload(a.z + k), oz), r = S::fload(a.r + k);
    const auto dx = S::fmax(S::fmax(S::fsub(f.lower[0], x), S::fsub(x, f.upper[0])), f.zero);
    const auto dy = S::fmax(S::fmax(S::fsub(f.lower[1], y), S::fsub(y, f.upper[1])), f.zero);
    const auto dz = S::fmax(S::fmax(S::fsub(f.lower[2], z), S::fsub(z, f.upper[2])), f.zero);
    const auto s = S::fadd(f.reach, r);
    const auto tag = S::iadd(S::iload(a.row + k), f.minus_lo);
    unsigned keep = S::flt(S::fadd(S::fadd(S::fmul(dx, dx), S::fmul(dy, dy)), S::fmul(dz, dz)), S::fmul(s, s)) &
                    S::igtu(tag, f.first);
    if (to - k < S::F) keep &= (1U << (to - k)) - 1U;
    S::keep(a.cx + m, x, keep);
    S::keep(a.cy + m, y, keep);
    S::keep(a.cz + m, z, keep);
    S::keep(a.cr + m, r, keep);
    S::keep(a.tag + m, tag, keep);
    m += __builtin_popcount(keep);
  }
  return m;
}

/// Packs the candidates of one level; -1 where the buffer is too small. `twice` becomes true where the cells wrap onto
/// themselves, so that a particle may come as two images.
template <class S>
TALUS_INLINE int pack_level(const SearchArgs& a, const GridLevel& l, const RowGroup& g, const BoxFilter<S>& f, int m,
                            bool& twice) {
  std::int32_t lo[3], hi[3];
  const double reach = static_cast<double>(g.most) + l.top;
  for (int k = 0; k < 3; ++k) {
    const bool periodic = a.period[k] != 0;
    const std::int32_t lowest = periodic ? -l.n[k] : 0, highest = periodic ? 2 * l.n[k] - 1 : l.n[k] - 1;
    lo[k] = clamp_cell((g.lower[k] - reach) * l.inverse[k], lowest, highest);
    hi[k] = clamp_cell((g.upper[k] + reach) * l.inverse[k], lowest, highest);
    twice = twice | (hi[k] - lo[k] >= l.n[k]);
  }
  for (std::int32_t cz = lo[2]; cz <= hi[2]; ++cz) {
    const std::int32_t wz = cz < 0 ? -1 : (cz >= l.n[2] ? 1 : 0);
    const auto oz = S::fset(static_cast<float>(wz * a.period[2]));
    for (std::int32_t cy = lo[1]; cy <= hi[1]; ++cy) {
      const std::int32_t wy = cy < 0 ? -1 : (cy >= l.n[1] ? 1 : 0);
      const auto oy = S::fset(static_cast<float>(wy * a.period[1]));
      const std::int32_t* pencil =
          a.start + l.first_cell + (static_cast<long>(cz - wz * l.n[2]) * l.n[1] + (cy - wy * l.n[1])) * l.n[0];
      for (std::int32_t cx = lo[0]; cx <= hi[0];) {  // up to three parts: before, in and behind the domain
        const std::int32_t wx = cx < 0 ? -1 : (cx >= l.n[0] ? 1 : 0), last = wx * l.n[0] + l.n[0] - 1;
        const std::int32_t to = last < hi[0] ? last : hi[0];
        const std::int32_t from_position = pencil[cx - wx * l.n[0]], to_position = pencil[to - wx * l.n[0] + 1];
        if (m + (to_position - from_position) > a.candidate_capacity) return -1;
        m = pack_range<S>(a, f, from_position, to_position, S::fset(static_cast<float>(wx * a.period[0])), oy, oz, m);
        cx = to + 1;
      }
    }
  }
  return m;
}

/// Heap sort for the long rows of coarse particles.
TALUS_INLINE void sort_long(std::int32_t* v, int n) {
  const auto sift = [v](int k, int end) {
    const std::int32_t t = v[k];
    for (int c = 2 * k + 1; c < end; c = 2 * k + 1) {
      if (c + 1 < end && v[c + 1] > v[c]) ++c;
      if (v[c] <= t) break;
      v[k] = v[c];
      k = c;
    }
    v[k] = t;
  };
  for (int k = n / 2; k-- > 0;) sift(k, n);
  for (int end = n - 1; end > 0; --end) {
    const std::int32_t t = v[0];
    v[0] = v[end];
    v[end] = t;
    sift(0, end);
  }
}

TALUS_INLINE void sort_row(std::int32_t* v, int n) {
  if (n > 64) return sort_long(v, n);
  for (int k = 1; k < n; ++k) {
    const std::int32_t t = v[k];
    int q = k - 1;
    for (; q >= 0 && v[q] > t; --q) v[q + 1] = v[q];
    v[q + 1] = t;
  }
}

/// Sorts the n hits of row i and appends them to the sections; false where these are full.
template <class S>
TALUS_INLINE bool emit_row(SearchArgs& a, std::int32_t i, int n, bool twice) {
  std::int32_t* v = a.hits;
  if (a.fixed != nullptr && a.fixed[i] != 0) {
    int kept = 0;
    for (int k = 0; k < n; ++k)
      if (a.fixed[v[k] + a.lo] == 0) v[kept++] = v[k];
    n = kept;
  }
  const std::int32_t rows = a.hi - a.lo;
  int part[3];
  if (n <= S::k_sorted) {
    S::sort_small(v, n);
  } else {
    sort_row(v, n);
  }
  if (twice) {
    int kept = 0;
    for (int k = 0; k < n; ++k)
      if (kept == 0 || v[kept - 1] != v[k]) v[kept++] = v[k];
    for (int k = kept; k < n; ++k) v[k] = INT32_MAX;
    n = kept;
  }
  int below = 0, within = 0;
  for (int k = 0; k < n; k += S::F) {
    const unsigned lanes = n - k < S::F ? (1U << (n - k)) - 1U : ~0U;
    const auto t = S::iload(v + k);
    below += __builtin_popcount(S::ilt(t, S::iset(0)) & lanes);
    within += __builtin_popcount(S::ilt(t, S::iset(rows)) & lanes);
  }
  part[0] = below;
  part[1] = within - below;
  part[2] = n - within;
  for (int s = 0; s < 3; ++s)
    if (a.count[s] + part[s] > a.capacity[s]) return false;
  const auto own = S::iset(i), lo = S::iset(a.lo);
  for (int s = 0; s < 3; ++s) {
    std::int32_t *pi = a.si[s] + a.count[s], *pj = a.sj[s] + a.count[s];
    for (int k = 0; k < part[s]; k += S::F) {
      S::istore(pi + k, own);
      S::istore(pj + k, S::iadd(S::iload(v + k), lo));
    }
    v += part[s];
    a.count[s] += part[s];
  }
  return true;
}

template <class S>
void search_rows(SearchArgs& args) {
  SearchArgs a = args;  // a local copy: the stores below cannot alias it
  RowGroup g;
  while (a.next < a.hi) {
    take_group(a, a.next, g);
    if (g.size == 0) {
      a.next = g.end;
      continue;
    }
    BoxFilter<S> f;
    for (int k = 0; k < 3; ++k) {
      f.lower[k] = S::fset(static_cast<float>(g.lower[k]));
      f.upper[k] = S::fset(static_cast<float>(g.upper[k]));
    }
    f.reach = S::fset(g.most);
    f.zero = S::fset(0.0F);
    f.minus_lo = S::iset(-a.lo);
    f.first = S::iset(g.row[0] - a.lo);
    int m = 0;
    bool twice = false, full = false;
    for (int l = 0; l < a.levels && m >= 0; ++l) m = pack_level<S>(a, a.level[l], g, f, m, twice);
    if (m < 0) break;
    for (int k = 0; k < S::F; ++k) a.cx[m + k] = 1e30F;  // padding lanes are out of reach
    for (int k = 0; k < S::F; ++k) a.cy[m + k] = a.cz[m + k] = a.cr[m + k] = 0;
    for (int q = 0; q < g.size; ++q) {
      const auto x = S::fset(g.x[q]), y = S::fset(g.y[q]), z = S::fset(g.z[q]), r = S::fset(g.r[q]);
      const auto own = S::iset(g.row[q] - a.lo);
      int n = 0;
      for (int k = 0; k < m; k += S::F) {
        const auto dx = S::fsub(x, S::fload(a.cx + k)), dy = S::fsub(y, S::fload(a.cy + k)),
                   dz = S::fsub(z, S::fload(a.cz + k)), s = S::fadd(r, S::fload(a.cr + k));
        const auto tag = S::iload(a.tag + k);
        const unsigned hit =
            S::flt(S::fadd(S::fadd(S::fmul(dx, dx), S::fmul(dy, dy)), S::fmul(dz, dz)), S::fmul(s, s)) &
            S::igtu(tag, own);
        S::keep(a.hits + n, tag, hit);
        n += __builtin_popcount(hit);
      }
      if (!emit_row<S>(a, g.row[q], n, twice)) {
        a.next = g.row[q];
        full = true;
        break;
      }
    }
    if (full) break;
    a.next = g.end;
  }
  for (int s = 0; s < 3; ++s) args.count[s] = a.count[s];
  args.next = a.next;
}

}  // namespace talus::kernels
