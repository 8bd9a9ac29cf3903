// When a run stops to write: steps derived from output times, and slices short enough to answer a signal.
// Called by scheduler/run/run.cpp. Invariant: output steps are a function of the scene alone; each time is rounded to a
// step once (k * every / dt), never summed, so that a resumed run writes at the same steps.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace talus {

/// Steps of an output that repeats every `every` seconds of simulated time.
class Repeat {
 public:
  /// every <= 0: never. `dt` [s] > 0.
  Repeat(double every, double dt) : ratio_(every > 0 ? std::clamp(every / dt, k_densest, k_rarest) : 0) {}
  bool on() const noexcept { return ratio_ > 0; }
  /// True at step 0, round(ratio), round(2 ratio), …
  bool due(std::int64_t step) const noexcept;
  /// First due step > `step`, INT64_MAX if there is none.
  std::int64_t after(std::int64_t step) const noexcept;

 private:
  // A quotient that under- or overflows is still an output that was asked for.
  static constexpr double k_densest = 1e-300, k_rarest = 1e300;
  double ratio_;  ///< steps between two outputs, not an integer in general
};

/// Something that is done again after so many seconds of wall time. Its cost stays below 2 % of the time.
class WallInterval {
 public:
  using Clock = std::chrono::steady_clock;
  /// seconds <= 0: never due.
  explicit WallInterval(double seconds) : seconds_(seconds), last_(Clock::now()) {}
  bool due() const noexcept { return due(Clock::now()); }
  bool due(Clock::time_point now) const noexcept {
    constexpr double k_share = 50;
    return seconds_ > 0 && seconds_between(last_, now) >= std::max(seconds_, k_share * cost_);
  }
  void begin() noexcept { begin(Clock::now()); }
  void begin(Clock::time_point now) noexcept { last_ = now; }
  void done() noexcept { done(Clock::now()); }
  void done(Clock::time_point now) noexcept {
    cost_ = seconds_between(last_, now);
    last_ = now;
  }

 private:
  static double seconds_between(Clock::time_point a, Clock::time_point b) noexcept {
    return std::chrono::duration<double>(b - a).count();
  }
  double seconds_, cost_ = 0;  ///< [s]; cost: of the last time
  Clock::time_point last_;
};

/// Chooses how many steps run before the program looks up again; never influences a result.
class Slicer {
 public:
  /// Steps for the next slice, at most `until` - `now`, >= 1 where until > now.
  std::int64_t next(std::int64_t now, std::int64_t until) const noexcept;
  /// The last slice of `steps` took `seconds`.
  void measured(std::int64_t steps, double seconds) noexcept;

 private:
  std::int64_t length_ = 1;
};

}  // namespace talus
