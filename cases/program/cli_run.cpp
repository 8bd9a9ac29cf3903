// `talus run SCENE`: the whole life of a run. Everything is validated and built before the folder is created; then the
// engine runs in slices up to the next output, checkpoint or signal. Invariants: slices and signals change no result;
// whatever ends the run (success, signal, physical failure) leaves a summary and readable files.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <memory>

#include "cases/program/cli.hpp"
#include "cases/program/cli_console.hpp"
#include "cases/program/cli_folder.hpp"
#include "cases/program/cli_outputs.hpp"
#include "cases/program/cli_schedule.hpp"
#include "cases/program/cli_signal.hpp"
#include "cases/program/cli_summary.hpp"
#include "cases/program/cli_timestep.hpp"
#include "cases/program/progress.hpp"
#include "core/base/text.hpp"
#include "core/scene/scene_forgotten.hpp"
#include "scheduler/simulation.hpp"

namespace talus::cli {
namespace {

/// Records the steps that --trace-from and --trace-steps name; the file is written as soon as they are over.
class TraceOnce {
 public:
  TraceOnce(Simulation& simulation, const Options& options)
      : path_(options.trace),
        from_(options.trace_from.value_or(simulation.step())),
        until_(from_ + options.trace_steps) {
    if (path_.empty()) return;
    if (until_ <= simulation.step() || from_ >= simulation.scene().steps)
      throw Error(ErrorCode::usage,
                  fmt::format("no step of this run ({} to {}) is in the trace", simulation.step(),
                              simulation.scene().steps - 1),
                  "--trace-from " + std::to_string(from_));
    simulation.start_trace(from_, options.trace_steps);
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

struct Outcome {
  int signal = 0;
  std::string failure;                  ///< message of the error that ended it
  ErrorCode code = ErrorCode::physics;  ///< of the failure
  std::string checkpoint;               ///< the last one
  double seconds = 0;                   ///< of the timed steps: after --warm, without the closing checkpoint
};

/// Says each kind of warning once, when it appears.
class WarningsOnce {
 public:
  void say(const Simulation& simulation) {
    for (; said_ < simulation.warnings().size(); ++said_)
      tell("{}talus: warning: {}\n", isatty(STDERR_FILENO) != 0 ? "\r\x1b[K" : "", simulation.warnings()[said_].text);
  }

 private:
  std::size_t said_ = 0;
};

/// After an output that could not be written: the state is good, so it is kept if there is room for it.
std::string rescue(const Simulation& simulation, RunOutputs& outputs) noexcept {
  try {
    return outputs.checkpoint(simulation);
  } catch (...) {
    return {};  // the checkpoints before are untouched
  }
}

/// The steps up to the last one or a signal, with all that is written meanwhile.
void advance(const Options& options, const Scene& scene, Simulation& simulation, RunOutputs& outputs,
             Progress& progress, const SignalGuard& signals, WarningsOnce& warnings, Outcome& outcome) {
  outputs.write(simulation);
  Slicer slicer;
  TraceOnce trace(simulation, options);
  warnings.say(simulation);
  // Benchmarks leave out the first steps: first-touch page faults and buffers that still grow are not the code's speed.
  const std::int64_t warm = simulation.step() + options.warm;
  while (simulation.step() < scene.steps && signals.caught() == 0) {
    const std::int64_t step = simulation.step();
    std::int64_t stop = trace.stop(std::min(scene.steps, outputs.next_stop(step)));
    if (step < warm) stop = std::min(stop, warm);
    const std::int64_t count = slicer.next(step, stop > step ? stop : scene.steps);
    const auto begin = std::chrono::steady_clock::now();
    simulation.run(count);
    slicer.measured(count, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    outputs.write(simulation);
    warnings.say(simulation);
    trace.after(simulation, false);
    progress.update(simulation.step(), simulation.time(), simulation.particles());
    if (options.warm > 0 && simulation.step() == warm) {
      progress.restart();
      simulation.restart_profile();
    }
  }
  outcome.seconds = progress.seconds();
  outcome.signal = simulation.step() < scene.steps ? signals.caught() : 0;
  // Also at the end: the state to continue from (more steps, or another scene such as the discharge of a full silo).
  outcome.checkpoint = outputs.checkpoint(simulation);
  outputs.check();
  trace.after(simulation, true);
}

/// Runs to the last step, a signal, or an error of the physics or of an output.
Outcome run_to_end(const Options& options, const Scene& scene, Simulation& simulation, RunOutputs& outputs,
                   Progress& progress, const SignalGuard& signals) {
  Outcome outcome;
  WarningsOnce warnings;
  try {
    advance(options, scene, simulation, outputs, progress, signals, warnings, outcome);
  } catch (const Error& e) {
    if (e.code() != ErrorCode::physics && e.code() != ErrorCode::io) throw;
    outcome.failure = e.what();
    outcome.code = e.code();
    if (outcome.seconds == 0) outcome.seconds = progress.seconds();
    warnings.say(simulation);
    outcome.checkpoint =
        e.code() == ErrorCode::physics ? outputs.dump_failure(simulation) : rescue(simulation, outputs);
  }
  progress.finish();
  return outcome;
}

/// Messages of a run that failed, and its exit code.
int tell_failure(const Outcome& outcome, const RunFolder& folder) {
  tell("talus: error: {}\n", outcome.failure);
  if (!outcome.checkpoint.empty()) tell("talus: the last state is in {}\n", outcome.checkpoint);
  if (outcome.code == ErrorCode::physics) tell("talus: what was written until then is in {}/\n", folder.dir());
  return static_cast<int>(outcome.code);
}

void print_closing(const Options& options, const std::string& folder, const Summary& s, const RunOutputs& outputs,
                   const Outcome& outcome) {
  put("\n{} at step {} (t = {:.6g} s) after {}: {} particles, {:.2f} M particle-steps/s, state hash {:016x}\n",
      outcome.signal != 0 ? "Stopped" : "Done", s.last_step, s.simulated_time, duration_text(s.wall_s),
      grouped(s.particles), s.particle_steps_per_s * 1e-6, s.state_hash);
  put("Results are in {}/\n", folder);
  const auto line = [](const char* what, const std::string& path) {
    if (!path.empty()) put("  {:<12} {}\n", what, path);
  };
  line("summary", folder + "/summary.json");
  line("time series", outputs.csv_file());
  line("checkpoint", outcome.checkpoint);
  if (!outputs.paraview_file().empty()) {
    line("particles", outputs.paraview_file());
    const bool hdf = outputs.paraview_file().ends_with(".vtkhdf");
    put("Look at them:   paraview {}{}\n", outputs.paraview_file(),
        hdf ? "    (ParaView 5.12 or newer; output.vtp = true for older ones)" : "");
  }
  put("Report:         {} report {}    (one HTML page with plots and pictures)\n", options.program, folder);
  if (outcome.signal != 0) put("Continue:       {} run {} --resume {}\n", options.program, options.scene, folder);
}
/// Table of the nodes of the step and where the threads' time went, for the timed steps (after --warm).
void print_profile(const Profile& p, double particle_steps) {
  const double steps = static_cast<double>(std::max<std::int64_t>(p.steps, 1));
  const double total = p.wall * static_cast<double>(p.threads.size());
  const auto percent = [](double part, double whole) { return whole > 0 ? 100 * part / whole : 0.0; };
  const auto row = [&](const std::string& name, const std::string& calls, double seconds,
                       const std::string& imbalance) {
    put("{:<20}{:>12}{:>12.3f}{:>8.1f}%{:>12.2f}{:>11}\n", name, calls, seconds, percent(seconds, total),
        particle_steps > 0 ? 1e9 * seconds / particle_steps : 0.0, imbalance);
  };
  put("{:<20}{:>12}{:>12}{:>9}{:>12}{:>11}\n", "node", "calls", "seconds", "share", "ns/p-step", "imbalance");
  for (const NodeTime& n : p.nodes) row(n.node, std::to_string(n.calls), n.seconds, fmt::format("{:.2f}", n.imbalance));
  double waiting = 0, idle = 0;
  for (const Profile::Thread& t : p.threads) {
    waiting += t.waiting;
    idle += t.idle;
  }
  if (p.threads.size() > 1) row("waiting in a node", "", waiting, "");
  row("scheduler and idle", "", idle, "");
  for (std::size_t k = 0; k < p.threads.size(); ++k) {
    const Profile::Thread& t = p.threads[k];
    put("thread {:<3} busy {:.3f} s ({:.1f} %), waiting {:.3f} s ({:.1f} %), idle {:.3f} s ({:.1f} %)\n", k, t.busy,
        percent(t.busy, p.wall), t.waiting, percent(t.waiting, p.wall), t.idle, percent(t.idle, p.wall));
  }
  const double hops = p.hop * static_cast<double>(p.tasks), reads = static_cast<double>(p.clock_reads);
  put("scheduler: {:.3f} us from a chunk's node to its next one, x {} executions = {:.3f} s ({:.2f} %)\n", 1e6 * p.hop,
      p.tasks, hops, percent(hops, total));
  put("clock: {:.0f} reads per step, {:.1f} ns each = {:.4f} s ({:.3f} %), always on\n", reads / steps,
      1e9 * p.clock_read, reads * p.clock_read, percent(reads * p.clock_read, total));
}

}  // namespace

int run(const Options& options) {
  const SignalGuard signals;  // from here on: a signal before the first step leaves a checkpoint, too
  const Start start = find_start(options);
  const Scene& scene = start.scene.scene;
  require_room(scene);
  tell_changes(start, options.quiet);

  const RunOptions& engine = options.run;
  std::unique_ptr<Simulation> simulation =
      start.checkpoint ? std::make_unique<Simulation>(scene, engine, *start.checkpoint, start.walls)
                       : std::make_unique<Simulation>(scene, engine);
  if (const std::string& warning = simulation->time_step().warning; !warning.empty())
    tell("talus: warning: {}\n", warning);
  if (start.checkpoint && simulation->step() > scene.steps) {
    throw Error(ErrorCode::usage,
                fmt::format("the checkpoint is at step {}, after the last step {}", simulation->step(), scene.steps),
                start.checkpoint->path(), "ask for more with --steps N");
  }
  const std::int64_t first = simulation->step();
  if (!options.quiet && !start.checkpoint)
    for (const std::string& note : forgotten_keys(start.scene)) tell("talus: note: {}\n", note);

  // From here on the scene is known to be good: only now may something appear on disk.
  const RunFolder folder = open_folder(options, start);
  if (!options.quiet)
    for (const auto& [wall, report] : simulation->meshes())
      tell("talus: wall \"{}\", mesh {}: {}\n", shown(wall), shown(report.file), describe(report));
  RunOutputs outputs(folder, *simulation, start.checkpoint ? &*start.checkpoint : nullptr, start.own.has_value(),
                     options.checkpoint_every, scene_record(start.scene));
  Progress progress(stderr, Progress::style_for(stderr, options.quiet), first, scene.steps);
  const Outcome outcome = run_to_end(options, scene, *simulation, outputs, progress, signals);

  const Summary summary = summary_of(
      *simulation, {outcome.seconds, progress.particle_steps(), first, outcome.signal, engine.audit, outcome.failure});
  try {
    write_summary(folder.summary(), summary);
  } catch (const Error&) {
    if (outcome.failure.empty()) throw;  // else the first error is the message that counts
  }
  if (!outcome.failure.empty()) return tell_failure(outcome, folder);
  if (options.json) {
    put_text(summary_json(summary));
  } else {
    if (options.run.profile) print_profile(simulation->profile(), progress.particle_steps());
    if (!options.quiet) print_closing(options, folder.dir(), summary, outputs, outcome);
  }
  return outcome.signal != 0 ? 128 + outcome.signal : 0;
}

}  // namespace talus::cli
