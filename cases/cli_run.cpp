// `talus run SCENE`: the whole life of a run. Everything is validated and built before the folder is created; then the
// engine runs in slices up to the next output, checkpoint or signal. Invariants: slices and signals change no result;
// whatever ends the run (success, signal, physical failure) leaves a summary and readable files.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>

#include "cases/cli.hpp"
#include "cases/cli_folder.hpp"
#include "cases/cli_outputs.hpp"
#include "cases/cli_schedule.hpp"
#include "cases/cli_signal.hpp"
#include "cases/cli_summary.hpp"
#include "cases/cli_timestep.hpp"
#include "cases/progress.hpp"
#include "scheduler/simulation.hpp"

namespace talus::cli {
namespace {

constexpr std::int64_t k_trace_steps = 200;  // enough to see rebuilds; more makes files that no viewer opens

/// A trace of the first steps, then full speed: the file is written as soon as they are over.
class TraceOnce {
 public:
  TraceOnce(Simulation& simulation, std::string path)
      : path_(std::move(path)), until_(simulation.step() + k_trace_steps) {
    if (!path_.empty()) simulation.start_trace();
  }
  std::int64_t stop(std::int64_t last) const { return path_.empty() ? last : std::min(last, until_); }
  void after(const Simulation& simulation, bool ending) {
    if (path_.empty() || (simulation.step() < until_ && !ending)) return;
    simulation.write_trace(path_);
    path_.clear();
  }

