// precision = "fast" where exact zeros stand: grains with friction that begin in contact have no
// tangential force yet.
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.hpp"
#include "kernels/kernel_table.hpp"
#include "tests/physics/physics_support.hpp"

namespace talus::physics {
namespace {

bool has_fast_kernels() {
  try {
    select_kernels(Isa::automatic, nullptr, Precision::fast);
    return true;
  } catch (const Error&) {
    return false;
  }
}

/// Of the first grain [m/s].
double speed_after(Scene s, Precision precision) {
  s.precision = precision;
  Simulation sim(s, options());
  sim.run(400);
  FrameRequest all;
  return sim.frame(all).v[0].x;
}

TEST(FastImpact, PairsWithoutATangentialForceMoveAsInTheExactMode) {
  if (!has_fast_kernels()) GTEST_SKIP() << "no instruction set with fused multiply-add here";
  for (const double damping : {0.0, 5.0})
    for (const double speed : {0.0, 1.0, -1.0}) {
      Scene s = open_scene({-5, -5, -5}, {5, 5, 5}, 1e-3);
      linear_law(s, 1e6, damping, 3e5, 0, 0.5);
      // at rest and parting they begin in overlap, the latter for less than a step
      const double x = speed > 0 ? 0.501 : speed < 0 ? 0.49999 : 0.49;
      add_grains(s, {{.x = {-x, 0, 0}, .v = {speed, 0, 0}}, {.x = {x, 0, 0}, .v = {-speed, 0, 0}}});
      s.allow_initial_overlap = true;
      const double exact = speed_after(s, Precision::exact), fast = speed_after(s, Precision::fast);
      EXPECT_NEAR(fast, exact, 1e-9) << "damping " << damping << ", speed " << speed;
      EXPECT_LT(exact, -0.1) << "they part";
    }
}

}  // namespace
}  // namespace talus::physics
