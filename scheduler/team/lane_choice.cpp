// Watches for stalled steps, tries fewer threads, keeps the fastest number.
#include "scheduler/team/lane_choice.hpp"

#include <algorithm>
#include <bit>

namespace talus {

namespace {

constexpr double k_window = 0.02;  // several time slices of the kernel [s]
constexpr std::int64_t k_least_steps = 8;
constexpr double k_stalled = 0.2;  // share of a window lost in stalls beyond which fewer threads are tried
constexpr double k_gain = 0.95;    // fewer threads are kept where a step takes less than this of the time
constexpr double k_first_hold = 0.5, k_longest_hold = 5;  // [s]
constexpr double k_believed = 0.1;                        // of regular steps before a load is taken to be gone [s]
constexpr int k_most_repeats = 2;                         // of a trial that stalls itself

}  // namespace

void LaneChoice::Window::add(double seconds) {
  const auto ns = static_cast<std::uint64_t>(std::clamp(1e9 * seconds, 4.0, 1e12));
  const int octave = std::bit_width(ns) - 1;
  const auto quarter = static_cast<int>(ns >> (octave - 2) & 3U);
  const auto k = static_cast<std::size_t>(std::min(4 * octave + quarter, k_classes - 1));
  ++count[k];
  sum[k] += seconds;
  ++steps;
  total += seconds;
}

double LaneChoice::Window::stalled_share() const {
  // what the fastest tenth of the steps takes; a step of three times as long has waited for somebody
  double usual = 0, stalled = 0;
  std::int64_t seen = 0;
  for (std::size_t k = 0; k < count.size(); ++k) {
    if (count[k] == 0) continue;
    if (10 * seen <= steps) usual = sum[k] / count[k];
    seen += count[k];
    if (sum[k] > 3 * usual * count[k]) stalled += sum[k] - usual * count[k];
  }
  return stalled / total;
}

void LaneChoice::prepare(int threads) {
  *this = LaneChoice();
  all_ = now_ = best_ = most_ = std::max(1, threads);
  hold_ = k_first_hold;
  for (const int c : {all_ - 1, all_ / 2, 1})
    if (c >= 1 && c < all_ && (candidates_.empty() || c < candidates_.back())) candidates_.push_back(c);
}

void LaneChoice::step_done(double now, bool regular) {
  if (all_ == 1 || most_ == 1) return;
  const double before = last_;
  last_ = now;
  if (before < 0) return;  // the first step of a run, or with this number of threads
  if (begin_ < 0) begin_ = before;
  if (regular) window_.add(now - before);
  if (now - begin_ >= k_window && window_.steps >= k_least_steps) window_ends(now);
}

void LaneChoice::window_ends(double now) {
  switch (phase_) {
    case Phase::watch:
      watch_ends(now);
      break;
    case Phase::trial:
      trial_ends(now);
      break;
    case Phase::hold:
      if (now >= until_) {
        phase_ = Phase::watch;
        returned_ = best_ < all_;
        since_return_ = {};
        if (returned_ && window_.stalled_share() < k_stalled)
          best_mean_ = window_.mean();  // steps change as grains move
        work_with(all_);
      }
      break;
  }
  window_ = {};
  begin_ = -1;
}

void LaneChoice::watch_ends(double now) {
  if (returned_) {
    // Beside a load some windows happen to be free of it: all of them together are held against the number kept.
    since_return_.steps += window_.steps;
    since_return_.total += window_.total;
    if (best_mean_ < k_gain * since_return_.mean()) {
      hold_ = std::min(2 * hold_, k_longest_hold);
      keep(best_, best_mean_, now);
    } else if (since_return_.total >= k_believed) {
      hold_ = k_first_hold;
      returned_ = false;
    }
    return;
  }
  if (!(window_.stalled_share() > k_stalled)) return;
  best_ = all_;
  best_mean_ = k_gain * window_.mean();
  phase_ = Phase::trial;
  next_ = 0;
  repeats_ = 0;
  work_with(candidates_[0]);
}

void LaneChoice::trial_ends(double now) {
  // the kernel takes some time to move the threads that are left to the free cores
  if (window_.stalled_share() > k_stalled && ++repeats_ <= k_most_repeats) return;
  repeats_ = 0;
  if (window_.mean() < best_mean_) {
    best_ = now_;
    best_mean_ = window_.mean();
  }
  if (++next_ < candidates_.size())
    work_with(candidates_[next_]);
  else
    keep(best_, best_mean_, now);
}

void LaneChoice::keep(int threads, double mean, double now) {
  best_ = threads;
  best_mean_ = mean;
  phase_ = Phase::hold;
  // where all threads are the best for now, a change is looked for soon
  until_ = now + (threads < all_ ? hold_ : k_window);
  work_with(threads);
}

void LaneChoice::work_with(int threads) {
  if (threads == now_) return;
  now_ = threads;
  last_ = -1;  // the step that follows builds another graph
  ++changes_;
}

}  // namespace talus
