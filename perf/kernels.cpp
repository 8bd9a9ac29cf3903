// Microbenchmarks of the kernels, per instruction set, in cache (4k grains) and out of cache (512k), on a real dense
// bed. Who calls it: people who tune the kernels: `perf_kernels --benchmark_filter=avx512`. Beside each result: ns and
// cycles per element (cycles = ns x the clock of a loop of dependent additions timed just before and after), and bytes
// that have to move and floating-point operations per element, so that each kernel can be placed on the roofline whose
// roof `triad` measures in the same program. Invariant: kernels are called through the kernel table, as the engine
// calls them; variants that the engine does not use (split columns) are local to this file.
#include <benchmark/benchmark.h>
#include <immintrin.h>

#include <cstring>
#include <ctime>
#include <memory>

#include "perf/bed.hpp"

namespace {
using namespace talus;
using talus::perf::Bed;

/// CPU time of this thread [ns]: what other programs on the core take does not count (their cache misses still do).
double now_ns() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e9 * static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_nsec);
}

/// Clock of this core now [GHz]: a dependent addition of two registers is one cycle. (Not of an immediate: Golden Cove
/// folds those at rename and would seem to run at 20 GHz.)
double clock_ghz() {
  constexpr int rounds = 20000, adds = 20;
  long x = 1, one = 1;
  const double begin = now_ns();
  for (int k = 0; k < rounds; ++k)
    asm volatile(
        "add %1, %0\n add %1, %0\n add %1, %0\n add %1, %0\n add %1, %0\n add %1, %0\n add %1, %0\n add %1, %0\n"
        "add %1, %0\n add %1, %0\n add %1, %0\n add %1, %0\n add %1, %0\n add %1, %0\n add %1, %0\n add %1, %0\n"
        "add %1, %0\n add %1, %0\n add %1, %0\n add %1, %0\n"
        : "+r"(x)
        : "r"(one));
  const double ns = now_ns() - begin;
  return static_cast<double>(rounds) * adds / ns;
}

/// Runs `body` once per iteration and reports per element; `excluded_ns` per element is taken off (set-up inside body).
template <class F>
void measure(benchmark::State& state, double elements, double bytes, double flops, double excluded_ns, F body) {
  body();  // first touch
  double before = clock_ghz();
  const double begin = now_ns();
  std::int64_t runs = 0;
  for (auto _ : state) {
    body();
    benchmark::ClobberMemory();
    ++runs;
  }
  const double ns = (now_ns() - begin) / static_cast<double>(runs);
  const double ghz = 0.5 * (before + clock_ghz()), each = ns / elements - excluded_ns;
  state.counters["ns"] = each;
  state.counters["cycles"] = each * ghz;
  state.counters["GHz"] = ghz;
  state.counters["bytes"] = bytes;
  state.counters["flops"] = flops;
  state.counters["GB_s"] = bytes / each;
  state.counters["Gflop_s"] = flops / each;
}

Bed& bed_of(bool large) {
  static std::unique_ptr<Bed> beds[2];
  auto& bed = beds[large ? 1 : 0];
  const std::string file = std::string(TALUS_SOURCE_DIR) + "/perf/states/settle32.csv.gz";
  if (!bed) bed = large ? std::make_unique<Bed>(file, 4, 2.0) : std::make_unique<Bed>(file, 1, 0.3536);
  return *bed;
}

using Lanes = double[k_block + k_pad];

/// One block's work in the order of the engine's contact_force node; parts can be left out to time the others.
struct BlockRun {
  alignas(64) Lanes x[4], r[8], e[3], reff;
  explicit BlockRun() { std::fill(reff, reff + k_block + k_pad, 0.25); }

  GatherArgs gather_args(const Bed& b, std::int64_t k0, bool with_reff) {
    GatherArgs g{};
    g.v = b.v.data();
    g.p = b.p.data();
    g.materials = 1;
    g.i = b.ci.data() + k0;
    g.j = b.cj.data() + k0;
    g.n = static_cast<int>(std::min<std::int64_t>(k_block, b.contacts - k0));
    g.x = x;
    g.r = r;
    for (double& half : g.half) half = 1e300;
    g.next_j = g.j + k_block;
    g.next_n = static_cast<int>(std::clamp<std::int64_t>(b.contacts - k0 - k_block, 0, g.n));
    g.reff = with_reff ? reff : nullptr;
    return g;
  }
  Block block(Bed& b, std::int64_t k0, int history) {
    Block q{};
    q.n = static_cast<int>(std::min<std::int64_t>(k_block, b.contacts - k0));
    q.x = x[0];
    q.y = x[1];
    q.z = x[2];
    q.w = x[3];
    q.r = r;
    for (int k = 0; k < history; ++k) q.h[k] = b.h[0][k].data() + k0;
    q.reff = reff;
    q.e = e;
    return q;
  }
  ScatterArgs scatter_args(Bed& b, std::int64_t k0) {
    const int n = static_cast<int>(std::min<std::int64_t>(k_block, b.contacts - k0));
    return {b.f.data(), b.ci.data() + k0, b.cj.data() + k0, n, 0, n, r};
  }
};

