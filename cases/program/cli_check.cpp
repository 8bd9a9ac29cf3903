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

Advice advise(const Scene& scene, Simulation& simulation, double calibrate) {
  Advice a;
  a.r_max = Insertion(scene).largest_radius();
  a.step = step_advice(simulation.time_step());
  a.soft = simulation.softening(0);
  a.cost = measure_cost(simulation, calibrate);
  a.k = advised_k(a.cost, a.r_max, scene.dt);
  a.time = predict(scene, a.cost, static_cast<double>(simulation.particles()),
                   arrivals_of(scene, scene.dt * static_cast<double>(a.cost.last)));
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

/// All that `check` says, before it is put into words.
struct Findings {
  const Scene& scene;
  const Simulation& simulation;
  const TimeStepReport& step;
  Plan plan;
  std::int64_t present, to_come;  ///< grains at step 0, at most after it
  double memory;                  ///< that the run needs [bytes]
  AvailableMemory left;
  double room;  ///< that it may have [bytes]
  std::vector<std::string> later, forgotten;
  Advice advice;

  std::string verdict() const {
    if (memory >= 0.9 * room) return "valid, but needs more memory than there is";
    if (!advice.cost.failure.empty()) return "valid, but the run ends early (see above)";
    return step.warning.empty() ? "valid" : "valid, but the time step is large (see above)";
  }
};

void add_advice(Json& j, const Findings& f) {
  const Advice& a = f.advice;
  j.begin_object("advice").add("time_step", a.step.advised).add("time_step_20", a.step.accurate);
  j.add("time_step_limit", a.step.limit);
  j.add("overlap", a.soft.overlap).add("overlap_by", a.soft.by_impact ? "impact" : "weight");
  j.add("stiffness_factor_for_one_percent", a.soft.factor).add("time_step_factor", a.soft.step_factor);
  j.add("verlet_k", a.k);
  j.begin_array("parts");
  for (const auto& [part, line] : f.simulation.part_advice()) j.add("", part + ": " + line);
  j.end_array().end_object();
  j.begin_object("predicted").add("seconds", a.time.seconds).add("seconds_outputs", a.time.outputs);
  j.add("seconds_loose", a.time.seconds_loose).add("seconds_dense", a.time.seconds_dense);
  j.add("ns_per_particle_step", 1e9 * a.cost.per_particle_step).add("measured_steps", a.cost.steps);
  j.add("contacts_per_particle", a.cost.contacts).add("threads", f.plan.threads);
  j.add("failure", a.cost.failure).end_object();
}

void add_meshes(Json& j, const Simulation& simulation) {
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
}

std::string json_of(const Findings& f) {
  const Scene& scene = f.scene;
  Json j;
  j.begin_object().add("scene", scene.file).add("valid", true).add("verdict", f.verdict());
  j.add("particles", f.present).add("particles_to_come_at_most", f.to_come).add("steps", scene.steps);
  j.add("duration", scene.dt * static_cast<double>(scene.steps)).add("memory_bytes", f.memory);
  j.add("bytes_per_particle", f.plan.bytes_per_particle);
  add_time_step(j, f.step);
  add_advice(j, f);
  add_meshes(j, f.simulation);
  j.begin_array("warnings");
  for (const Warning& w : f.simulation.warnings()) j.add("", w.text);
  for (const std::string& note : f.later) j.add("", note);
  j.end_array();
  j.begin_array("forgotten");
  for (const std::string& note : f.forgotten) j.add("", note);
  j.end_array();
  return j.end_object().text();
}

void put_lines(const Findings& f) {
  const Scene& scene = f.scene;
  put("{}{}{}\n", shown_path(scene.file), scene.title.empty() ? "" : ": ", scene.title);
  put("  particles   {} at step 0", grouped(f.present));
  if (f.to_come > 0) put(", at most {} to come", grouped(f.to_come));
  put("\n  duration    {} steps of {:.6g} s = {:.6g} s\n", grouped(scene.steps), scene.dt,
      scene.dt * static_cast<double>(scene.steps));
  put("  law         {}\n", f.plan.law);
  put("  memory      about {} ({:.0f} B per particle) of {} ({})\n", human_bytes(f.memory), f.plan.bytes_per_particle,
      human_bytes(f.room), f.left.by);
  for (const auto& [wall, report] : f.simulation.meshes())
    put("  mesh        wall \"{}\", {}: {}\n", shown(wall), shown(report.file), describe(report));
  put("  time step\n{}", time_step_text(f.step));
  put("  advice\n    time step  {}\n    stiffness  {}\n    verlet_k   {}\n",
      step_text(scene, f.advice.step, f.step.contact.seconds), soft_text(scene, f.advice.soft),
      k_text(scene, f.advice));
  for (const auto& [part, line] : f.simulation.part_advice()) put("    {:<10} {}\n", part, line);
  put("  run time    about {}\n", time_text(scene, f.advice.time, f.advice.cost, f.plan.threads));
  for (const std::string& note : f.forgotten) tell("talus: note: {}\n", note);
  for (const Warning& w : f.simulation.warnings()) tell("talus: warning: {}\n", w.text);
  for (const std::string& note : f.later) tell("talus: warning: {}\n", note);
  if (!f.advice.cost.failure.empty()) tell("talus: warning: the run would end early: {}\n", f.advice.cost.failure);
  if (!f.step.warning.empty()) tell("talus: warning: {}\n", f.step.warning);
  put("{}: {}\n", shown_path(scene.file), f.verdict());
}

}  // namespace

int check(const Options& options) {
  const SceneText text = scene_text_of(options);
  const Scene& scene = text.scene;
  Simulation simulation(scene, options.run);
  const Plan plan = simulation.plan();
  const std::int64_t present = simulation.particles();
  const std::int64_t to_come = count_ceil(arrivals_of(scene).most);
  // The engine holds what is there now; later particles cost what the present ones do, lists included.
  const double memory =
      static_cast<double>(simulation.bytes()) + static_cast<double>(to_come) * plan.bytes_per_particle;
  const std::vector<std::string> later = notes_of_later_sources(scene);
  const Advice advice = advise(scene, simulation, options.calibrate);
  // What the engine already holds is no longer available to it.
  const AvailableMemory left = available_memory();
  const double room = left.bytes + static_cast<double>(simulation.bytes());
  const std::vector<std::string> forgotten = forgotten_keys(text, options.steps.has_value());
  const Findings found{scene,     simulation, simulation.time_step(), plan, present, to_come, memory, left, room, later,
                       forgotten, advice};
  if (options.json)
    put("{}\n", json_of(found));
  else
    put_lines(found);
  return 0;
}

}  // namespace talus::cli
