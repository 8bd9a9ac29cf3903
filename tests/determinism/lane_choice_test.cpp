// How many threads work: unchanged while steps do not stall, fewer beside another process, all again when it has gone.
#include "scheduler/team/lane_choice.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "scheduler/team/available_cores.hpp"

namespace {

/// Steps of a run whose last core another process takes for 3 of every 6 ms, and that also rebuilds its lists.
class Machine {
 public:
  explicit Machine(int threads) : threads_(threads) { choice.prepare(threads); }
  void run(double seconds, bool loaded) {
    const double end = now_ + seconds;
    for (std::int64_t n = 0; now_ < end; ++n) {
      double step = k_work / choice.threads();
      const double phase = now_ - k_slice * 2 * static_cast<double>(static_cast<std::int64_t>(now_ / (2 * k_slice)));
      if (loaded && choice.threads() == threads_ && phase + step > k_slice) step = 2 * k_slice - phase;
      const bool rebuild = n % 50 == 49;
      if (rebuild) step += 6 * k_work / choice.threads();
      now_ += step;
      ++steps;
      choice.step_done(now_, !rebuild);
    }
  }
  talus::LaneChoice choice;
  std::int64_t steps = 0;
  static constexpr double k_work = 400e-6, k_slice = 3e-3;

 private:
  const int threads_;
  double now_ = 1;
};

TEST(LaneChoice, NothingIsTriedWhileStepsDoNotStall) {
  for (const int threads : {1, 2, 28}) {
    Machine m(threads);
    m.run(10, false);
    EXPECT_EQ(m.choice.changes(), 0) << threads;
    EXPECT_EQ(m.choice.threads(), threads);
  }
}

TEST(LaneChoice, BesideAnotherProcessARunIsAsFastAsWithOneThreadLess) {
  for (const int threads : {2, 4, 28}) {
    Machine m(threads);
    m.run(1, true);
    if (threads > 2) {  // two threads, one of them at work half of the time, are worth one
      EXPECT_EQ(m.choice.threads(), threads - 1);
    }
    m.steps = 0;
    m.run(10, true);
    Machine alone(threads - 1);
    alone.run(10, false);
    EXPECT_GE(static_cast<double>(m.steps), 0.95 * static_cast<double>(alone.steps)) << threads;
  }
}

TEST(LaneChoice, AllThreadsWorkAgainWhenTheOtherProcessHasGone) {
  Machine m(4);
  m.run(3, true);
  EXPECT_EQ(m.choice.threads(), 3);
  m.run(6, false);
  EXPECT_EQ(m.choice.threads(), 4);
  const auto changes = m.choice.changes();
  m.run(6, false);
  EXPECT_EQ(m.choice.changes(), changes);
}

TEST(AvailableCores, TheSmallestQuotaOnTheWayUpCounts) {
  namespace fs = std::filesystem;
  const fs::path root = fs::path(testing::TempDir()) / "talus_cgroup";
  fs::remove_all(root);
  fs::create_directories(root / "a" / "b");
  fs::create_directories(root / "cpu" / "c");
  const auto write = [](const fs::path& p, const char* text) { std::ofstream(p) << text; };
  const auto quota = [&](const char* membership) {
    write(root / "membership", membership);
    return talus::quota_cores((root / "membership").string(), root.string());
  };
  EXPECT_EQ(quota("0::/a/b\n"), std::numeric_limits<double>::infinity());
  write(root / "a" / "cpu.max", "250000 100000\n");
  write(root / "a" / "b" / "cpu.max", "max 100000\n");
  EXPECT_EQ(quota("0::/a/b\n"), 2.5);
  EXPECT_EQ(quota("0::/\n"), std::numeric_limits<double>::infinity());
  write(root / "cpu" / "c" / "cpu.cfs_quota_us", "50000\n");
  write(root / "cpu" / "c" / "cpu.cfs_period_us", "100000\n");
  EXPECT_EQ(quota("5:cpu,cpuacct:/c\n0::/a/b\n"), 0.5);
  EXPECT_EQ(quota("5:cpuset:/c\n"), std::numeric_limits<double>::infinity());
  EXPECT_EQ(talus::quota_cores("/nonexistent", root.string()), std::numeric_limits<double>::infinity());
  EXPECT_GE(talus::available_cores(), 1);
}

}  // namespace
