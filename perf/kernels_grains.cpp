// Microbenchmarks of heat and conversion of grains: ns per grain and heat step with 20 shells, by instruction set, in
// cache and out of it, beside the time that the rows' way from and to memory takes at the bandwidth of a copy. In cache
// every round of steps begins at the same state, 6 s after the start, in which shells dry, decompose and burn at once,
// or 30 s after it, when all are dry and most are char (`late`).
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "core/conversion/film.hpp"
#include "kernels/conversion/grain_batch.hpp"
#include "kernels/kernel_table.hpp"
#include "perf/kernels_measure.hpp"

namespace talus {
namespace {
using namespace conversion;

constexpr int k_shells = 20;

enum class What { heat, pyrolysis, burning };

/// Wood: heat alone, three reactions and drying, or these with burning char, blowing and heat that gas carries.
Matter matter_of(What what) {
  Matter m;
  m.density = 600;
  for (auto& x : m.heat_capacity) x = Property::polynomial({1500, 1.0}, 273.15, 200, 2000);
  for (auto& x : m.conductivity) x = Property::polynomial({0.1, 1e-4}, 273.15, 200, 2000);
  m.conductivity_wet = Property::constant(0.3);
  m.gas_heat_capacity = Property::constant(1100);
  if (what == What::heat) {
    m.solids = {{"solid", Kind::fuel, 1, {}}};
  } else {
    add_scheme(m, "di_blasi_branca");
    m.solids[m.solid("wood")].initial = 0.69;
    m.solids.push_back({"moisture", Kind::moisture, 0.3, {}});
    m.solids.push_back({"ash", Kind::ash, 0.01, {}});
    m.drying = {Drying::boiling, 0, 0, 373.15, 2.26e6};
    m.shrinkage = {0.1, 0.3, 0.9};
    for (Reaction& r : m.reactions) r.heat = 1e5;
  }
  if (what == What::burning) {
    m.char_reactions = {{CharReaction::Oxidant::oxygen, 1.715, 1, 74830, 4.3, 28186}};
    m.gas_convection = m.blowing = true;
  }
  check_matter(m);
  return m;
}

struct Grains {
  BedTables tables;
  std::vector<double> numbers, in, out, scratch, kept;
  double* rows;  ///< of all grains, aligned as columns of a run are
  std::vector<double*> row;
  GrainBatch batch;

  Grains(What what, long grains) : tables(matter_of(what), k_shells, conversion::k_air, FilmLaw::ranz_marshall) {
    const BedMatter& m = tables.matter();
    const long size = bed_row(m).size, stride = (grains + 7) / 8 * 8;
    numbers.resize(static_cast<std::size_t>(size * grains + 8));
    rows = aligned(numbers);
    for (long k = 0; k < grains; ++k) {
      row.push_back(rows + size * k);
      tables.begin(0.003 * (1 + 0.01 * static_cast<double>(k % 32)), 300, row.back());
    }
    in.assign(static_cast<std::size_t>(k_bed_in * stride), 0.0);
    out.assign(static_cast<std::size_t>((k_out_released + m.gases) * stride), 0.0);
    scratch.assign(static_cast<std::size_t>(bed_scratch(m)) + 8, 0.0);
    const auto set = [&](BedIn c, double v) { std::fill_n(in.data() + c * stride, stride, v); };
    set(k_in_gas, 900), set(k_in_wall, 1100), set(k_in_film, -1), set(k_in_sees, 1), set(k_in_velocity, 1);
    set(k_in_oxygen, 0.2), set(k_in_molar, 0.0288);
    set(k_in_pressure, 101325);
    batch.grains = grains;
    batch.row = row.data();
    batch.in = in.data();
    batch.out = out.data();
    batch.stride = stride;
    batch.dt = 0.01;
    batch.scratch = aligned(scratch);
  }
  static double* aligned(std::vector<double>& v) {
    return reinterpret_cast<double*>((reinterpret_cast<std::uintptr_t>(v.data()) + 63) / 64 * 64);
  }
  void keep() { kept.assign(rows, rows + bed_row(tables.matter()).size * batch.grains); }
  void begin_again() { std::copy(kept.begin(), kept.end(), rows); }
};

/// Seconds per byte of a copy that is not in cache, read and write counted.
double copy_ns_per_byte() {
  static const double ns = [] {
    std::vector<char> a(std::size_t{64} << 20), b(a.size());
    std::memcpy(b.data(), a.data(), a.size());
    const double begin = perf::now_ns();
    for (int k = 0; k < 4; ++k) std::memcpy(b.data(), a.data(), a.size());
    benchmark::DoNotOptimize(b.data());
    return (perf::now_ns() - begin) / (8.0 * static_cast<double>(a.size()));
  }();
  return ns;
}

constexpr int k_round = 32;  // steps from the same state: a third of a second

void step(benchmark::State& state, const std::string& isa, What what, long grains, bool late) {
  Grains g(what, grains);
  const GrainSolver solver = grain_solver(isa);
  const bool in_cache = grains < 1000;
  for (int k = 0; k < (in_cache ? (late ? 3000 : 600) : 4); ++k) solver(g.tables.matter(), g.batch);
  g.keep();
  double ns = 1e30;  // of the fastest round: others share the machine
  for (auto _ : state) {
    if (in_cache) g.begin_again();
    const double begin = perf::now_ns();
    const int steps = in_cache ? k_round : 1;
    for (int k = 0; k < steps; ++k) solver(g.tables.matter(), g.batch);
    ns = std::min(ns, (perf::now_ns() - begin) / (steps * static_cast<double>(grains)));
  }
  const double bytes = 16.0 * static_cast<double>(bed_row(g.tables.matter()).size);
  state.counters["ns/grain"] = ns;
  state.counters["bytes/grain"] = bytes / 2;
  if (!in_cache) state.counters["copy_ns"] = bytes * copy_ns_per_byte();
}

void add(const std::string& name, const std::string& set, What what, long grains, bool late) {
  benchmark::RegisterBenchmark(
      ("grain_shells/" + name + (late ? "_late/" : "/") + std::to_string(grains) + "/" + set).c_str(),
      [=](benchmark::State& s) { step(s, set, what, grains, late); });
}

const bool k_registered = [] {
  for (const Isa isa : available_isas())
    for (const auto& [name, what] :
         {std::pair{"heat", What::heat}, {"pyrolysis", What::pyrolysis}, {"burning", What::burning}}) {
      const std::string set = isa_name(isa);
      add(name, set, what, 32, false);
      if (what != What::heat) add(name, set, what, 32, true);
      add(name, set, what, 65536, false);
    }
  return true;
}();

}  // namespace
}  // namespace talus
