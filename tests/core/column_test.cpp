// Claims about columns: arrays of every size class are aligned, apart from each other, and usable again when freed.
#include <gtest/gtest.h>

#include <cstdint>
#include <set>
#include <vector>

#include "core/base/types.hpp"

namespace talus {
namespace {

TEST(Column, ArraysOfEverySizeAreAlignedAndKeepTheirContents) {
  // malloc's own, pieces of the pool, mappings; one byte beside each border
  for (const std::size_t bytes :
       {std::size_t{64}, k_pool_smallest - 1, k_pool_smallest, k_pool_largest, k_pool_largest + 1, 4 * k_pool_largest})
    for (int round = 0; round < 3; ++round) {  // freed memory comes back
      std::vector<Column<std::uint8_t>> columns(5);
      for (std::size_t k = 0; k < columns.size(); ++k) columns[k].assign(bytes, static_cast<std::uint8_t>(k + 1));
      for (std::size_t k = 0; k < columns.size(); ++k) {
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(columns[k].data()) % 64, 0u) << bytes;
        for (const std::uint8_t x : columns[k]) ASSERT_EQ(x, k + 1) << bytes;
      }
    }
}

TEST(Column, LargeArraysStartAtDifferentLinesOfAPage) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "every array is malloc's own";
#endif
  std::vector<Column<double>> columns(4);
  std::set<std::uintptr_t> lines;
  for (auto& c : columns) {
    c.resize(k_pool_largest / sizeof(double) + 1);
    lines.insert(reinterpret_cast<std::uintptr_t>(c.data()) % 4096);
  }
  EXPECT_EQ(lines.size(), columns.size());
}

}  // namespace
}  // namespace talus
