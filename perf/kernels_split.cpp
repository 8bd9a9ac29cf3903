// Rows against split columns: what `gather` and `scatter` do, from one array per component instead of one row per
// particle; kept so that the choice of rows stays proven. Who calls it: perf/kernels.cpp. Invariant: the same contacts
// of the same bed in the same order as gather and scatter.
#include <immintrin.h>

#include "perf/bed.hpp"
#include "perf/kernels_measure.hpp"

namespace talus::perf {

namespace {

using Lanes = double[k_block + k_pad];

/// The bed's rows as one array per component, and its contacts as one list of absolute rows.
struct Split {
  Column<double> c[11], f[7];  // x y z r, vx vy vz wx wy wz (times r), 1/m; forces, stiffness and torques
  Column<std::int32_t> i, j;
  explicit Split(Bed& b) {
    World& w = b.w;
    const auto rows = static_cast<std::size_t>(w.rows.n) + 1;
    for (auto& column : c) column.resize(rows);
    for (auto& column : f) column.assign(rows, 0.0);
    for (std::size_t q = 0; q < rows; ++q) {
      for (std::size_t k = 0; k < 4; ++k) c[k][q] = w.rows.p[4 * q + k];
      for (std::size_t k = 0; k < 3; ++k) {
        c[4 + k][q] = w.rows.v[8 * q + k];
        c[7 + k][q] = w.rows.v[8 * q + 4 + k];
      }
      c[10][q] = w.rows.v[8 * q + 7];
    }
    for (const auto& chunk : w.contacts.chunks) {
      b.nodes.narrow(*chunk);
      const Scratch& s = *chunk->scratch;
      i.insert(i.end(), s.ci.begin(), s.ci.begin() + chunk->contacts.end[2]);
      j.insert(j.end(), s.cj.begin(), s.cj.begin() + chunk->contacts.end[2]);
      b.nodes.give_back(*chunk);
    }
    i.resize(i.size() / k_block * k_block);
    j.resize(i.size());
  }
  static Split& get(bool large) {
    static std::array<std::unique_ptr<Split>, 2> all;
    auto& split = all[large ? 1 : 0];
    if (!split) split = std::make_unique<Split>(Bed::get(large));
    return *split;
  }
};

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"  // GCC 12 warns about its own gather intrinsics
__attribute__((target("avx512f,avx512vl"))) void gather_avx512(const Split& s, std::size_t k0, Lanes* to) {
  for (std::size_t k = 0; k < k_block; k += 8) {
    const __m256i i = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(s.i.data() + k0 + k));
    const __m256i j = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(s.j.data() + k0 + k));
    for (int c = 0; c < 11; ++c) {
      const double* column = s.c[c].data();
      const __m512d u = _mm512_i32gather_pd(i, column, 8), w = _mm512_i32gather_pd(j, column, 8);
      _mm512_storeu_pd(to[c] + k, c == 3 || c > 6 ? _mm512_add_pd(u, w) : _mm512_sub_pd(u, w));
    }
  }
}

__attribute__((target("avx2"))) void gather_avx2(const Split& s, std::size_t k0, Lanes* to) {
  for (std::size_t k = 0; k < k_block; k += 4) {
    const __m128i i = _mm_loadu_si128(reinterpret_cast<const __m128i*>(s.i.data() + k0 + k));
    const __m128i j = _mm_loadu_si128(reinterpret_cast<const __m128i*>(s.j.data() + k0 + k));
    for (int c = 0; c < 11; ++c) {
      const double* column = s.c[c].data();
      const __m256d u = _mm256_i32gather_pd(column, i, 8), w = _mm256_i32gather_pd(column, j, 8);
      _mm256_storeu_pd(to[c] + k, c == 3 || c > 6 ? _mm256_add_pd(u, w) : _mm256_sub_pd(u, w));
    }
  }
}
#pragma GCC diagnostic pop

void run_gather(benchmark::State& state, const KernelTable& t, bool large) {
  const Split& s = Split::get(large);
  const auto fn = t.width == 8 ? gather_avx512 : gather_avx2;
  static Lanes to[11];
  const auto contacts = static_cast<double>(s.i.size());
  measure(state, t, {"split_gather", contacts, 8 + 88.0 * Bed::get(large).particles / contacts, false},
          [&](const KernelTable&) {
            for (std::size_t k0 = 0; k0 < s.i.size(); k0 += k_block) fn(s, k0, to);
          });
}

void run_scatter(benchmark::State& state, const KernelTable& t, bool large) {
  Split& s = Split::get(large);
  static Lanes r[7];
  const auto contacts = static_cast<double>(s.i.size());
  measure(state, t, {"split_scatter", contacts, 8 + 112.0 * Bed::get(large).particles / contacts, false},
          [&](const KernelTable&) {
            for (std::size_t k0 = 0; k0 < s.i.size(); k0 += k_block)
              for (std::size_t k = 0; k < k_block; ++k) {
                const auto i = static_cast<std::size_t>(s.i[k0 + k]), j = static_cast<std::size_t>(s.j[k0 + k]);
                for (int c = 0; c < 7; ++c) s.f[c][i] += r[c][k];
                for (int c = 0; c < 7; ++c) s.f[c][j] += c < 3 ? -r[c][k] : r[c][k];
              }
          });
}

}  // namespace

void register_split_columns() {
  for (const bool large : {false, true}) {
    for (const Isa isa : available_isas())
      if (isa == Isa::avx512 || isa == Isa::avx2) add("split_gather", select_kernels(isa), large, run_gather);
    add("split_scatter", select_kernels(Isa::automatic), large, run_scatter);
  }
}

}  // namespace talus::perf
