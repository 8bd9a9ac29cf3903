// The energy ledger: of one bouncing grain against closed forms, and its bits over threads, chunks, instruction sets.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "kernels/kernel_table.hpp"
#include "physics_support.hpp"

namespace talus::physics {
namespace {

std::array<double, 9> all(const Energies& e) {
  return {e.kinetic_translation + e.kinetic_rotation, e.potential, e.elastic, e.dissipated_damping, e.dissipated_friction,
          e.dissipated_background, e.wall_work, e.inserted, e.residual};
}

struct Ledger {
  double residual = 0;  ///< largest, over the energy at the start
  double first = 0;     ///< lost in the first bounce, over the kinetic energy of the impact
};

/// A grain falls by ten radii and bounces until 1.2 s, seven or eight times.
Ledger bounces(double e, double dt) {
  const double r = 0.005, g = 9.81, height = 10 * r;
  Scene s = open_scene({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.2}, dt);
  linear_restitution(s, 1e5, e);
  s.walls = {plane("floor", {0, 0, 0}, {0, 0, 1})};
  s.gravity = {0, 0, -g};
  s.output.energies = true;
  add_grains(s, {{{0, 0, r + height}, {}, r}});
  Simulation sim(s, options());
  const double start = sphere_mass(s.materials[0].density, r) * g * height;
  Ledger l;
  for (double t = 0.01; t < 1.2; t += 0.01) {
    sim.run(std::llround(t / dt) - sim.step());
    const Energies q = sim.energies();
    l.residual = std::max(l.residual, std::fabs(q.residual) / start);
    if (l.first == 0 && q.dissipated_damping > 0 && q.elastic == 0) l.first = q.dissipated_damping / start;
  }
  return l;
}

TEST(PhysicsLedger, OfABouncingGrainClosesAndHoldsTheLossOfTheClosedForm) {
  for (const double e : {0.95, 0.8, 0.5}) {
    const Ledger coarse = bounces(e, 4e-6), fine = bounces(e, 2e-6);
    figure("bouncing grain, e " + std::to_string(e) + ", dt 4e-6: largest residual / start energy", coarse.residual);
    figure("bouncing grain, e " + std::to_string(e) + ", dt 2e-6: largest residual / start energy", fine.residual);
    figure("bouncing grain, e " + std::to_string(e) + ": loss of the first bounce / (1 - e^2) of the energy, less 1",
           fine.first / (1 - e * e) - 1);
    // midpoint rule over 25 and 50 steps per contact; the grain also gains m g delta on its way, 1e-3 of the energy
    EXPECT_LT(coarse.residual, 1e-3) << e;
    EXPECT_LT(fine.residual, 0.35 * coarse.residual) << e;
    EXPECT_NEAR(fine.first, 1 - e * e, 5e-3) << e;
  }
}

TEST(PhysicsLedger, HasTheSameBitsForEveryNumberOfThreadsChunkAndInstructionSet) {
  Scene s = open_scene({0, 0, 0}, {0.06, 0.06, 0.2}, 1e-5);
  s.domain.boundary[2] = {Boundary::wall, Boundary::wall};
  linear_law(s, 2e3, 300, 1000, 150, 0.4);
  s.gravity = {0, 0, -9.81};
  s.local_damping = 0.05;
  s.output.energies = true;
  std::vector<Grain> grains;
  for (int k = 0; k < 1500; ++k) {
    const auto q = [k](int c) { return uniform(5, static_cast<std::uint64_t>(8 * k + c)) - 0.5; };
    grains.push_back({{0.004 + 0.0055 * (k % 10), 0.004 + 0.0055 * (k / 10 % 10), 0.004 + 0.006 * (k / 100)},
                      {q(0), q(1), q(2)},
                      0.0025 + 0.0004 * q(3)});
  }
  add_grains(s, grains);
  const auto ledger = [&](int threads, int chunk, Isa isa) {
    RunOptions o;
    o.threads = threads;
    o.chunk = chunk;
    o.isa = isa;
    Simulation sim(s, o);
    sim.run(3000);
    return all(sim.energies());
  };
  const auto reference = ledger(1, 4096, Isa::scalar);
  EXPECT_GT(reference[3], 0);  // the bed has lost energy to dashpots, friction and local damping
  EXPECT_GT(reference[4], 0);
  EXPECT_GT(reference[5], 0);
  for (const Isa isa : available_isas())
    for (const auto& [threads, chunk] : {std::pair{1, 64}, {2, 256}, {3, 1000}}) {
      const auto other = ledger(threads, chunk, isa);
      for (std::size_t k = 0; k < other.size(); ++k)
        EXPECT_EQ(std::bit_cast<std::uint64_t>(other[k]), std::bit_cast<std::uint64_t>(reference[k]))
            << isa_name(isa) << ", " << threads << " threads, chunk " << chunk << ", entry " << k << ": " << other[k]
            << " and " << reference[k];
    }
}

}  // namespace
}  // namespace talus::physics
