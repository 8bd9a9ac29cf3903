// Microbenchmarks of the motion of bodies: ns per body, by instruction set and number of spheres.
#include <benchmark/benchmark.h>

#include <memory>
#include <string>

#include "core/base/rng.hpp"
#include "core/shapes/rigid_motion.hpp"
#include "kernels/bodies/motion_batch.hpp"
#include "kernels/kernel_table.hpp"

namespace talus {
namespace {

/// A full batch of bodies with three different moments, which spin by some 1e-2 rad per step.
std::unique_ptr<MotionBatch> batch_of(int spheres) {
  auto batch = std::make_unique<MotionBatch>();
  const CounterRng rng(1, 3);
  std::uint64_t draw = 0;
  const auto put = [&](MotionBatch::Lane* to, int lane, double size) {
    for (int k = 0; k < 3; ++k) to[k][lane] = rng.uniform(draw++, -size, size);
  };
  const shapes::Rotor rotor = shapes::make_rotor({1e-6, 2e-6, 2.5e-6});
  for (int lane = 0; lane < MotionBatch::k_bodies; ++lane) {
    put(batch->x, lane, 1), put(batch->v, lane, 1), put(batch->spin, lane, 1e-9);
    const auto q =
        shapes::normalised({1, rng.uniform(draw, -1, 1), rng.uniform(draw + 1, -1, 1), rng.uniform(draw + 2, -1, 1)});
    draw += 3;
    batch->turn[0][lane] = q.w, batch->turn[1][lane] = q.x, batch->turn[2][lane] = q.y, batch->turn[3][lane] = q.z;
    batch->scale[lane] = 1, batch->mass[lane] = 1e-5, batch->inverse_mass[lane] = 1e5;
    for (int k = 0; k < 3; ++k) batch->inverse[k][lane] = rotor.inverse[k];
    batch->reference[lane] = rotor.reference, batch->extra_p[lane] = rotor.extra_p,
    batch->extra_q[lane] = rotor.extra_q;
    batch->axis_p[lane] = rotor.p, batch->axis_q[lane] = rotor.q;
    for (int k = 0; k < spheres; ++k) {
      put(batch->sphere[k].place, lane, 1e-3);
      batch->sphere[k].radius[lane] = 1e-3;
    }
  }
  batch->bodies = MotionBatch::k_bodies;
  batch->spheres = spheres;
  batch->rotation = 1;
  batch->dt = batch->kick = 1e-5;
  batch->per_step = 1e5;
  return batch;
}

void move(benchmark::State& state, const std::string& isa, int spheres) {
  const auto start = batch_of(spheres);
  auto batch = std::make_unique<MotionBatch>(*start);
  const BodyMover mover = body_mover(isa);
  for (auto _ : state) mover(*batch);  // free flight: what comes out goes in again
  double wide = 0;
  for (const double lane : batch->wide) wide += lane;
  state.counters["wide"] = wide;
  state.counters["ns/body"] = benchmark::Counter(static_cast<double>(state.iterations() * MotionBatch::k_bodies) * 1e-9,
                                                 benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

const bool k_registered = [] {
  for (const Isa isa : available_isas())
    for (const int spheres : {1, 3, 8, 32}) {
      const std::string set = isa_name(isa);
      benchmark::RegisterBenchmark(("body_motion/" + std::to_string(spheres) + "/" + set).c_str(),
                                   [set, spheres](benchmark::State& s) { move(s, set, spheres); });
    }
  return true;
}();

}  // namespace
}  // namespace talus
