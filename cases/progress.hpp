// Progress of a run on a terminal (one line that is rewritten) or in a log (one line per 10 %). Called by cli_run.cpp.
// Invariant: writes to the given stream only, at most ten times a second on a terminal, never after finish().
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <string>

namespace talus::cli {

/// "4.2 s", "3:07", "2:05:10"; "?" where nothing is known yet. [s]
std::string duration_text(double seconds);

class Progress {
 public:
  enum class Style { off, bar, lines };
  /// bar where `stream` is a terminal, lines otherwise.
  static Style style_for(std::FILE* stream, bool quiet);

  Progress(std::FILE* stream, Style style, std::int64_t first_step, std::int64_t last_step);
  ~Progress() { finish(); }  ///< an error must not be printed behind a bar
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  /// `step` done, at simulated time `time` [s] with `particles` present; call after every slice.
  void update(std::int64_t step, double time, std::int64_t particles);
  /// Clock and work start anew here: seconds() and particle_steps() count from now on.
  void restart();
  /// Ends the line of the bar, so that later text starts on its own line.
  void finish();

  double seconds() const;  ///< since construction [s]
  double particle_steps() const { return particle_steps_; }

 private:
  using Clock = std::chrono::steady_clock;
  double recent_rate(double now) const;  ///< particle-steps/s over the last seconds

  std::FILE* stream_;
  Style style_;
  std::int64_t first_, last_, step_;
  Clock::time_point start_;
  double particle_steps_ = 0;
  double drawn_ = -1;  ///< time of the last drawing [s]
  int tenths_ = 0;     ///< 10 % marks already printed
  // The ETA follows the recent speed: filling and flowing differ by a factor of several.
  double mark_seconds_ = 0, mark_steps_ = 0, mark_work_ = 0;  ///< older end of the averaging window
  double next_seconds_ = 0, next_steps_ = 0, next_work_ = 0;  ///< becomes the older end next
  bool line_open_ = false;
};

}  // namespace talus::cli
