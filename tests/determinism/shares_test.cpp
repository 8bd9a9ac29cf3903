// Shares of the chunks: every chunk once per round whoever asks, a thread's own chunks first, shares as even as
// consecutive chunks allow.
#include "scheduler/team/shares.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <thread>

namespace talus::determinism {
namespace {

TEST(ChunkShares, EveryChunkOncePerRoundWhoeverAsks) {
  ChunkShares shares;
  for (const auto& [chunks, threads] : {std::pair{1, 1}, {5, 8}, {37, 4}, {1000, 3}, {64, 4}}) {
    shares.prepare(chunks, threads);
    for (int round = 0; round < 50; ++round) {
      shares.begin_round();
      std::vector<std::vector<int>> taken(static_cast<std::size_t>(threads));
      std::atomic<int> left{chunks};
      const auto work = [&](int slot) {
        // one thread has no slot, one comes late: others have to take its share
        if (slot == 1 && round % 3 == 0) std::this_thread::yield();
        while (left.fetch_sub(1) > 0)
          taken[static_cast<std::size_t>(slot)].push_back(shares.take(slot == 2 && round % 2 == 0 ? -1 : slot));
      };
      std::vector<std::thread> pool;
      for (int t = 1; t < threads; ++t) pool.emplace_back(work, t);
      work(0);
      for (std::thread& t : pool) t.join();
      std::vector<int> all;
      for (const auto& t : taken) all.insert(all.end(), t.begin(), t.end());
      std::sort(all.begin(), all.end());
      std::vector<int> wanted(static_cast<std::size_t>(chunks));
      std::iota(wanted.begin(), wanted.end(), 0);
      ASSERT_EQ(all, wanted) << chunks << " chunks, " << threads << " threads, round " << round;
    }
    EXPECT_EQ(shares.take(0), -1);
  }
}

TEST(ChunkShares, OwnChunksFirstInTurningOrderThenTheFarEndOfTheFullestShare) {
  ChunkShares shares;
  shares.prepare(8, 2);
  ASSERT_EQ(shares.bounds(), (std::vector<int>{0, 4, 8}));
  std::vector<std::vector<int>> rounds;
  for (int round = 0; round < 2; ++round) {
    shares.begin_round();
    std::vector<int> order;
    for (int k = 0; k < 8; ++k) {
      const int next = shares.next(1);
      order.push_back(shares.take(1));
      EXPECT_EQ(next, k < 4 ? order.back() : -1);  // of the own share alone
    }
    rounds.push_back(order);
  }
  std::sort(rounds.begin(), rounds.end());
  EXPECT_EQ(rounds[0], (std::vector<int>{4, 5, 6, 7, 3, 2, 1, 0}));
  EXPECT_EQ(rounds[1], (std::vector<int>{7, 6, 5, 4, 0, 1, 2, 3}));
}

TEST(ChunkShares, TheMostExpensiveShareIsAsCheapAsConsecutiveChunksAllow) {
  ChunkShares shares;
  shares.divide({9, 1, 1, 1, 1, 1, 1, 1, 8}, 3);
  EXPECT_EQ(shares.bounds(), (std::vector<int>{0, 1, 8, 9}));
  // a share that is nearly as good stays, a better one replaces it
  shares.divide({9, 1, 1, 1, 1, 1, 1, 1.05, 8}, 3);
  EXPECT_EQ(shares.bounds(), (std::vector<int>{0, 1, 8, 9}));
  shares.divide({2, 2, 2, 2, 2, 2, 2, 2, 2}, 3);
  EXPECT_EQ(shares.bounds(), (std::vector<int>{0, 3, 6, 9}));
  // every thread has something to do where there is something for it
  shares.divide({1, 1, 1, 20}, 4);
  EXPECT_EQ(shares.bounds(), (std::vector<int>{0, 1, 2, 3, 4}));
  shares.divide({1, 1}, 4);
  EXPECT_EQ(shares.bounds().back(), 2);
}

}  // namespace
}  // namespace talus::determinism
