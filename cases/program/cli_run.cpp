// `talus run SCENE`: everything is validated and built before the folder is created; then scheduler/run goes through
// the steps. Invariant: whatever ends the run (success, signal, physical failure) leaves a summary and readable files.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "cases/program/cli.hpp"
#include "cases/program/cli_console.hpp"
#include "cases/program/cli_folder.hpp"
#include "cases/program/cli_signal.hpp"
#include "cases/program/cli_timestep.hpp"
#include "cases/program/progress.hpp"
#include "core/base/text.hpp"
#include "core/scene/scene_forgotten.hpp"
#include "scheduler/run/run.hpp"
#include "scheduler/run/summary_of.hpp"
#include "scheduler/simulation.hpp"
#include "version.hpp"

namespace talus::cli {
namespace {

/// Progress line, signals and warnings of a run on a terminal.
class Terminal final : public RunWatcher {
 public:
  Terminal(const SignalGuard& signals, Progress& progress) : signals_(signals), progress_(progress) {}
  int stop() override { return signals_.caught(); }
  void stepped(const Simulation& s) override { progress_.update(s.step(), s.time(), s.particles()); }
  void warmed_up() override { progress_.restart(); }
  void warn(const std::string& text) override {
    tell("{}talus: warning: {}\n", isatty(STDERR_FILENO) != 0 ? "\r\x1b[K" : "", text);
  }

 private:
  const SignalGuard& signals_;
  Progress& progress_;
};

/// Messages of a run that failed, and its exit code.
int tell_failure(const RunOutcome& outcome, const RunFolder& folder) {
  tell("talus: error: {}\n", outcome.failure);
  if (!outcome.checkpoint.empty()) tell("talus: the last state is in {}\n", shown_path(outcome.checkpoint));
  if (outcome.code == ErrorCode::physics)
    tell("talus: what was written until then is in {}/\n", shown_path(folder.dir()));
  return static_cast<int>(outcome.code);
}

void print_closing(const Options& options, const std::string& folder, const Summary& s, const RunOutputs& outputs,
                   const RunOutcome& outcome) {
  put("\n{} at step {} (t = {:.6g} s) after {}\n", outcome.signal != 0 ? "Stopped" : "Done", s.last_step,
      s.simulated_time, duration_text(s.wall_s));
  put("{} particles, {:.2f} M particle-steps/s, state hash {:016x}\n", grouped(s.particles),
      s.particle_steps_per_s * 1e-6, s.state_hash);
  put("Results are in {}/\n", shown_path(folder));
  const auto line = [](const char* what, const std::string& path) {
    if (!path.empty()) put("  {:<12} {}\n", what, shown_path(path));
  };
  line("summary", folder + "/summary.json");
  line("time series", outputs.csv_file());
  line("checkpoint", outcome.checkpoint);
  if (!outputs.paraview_file().empty()) {
    line("particles", outputs.paraview_file());
    if (const std::string bodies = folder + "/bodies.pvd"; std::filesystem::exists(bodies)) line("bodies", bodies);
    const bool hdf = outputs.paraview_file().ends_with(".vtkhdf");
    put("Look at them:   paraview {}{}\n", shown_path(outputs.paraview_file()),
        hdf ? "    (ParaView 5.12 or newer; output.vtp = true for older ones)" : "");
  }
  put("Report:         {} report {}    (a page with plots)\n", options.program, shown_path(folder));
  if (outcome.signal != 0)
    put("Continue:       {} run {} --resume {}\n", options.program, shown_path(options.scene), shown_path(folder));
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
    for (const std::string& note : forgotten_keys(start.scene, options.steps.has_value()))
      tell("talus: note: {}\n", note);

  // From here on the scene is known to be good: only now may something appear on disk.
  const RunFolder folder = open_folder(options, start);
  if (!options.quiet)
    for (const auto& [wall, report] : simulation->meshes())
      tell("talus: wall \"{}\", mesh {}: {}\n", shown(wall), shown(report.file), describe(report));
  RunOutputs outputs(folder, *simulation, start.checkpoint ? &*start.checkpoint : nullptr, start.own.has_value(),
                     options.checkpoint_every, scene_record(start.scene),
                     [](const std::string& text) { tell("talus: warning: {}\n", text); });
  Progress progress(stderr, Progress::style_for(stderr, options.quiet), first, scene.steps);
  Terminal terminal(signals, progress);
  const RunOutcome outcome = run_to_end(
      *simulation, outputs, {options.warm, options.trace, options.trace_from, options.trace_steps}, terminal);
  progress.finish();

  const Summary summary = summary_of(*simulation, {outcome.seconds, outcome.particle_steps, first, outcome.signal,
                                                   engine.audit, outcome.failure, TALUS_FULL_VERSION});
  try {
    write_summary(folder.summary(), summary);
  } catch (const Error&) {
    if (outcome.failure.empty()) throw;  // else the first error is the message that counts
  }
  if (!outcome.failure.empty()) return tell_failure(outcome, folder);
  if (options.json) {
    put_text(summary_json(summary));
  } else {
    if (options.run.profile) print_profile(simulation->profile(), outcome.particle_steps);
    if (!options.quiet) print_closing(options, folder.dir(), summary, outputs, outcome);
  }
  return outcome.signal != 0 ? 128 + outcome.signal : 0;
}

}  // namespace talus::cli
