// Broad phase: linked-cell search of one chunk's rows. Cells are ordered as Morton-ranked pencils of x-contiguous
// cells, so the 27-cell stencil is 9 contiguous ranges that are tested in place, F float lanes at a time (copying 27
// cells' candidates together first, as the prototype did, costs more than the tests themselves). The float32 reaches
// are inflated by the caller by a bound of all roundings, so no pair within reach is lost (I1). Rows leave sorted by
// storage index (I3), split at the chunk's borders into three sections (I8).
#pragma once

#include "kernels/simd.hpp"
#include "kernels/views.hpp"

namespace talus::kernels {

/// Appends the rows of sorted positions [from, to) within reach that are > i or in a lower chunk (< lo).
template <class S>
TALUS_INLINE int search_range(const SearchArgs& a, std::int32_t from, std::int32_t to, float px, float py, float pz,
                              float pr, std::int32_t i, std::int32_t* out) {
  int n = 0;
  for (std::int32_t k = from; k < to; k += S::F) {
    unsigned m = S::reach(px, py, pz, pr, a.x + k, a.y + k, a.z + k, a.r + k);
    if (to - k < S::F) m &= (1U << (to - k)) - 1U;
    if (m == 0) continue;
    m &= S::index_gt(a.row + k, i) | ~S::index_gt(a.row + k, a.lo - 1);
    n += S::compress_i32(out + n, a.row + k, m);
  }
  return n;
}

/// Insertion sort: rows hold about six nearly random entries.
TALUS_INLINE void sort_row(std::int32_t* v, int n) {
  for (int k = 1; k < n; ++k) {
    const std::int32_t t = v[k];
    int q = k - 1;
    for (; q >= 0 && v[q] > t; --q) v[q + 1] = v[q];
    v[q + 1] = t;
  }
}

TALUS_INLINE std::int32_t cell_of(double x, double inverse, std::int32_t n) {
  const auto c = static_cast<std::int32_t>(x * inverse);
  return c < 0 ? 0 : (c >= n ? n - 1 : c);
}

template <class S>
void search_rows(SearchArgs& a) {
  for (; a.next < a.hi; ++a.next) {
    const std::int32_t i = a.next;
    const double* x = a.p + 4L * i;
    if (!(x[0] < 1e100)) continue;  // removed
    const std::int32_t cx = cell_of(x[0], a.inverse[0], a.n[0]), cy = cell_of(x[1], a.inverse[1], a.n[1]),
                       cz = cell_of(x[2], a.inverse[2], a.n[2]);
    const auto px = static_cast<float>(x[0]), py = static_cast<float>(x[1]), pz = static_cast<float>(x[2]);
    const float pr = a.reach[i];
    int n = 0;
    bool full = false;
    for (int dz = -1; dz <= 1; ++dz) {
      std::int32_t qz = cz + dz;
      float oz = 0;
      if (qz < 0 || qz >= a.n[2]) {
        if (a.period[2] == 0) continue;
        oz = qz < 0 ? a.period[2] : -a.period[2];
        qz = qz < 0 ? a.n[2] - 1 : 0;
      }
      for (int dy = -1; dy <= 1; ++dy) {
        std::int32_t qy = cy + dy;
        float oy = 0;
        if (qy < 0 || qy >= a.n[1]) {
          if (a.period[1] == 0) continue;
          oy = qy < 0 ? a.period[1] : -a.period[1];
          qy = qy < 0 ? a.n[1] - 1 : 0;
        }
        const std::int32_t* cell = a.start + static_cast<long>(a.rank[static_cast<long>(qz) * a.n[1] + qy]) * a.n[0];
        const std::int32_t c0 = cx > 0 ? cx - 1 : 0, c1 = cx + 2 < a.n[0] ? cx + 2 : a.n[0];
        const std::int32_t f = cell[c0], t = cell[c1];
        if (n + (t - f) > a.scratch_capacity) {
          full = true;
          break;
        }
        n += search_range<S>(a, f, t, px, py + oy, pz + oz, pr, i, a.scratch + n);
        if (a.period[0] != 0 && (cx == 0 || cx == a.n[0] - 1)) {
          for (int side = 0; side < 2; ++side) {
            if (side == 0 ? cx != 0 : cx != a.n[0] - 1) continue;
            const std::int32_t q = side == 0 ? a.n[0] - 1 : 0, qf = cell[q], qt = cell[q + 1];
            if (n + (qt - qf) > a.scratch_capacity) {
              full = true;
              break;
            }
            n += search_range<S>(a, qf, qt, px + (side == 0 ? a.period[0] : -a.period[0]), py + oy, pz + oz, pr, i,
                                 a.scratch + n);
          }
        }
      }
      if (full) break;
    }
    if (full) return;
    for (int s = 0; s < 3; ++s)
      if (a.count[s] + n > a.capacity[s]) return;
    sort_row(a.scratch, n);
    const bool fixed = a.fixed != nullptr && a.fixed[i] != 0;
    for (int k = 0; k < n; ++k) {
      const std::int32_t j = a.scratch[k];
      if (fixed && a.fixed[j] != 0) continue;
      const int s = j < a.lo ? 0 : (j < a.hi ? 1 : 2);
      a.si[s][a.count[s]] = i;
      a.sj[s][a.count[s]++] = j;
    }
  }
}

}  // namespace talus::kernels
