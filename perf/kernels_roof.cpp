// The roofs: STREAM (copy, scale, add, triad; one and two threads) at sizes from L1 to memory, and the peaks of
// arithmetic without fused multiply-add, of division and of the square root, per vector width. Who calls it:
// perf/kernels.cpp. Bytes are counted as STREAM does: what the loop names, not the line that a store fetches first.
#include <fmt/format.h>
#include <immintrin.h>
#include <sched.h>

#include <atomic>
#include <thread>
#include <vector>

#include "core/base/types.hpp"
#include "perf/kernels_measure.hpp"

namespace talus::perf {

namespace {

#define TALUS_CLONES __attribute__((target_clones("avx512f", "avx2", "default"), noinline))
TALUS_CLONES void copy(double* a, const double* b, const double*, long n) {
  for (long k = 0; k < n; ++k) a[k] = b[k];
}
TALUS_CLONES void scale(double* a, const double* b, const double*, long n) {
  for (long k = 0; k < n; ++k) a[k] = 3.0 * b[k];
}
TALUS_CLONES void add_arrays(double* a, const double* b, const double* c, long n) {
  for (long k = 0; k < n; ++k) a[k] = b[k] + c[k];
}
TALUS_CLONES void triad(double* a, const double* b, const double* c, long n) {
  for (long k = 0; k < n; ++k) a[k] = b[k] + 3.0 * c[k];
}

/// Copy with stores that pass the caches by and fetch no line first: what an out-of-place integration could save.
__attribute__((target("sse2"), noinline)) void copy_around(double* a, const double* b, const double*, long n) {
  for (long k = 0; k + 8 <= n; k += 8)
    for (long q = k; q < k + 8; q += 2) _mm_stream_pd(a + q, _mm_load_pd(b + q));
  _mm_sfence();
}

struct StreamCase {
  const char* name;
  void (*run)(double*, const double*, const double*, long);
  double bytes, flops;
};
constexpr StreamCase k_streams[] = {{"stream_copy", copy, 16, 0},
                                    {"stream_scale", scale, 16, 1},
                                    {"stream_add", add_arrays, 24, 1},
                                    {"stream_triad", triad, 24, 2},
                                    {"stream_copy_around", copy_around, 16, 0}};
constexpr long k_sizes[] = {24, 768, 196608, 1572864};  // KiB of three arrays: L1, L2, what 512k grains occupy, memory

/// Three arrays of the last size asked for: the four loops of a size share them.
struct Arrays {
  Column<double> a, b, c;
  static Arrays& get(long n) {
    static Arrays all;
    if (static_cast<long>(all.a.size()) != n) {
      all = {};
      for (auto* q : {&all.a, &all.b, &all.c}) q->assign(static_cast<std::size_t>(n), 1.0);
    }
    return all;
  }
};

void report(benchmark::State& state, double n, double ns_per_pass, double ghz, const StreamCase& s) {
  const double each = ns_per_pass / n;
  state.counters["ns"] = each;
  state.counters["cycles"] = each * ghz;
  state.counters["GHz"] = ghz;
  state.counters["elements"] = n;
  state.counters["bytes"] = s.bytes;
  state.counters["GB_s"] = s.bytes / each;
  state.counters["flops"] = s.flops;
  state.counters["Gflop_s"] = s.flops / each;
}

void run_stream(benchmark::State& state, const StreamCase& s, long kib) {
  const long n = kib * 1024 / 24;
  Arrays& q = Arrays::get(n);
  s.run(q.a.data(), q.b.data(), q.c.data(), n);
  const double before = clock_ghz(), begin = now_ns();
  std::int64_t runs = 0;
  for (auto _ : state) {
    s.run(q.a.data(), q.b.data(), q.c.data(), n);
    benchmark::ClobberMemory();
    ++runs;
  }
  const double ns = (now_ns() - begin) / static_cast<double>(runs);
  report(state, static_cast<double>(n), ns, 0.5 * (before + clock_ghz()), s);
}

/// Two threads, each on a core of its own and on its half of the arrays; wall time of the slower one.
void run_stream_pair(benchmark::State& state, const StreamCase& s, long kib, const cpu_set_t& given) {
  const long n = kib * 1024 / 24, half = n / 2;
  Arrays& q = Arrays::get(n);
  int core[2], found = 0;
  for (int k = 0; k < CPU_SETSIZE && found < 2; ++k)
    if (CPU_ISSET(static_cast<std::size_t>(k), &given)) core[found++] = k;
  const long passes = std::max(1L, static_cast<long>(4e8 / (s.bytes * static_cast<double>(n))));
  double wall = 0;
  std::int64_t runs = 0;
  for (auto _ : state) {
    std::atomic<int> ready{0};
    double begin[2], end[2];
    const auto work = [&](int id) {
      cpu_set_t own;
      CPU_ZERO(&own);
      CPU_SET(static_cast<std::size_t>(core[id]), &own);
      sched_setaffinity(0, sizeof own, &own);
      ++ready;
      while (ready.load() < 2) {
      }
      begin[id] = wall_ns();
      for (long k = 0; k < passes; ++k)
        s.run(q.a.data() + id * half, q.b.data() + id * half, q.c.data() + id * half, half);
      end[id] = wall_ns();
    };
    std::thread other(work, 1);
    std::thread mine(work, 0);  // not this thread: it keeps its own core
    other.join();
    mine.join();
    wall += std::max(end[0], end[1]) - std::min(begin[0], begin[1]);
    ++runs;
  }
  report(state, static_cast<double>(2 * half), wall / static_cast<double>(runs) / static_cast<double>(passes),
         clock_ghz(), s);
}

// Peaks: independent chains in registers. Half additions, half multiplications, none fused (exact mode never fuses).
enum class Peak { arithmetic, division, root };
constexpr int k_chains = 12;

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"  // GCC 12 warns about its own square root
#define TALUS_PEAK(name, isa, V, set, plus, times, over, root)          \
  template <Peak kind>                                                  \
  __attribute__((target(isa), noinline)) void name(long rounds) {       \
    V q[k_chains], one = set(1.0000001);                                \
    for (int c = 0; c < k_chains; ++c) q[c] = set(1.5 + c);             \
    for (long k = 0; k < rounds; ++k) {                                 \
      _Pragma("GCC unroll 12") for (int c = 0; c < k_chains; ++c) {     \
        if constexpr (kind == Peak::arithmetic)                         \
          q[c] = c % 2 == 0 ? plus(q[c], one) : times(q[c], one);       \
        else                                                            \
          q[c] = kind == Peak::division ? over(one, q[c]) : root(q[c]); \
      }                                                                 \
    }                                                                   \
    V sum = q[0];                                                       \
    for (int c = 1; c < k_chains; ++c) sum = plus(sum, q[c]);           \
    asm volatile("" : : "x"(sum));                                      \
  }
TALUS_PEAK(peak_sse2, "sse2", __m128d, _mm_set1_pd, _mm_add_pd, _mm_mul_pd, _mm_div_pd, _mm_sqrt_pd)
TALUS_PEAK(peak_avx2, "avx2", __m256d, _mm256_set1_pd, _mm256_add_pd, _mm256_mul_pd, _mm256_div_pd, _mm256_sqrt_pd)
TALUS_PEAK(peak_avx512, "avx512f", __m512d, _mm512_set1_pd, _mm512_add_pd, _mm512_mul_pd, _mm512_div_pd, _mm512_sqrt_pd)
#undef TALUS_PEAK
#pragma GCC diagnostic pop

template <Peak kind>
void run_peak(benchmark::State& state, const KernelTable& t) {
  const auto fn = t.width == 8 ? peak_avx512<kind> : t.width == 4 ? peak_avx2<kind> : peak_sse2<kind>;
  constexpr long rounds = 2000;
  measure(state, t, {"peak", static_cast<double>(k_chains * rounds * t.width), 0, false},
          [&](const KernelTable&) { fn(rounds); });
  state.counters["flops"] = 1;
  state.counters["Gflop_s"] = 1 / static_cast<double>(state.counters["ns"]);
}

}  // namespace

void register_roofs(const cpu_set_t& given) {
  const int threads = CPU_COUNT(&given);
  for (const long kib : k_sizes)
    for (const StreamCase& s : k_streams) {
      const auto name = [&s, kib](int count) { return fmt::format("{}/{}t/{}KiB", s.name, count, kib); };
      benchmark::RegisterBenchmark(name(1).c_str(), [&s, kib](benchmark::State& state) { run_stream(state, s, kib); });
      if (threads > 1)
        benchmark::RegisterBenchmark(name(2).c_str(), [&s, kib, given](benchmark::State& state) {
          run_stream_pair(state, s, kib, given);
        })->UseRealTime();
    }
  for (const Isa isa : available_isas()) {
    if (isa == Isa::scalar) continue;
    const auto row = [isa](const char* name, auto run) {
      const KernelTable& t = select_kernels(isa);
      benchmark::RegisterBenchmark((std::string(name) + "/" + t.name).c_str(),
                                   [run, &t](benchmark::State& s) { run(s, t); });
    };
    row("peak_arithmetic", run_peak<Peak::arithmetic>);
    row("peak_division", run_peak<Peak::division>);
    row("peak_root", run_peak<Peak::root>);
  }
}

}  // namespace talus::perf
