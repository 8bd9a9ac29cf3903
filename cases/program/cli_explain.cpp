// `talus explain SCENE`: what the step of this scene consists of, what is left out and why, from Simulation::plan() and
// the time-step limits. Nothing is run; the engine is built for step 0 so that the numbers are those of a run.
#include <fmt/format.h>

#include <algorithm>

#include "cases/program/cli.hpp"
#include "cases/program/cli_console.hpp"
#include "cases/program/cli_json.hpp"
#include "cases/program/cli_timestep.hpp"
#include "scheduler/simulation.hpp"

namespace talus::cli {
namespace {

/// Width of a column that fits all its cells.
template <class Rows, class Cell>
std::size_t width(const Rows& rows, std::size_t title, Cell cell) {
  std::size_t w = title;
  for (const auto& row : rows) w = std::max(w, std::string(cell(row)).size());
  return w;
}

void print_nodes(const Plan& plan) {
  const auto name = width(plan.nodes, 4, [](const auto& n) { return n.name; });
  put("\nNodes of the step\n  {:<{}}  {:<4} {}\n", "node", name, "in?", "why; what it reads -> writes");
  for (const auto& n : plan.nodes) {
    put("  {:<{}}  {:<4} {}\n", n.name, name, n.in ? "in" : "out", n.why);
    if (n.in && !(n.reads.empty() && n.writes.empty())) {
      put("  {:<{}}       {} -> {}\n", "", name, n.reads, n.writes);
    }
  }
}

void print_arrays(const Plan& plan) {
  const auto name = width(plan.arrays, 5, [](const auto& a) { return a.name; });
  put("\nArrays\n  {:<{}}  {:<4} {:>12}  {}\n", "array", name, "in?", "B/particle", "why");
  for (const auto& a : plan.arrays) {
    put("  {:<{}}  {:<4} {:>12.1f}  {}\n", a.name, name, a.in ? "in" : "out", a.bytes_per_particle, a.why);
  }
  put("  {:<{}}       {:>12.1f}  total\n", "", name, plan.bytes_per_particle);
}

std::string as_json(const Scene& scene, const Plan& plan, const Simulation& simulation, const TimeStepReport& step) {
  Json j;
  j.begin_object();
  j.add("scene", scene.file).add("title", scene.title).add("particles", simulation.particles());
  j.add("law", plan.law).add("policy", plan.policy).add("isa", plan.isa).add("isa_why", plan.isa_why);
  j.add("threads", plan.threads).add("chunk", plan.chunk).add("chunks", plan.chunks);
  j.add("bytes_per_particle", plan.bytes_per_particle);
  j.begin_array("nodes");
  for (const auto& n : plan.nodes) {
    j.begin_object().add("name", n.name).add("in", n.in).add("why", n.why);
    j.add("reads", n.reads).add("writes", n.writes).end_object();
  }
  j.end_array().begin_array("arrays");
  for (const auto& a : plan.arrays) {
    j.begin_object().add("name", a.name).add("in", a.in).add("bytes_per_particle", a.bytes_per_particle);
    j.add("why", a.why).end_object();
  }
  j.end_array().add("graph", plan.graph);
  add_time_step(j, step);
  j.end_object();
  return j.text();
}
}  // namespace

int explain(const Options& options) {
  const Scene scene = scene_of(options);
  const Simulation simulation(scene, options.run);
  const TimeStepReport& step = simulation.time_step();
  const Plan plan = simulation.plan();
  if (options.json) {
    put("{}\n", as_json(scene, plan, simulation, step));
    return 0;
  }
  put("{}{}{}\n", shown_path(scene.file), scene.title.empty() ? "" : ": ", scene.title);
  put("  particles at step 0   {}\n", grouped(simulation.particles()));
  put("  contact law           {}\n", plan.law);
  put("  list policy           {}, K = {}; {}\n", plan.policy,
      scene.list.automatic ? std::string("auto") : fmt::format("{}", scene.list.verlet_k), plan.guarantee);
  put("  instruction set       {} ({})\n", plan.isa, plan.isa_why);
  put("  threads, chunks       {} threads, {} chunks of {} particles\n", plan.threads, plan.chunks, plan.chunk);
  print_nodes(plan);
  print_arrays(plan);
  put("\nGraph\n{}{}", plan.graph, plan.graph.empty() || plan.graph.back() == '\n' ? "" : "\n");
  put("\nTime step\n{}", time_step_text(step));
  return 0;
}

}  // namespace talus::cli
