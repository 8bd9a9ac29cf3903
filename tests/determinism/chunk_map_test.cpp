// Borders of the chunks: every row has one chunk, none is empty, rows inserted behind the last border find one, and
// chunks cost the same where rows do not.
#include "scheduler/team/chunk_map.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace talus::determinism {
namespace {

/// Borders and owner of every row agree; returns the number of chunks.
int check(const ChunkMap& map, Row n) {
  const int chunks = map.count(n);
  EXPECT_EQ(map.lo(0), 0);
  EXPECT_EQ(map.hi(chunks - 1, n), n);
  for (int k = 0; k < chunks; ++k) {
    EXPECT_LT(map.lo(k), map.hi(k, n)) << k;
    if (k > 0) {
      EXPECT_EQ(map.lo(k), map.hi(k - 1, n)) << k;
    }
    for (Row i = map.lo(k); i < map.hi(k, n); ++i)
      if (map(i) != k) {
        ADD_FAILURE() << "row " << i << " is in chunk " << map(i) << " instead of " << k;
        break;
      }
  }
  return chunks;
}

TEST(ChunkMap, EveryRowHasOneChunkAlsoBehindTheLastBorder) {
  for (const int size : {1, 7, 64, 101, 1000, 4096})
    for (const Row n : {1, 63, 101, 202, 1000, 12345}) {
      if (n / size > 3000) continue;
      std::vector<double> cost;
      for (Row i = 0; i < n; i += ChunkMap::group_rows(size)) cost.push_back(1 + std::sin(0.01 * i));
      const ChunkMap equal(size), uneven(size, n, cost);
      EXPECT_EQ(check(equal, n), (n + size - 1) / size);
      EXPECT_LE(check(uneven, n), (n + size - 1) / size);
      for (const Row more : {n + 1, n + 65, 3 * n}) {
        check(equal, more);
        check(uneven, more);
      }
    }
}

TEST(ChunkMap, ChunksOfEqualCostWhereRowsDiffer) {
  const Row n = 40000;
  const int size = 1000;
  const Row rows = ChunkMap::group_rows(size);
  std::vector<double> cost;
  for (Row i = 0; i < n; i += rows) cost.push_back(i < n / 2 ? 1.0 : 3.0);
  const ChunkMap map(size, n, cost);
  ASSERT_EQ(check(map, n), n / size);
  const auto spread = [&](const ChunkMap& m) {
    double least = 1e300, most = 0;
    for (int k = 0; k < m.count(n); ++k) {
      double sum = 0;
      for (Row i = m.lo(k); i < m.hi(k, n); ++i) sum += cost[static_cast<std::size_t>(i / rows)] / rows;
      least = std::min(least, sum);
      most = std::max(most, sum);
    }
    return most / least;
  };
  EXPECT_NEAR(spread(ChunkMap(size)), 3, 1e-9);  // control: equal chunks are not
  // a border is off by at most half a group of rows at either end
  EXPECT_LT(spread(map), (1 + 3.0 * rows / (2.0 * size)) / (1 - 3.0 * rows / (2.0 * size)));
}

}  // namespace
}  // namespace talus::determinism
