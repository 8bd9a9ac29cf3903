// Grains in the gas: a falling grain.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>

#include "core/base/error.hpp"
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

/// Drag may not stop a grain within a step; a grain that is held has none to stop it.
TEST(GasPart, OnlyGrainsThatMoveLimitTheStep) {
  const std::string path = testing::TempDir() + "gas-held-" + std::to_string(getpid()) + ".csv";
  const auto refusal = [&](int held) {
    std::ofstream(path) << "x,y,z,radius,fixed\n0.002,0.005,0.005,1e-5," << held << "\n0.007,0.005,0.005,5e-4,0\n";
    Scene s = box({0.01, 0.01, 0.01}, {2, 2, 2}, 1e-3);
    s.contact.normal_stiffness = 1e-6;
    s.contact.normal_damping = 0;
    s.gas.every = 2;
    s.dt = 5e-3;  // m/drag = 2 rho r^2 / (9 mu): 3 ms and 7.6 s
    s.steps = 10;
    s.allow_unstable_step = true;
    s.gravity = {};
    Source file;
    file.kind = Source::Kind::file;
    file.file = path;
    s.sources = {file};
    GroupSpec g;
    g.name = "held";
    g.fixed_in_file = true;
    s.groups = {g};
    try {
      Simulation sim(s, RunOptions{});
      sim.run(10);
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  EXPECT_NE(refusal(0).find("time.step is too long for part 'gas'"), std::string::npos) << refusal(0);
  EXPECT_EQ(refusal(1), "accepted");
  std::remove(path.c_str());
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
