// Grains in the gas: a falling grain.
#include <gtest/gtest.h>

#include <cmath>

#include "core/gas/drag.hpp"
#include "core/gas/species.hpp"
#include "scheduler/simulation.hpp"

namespace talus::gas {
namespace {

/// Grains of one size and density in a box that the gas fills, walls at bottom and top.
Scene box(Vec3 size, std::array<int, 3> cells, double d) {
  Scene s;
  s.domain.upper = size;
  s.domain.boundary[0] = s.domain.boundary[1] = {Boundary::periodic, Boundary::periodic};
  s.materials = {Material{"glass", 2500}};
  s.pairs = {PairCoefficients{}};
  s.gravity = {0, 0, -9.81};
  s.contact.friction = false;
  s.contact.normal_stiffness = 20;
  s.contact.normal_damping = 1000;
  s.dt = 2e-5;
  s.gas.on = true;
  s.gas.upper = size;
  s.gas.cells = cells;
  s.gas.every = 50;
  Source a;
  a.kind = Source::Kind::lattice;
  a.lattice = Source::Lattice::cubic;
  a.spacing = 1.02;
  a.size.diameter = d;
  s.sources = {a};
  return s;
}

TEST(GasPart, GasThatNeverActsInARunIsSaid) {
  for (const std::int64_t every : {100, 101}) {
    Scene s = box({0.01, 0.01, 0.01}, {2, 2, 2}, 1e-3);
    s.sources[0].number = 2;
    s.sources[0].region.upper = s.domain.upper;
    s.steps = 100;
    s.gas.every = every;
    const Simulation sim(s, RunOptions{});
    int said = 0;
    for (const Warning& w : sim.warnings()) said += w.text.find("'gas' acts every 101 steps") != std::string::npos;
    EXPECT_EQ(said, every > 100 ? 1 : 0);
  }
}

TEST(GasPart, FallingGrainReachesItsTerminalVelocity) {
  const double rho = 101325 / (specific_gas_constant(k_air) * 300), mu = viscosity(300);
  for (const GasDrag law : {GasDrag::gidaspow, GasDrag::di_felice})
    for (const double d : {60e-6, 200e-6}) {
      Scene s = box({0.02, 0.02, 1}, {1, 1, 50}, d);
      s.gas.drag = law;
      s.dt = 1e-5;
      s.contact.normal_stiffness = 0.01;
      s.contact.normal_damping = 0;
      s.sources[0].number = 1;
      s.sources[0].region.lower = {0.009, 0.009, 0.98};
      s.sources[0].region.upper = {0.011, 0.011, 0.99};
      s.steps = 1000000;
      Simulation sim(s, RunOptions{});
      sim.run(d > 1e-4 ? 60000 : 20000);
      ASSERT_EQ(sim.particles(), 1);
      const double v = -sim.frame().v[0].z;
      // weight less buoyancy = drag of the law's single sphere
      const double weight = 3.14159265358979 / 6 * d * d * d * (2500 - rho) * 9.81;
      double low = 0, high = 20;
      for (int k = 0; k < 80; ++k) {
        const double u = 0.5 * (low + high), re = rho * u * d / mu;
        const double f = 3 * 3.14159265358979 * mu * d * u * drag_factor(law, 1, re);
        (f < weight ? low : high) = u;
      }
      std::printf("terminal velocity, %s, d %g m: %.6f m/s, law %.6f\n", std::string(enum_word(law)).c_str(), d, v,
                  low);
      EXPECT_NEAR(v / low, 1, 0.005);
    }
}

}  // namespace
}  // namespace talus::gas
