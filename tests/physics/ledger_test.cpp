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
  return {e.kinetic_translation + e.kinetic_rotation,
          e.potential,
          e.elastic,
          e.dissipated_damping,
          e.dissipated_friction,
          e.dissipated_background,
          e.wall_work,
          e.inserted,
          e.residual};
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

const FrameRequest k_all{.contacts = true, .coordination = true, .stress = true, .walls = true, .wall_loads = true};

TEST(PhysicsLedger, OfAGrainBetweenTwoPlatesIsTheirTwoSpringsHoweverOftenOneLooks) {
  // Each plate is pressed in by d: 2 * 1/2 k d^2 = 1e5 * (1.95e-4)^2 J.
  constexpr double r = 0.005, k = 1e5, d = 1.95e-4, elastic = 0.0038025;
  for (const bool look : {false, true}) {
    Scene s = open_scene({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}, 4e-6);
    linear_restitution(s, k, 0.8);
    s.walls = {plane("floor", {0, 0, d - r}, {0, 0, 1}), plane("lid", {0, 0, r - d}, {0, 0, -1})};
    s.output.energies = true;
    s.allow_initial_overlap = true;
    add_grains(s, {{{}, {}, r}});
    Simulation sim(s, options());
    for (int n = 0; n < 60; ++n) {
      sim.run(1);
      if (look) {
        const Frame f = sim.frame(k_all);
        ASSERT_EQ(f.contacts.size(), 2U);
        EXPECT_NEAR(norm(f.contacts[0].normal_force), k * d, 1e-9 * k * d);
      }
      const Energies e = sim.energies();
      EXPECT_NEAR(e.elastic, elastic, 1e-12 * elastic) << n;
      EXPECT_NEAR(e.residual, 0, 1e-12 * elastic) << n;
    }
  }
}

TEST(PhysicsLedger, OfAnOedometerClosesHoweverOftenOneLooks) {
  // 4^3 grains in a box of their own width, pressed together by 3 % from above.
  constexpr double r = 0.005, side = 8 * r;
  std::array<std::array<double, 9>, 2> ledgers{};
  for (const bool look : {false, true}) {
    Scene s = open_scene({0, 0, 0}, {side, side, 1.2 * side}, 4e-6);
    for (auto& axis : s.domain.boundary) axis = {Boundary::wall, Boundary::wall};
    linear_law(s, 1e5, 300, 3e4, 150, 0.4);
    WallSpec lid = plane("lid", {0, 0, side}, {0, 0, -1});
    lid.motion.velocity = {0, 0, -0.06};
    s.walls = {lid};
    s.output.energies = true;
    std::vector<Grain> grains;
    for (int k = 0; k < 64; ++k)
      grains.push_back(
          {{r * (1 + 2 * (k % 4)), r * (1 + 2 * (k / 4 % 4)), r * (1 + 2 * (k / 16))}, {}, r * (1 - 1e-4)});
    add_grains(s, grains);
    Simulation sim(s, options());
    for (int n = 0; n < 5000; n += 25) {
      sim.run(25);
      if (look) sim.frame(k_all);
    }
    const Energies e = sim.energies();
    EXPECT_GT(e.elastic, 0.1 * e.wall_work);
    EXPECT_LT(std::fabs(e.residual), 1e-3 * e.wall_work);
    figure(std::string("oedometer, ") + (look ? "with" : "without") + " frames: residual / work of the lid",
           e.residual / e.wall_work);
    ledgers[look ? 1 : 0] = all(e);
  }
  for (std::size_t k = 0; k < ledgers[0].size(); ++k)
    EXPECT_EQ(std::bit_cast<std::uint64_t>(ledgers[1][k]), std::bit_cast<std::uint64_t>(ledgers[0][k])) << k;
}

}  // namespace
}  // namespace talus::physics