struct LawCase {
  const char* name;
  ContactModel model;
  bool friction;
  double flops;  // of the formulas for a sticking contact, counted by hand; sqrt and division count as one
};
constexpr LawCase k_law_cases[] = {{"linear", ContactModel::linear, true, 125},
                                   {"linear_frictionless", ContactModel::linear, false, 28},
                                   {"hertz", ContactModel::hertz_mindlin, true, 135},
                                   {"hertz_frictionless", ContactModel::hertz_mindlin, false, 33}};

LawArgs law_args(const LawCase& c) {
  LawArgs a{};
  const bool linear = c.model == ContactModel::linear;
  a.one.kn = linear ? 2e5 : 1e7;
  a.one.kt = linear ? 57142.857142857145 : 1e7;
  a.one.gn = linear ? 50 : 0.3;
  a.one.gt = linear ? 25 : 0.2;
  a.one.mu = 0.5;
  a.table = &a.one;
  a.dt = 1e-9;  // history must not drift into sliding over millions of repetitions on the same block
  a.centred = a.onset = a.synchronised = a.contact_lever = 1;
  return a;
}

void add(const std::string& name, void (*fn)(benchmark::State&, const KernelTable&, bool), const KernelTable& t,
         bool large) {
  benchmark::RegisterBenchmark((name + "/" + t.name + "/" + (large ? "512k" : "4k")).c_str(),
                               [fn, &t, large](benchmark::State& s) { fn(s, t, large); });
}

void run_search(benchmark::State& state, const KernelTable& t, bool large) {
  Bed& b = bed_of(large);
  const double pairs = static_cast<double>(b.candidates) / b.n;
  // 8 operations per tested candidate in float; the stencil's columns come from cache, each particle's own data once
  measure(state, b.n, 32 + 4 + 20 + 8 * pairs, 10 * b.tested, 0, [&] {
    SearchArgs a = b.search_args();
    t.search(a);
  });
  state.SetLabel(std::to_string(b.tested) + " tested, " + std::to_string(pairs) + " pairs per grain");
}

void run_narrow(benchmark::State& state, const KernelTable& t, bool large) {
  Bed& b = bed_of(large);
  const double share = static_cast<double>(b.contacts) / static_cast<double>(b.candidates);
  const double bytes = 8 + 0.25 + 32.0 * b.n / static_cast<double>(b.candidates) + share * (8 + 6 * 8);
  measure(state, static_cast<double>(b.candidates), bytes, 12, 0, [&] {
    NarrowArgs a = b.narrow_args(3);
    t.narrow(a);
  });
  state.SetLabel("touching: " + std::to_string(share));
}

void run_gather(benchmark::State& state, const KernelTable& t, bool large) {
  Bed& b = bed_of(large);
  auto run = std::make_unique<BlockRun>();
  measure(state, static_cast<double>(b.contacts), 8 + 96.0 * b.n / static_cast<double>(b.contacts), 12, 0, [&] {
    for (std::int64_t k0 = 0; k0 < b.contacts; k0 += k_block) t.gather[1](run->gather_args(b, k0, false));
  });
}

void run_scatter(benchmark::State& state, const KernelTable& t, bool large) {
  Bed& b = bed_of(large);
  auto run = std::make_unique<BlockRun>();
  std::memset(run->r, 0, sizeof run->r);
  measure(state, static_cast<double>(b.contacts), 8 + 128.0 * b.n / static_cast<double>(b.contacts), 14, 0, [&] {
    for (std::int64_t k0 = 0; k0 < b.contacts; k0 += k_block) t.scatter[1](run->scatter_args(b, k0));
  });
}

void run_integrate(benchmark::State& state, const KernelTable& t, bool large) {
  Bed& b = bed_of(large);
  IntegrateArgs a{};
  a.hi = b.n;
  a.p = b.p.data();
  a.v = b.v.data();
  a.f = b.f.data();
  a.p2 = b.p2.data();
  a.v2 = b.v2.data();
  a.x0 = b.x0.data();
  a.dt = a.kick = 1e-4;
  a.gravity[2] = -1;
  for (int k = 0; k < 4; ++k) {
    a.upper[k] = k < 3 ? b.size[k] : 1e300;
    a.half[k] = 1e300;
  }
  a.unstable = 1e300;
  a.out = b.out.data();
  measure(state, b.n, 32 + 64 + 64 + 32 + 32 + 64, 43, 0, [&] { t.integrate[1](a); });
}

