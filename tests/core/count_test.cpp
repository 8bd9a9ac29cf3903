// Claims about the conversion of quotients to counts.
#include "core/base/count.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace talus {
namespace {

constexpr double k_inf = std::numeric_limits<double>::infinity(), k_nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::int64_t k_top = std::numeric_limits<std::int64_t>::max(),
                       k_bottom = std::numeric_limits<std::int64_t>::min();

TEST(Count, RoundsAsItsNameSays) {
  EXPECT_EQ(count_nearest(2.5), 3);
  EXPECT_EQ(count_nearest(2.4999999), 2);
  EXPECT_EQ(count_nearest(-2.5, -10), -3);
  EXPECT_EQ(count_floor(2.999), 2);
  EXPECT_EQ(count_floor(-0.001, -5), -1);
  EXPECT_EQ(count_ceil(2.0), 2);
  EXPECT_EQ(count_ceil(2.000001), 3);
  EXPECT_EQ(count_ceil(-1.5, -5), -1);
  EXPECT_EQ(cell_index(2.7, 4), 2);
}

TEST(Count, EveryDoubleStaysWithinTheBounds) {
  for (const double q : {k_inf, 1e300, 1e19, 9.3e18, 0x1p62, 0x1p63}) {
    EXPECT_EQ(count_nearest(q, 1, 100), 100) << q;
    EXPECT_EQ(count_floor(q, 1, 100), 100) << q;
    EXPECT_EQ(count_ceil(q, 1, 100), 100) << q;
    EXPECT_EQ(count_nearest(q), k_most_count) << q;
    EXPECT_EQ(cell_index(q, 7), 6) << q;
    EXPECT_EQ(count_nearest(-q, 1, 100), 1) << q;
    EXPECT_EQ(count_floor(-q, -7, 100), -7) << q;
    EXPECT_EQ(count_ceil(-q, -7, 100), -7) << q;
    EXPECT_EQ(cell_index(-q, 7), 0) << q;
  }
  for (const auto f : {count_nearest, count_floor, count_ceil}) {
    EXPECT_EQ(f(k_nan, 3, 100), 3) << "what is no number counts as the least";
    EXPECT_EQ(f(1e300, k_bottom, k_top), k_top);
    EXPECT_EQ(f(-1e300, k_bottom, k_top), k_bottom);
    EXPECT_EQ(f(0x1p-1074, 0, 100), f == count_ceil ? 1 : 0);
  }
}

}  // namespace
}  // namespace talus
