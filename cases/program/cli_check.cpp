// `talus check SCENE`: is the scene valid, is its time step safe, how soft may its contacts be, which K suits it, and
// how many particles, how much time and how much memory it will need. Builds the engine for step 0 (so initial overlaps
// and particles outside are found) and runs its first steps for two seconds to measure their cost; writes nothing.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cases/program/cli.hpp"
#include "cases/program/cli_check_cost.hpp"
#include "cases/program/cli_check_time.hpp"
#include "cases/program/cli_console.hpp"
#include "cases/program/cli_json.hpp"
#include "cases/program/cli_timestep.hpp"
#include "core/base/count.hpp"
#include "core/base/memory.hpp"
#include "core/base/text.hpp"
#include "core/grains/body.hpp"
#include "core/grains/insertion.hpp"
#include "core/grains/source_notes.hpp"
#include "core/rules/laws/law.hpp"
#include "core/scene/scene_forgotten.hpp"
#include "scheduler/simulation.hpp"

namespace talus::cli {
namespace {

/// What can be said about a scene before it runs.
struct Advice {
  StepAdvice step;
  Softening soft;
  Cost cost;
  double r_max = 0;
  double k = 0;  ///< 0: no rebuild was measured
  RunTime time;
};

Advice advise(const Scene& scene, Simulation& simulation, const Arrivals& arrivals, double calibrate) {
  Advice a;
  a.r_max = Insertion(scene).largest_radius();
  a.step = step_advice(simulation.time_step());
  a.soft = simulation.softening(0);
  const std::int64_t before = simulation.particles();
  a.cost = measure_cost(simulation, calibrate);
  a.k = advised_k(a.cost, a.r_max, scene.dt);
  // What sources have delivered while it was measured is counted among those to come.
  const double present = std::min(static_cast<double>(before), static_cast<double>(simulation.particles()));
  a.time = predict(scene, a.cost, present, arrivals);
  return a;
}

std::string step_text(const Scene& scene, const StepAdvice& a, double contact) {
  if (!std::isfinite(a.accurate) || !(a.accurate > 0)) return "nothing can ever touch: no limit";
  const std::string limit = fmt::format("a run accepts up to {} s", at_most(a.limit));
  if (a.advised == scene.dt)
    return fmt::format("{:.3g} s as set makes {:.3g} steps per contact ({} s: 20); {}", scene.dt, contact / scene.dt,
                       at_most(a.accurate), limit);
  return fmt::format("{} s ({:.3g} x the scene's): {:.3g} steps per contact; {}", at_most(a.accurate),
                     a.accurate / scene.dt, contact / a.accurate, limit);
}

std::string soft_text(const Scene& scene, const Softening& s) {
  if (!(s.factor > 0)) return "nothing moves or weighs: no overlap to judge";
  std::string text =
      fmt::format("{} press contacts by about {:.2g} of the radius; ",
                  s.by_impact ? fmt::format("impacts at {:.3g} m/s (the fastest that the scene lets expect)", s.speed)
                              : fmt::format("a bed as high as the domain ({:.3g} N per contact)", s.load),
                  s.overlap);
  const std::string value = law_of(scene).by_modulus ? fmt::format("Young's moduli {:.3g} times as large", s.factor)
                                                     : fmt::format("normal_stiffness = {:.3g} N/m",
                                                                   s.factor * scene.contact.normal_stiffness);
  if (s.factor < 1)
    text += fmt::format("{} would allow 1 % and a time step {:.2g} times as long", value, s.step_factor);
  else
    text += fmt::format("for at most 1 % take {} and a time step {:.2g} times as long", value, s.step_factor);
  return text;
}

std::string k_text(const Scene& scene, const Advice& a) {
  const std::string set = scene.list.automatic ? "auto" : fmt::format("{:g}", scene.list.verlet_k);
  if (!(a.k > 0)) return set + " as set: no rebuild was needed in the measured steps";
  return fmt::format(
      "about {:.0f} (set: {}): sqrt(B R / (3 c v dt)) at rms {:.3g} m/s, rebuild {:.3g} ms, narrow phase "
      "{:.3g} ms per step; the optimum is flat",
      a.k, set, a.cost.speed, 1e3 * a.cost.rebuild, 1e3 * a.cost.narrow);
}

std::vector<std::string> notes_of_later_sources(const Scene& scene) {
  WallSet walls(in_stored_frame(scene), 1.01 * Insertion(scene).largest_radius());
  return later_shortfalls(scene, walls);
}

}  // namespace

int check(const Options& options) {
  const SceneText text = scene_text_of(options);
  const Scene& scene = text.scene;
  const std::vector<std::string> forgotten = forgotten_keys(text);
  Simulation simulation(scene, options.run);
  const TimeStepReport& step = simulation.time_step();
  const Plan plan = simulation.plan();
  const std::int64_t present = simulation.particles();
  const Arrivals arrivals = arrivals_of(scene);
  const std::int64_t to_come = count_ceil(arrivals.most);
  // The engine holds what is there now; later particles cost what the present ones do, lists included.
  const double memory =
      static_cast<double>(simulation.bytes()) + static_cast<double>(to_come) * plan.bytes_per_particle;
  const std::vector<std::string> later = notes_of_later_sources(scene);
  const Advice advice = advise(scene, simulation, arrivals, options.calibrate);
  // What the engine already holds is no longer available to it.
  const AvailableMemory left = available_memory();
  const double room = left.bytes + static_cast<double>(simulation.bytes());
  const bool fits = memory < 0.9 * room;
  const std::string verdict = !fits                          ? "valid, but needs more memory than there is"
                              : !advice.cost.failure.empty() ? "valid, but the run ends early (see above)"
                              : !step.warning.empty()        ? "valid, but the time step is large (see above)"
                                                             : "valid";

  if (options.json) {
    Json j;
    j.begin_object().add("scene", scene.file).add("valid", true).add("verdict", verdict);
    j.add("particles", present).add("particles_to_come_at_most", to_come).add("steps", scene.steps);
    j.add("duration", scene.dt * static_cast<double>(scene.steps)).add("memory_bytes", memory);
    j.add("bytes_per_particle", plan.bytes_per_particle);
    add_time_step(j, step);
    j.begin_object("advice").add("time_step", advice.step.advised).add("time_step_20", advice.step.accurate);
    j.add("time_step_limit", advice.step.limit);
    j.add("overlap", advice.soft.overlap).add("overlap_by", advice.soft.by_impact ? "impact" : "weight");
    j.add("stiffness_factor_for_one_percent", advice.soft.factor).add("time_step_factor", advice.soft.step_factor);
    j.add("verlet_k", advice.k);
    j.begin_array("parts");
    for (const auto& [part, line] : simulation.part_advice()) j.add("", part + ": " + line);
    j.end_array().end_object();
    j.begin_object("predicted").add("seconds", advice.time.seconds).add("seconds_outputs", advice.time.outputs);
    j.add("seconds_loose", advice.time.seconds_loose).add("seconds_dense", advice.time.seconds_dense);
    j.add("ns_per_particle_step", 1e9 * advice.cost.per_particle_step).add("measured_steps", advice.cost.steps);
    j.add("contacts_per_particle", advice.cost.contacts).add("threads", plan.threads);
    j.add("failure", advice.cost.failure).end_object();
    j.begin_array("meshes");
    for (const auto& [wall, r] : simulation.meshes()) {
      j.begin_object().add("wall", wall).add("file", r.file).add("facets", r.facets_read - r.dropped());
      j.add("facets_read", r.facets_read).add("degenerate", r.degenerate).add("duplicate", r.duplicate);
      j.add("open_edges", r.open_edges).add("forked_edges", r.forked_edges).add("flipped", r.flipped);
      j.add("parts", r.parts).add("watertight", r.watertight).add("volume", r.watertight ? r.volume : NAN);
      j.begin_array("lower").add("", r.lower.x).add("", r.lower.y).add("", r.lower.z).end_array();
      j.begin_array("upper").add("", r.upper.x).add("", r.upper.y).add("", r.upper.z).end_array();
      j.add("rounding", r.rounding).end_object();
    }
    j.end_array();
    j.begin_array("warnings");
    for (const Warning& w : simulation.warnings()) j.add("", w.text);
    for (const std::string& note : later) j.add("", note);
    j.end_array();
    j.begin_array("forgotten");
    for (const std::string& note : forgotten) j.add("", note);
    j.end_array();
    put("{}\n", j.end_object().text());
    return 0;
  }
  put("{}{}{}\n", shown_path(scene.file), scene.title.empty() ? "" : ": ", scene.title);
  put("  particles   {} at step 0", grouped(present));
  if (to_come > 0) put(", at most {} to come", grouped(to_come));
  put("\n  duration    {} steps of {:.6g} s = {:.6g} s\n", grouped(scene.steps), scene.dt,
      scene.dt * static_cast<double>(scene.steps));
  put("  law         {}\n", plan.law);
  put("  memory      about {} ({:.0f} B per particle; {} by the {})\n", human_bytes(memory), plan.bytes_per_particle,
      human_bytes(room), left.by);
  for (const auto& [wall, report] : simulation.meshes())
    put("  mesh        wall \"{}\", {}: {}\n", shown(wall), shown(report.file), describe(report));
  put("  time step\n{}", time_step_text(step));
  put("  advice\n    time step  {}\n    stiffness  {}\n    verlet_k   {}\n",
      step_text(scene, advice.step, step.contact.seconds), soft_text(scene, advice.soft), k_text(scene, advice));
  for (const auto& [part, line] : simulation.part_advice()) put("    {:<10} {}\n", part, line);
  put("  run time    about {}\n", time_text(scene, advice.time, advice.cost, plan.threads));
  for (const std::string& note : forgotten) tell("talus: note: {}\n", note);
  for (const Warning& w : simulation.warnings()) tell("talus: warning: {}\n", w.text);
  for (const std::string& note : later) tell("talus: warning: {}\n", note);
  if (!advice.cost.failure.empty()) tell("talus: warning: the run would end early: {}\n", advice.cost.failure);
  if (!step.warning.empty()) tell("talus: warning: {}\n", step.warning);
  put("{}: {}\n", shown_path(scene.file), verdict);
  return 0;
}

}  // namespace talus::cli