template <int Case>
void run_law(benchmark::State& state, const KernelTable& t, bool large) {
  Bed& b = bed_of(large);
  const LawCase& c = k_law_cases[Case];
  const LawInfo& info = law_info(c.model);
  const int history = c.friction ? info.history : 0;
  auto run = std::make_unique<BlockRun>();
  auto kept = std::make_unique<BlockRun>();
  t.gather[1](kept->gather_args(b, 0, false));
  if (!c.friction) std::memcpy(kept->r[3], kept->r[7], sizeof(Lanes));  // without rotation 1/m_i + 1/m_j is in lane 3
  *run = *kept;
  const LawArgs args = law_args(c);
  const auto law = t.law[law_index(info, c.friction, false, false)];
  // The law works in place: its input is put back from a copy in L1. The copy is timed alone and taken off.
  const std::size_t bytes = sizeof(Lanes) * (c.friction ? 8 : 4);
  const auto restore = [&] {
    std::memcpy(run->r, kept->r, bytes);
    benchmark::ClobberMemory();
  };
  const int repeats = 20000;
  const double begin = now_ns();
  for (int k = 0; k < repeats; ++k) restore();
  const double copy = (now_ns() - begin) / repeats / k_block;
  measure(state, static_cast<double>(b.contacts), 16.0 * history, c.flops, copy, [&] {
    for (std::int64_t k0 = 0; k0 < b.contacts; k0 += k_block) {
      restore();
      Block q = run->block(b, k0, history);
      law(q, args);
    }
  });
  state.SetLabel("copy taken off: " + std::to_string(copy) + " ns");
}

/// gather, law and scatter of every contact as the contact_force node runs them.
template <int Case>
void run_force(benchmark::State& state, const KernelTable& t, bool large) {
  Bed& b = bed_of(large);
  const LawCase& c = k_law_cases[Case];
  const LawInfo& info = law_info(c.model);
  const int history = info.history;
  auto run = std::make_unique<BlockRun>();
  const LawArgs args = law_args(c);
  const auto law = t.law[law_index(info, true, false, false)];
  const double rows = static_cast<double>(b.n) / static_cast<double>(b.contacts);
  measure(state, static_cast<double>(b.contacts), 8 + 16.0 * history + (96 + 128) * rows, 12 + c.flops + 14, 0, [&] {
    for (std::int64_t k0 = 0; k0 < b.contacts; k0 += k_block) {
      t.gather[1](run->gather_args(b, k0, info.wants_reff));
      Block q = run->block(b, k0, history);
      law(q, args);
      t.scatter[1](run->scatter_args(b, k0));
    }
  });
}

// ------------------------------------------------------------------------------------ rows against split columns

/// The bed's rows as one array per component.
struct Split {
  Column<double> c[11];  // x y z r, vx vy vz wx wy wz (times r), 1/m
  explicit Split(const Bed& b) {
    for (auto& column : c) column.resize(static_cast<std::size_t>(b.n) + 1);
    for (std::size_t i = 0; i <= static_cast<std::size_t>(b.n); ++i) {
      for (std::size_t k = 0; k < 4; ++k) c[k][i] = b.p[4 * i + k];
      for (std::size_t k = 0; k < 3; ++k) {
        c[4 + k][i] = b.v[8 * i + k];
        c[7 + k][i] = b.v[8 * i + 4 + k];
      }
      c[10][i] = b.v[8 * i + 7];
    }
  }
};

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"  // GCC 12 warns about its own gather intrinsics
/// What `gather` does, from split columns with hardware gathers: positions and velocities of a block's contacts.
__attribute__((target("avx512f,avx512vl"))) void split_gather_avx512(const Split& s, const GatherArgs& a) {
  for (int k = 0; k < a.n; k += 8) {
    const __m256i i = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(a.i + k));
    const __m256i j = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(a.j + k));
    for (int c = 0; c < 11; ++c) {
      const double* column = s.c[c].data();
      const __m512d u = _mm512_i32gather_pd(i, column, 8), w = _mm512_i32gather_pd(j, column, 8);
      double* to = c < 4 ? a.x[c] : a.r[c < 7 ? c - 4 : c - 3];
      _mm512_store_pd(to + k, c == 3 || c > 6 ? _mm512_add_pd(u, w) : _mm512_sub_pd(u, w));
    }
  }
}

