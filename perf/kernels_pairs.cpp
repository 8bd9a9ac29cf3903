// Microbenchmarks of the contact of two superquadrics: ns per pair, by instruction set and shape; from the line of
// centres (a new contact) and from the normal of a step before.
#include <benchmark/benchmark.h>

#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include "core/base/rng.hpp"
#include "core/shapes/pair_contact.hpp"
#include "kernels/bodies/pair_batch.hpp"
#include "kernels/kernel_table.hpp"

namespace talus {
namespace {
using namespace shapes;

constexpr std::int64_t k_pairs = 1024;

struct Pairs {
  std::vector<double> in = std::vector<double>(PairColumns::k_in * k_pairs),
                      out = std::vector<double>(PairColumns::k_out * k_pairs);

  /// Pairs of equal shapes that overlap by 1e-3 along a random normal; `warm`: started from near the solution.
  Pairs(double n, double aspect, bool warm) {
    const CounterRng rng(1, 2);
    std::uint64_t draw = 0;
    const auto number = [&] { return rng.uniform(draw++, -1, 1); };
    const auto direction = [&] {
      for (;;) {
        const Vec3 v{number(), number(), number()};
        if (norm2(v) < 1 && norm2(v) > 0.01) return (1 / norm(v)) * v;
      }
    };
    const Superquadric s{{aspect, 1, 1}, n, n};
    for (std::int64_t k = 0; k < k_pairs; ++k) {
      const auto turn = [&] { return normalised({1 + number(), number(), number(), number()}); };
      Body i = make_body(s, 0, {}, turn()), j = make_body(s, 0, {}, turn());
      const Vec3 normal = direction();
      const Vec3 xi = to_space(i.turn, support_point(s, to_body(i.turn, normal)).point);
      const Vec3 xj = to_space(j.turn, support_point(s, to_body(j.turn, -normal)).point);
      j.centre = (xi - xj) - 1e-3 * normal;
      const PairForm<Plain> p = pair_form(i, j);
      const Vec3 near = to_body(i.turn, normal + 1e-4 * direction());
      const Triple<Plain> start = unit<Plain>(warm ? Triple<Plain>{near.x, near.y, near.z} : p.d);
      int column = 0;
      const auto put = [&](double v) { in[static_cast<std::size_t>(column++ * k_pairs + k)] = v; };
      for (const DualForm<Plain>& f : {p.i, p.j})
        for (const double v : {f.axes2.x, f.axes2.y, f.axes2.z, f.p1, f.p2}) put(v);
      for (const auto& row : p.turn)
        for (const double v : {row.x, row.y, row.z}) put(v);
      for (const double v : {p.d.x, p.d.y, p.d.z, p.size, 0.0, start.x, start.y, start.z, warm ? k_warm_eta : 1.0, 1.0})
        put(v);
    }
  }
};

void solve(benchmark::State& state, const std::string& isa, double n, double aspect, bool warm) {
  Pairs pairs(n, aspect, warm);
  const PairSolver solver = pair_solver(isa);
  for (auto _ : state) solver({k_pairs, k_pairs, pairs.in.data(), pairs.out.data()}, 80);
  double evaluations = 0, solved = 0;
  for (std::size_t k = 0; k < k_pairs; ++k)
    evaluations += pairs.out[9 * k_pairs + k], solved += pairs.out[10 * k_pairs + k];
  state.counters["ns/pair"] = benchmark::Counter(static_cast<double>(state.iterations() * k_pairs) * 1e-9,
                                                 benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  state.counters["evaluations"] = evaluations / k_pairs;
  state.counters["solved"] = solved / k_pairs;
}

const bool k_registered = [] {
  for (const Isa isa : available_isas())
    for (const bool warm : {false, true})
      for (const auto& [name, n, aspect] :
           {std::tuple{"ellipsoid", 2.0, 2.0}, {"rounded_cube", 4.0, 1.0}, {"cube", 20.0, 1.0}}) {
        const std::string set = isa_name(isa);
        benchmark::RegisterBenchmark(
            ("superquadric_pair/" + std::string(name) + (warm ? "/warm/" : "/new/") + set).c_str(),
            [set, n = n, aspect = aspect, warm](benchmark::State& s) { solve(s, set, n, aspect, warm); });
      }
  return true;
}();

}  // namespace
}  // namespace talus
