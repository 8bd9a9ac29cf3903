// See cli_check_cost.hpp.
#include "cases/program/cli_check_cost.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/base/error.hpp"

namespace talus::cli {
namespace {

constexpr double k_stated = 60e-9;      // [s] per particle-step of a dense frictional bed on one thread of a 3 GHz core
constexpr double k_contact = 8e-9;      // [s] per contact and step, where too few are there to measure
constexpr double k_dense_contacts = 3;  // per particle: coordination 6
constexpr std::int64_t k_most_steps = 2000;

}  // namespace

Cost measure_cost(Simulation& simulation, double seconds) {
  using Clock = std::chrono::steady_clock;
  Cost c;
  const Scene& scene = simulation.scene();
  const std::int64_t last = std::min(scene.steps, simulation.step() + k_most_steps);
  double particle_steps = 0, spent = 0;
  std::int64_t before = 0;
  try {
    // The first steps allocate and touch memory: they are not timed.
    if (seconds > 0) simulation.run(std::min<std::int64_t>(2, last - simulation.step()));
    simulation.restart_profile();
    before = simulation.step();
    while (spent < seconds && simulation.step() < last) {
      const auto begin = Clock::now();
      const std::int64_t n = std::min<std::int64_t>(10, last - simulation.step());
      simulation.run(n);
      spent += std::chrono::duration<double>(Clock::now() - begin).count();
      particle_steps += static_cast<double>(n) * static_cast<double>(simulation.particles());
    }
  } catch (const Error& e) {
    c.failure = e.what();
  }
  c.steps = simulation.step() - before;
  const int threads = simulation.plan().threads;
  double force = 0;
  const Counters counters = simulation.counters();
  const double contacts = static_cast<double>(counters.contacts + counters.wall_contacts);
  for (const NodeTime& t : simulation.profile().nodes) {
    if (t.node == "rebuild" && t.calls > 0) c.rebuild = t.seconds / static_cast<double>(t.calls);
    if (t.node == "narrow_phase" && c.steps > 0) c.narrow = t.seconds / static_cast<double>(c.steps);
    if (t.node == "contact_force" && c.steps > 0) force = t.seconds / static_cast<double>(c.steps);
  }
  const auto n = static_cast<double>(simulation.particles());
  if (n > 0) {
    const Frame f = simulation.frame({});
    double v2 = 0;
    for (const Vec3& v : f.v) v2 += norm2(v) / n;
    c.speed = std::sqrt(v2);
    c.contacts = contacts / n;
  }
  if (particle_steps > 0) {
    c.per_particle_step = spent / particle_steps;
    // contact forces scale with the contacts, everything else with the particles
    const double each = c.contacts > 1 ? force / contacts / threads : k_contact / threads;
    c.dense = c.per_particle_step + std::max(0.0, k_dense_contacts - c.contacts) * each;
  } else {
    c.per_particle_step = c.dense = k_stated / threads;
    c.stated = fmt::format("nothing to measure in the first steps: {:.0f} ns per particle-step and thread assumed",
                           1e9 * k_stated);
  }
  return c;
}

double advised_k(const Cost& c, double radius, double dt) {
  if (!(c.speed > 0) || !(c.rebuild > 0) || !(c.narrow > 0)) return 0;
  const double travel = c.speed * dt;
  return std::clamp(std::sqrt(c.rebuild * radius / (3 * c.narrow * travel)), 1.0, std::max(1.0, 0.5 * radius / travel));
}

}  // namespace talus::cli