__attribute__((target("avx2"))) void split_gather_avx2(const Split& s, const GatherArgs& a) {
  for (int k = 0; k < a.n; k += 4) {
    const __m128i i = _mm_loadu_si128(reinterpret_cast<const __m128i*>(a.i + k));
    const __m128i j = _mm_loadu_si128(reinterpret_cast<const __m128i*>(a.j + k));
    for (int c = 0; c < 11; ++c) {
      const double* column = s.c[c].data();
      const __m256d u = _mm256_i32gather_pd(column, i, 8), w = _mm256_i32gather_pd(column, j, 8);
      double* to = c < 4 ? a.x[c] : a.r[c < 7 ? c - 4 : c - 3];
      _mm256_store_pd(to + k, c == 3 || c > 6 ? _mm256_add_pd(u, w) : _mm256_sub_pd(u, w));
    }
  }
}

#pragma GCC diagnostic pop

void run_split_gather(benchmark::State& state, const KernelTable& t, bool large) {
  Bed& b = bed_of(large);
  const Split split(b);
  auto run = std::make_unique<BlockRun>();
  const auto fn = t.width == 8 ? split_gather_avx512 : split_gather_avx2;
  measure(state, static_cast<double>(b.contacts), 8 + 88.0 * b.n / static_cast<double>(b.contacts), 12, 0, [&] {
    for (std::int64_t k0 = 0; k0 < b.contacts; k0 += k_block) fn(split, run->gather_args(b, k0, false));
  });
}

/// What `scatter` does, into six split force columns.
void run_split_scatter(benchmark::State& state, const KernelTable& t, bool large) {
  Bed& b = bed_of(large);
  Column<double> f[7];
  for (auto& column : f) column.assign(static_cast<std::size_t>(b.n) + 1, 0.0);
  auto run = std::make_unique<BlockRun>();
  std::memset(run->r, 0, sizeof run->r);
  measure(state, static_cast<double>(b.contacts), 8 + 112.0 * b.n / static_cast<double>(b.contacts), 14, 0, [&] {
    for (std::int64_t k0 = 0; k0 < b.contacts; k0 += k_block) {
      const ScatterArgs a = run->scatter_args(b, k0);
      for (int k = 0; k < a.n; ++k) {
        const auto i = static_cast<std::size_t>(a.i[k]), j = static_cast<std::size_t>(a.j[k]);
        for (int c = 0; c < 7; ++c) f[c][i] += a.r[c][k];
        for (int c = 0; c < 7; ++c) f[c][j] += c < 3 ? -a.r[c][k] : a.r[c][k];
      }
    }
  });
}

// ------------------------------------------------------------------------------------------------------- the roof

__attribute__((target_clones("avx512f", "avx2", "default"))) void triad(double* a, const double* b, const double* c,
                                                                        long n) {
  for (long k = 0; k < n; ++k) a[k] = b[k] + 3.0 * c[k];
}

void run_triad(benchmark::State& state, long n) {
  Column<double> a(static_cast<std::size_t>(n), 0.0), b(static_cast<std::size_t>(n), 1.0),
      c(static_cast<std::size_t>(n), 2.0);
  measure(state, static_cast<double>(n), 24, 2, 0, [&] { triad(a.data(), b.data(), c.data(), n); });
}

void register_all() {
  for (const long kib : {24L, 768L, 49152L, 1572864L})  // all three arrays: L1, L2, shared cache, memory
    benchmark::RegisterBenchmark(("triad/" + std::to_string(kib) + "KiB").c_str(),
                                 [kib](benchmark::State& s) { run_triad(s, kib * 1024 / 24); });
  for (const Isa isa : available_isas()) {
    const KernelTable& t = select_kernels(isa);
    for (const bool large : {false, true}) {
      add("search", run_search, t, large);
      add("narrow", run_narrow, t, large);
      add("gather", run_gather, t, large);
      add("law_linear", run_law<0>, t, large);
      add("law_linear_frictionless", run_law<1>, t, large);
      add("law_hertz", run_law<2>, t, large);
      add("law_hertz_frictionless", run_law<3>, t, large);
      add("scatter", run_scatter, t, large);
      add("force_linear", run_force<0>, t, large);
      add("force_hertz", run_force<2>, t, large);
      add("integrate", run_integrate, t, large);
      if (isa == Isa::avx512 || isa == Isa::avx2) add("split_gather", run_split_gather, t, large);
      if (isa == available_isas().front()) add("split_scatter", run_split_scatter, t, large);
    }
  }
}
}  // namespace

int main(int argc, char** argv) {
  register_all();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
