// How the microbenchmarks measure: clock of the core, time per element, operations counted, registration by kernel,
// instruction set and size. Who calls it: perf/kernels*.cpp. Invariant: ns are those of the timed part alone; cycles
// are ns x the clock of a loop of dependent additions timed just before and after; operations come from running the
// same body once with kernels of a counting number type (kernels_count.cpp), so they follow every change of a kernel.
#pragma once

#include <benchmark/benchmark.h>
#include <sched.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <type_traits>

#include "kernels/kernel_table.hpp"

namespace talus::perf {

/// Arithmetic of counting kernels. Loads, compares, selects and integer work count nothing.
struct Operations {
  double flops = 0;      ///< + - * / sqrt of one lane, each counted as one
  double divisions = 0;  ///< of which divisions
  double roots = 0;      ///< of which square roots
};
const KernelTable& counting_kernels();
Operations& operations();  ///< so far; whoever counts sets it to zero

double now_ns();     ///< CPU time of this thread: what other programs on the core take does not count
double wall_ns();    ///< for parts too short for the CPU clock's system call
double clock_ghz();  ///< clock of this core now

/// What one call of a body does.
struct Work {
  std::string key;     ///< kernel and size: operations are counted once per key
  double elements;     ///< per call
  double bytes;        ///< per element, that have to move from or to memory if everything else hits the cache
  bool counts = true;  ///< the body runs kernels of the table, whose arithmetic can be counted
};

template <class F>
Operations count_once(const Work& work, F body) {
  static std::map<std::string, Operations> known;
  const auto [at, fresh] = known.try_emplace(work.key);
  if (fresh && work.counts) {
    operations() = {};
    body(counting_kernels());
    at->second = operations();
  }
  return at->second;
}

/// Runs body(kernels) once per iteration and reports per element. A body that returns ns is charged those; otherwise
/// the whole loop counts. `excluded_ns` per element is taken off (set-up inside the body).
template <class F>
void measure(benchmark::State& state, const KernelTable& t, const Work& work, F body, double excluded_ns = 0) {
  constexpr bool self_timed = !std::is_void_v<std::invoke_result_t<F, const KernelTable&>>;
  const Operations ops = count_once(work, body);
  body(t);  // first touch
  const double before = clock_ghz(), begin = now_ns();
  double inside = 0;
  std::int64_t runs = 0;
  for (auto _ : state) {
    if constexpr (self_timed)
      inside += body(t);
    else
      body(t);
    benchmark::ClobberMemory();
    ++runs;
  }
  const double ns = (self_timed ? inside : now_ns() - begin) / static_cast<double>(runs);
  const double ghz = 0.5 * (before + clock_ghz()), each = ns / work.elements - excluded_ns;
  const auto set = [&](const char* name, double value) { state.counters[name] = value; };
  set("ns", each);
  set("cycles", each * ghz);
  set("GHz", ghz);
  set("elements", work.elements);
  set("bytes", work.bytes);
  set("GB_s", work.bytes / each);
  set("flops", ops.flops / work.elements);
  set("divisions", ops.divisions / work.elements);
  set("roots", ops.roots / work.elements);
  set("Gflop_s", ops.flops / work.elements / each);
}

using Run = std::function<void(benchmark::State&, const KernelTable&, bool large)>;

inline const char* size_name(bool large) { return large ? "512k" : "4k"; }

/// One row "kernel/instruction set/size".
void add(const std::string& kernel, const KernelTable& t, bool large, const Run& run);
/// A row for every instruction set and both sizes, or for the engine's own code ("core") once per size.
void add_kernel(const std::string& kernel, const Run& run);
void add_core(const std::string& kernel, const Run& run);

// One function per file that registers its rows.
void register_roofs(const cpu_set_t& given);  ///< the cores that the program was given
void register_contacts();
void register_laws();
void register_split_columns();
void register_rebuild();
void register_walls();

}  // namespace talus::perf
