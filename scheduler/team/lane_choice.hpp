// How many threads work at present. Who calls it: the end of every step (step_done) and the step graph (threads).
// Purpose: a step ends with its last chunk, so one thread whose core is taken by another process for some milliseconds
// holds up all others: two threads beside a busy loop ran at a third of the speed of one. Where steps stall, fewer
// threads are tried and the fastest number is kept for a while. Invariants: nothing is tried while steps do not stall;
// the number of threads changes no result (I8).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace talus {

class LaneChoice {
 public:
  /// All `threads` work from now on; with one there is nothing to choose.
  void prepare(int threads);
  int threads() const noexcept { return now_ < most_ ? now_ : most_; }
  /// No more threads than this from now on: a scene of few grains has no work for others.
  void limit(int most) noexcept { most_ = most < 1 ? 1 : most; }
  /// A step has ended at `now` [s of any steady clock]. `regular`: it had no rebuild, whose time says nothing here.
  void step_done(double now, bool regular);
  std::int64_t changes() const noexcept { return changes_; }  ///< of the number of threads

 private:
  enum class Phase : std::uint8_t { watch, trial, hold };
  /// Durations of the regular steps of a window, in classes a quarter of an octave wide.
  struct Window {
    static constexpr int k_classes = 4 * 40;
    std::array<std::int32_t, k_classes> count{};
    std::array<double, k_classes> sum{};
    std::int64_t steps = 0;
    double total = 0;  ///< [s]
    void add(double seconds);
    double mean() const { return total / static_cast<double>(steps); }
    double stalled_share() const;
  };
  void window_ends(double now);
  void watch_ends(double now);
  void trial_ends(double now);
  void work_with(int threads);
  void keep(int threads, double mean, double now);

  int all_ = 1, now_ = 1, most_ = 1;
  Phase phase_ = Phase::watch;
  Window window_;
  double last_ = -1;       ///< end of the step before [s]; negative: unknown
  double begin_ = -1;      ///< of the window [s]
  double until_ = 0;       ///< end of Phase::hold [s]
  double hold_ = 0;        ///< length of the next hold [s]
  bool returned_ = false;  ///< the present watch follows a hold with fewer threads
  Window since_return_;    ///< steps and total only
  int repeats_ = 0;        ///< of the present trial
  std::vector<int> candidates_;
  std::size_t next_ = 0;
  int best_ = 1;
  double best_mean_ = 0;  ///< [s] per regular step
  std::int64_t changes_ = 0;
};

}  // namespace talus
