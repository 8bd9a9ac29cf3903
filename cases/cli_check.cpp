// `talus check SCENE`: is the scene valid, is its time step safe, how many particles and how much memory will it need.
// Builds the engine for step 0 (so initial overlaps and particles outside are found) but runs nothing and writes
// nothing.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "cases/cli.hpp"
#include "cases/cli_json.hpp"
#include "cases/cli_timestep.hpp"
#include "scheduler/simulation.hpp"

namespace talus::cli {
namespace {

/// Upper bound of what the sources deliver after step 0 [particles].
std::int64_t most_to_come(const Scene& scene) {
  const double pi = 3.14159265358979323846;
  const double duration = scene.dt * static_cast<double>(scene.steps);
  double total = 0;
  for (const Source& s : scene.sources) {
    const bool later = s.kind == Source::Kind::stream ||
                       (s.start > 0 && (s.kind == Source::Kind::lattice || s.kind == Source::Kind::random));
    if (!later || s.start >= duration) continue;
    const double d = s.size.smallest();
    const double lightest = scene.materials.at(static_cast<std::size_t>(s.material)).density * pi / 6 * d * d * d;
    const double time = std::min(s.end, duration) - s.start;
    double most = HUGE_VAL;
    if (s.number > 0) most = std::min(most, static_cast<double>(s.number));
    if (s.mass > 0) most = std::min(most, s.mass / lightest);
    if (s.number_rate > 0) most = std::min(most, s.number_rate * time);
    if (s.mass_rate > 0) most = std::min(most, s.mass_rate * time / lightest);
    if (std::isfinite(most)) total += most;
  }
  return static_cast<std::int64_t>(std::ceil(total));
}

double physical_memory() {
  return static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
}
}  // namespace

int check(const Options& options) {
  const Scene scene = scene_of(options);
  const TimeStepReport step = judge_time_step(scene);
  const Simulation simulation(scene, options.run);
  const Plan plan = simulation.plan();
  const std::int64_t present = simulation.particles();
  const std::int64_t to_come = most_to_come(scene);
  // The engine holds what is there now; later particles cost what the present ones do, lists included.
  const double memory =
      static_cast<double>(simulation.bytes()) + static_cast<double>(to_come) * plan.bytes_per_particle;
  const bool fits = memory < 0.9 * physical_memory();
  const std::string verdict = !fits
                                  ? "valid, but needs more memory than this machine has"
                                  : (step.warning.empty() ? "valid" : "valid, but the time step is large (see above)");

  if (options.json) {
    Json j;
    j.begin_object().add("scene", scene.file).add("valid", true).add("verdict", verdict);
    j.add("particles", present).add("particles_to_come_at_most", to_come).add("steps", scene.steps);
    j.add("duration", scene.dt * static_cast<double>(scene.steps)).add("memory_bytes", memory);
    j.add("bytes_per_particle", plan.bytes_per_particle);
    add_time_step(j, step);
    fmt::print("{}\n", j.end_object().text());
    return 0;
  }
  fmt::print("{}{}{}\n", scene.file, scene.title.empty() ? "" : ": ", scene.title);
  fmt::print("  particles   {} at step 0", grouped(present));
  if (to_come > 0) fmt::print(", at most {} to come", grouped(to_come));
  fmt::print("\n  duration    {} steps of {:.6g} s = {:.6g} s\n", grouped(scene.steps), scene.dt,
             scene.dt * static_cast<double>(scene.steps));
  fmt::print("  law         {}\n", plan.law);
  fmt::print("  memory      about {} ({:.0f} B per particle; this machine has {})\n", human_bytes(memory),
             plan.bytes_per_particle, human_bytes(physical_memory()));
  fmt::print("  time step\n{}", time_step_text(step));
  if (!step.warning.empty()) fmt::print(stderr, "talus: warning: {}\n", step.warning);
  fmt::print("{}: {}\n", scene.file, verdict);
  return 0;
}

}  // namespace talus::cli
