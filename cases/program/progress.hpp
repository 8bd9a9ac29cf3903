// Progress of a run on a terminal (one line that is rewritten) or in a log (one line per 10 %, and one per 10 minutes).
// Called by cli_run.cpp. Invariants: writes to the given stream only, at most ten times a second on a terminal, never
// after finish(); a line on a terminal is shorter than the terminal is wide, since one that wraps cannot be rewritten.
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <string>

namespace talus::cli {

/// "4.2 s", "3:07", "2:05:10"; "?" where nothing is known yet. [s]
std::string duration_text(double seconds);

/// Speed over the last 10 to 20 s, and what it says about the end: filling and flowing differ by a factor of several.
class Pace {
 public:
  explicit Pace(double steps = 0) : mark_{0, steps, 0}, next_{0, steps, 0}, now_{0, steps, 0} {}
  /// After `now` seconds, `steps` and `work` are done; none of them ever falls.
  void note(double now, double steps, double work);
  double steps_per_s() const;             ///< 0 where nothing is known yet
  double work_per_s() const;              ///< the same
  double seconds_to(double steps) const;  ///< until so many are done; -1 where nothing is known yet

 private:
  struct Point {
    double seconds, steps, work;
  };
  Point mark_, next_, now_;  ///< older end of the window; becomes it next; newest
};

/// What a progress line can tell.
struct ProgressFacts {
  double share = 0;  ///< done, 0 to 1
  std::int64_t step = 0, last = 0;
  double time = 0;  ///< simulated [s]
  std::int64_t particles = 0;
  double work_per_s = 0;  ///< particle-steps per second
  double eta = -1;        ///< [s]; -1 where nothing is known yet
};

/// All of it, for a log.
std::string log_line(const ProgressFacts& facts);
/// As much of it as is shorter than `columns`: share and end first, then rate, bar, step, time, particles.
std::string terminal_line(const ProgressFacts& facts, int columns);
/// Width of the terminal behind a descriptor: its own answer, else $COLUMNS, else 80.
int terminal_columns(int descriptor);

class Progress {
 public:
  enum class Style { off, bar, lines };
  /// bar where `stream` is a terminal that can rewrite a line, lines otherwise.
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
  void show(const std::string& text);

  std::FILE* stream_;
  Style style_;
  std::int64_t first_, last_, step_;
  Clock::time_point start_;
  double particle_steps_ = 0;
  double drawn_ = -1;  ///< time of the last drawing or line [s]
  int tenths_ = 0;     ///< 10 % marks already printed
  Pace pace_;
  bool line_open_ = false;
};

}  // namespace talus::cli
