// Claims about the grid of spheres that insertion asks.
#include "core/grains/overlap_grid.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace talus {
namespace {

TEST(OverlapGrid, SphereFarLargerThanOthersFindsThem) {
  OverlapGrid grid(1);
  for (int k = 0; k < 100; ++k) grid.add({3.0 * k, 0, 0}, k % 2 == 0 ? 1e-9 : 1e-7, k);
  for (int k = 0; k < 100; ++k) {
    std::vector<std::int32_t> found;
    int visits = 0;
    EXPECT_FALSE(grid.any({3.0 * k + 0.999999, 0, 0}, 1, [&](const OverlapGrid::Sphere& s, double d2) {
      ++visits;
      if (d2 < (1 + s.r) * (1 + s.r)) found.push_back(s.index);
      return false;
    }));
    EXPECT_LE(visits, 300);
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    EXPECT_EQ(found, std::vector<std::int32_t>{k});
  }
}

}  // namespace
}  // namespace talus
