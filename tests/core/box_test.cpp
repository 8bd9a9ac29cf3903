// Claims about the minimum image and about a grain's body: both have one place each.
#include "core/base/box.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/grains/body.hpp"
#include "core/scene/scene.hpp"

namespace talus {
namespace {

const Box k_box{{2, 4, 8}, {true, false, true}};

TEST(Box, ImageIsTheNearestOfAllAndWallsHaveNone) {
  for (double x = -1.9; x < 2; x += 0.1) {
    const Vec3 d = k_box.nearest({x, x, 4 * x});
    for (int k = -2; k <= 2; ++k) {
      EXPECT_LE(std::abs(d.x), std::abs(x + 2 * k) + 1e-15);
      EXPECT_LE(std::abs(d.z), std::abs(4 * x + 8 * k) + 1e-15);
    }
    EXPECT_EQ(d.y, x);
    EXPECT_EQ(d.x, x - 2 * k_box.wraps(0, x));
    EXPECT_EQ(k_box.wraps(1, x), 0);
  }
}

TEST(Box, HalfAPeriodStaysAsItIs) {
  EXPECT_EQ(k_box.nearest(0, 1), 1);
  EXPECT_EQ(k_box.nearest(0, -1), -1);
  EXPECT_EQ(k_box.nearest(0, std::nextafter(1, 2)), std::nextafter(1, 2) - 2);
}

TEST(Box, DifferencesOfManyPeriodsHaveTheSameImage) {
  for (int n = -5; n <= 5; ++n) {
    const Vec3 d = k_box.nearest_of_any({0.25 + 2 * n, 0.25 + 4 * n, -1.5 + 8 * n});
    EXPECT_EQ(d.x, 0.25);
    EXPECT_EQ(d.y, 0.25 + 4 * n);
    EXPECT_EQ(d.z, -1.5);
  }
}

TEST(Box, FollowsTheSidesOfTheDomain) {
  Domain domain;
  domain.lower = {-1, 0, 2};
  domain.upper = {1, 4, 10};
  domain.boundary[0] = domain.boundary[2] = {Boundary::periodic, Boundary::periodic};
  const Box box = domain.box();
  EXPECT_EQ(box.size.z, 8);
  EXPECT_EQ(box.periodic, k_box.periodic);
  EXPECT_EQ(box.half(1), 1e300);
  EXPECT_EQ(box.period(2), 8);
}

TEST(Body, IsASolidSphere) {
  const Body b{0.5, 3};
  EXPECT_NEAR(b.volume(), 0.52359877559829887, 1e-16);
  EXPECT_NEAR(b.mass(), 3 * b.volume(), 1e-15);
  EXPECT_NEAR(b.inertia(), 0.1 * b.mass(), 1e-16);  // 2/5 m r^2
}

}  // namespace
}  // namespace talus
