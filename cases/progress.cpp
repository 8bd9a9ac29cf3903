// Progress display; see progress.hpp.
#include "cases/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "core/count.hpp"

namespace talus::cli {
namespace {
constexpr double k_redraw_s = 0.1;   // fast enough for the eye, no load for a slow terminal
constexpr double k_window_s = 10.0;  // the averaging window of speed and ETA is 10 to 20 s
constexpr int k_bar_width = 24;

std::string rate_text(double particle_steps_per_s) {
  if (particle_steps_per_s >= 1e6) return fmt::format("{:.2f} M particle-steps/s", particle_steps_per_s * 1e-6);
  return fmt::format("{:.0f} k particle-steps/s", particle_steps_per_s * 1e-3);
}
}  // namespace

std::string duration_text(double seconds) {
  if (!(seconds >= 0) || seconds > 1e9) return "?";
  if (seconds < 60) return fmt::format("{:.1f} s", seconds);
  const auto s = count_nearest(seconds);
  if (s < 3600) return fmt::format("{}:{:02d}", s / 60, s % 60);
  return fmt::format("{}:{:02d}:{:02d}", s / 3600, s / 60 % 60, s % 60);
}

Progress::Style Progress::style_for(std::FILE* stream, bool quiet) {
  if (quiet) return Style::off;
  return isatty(fileno(stream)) ? Style::bar : Style::lines;
}

Progress::Progress(std::FILE* stream, Style style, std::int64_t first_step, std::int64_t last_step)
    : stream_(stream), style_(style), first_(first_step), last_(last_step), step_(first_step), start_(Clock::now()) {}

double Progress::seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

void Progress::restart() {
  start_ = Clock::now();
  particle_steps_ = 0;
  drawn_ = -1;
  pace_ = Pace(static_cast<double>(step_ - first_));
}

void Pace::note(double now, double steps, double work) {
  if (now - next_.seconds > k_window_s) mark_ = std::exchange(next_, {now, steps, work});
  now_ = {now, steps, work};
}

double Pace::steps_per_s() const {
  return now_.seconds > mark_.seconds ? (now_.steps - mark_.steps) / (now_.seconds - mark_.seconds) : 0;
}

double Pace::work_per_s() const {
  return now_.seconds > mark_.seconds ? (now_.work - mark_.work) / (now_.seconds - mark_.seconds) : 0;
}

double Pace::seconds_to(double steps) const {
  const double rate = steps_per_s();
  return rate > 0 ? std::max(0.0, steps - now_.steps) / rate : -1;
}

void Progress::update(std::int64_t step, double time, std::int64_t particles) {
  const double now = seconds();
  particle_steps_ += static_cast<double>(step - step_) * static_cast<double>(particles);
  step_ = step;
  const double done = static_cast<double>(step - first_);
  pace_.note(now, done, particle_steps_);
  if (style_ == Style::off) return;

  const double total = static_cast<double>(std::max<std::int64_t>(1, last_ - first_));
  const double share = done / total;
  const std::string eta = duration_text(pace_.seconds_to(total));
  const auto text = [&] {
    return fmt::format("{:5.1f} %  step {}/{}  t = {:.4g} s  {} particles  {}  ETA {}", 100 * share, step, last_, time,
                       particles, rate_text(pace_.work_per_s()), eta);
  };
  if (style_ == Style::bar) {
    if (drawn_ >= 0 && now - drawn_ < k_redraw_s && step < last_) return;
    drawn_ = now;
    const int filled = std::clamp(static_cast<int>(share * k_bar_width), 0, k_bar_width);
    // ESC [K clears what a longer previous line left behind.
    show(fmt::format("\r[{}{}] {}\x1b[K", std::string(filled, '#'), std::string(k_bar_width - filled, '.'), text()));
    line_open_ = true;
  } else {
    const int tenths = static_cast<int>(10 * (step - first_) / std::max<std::int64_t>(1, last_ - first_));
    if (tenths <= tenths_) return;
    tenths_ = tenths;
    show(text() + "\n");
  }
}

void Progress::show(const std::string& text) {
  // A terminal that is gone must not end a run.
  static_cast<void>(std::fwrite(text.data(), 1, text.size(), stream_));
  static_cast<void>(std::fflush(stream_));
}

void Progress::finish() {
  if (line_open_) show("\n");
  line_open_ = false;
  style_ = Style::off;
}

}  // namespace talus::cli
