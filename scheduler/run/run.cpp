// See run.hpp.
#include "scheduler/run/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "scheduler/run/schedule.hpp"

namespace talus {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

/// Records the steps to trace; the file is written as soon as they are over.
class TraceOnce {
 public:
  TraceOnce(Simulation& simulation, const RunWish& wish)
      : path_(wish.trace), from_(wish.trace_from.value_or(simulation.step())), until_(from_ + wish.trace_steps) {
    if (path_.empty()) return;
    if (until_ <= simulation.step() || from_ >= simulation.scene().steps)
      throw Error(ErrorCode::usage,
                  fmt::format("no step of this run ({} to {}) is in the trace", simulation.step(),
                              simulation.scene().steps - 1),
                  "--trace-from " + std::to_string(from_));
    simulation.start_trace(from_, wish.trace_steps);
  }
  std::int64_t stop(std::int64_t last) const { return path_.empty() ? last : std::min(last, until_); }
  void after(const Simulation& simulation, bool ending) {
    if (path_.empty() || (simulation.step() < until_ && !ending)) return;
    simulation.write_trace(path_);
    path_.clear();
  }

 private:
  std::string path_;
  std::int64_t from_, until_;
};

/// One run: its outcome grows while it goes on.
class Runner {
 public:
  Runner(Simulation& simulation, RunOutputs& outputs, const RunWish& wish, RunWatcher& watcher)
      : simulation_(simulation), outputs_(outputs), wish_(wish), watcher_(watcher) {}

  RunOutcome run() {
    try {
      advance();
    } catch (const Error& e) {
      if (e.code() != ErrorCode::physics && e.code() != ErrorCode::io) throw;
      out_.failure = e.what();
      // A part that judges its own state knows no clock.
      if (e.code() == ErrorCode::physics && !out_.failure.starts_with("step "))
        out_.failure = fmt::format("step {}: {}", simulation_.step(), out_.failure);
      out_.code = e.code();
      if (out_.seconds == 0) out_.seconds = seconds_since(begin_);
      say_warnings();
      out_.checkpoint = e.code() == ErrorCode::physics ? outputs_.dump_failure(simulation_) : rescue();
    }
    return std::move(out_);
  }

 private:
  /// The steps up to the last one or a stop, with all that is written meanwhile.
  void advance() {
    const std::int64_t last = simulation_.scene().steps;
    outputs_.write(simulation_);
    Slicer slicer;
    TraceOnce trace(simulation_, wish_);
    say_warnings();
    // Benchmarks leave out the first steps: first-touch page faults and buffers that still grow are not the code's
    // speed.
    const std::int64_t warm = simulation_.step() + wish_.warm;
    while (simulation_.step() < last && watcher_.stop() == 0) {
      const std::int64_t step = simulation_.step();
      std::int64_t stop = trace.stop(std::min(last, outputs_.next_stop(step)));
      if (step < warm) stop = std::min(stop, warm);
      step_slice(slicer, slicer.next(step, stop > step ? stop : last));
      trace.after(simulation_, false);
      watcher_.stepped(simulation_);
      if (wish_.warm > 0 && simulation_.step() == warm) restart();
    }
    out_.seconds = seconds_since(begin_);
    out_.signal = simulation_.step() < last ? watcher_.stop() : 0;
    // Also at the end: the state to continue from (more steps, or another scene such as the discharge of a full silo).
    out_.checkpoint = outputs_.checkpoint(simulation_);
    outputs_.check();
    trace.after(simulation_, true);
  }

  void step_slice(Slicer& slicer, std::int64_t count) {
    const auto begin = Clock::now();
    simulation_.run(count);
    slicer.measured(count, seconds_since(begin));
    out_.particle_steps += static_cast<double>(count) * static_cast<double>(simulation_.particles());
    outputs_.write(simulation_);
    say_warnings();
  }

  void restart() {
    begin_ = Clock::now();
    out_.particle_steps = 0;
    watcher_.warmed_up();
    simulation_.restart_profile();
  }

  void say_warnings() {
    for (; said_ < simulation_.warnings().size(); ++said_) watcher_.warn(simulation_.warnings()[said_].text);
  }

  /// After an output that could not be written: the state is good, so it is kept if there is room for it.
  std::string rescue() noexcept {
    try {
      return outputs_.checkpoint(simulation_);
    } catch (...) {
      return {};  // the checkpoints before are untouched
    }
  }

  Simulation& simulation_;
  RunOutputs& outputs_;
  const RunWish& wish_;
  RunWatcher& watcher_;
  RunOutcome out_;
  Clock::time_point begin_ = Clock::now();
  std::size_t said_ = 0;
};

}  // namespace

RunOutcome run_to_end(Simulation& simulation, RunOutputs& outputs, const RunWish& wish, RunWatcher& watcher) {
  return Runner(simulation, outputs, wish, watcher).run();
}

}  // namespace talus
