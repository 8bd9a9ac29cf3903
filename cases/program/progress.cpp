// Progress display; see progress.hpp.
#include "cases/program/progress.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/count.hpp"

namespace talus::cli {
namespace {
constexpr double k_redraw_s = 0.1;   // fast enough for the eye, no load for a slow terminal
constexpr double k_window_s = 10.0;  // the averaging window of speed and ETA is 10 to 20 s
constexpr double k_start_s = 0.25;   // the first steps touch memory: they say little of the others
constexpr double k_silence_s = 600;  // a log shows that a long run is alive
constexpr int k_bar_least = 6, k_bar_most = 24;

std::string rate_text(double particle_steps_per_s) {
  if (particle_steps_per_s >= 1e6) return fmt::format("{:.2f} M", particle_steps_per_s * 1e-6);
  return fmt::format("{:.0f} k", particle_steps_per_s * 1e-3);
}

std::string bar_text(double share, int width) {
  const int filled = std::clamp(static_cast<int>(share * width), 0, width);
  return "[" + std::string(static_cast<std::size_t>(filled), '#') +
         std::string(static_cast<std::size_t>(width - filled), '.') + "]";
}
}  // namespace

std::string log_line(const ProgressFacts& f) {
  return fmt::format("{:5.1f} %  step {}/{}  t = {:.4g} s  {} particles  {} particle-steps/s  ETA {}", 100 * f.share,
                     f.step, f.last, f.time, f.particles, rate_text(f.work_per_s), duration_text(f.eta));
}

std::string terminal_line(const ProgressFacts& f, int columns) {
  const std::size_t room = static_cast<std::size_t>(std::max(columns, 1)) - 1;  // the last column would wrap
  const std::string percent = fmt::format("{:5.1f} %", 100 * f.share), rate = rate_text(f.work_per_s);
  const std::string end = "ETA " + duration_text(f.eta), last = fmt::format("{}", f.last);
  // In the order of the line; empty until it is known to fit.
  std::string bar, step, time, particles, speed, eta;
  std::size_t used = percent.size();
  const auto add = [&](std::string& part, std::string text) {
    if (used + 2 + text.size() > room) return false;
    used += 2 + text.size();
    part = std::move(text);
    return true;
  };
  if (percent.size() > room) return percent.substr(0, room);
  if (!add(eta, end)) return percent.size() + 1 + end.size() > room ? percent : percent + " " + end;
  if (!add(speed, rate + " particle-steps/s")) add(speed, rate + "/s");
  add(bar, bar_text(f.share, k_bar_least));
  add(step, fmt::format("step {:>{}}/{}", f.step, last.size(), last));
  add(time, fmt::format("t = {:.4g} s", f.time));
  add(particles, fmt::format("{} particles", f.particles));
  if (!bar.empty()) {
    const std::size_t more = std::min<std::size_t>(room - used, k_bar_most - k_bar_least);
    bar = bar_text(f.share, k_bar_least + static_cast<int>(more));
  }
  std::string line;
  for (const std::string& part : {bar, percent, step, time, particles, speed, eta})
    if (!part.empty()) line += (line.empty() ? "" : "  ") + part;
  return line;
}

int terminal_columns(int descriptor) {
  constexpr int usual = 80, most = 10000;
  struct winsize size = {};
  if (ioctl(descriptor, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
  const char* text = std::getenv("COLUMNS");
  const std::string_view digits = text != nullptr ? text : "";
  int columns = 0;
  const auto parsed = std::from_chars(digits.data(), digits.data() + digits.size(), columns);
  const bool good = parsed.ec == std::errc() && parsed.ptr == digits.data() + digits.size();
  return good && columns > 0 && columns <= most ? columns : usual;
}

std::string duration_text(double seconds) {
  if (!(seconds >= 0) || seconds > 1e9) return "?";
  if (seconds < 60) return fmt::format("{:.1f} s", seconds);
  const auto s = count_nearest(seconds);
  if (s < 3600) return fmt::format("{}:{:02d}", s / 60, s % 60);
  return fmt::format("{}:{:02d}:{:02d}", s / 3600, s / 60 % 60, s % 60);
}

Progress::Style Progress::style_for(std::FILE* stream, bool quiet) {
  if (quiet) return Style::off;
  const char* kind = std::getenv("TERM");
  const bool rewrites = kind == nullptr || std::string_view(kind) != "dumb";
  return isatty(fileno(stream)) && rewrites ? Style::bar : Style::lines;
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
  if (now_.seconds < k_start_s) return -1;
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
  const ProgressFacts facts{done / total, step, last_, time, particles, pace_.work_per_s(), pace_.seconds_to(total)};
  if (style_ == Style::bar) {
    if (drawn_ >= 0 && now - drawn_ < k_redraw_s && step < last_) return;
    // ESC [K clears what a longer previous line left behind. The width may change at any time.
    show("\r" + terminal_line(facts, terminal_columns(fileno(stream_))) + "\x1b[K");
    line_open_ = true;
  } else {
    const int tenths = static_cast<int>(10 * done / total);
    if (tenths <= tenths_ && now - std::max(drawn_, 0.0) < k_silence_s) return;
    tenths_ = tenths;
    show(log_line(facts) + "\n");
  }
  drawn_ = now;
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
