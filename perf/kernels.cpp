// Microbenchmarks of every kernel, per instruction set, in cache (4k grains) and out of cache (512k), with the roof
// (STREAM and arithmetic peaks) in the same run. Who calls it: people who tune the kernels, and perf/roofline.py:
// `perf_kernels --benchmark_filter=avx512 --benchmark_format=json`. Invariant: kernels run through the kernel table and
// the chunk functions, as in a step; nothing of the engine is copied here.
#include <sched.h>

#include <ctime>

#include "perf/kernels_measure.hpp"

namespace talus::perf {

double now_ns() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e9 * static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_nsec);
}

double wall_ns() {
  return std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// A dependent addition of two registers is one cycle. (Not of an immediate: recent cores fold those at rename and
/// would seem to run at 20 GHz.)
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
  return static_cast<double>(rounds) * adds / (now_ns() - begin);
}

void add(const std::string& kernel, const KernelTable& t, bool large, const Run& run) {
  benchmark::RegisterBenchmark((kernel + "/" + t.name + "/" + size_name(large)).c_str(),
                               [run, &t, large](benchmark::State& s) { run(s, t, large); });
}

void add_kernel(const std::string& kernel, const Run& run) {
  for (const Isa isa : available_isas())
    for (const bool large : {false, true}) add(kernel, select_kernels(isa), large, run);
}

void add_core(const std::string& kernel, const Run& run) {
  for (const bool large : {false, true})
    benchmark::RegisterBenchmark((kernel + "/core/" + size_name(large)).c_str(),
                                 [run, large](benchmark::State& s) { run(s, select_kernels(Isa::automatic), large); });
}

}  // namespace talus::perf

int main(int argc, char** argv) {
  // One core: the engine's parallel loops then find a single one, and CPU time of this thread is all there is. The
  // two-thread STREAM rows take their cores from the mask the program was given.
  cpu_set_t given, own;
  sched_getaffinity(0, sizeof given, &given);
  CPU_ZERO(&own);
  CPU_SET(static_cast<std::size_t>(sched_getcpu()), &own);
  sched_setaffinity(0, sizeof own, &own);
  using namespace talus::perf;
  register_roofs(given);
  register_contacts();
  register_laws();
  register_split_columns();
  register_rebuild();
  register_walls();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
