// Tables over time: what a step receives of one is its exact mean over the step, wherever its points lie.
#include "core/base/curve.hpp"

#include <gtest/gtest.h>

namespace talus {
namespace {

TEST(TimeTable, MeansAddUpToTheIntegralAtEveryStep) {
  const TimeTable pulse{{0, 1, 1.02, 1.06, 1.08, 3}, {0, 0, 100, 100, 0, 0}};  // 6 J of a power in W
  const TimeTable jump{{0, 1, 1, 2, 2}, {2, 2, 5, 7, 1}};                      // 2 to 1 s, 5 to 7 to 2 s, then 1
  for (const double step : {0.001, 0.0137, 0.1, 0.5, 4.0}) {
    double energy = 0, sum = 0;
    const int steps = static_cast<int>(4 / step + 0.5);
    for (int k = 0; k < steps; ++k) {
      energy += step * pulse.mean((k + 0.5) * step, step);
      sum += step * jump.mean((k + 0.5) * step, step);
    }
    EXPECT_NEAR(energy, 6, 1e-11) << step;
    EXPECT_NEAR(sum, 2 + 6 + (steps * step - 2), 1e-11) << step;
  }
}

TEST(TimeTable, WithoutAPointWithinTheMeanIsTheValueInTheMiddle) {
  const TimeTable line{{0, 10}, {300, 400}}, constant = TimeTable::constant(7);
  EXPECT_EQ(line.mean(3.3, 0.1), line(3.3));
  EXPECT_EQ(line.mean(12, 1), 400);
  EXPECT_EQ(constant.mean(-5, 100), 7);
  EXPECT_NEAR(line.mean(10, 4), (0.5 * (380 + 400) * 2 + 2 * 400) / 4, 1e-12);
}

}  // namespace
}  // namespace talus
