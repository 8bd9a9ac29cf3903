// The gate between two steps: every lane works once in every round, having waited, given up waiting or been dismissed.
#include "scheduler/team/step_gate.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

namespace {

/// Lanes and the threads that take them, without a flow graph: the last lane to report does the serial part.
class Steps {
 public:
  Steps(int lanes, int rounds) : lanes_(lanes), rounds_(rounds), entered_(static_cast<std::size_t>(lanes)) {
    gate_.prepare(lanes);
    start();
  }
  void work() {
    while (!done_.load()) {
      const int lane = take();
      if (lane < 0) {
        std::this_thread::yield();
        continue;
      }
      bool goes_on = true;
      while (goes_on) {
        const int round = ++entered_[static_cast<std::size_t>(lane)];
        if (round != round_.load()) failures.fetch_add(1);  // left out, or run twice
        const std::uint32_t seen = gate_.round();
        if (reported_.fetch_add(1) + 1 == lanes_) serial();
        goes_on = gate_.await(seen, lane);
      }
    }
  }
  int rounds() const { return round_.load(); }
  int again() const { return again_; }
  std::atomic<int> failures{0};

 private:
  void serial() {
    const int round = round_.load();
    reported_.store(0);
    // long enough for lanes to give up
    if (round % 7 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(2));
    if (round == rounds_) {
      gate_.dismiss();
      done_.store(true);
      return;
    }
    if (round % 5 == 0) gate_.dismiss();
    if (round % 10 == 0) gate_.dismiss();  // a second loop of the same step: nothing happens
    round_.store(round + 1);
    if (gate_.dismissed()) {
      start();
    } else {
      gate_.open([this](std::uint16_t lane) {
        ++again_;
        give(lane);
      });
    }
  }
  void start() {
    gate_.started();
    for (int k = 0; k < lanes_; ++k) give(k);
  }
  void give(int lane) {
    const std::lock_guard<std::mutex> lock(mutex_);
    queue_.push_back(lane);
  }
  int take() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (queue_.empty()) return -1;
    const int lane = queue_.front();
    queue_.pop_front();
    return lane;
  }

  talus::StepGate gate_;
  const int lanes_, rounds_;
  std::vector<std::atomic<int>> entered_;
  std::atomic<int> round_{1}, reported_{0};
  std::atomic<bool> done_{false};
  int again_ = 0;
  std::mutex mutex_;
  std::deque<int> queue_;
};

void run(Steps& steps, int threads) {
  std::vector<std::thread> all;
  for (int t = 0; t < threads; ++t) all.emplace_back([&steps] { steps.work(); });
  for (std::thread& t : all) t.join();
}

TEST(StepGate, EveryLaneEntersEveryRoundOnce) {
  for (const int threads : {1, 2, 4}) {
    Steps steps(4, 400);
    run(steps, threads);
    EXPECT_EQ(steps.failures.load(), 0) << threads << " threads";
    EXPECT_EQ(steps.rounds(), 400) << threads << " threads";
    // on one thread a lane can only go on because the one before it gave up
    if (threads == 1) {
      EXPECT_GE(steps.again(), 3 * 300);
    }
  }
}

TEST(StepGate, ADismissedLaneThatLooksLateStaysAway) {
  talus::StepGate gate;
  gate.prepare(2);
  gate.started();
  const std::uint32_t round = gate.round();
  gate.dismiss();
  EXPECT_TRUE(gate.dismissed());
  EXPECT_FALSE(gate.await(round, 1));
  gate.started();
  gate.open([](std::uint16_t) { FAIL() << "nobody gave up waiting"; });
  EXPECT_FALSE(gate.await(round, 1)) << "its lane was handed out again: it would run twice";
  EXPECT_TRUE(gate.await(round + 1, 1));
}

// A thread that is stopped while its lane gives up, until the lane was handed out again and has given up once more.
TEST(StepGate, AThreadThatWasStoppedWhileLeavingLosesNoLane) {
  talus::StepGate gate;
  gate.prepare(3, false);
  gate.started();
  const std::uint32_t first = gate.round();
  ASSERT_FALSE(gate.await(first, 2));
  const talus::StepGate::Look stopped = gate.look_at(0);
  gate.dismiss();
  gate.started();
  const std::uint32_t second = gate.round();
  for (const int lane : {1, 0, 2}) ASSERT_FALSE(gate.await(second, lane));
  EXPECT_FALSE(gate.leave(stopped, 0));
  std::vector<int> again;
  gate.open([&again](std::uint16_t lane) { again.push_back(lane); });
  EXPECT_EQ(again, (std::vector<int>{2, 0, 1}));
}

// The same without a stop: whoever was overtaken by another lane of its round looks again and leaves.
TEST(StepGate, ALaneThatIsOvertakenWhileLeavingLeavesBehindTheOther) {
  talus::StepGate gate;
  gate.prepare(2, false);
  gate.started();
  const talus::StepGate::Look before = gate.look_at(0);
  ASSERT_FALSE(gate.await(gate.round(), 1));
  EXPECT_FALSE(gate.leave(before, 0));
  EXPECT_FALSE(gate.await(gate.round(), 0));
  std::vector<int> again;
  gate.open([&again](std::uint16_t lane) { again.push_back(lane); });
  EXPECT_EQ(again, (std::vector<int>{0, 1}));
}

}  // namespace