 private:
  std::string path_;
  std::int64_t until_;
};

struct Outcome {
  int signal = 0;
  std::string failure;     ///< message of Error{physics}
  std::string checkpoint;  ///< the last one
  double seconds = 0;      ///< of the timed steps: after --warm, without the closing checkpoint
};

/// Runs to the last step, a signal or a physical failure.
Outcome advance(const Options& options, const Scene& scene, Simulation& simulation, RunOutputs& outputs,
                Progress& progress) {
  Outcome outcome;
  SignalGuard signals;
  Slicer slicer;
  TraceOnce trace(simulation, options.trace);
  // Benchmarks leave out the first steps: first-touch page faults and buffers that still grow are not the code's speed.
  const std::int64_t warm = simulation.step() + options.warm;
  try {
    while (simulation.step() < scene.steps && signals.caught() == 0) {
      const std::int64_t step = simulation.step();
      std::int64_t stop = trace.stop(std::min(scene.steps, outputs.next_stop(step)));
      if (step < warm) stop = std::min(stop, warm);
      const std::int64_t count = slicer.next(step, stop > step ? stop : scene.steps);
      const auto begin = std::chrono::steady_clock::now();
      simulation.run(count);
      slicer.measured(count, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
      outputs.write(simulation);
      trace.after(simulation, false);
      progress.update(simulation.step(), simulation.time(), simulation.particles());
      if (simulation.step() == warm) progress.restart();
    }
    outcome.seconds = progress.seconds();
    outcome.signal = simulation.step() < scene.steps ? signals.caught() : 0;
    // Also at the end: the state to continue from (more steps, or another scene such as the discharge of a full silo).
    outcome.checkpoint = outputs.checkpoint(simulation);
  } catch (const Error& e) {
    if (e.code() != ErrorCode::physics) throw;
    outcome.failure = e.what();
    outcome.seconds = progress.seconds();
    outcome.checkpoint = outputs.dump_failure(simulation);
  }
  progress.finish();
  trace.after(simulation, true);
  return outcome;
}

void print_closing(const Options& options, const std::string& folder, const Summary& s, const RunOutputs& outputs,
                   const Outcome& outcome) {
  fmt::print("\n{} at step {} (t = {:.6g} s) after {}: {} particles, {:.2f} M particle-steps/s, state hash {:016x}\n",
             outcome.signal != 0 ? "Stopped" : "Done", s.last_step, s.simulated_time, duration_text(s.wall_s),
             grouped(s.particles), s.particle_steps_per_s * 1e-6, s.state_hash);
  fmt::print("Results are in {}/\n", folder);
  const auto line = [](const char* what, const std::string& path) {
    if (!path.empty()) fmt::print("  {:<12} {}\n", what, path);
  };
  line("summary", folder + "/summary.json");
  line("time series", outputs.csv_file());
  line("checkpoint", outcome.checkpoint);
  if (!outputs.paraview_file().empty()) {
    line("particles", outputs.paraview_file());
    const bool hdf = outputs.paraview_file().ends_with(".vtkhdf");
    fmt::print("Look at them:   paraview {}{}\n", outputs.paraview_file(),
               hdf ? "    (ParaView 5.12 or newer; --set output.vtp=true for older ones)" : "");
  }
  fmt::print("Report:         {} report {}    (one HTML page with plots and pictures)\n", options.program, folder);
  if (outcome.signal != 0)
    fmt::print("Continue:       {} run {} --resume {}\n", options.program, options.scene, folder);
}
/// Table of the nodes of the step: calls, seconds summed over threads, share, time per particle-step.
void print_profile(const Summary& summary, double particle_steps) {
  double total = 0;
  for (const auto& n : summary.nodes) total += n.seconds;
  fmt::print("{:<20}{:>12}{:>12}{:>9}{:>12}\n", "node", "calls", "seconds", "share", "ns/p-step");
  for (const auto& n : summary.nodes)
    fmt::print("{:<20}{:>12}{:>12.3f}{:>8.1f}%{:>12.2f}\n", n.name, n.calls, n.seconds,
               total > 0 ? 100 * n.seconds / total : 0.0, particle_steps > 0 ? 1e9 * n.seconds / particle_steps : 0.0);
}

}  // namespace

int run(const Options& options) {
  const Scene scene = scene_of(options);
  const TimeStepReport time_step = judge_time_step(scene);
  const Start start = find_start(options, scene);
  if (!time_step.warning.empty()) fmt::print(stderr, "talus: warning: {}\n", time_step.warning);

  const RunOptions& engine = options.run;
  std::unique_ptr<Simulation> simulation = start.checkpoint
                                               ? std::make_unique<Simulation>(scene, engine, *start.checkpoint)
                                               : std::make_unique<Simulation>(scene, engine);
  if (start.checkpoint && simulation->step() > scene.steps) {
    throw Error(ErrorCode::usage,
                fmt::format("the checkpoint is at step {}, after the last step {}", simulation->step(), scene.steps),
                start.checkpoint->path(), "ask for more with --steps N");
  }
  const std::int64_t first = simulation->step();

  // From here on the scene is known to be good: only now may something appear on disk.
  const RunFolder folder = open_folder(options, scene, start);
  RunOutputs outputs(folder, *simulation, start.checkpoint ? &*start.checkpoint : nullptr, start.append,
                     options.checkpoint_every);
  Progress progress(stderr, Progress::style_for(stderr, options.quiet), first, scene.steps);
  outputs.write(*simulation);
  const Outcome outcome = advance(options, scene, *simulation, outputs, progress);

  const Summary summary = summary_of(
      *simulation, {outcome.seconds, progress.particle_steps(), first, outcome.signal, engine.audit, outcome.failure});
  write_summary(folder.summary(), summary);
  if (!outcome.failure.empty()) {
    fmt::print(stderr, "talus: error: {}\n", outcome.failure);
    if (!outcome.checkpoint.empty()) fmt::print(stderr, "talus: the last state is in {}\n", outcome.checkpoint);
    fmt::print(stderr, "talus: what was written until then is in {}/\n", folder.dir());
    return static_cast<int>(ErrorCode::physics);
  }
  if (options.json) {
    fmt::print("{}", summary_json(summary));
  } else if (!options.quiet) {
    if (options.run.profile) print_profile(summary, progress.particle_steps());
    print_closing(options, folder.dir(), summary, outputs, outcome);
  }
  return outcome.signal != 0 ? 128 + outcome.signal : 0;
}

}  // namespace talus::cli
