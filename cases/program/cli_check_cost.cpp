// See cli_check_cost.hpp.
#include "cases/program/cli_check_cost.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/base/error.hpp"
#include "core/io/vtkhdf.hpp"
#include "core/io/vtp.hpp"

namespace talus::cli {
namespace {

constexpr double k_stated = 60e-9;  // [s] per particle-step of a dense frictional bed on one thread of a 3 GHz core
constexpr double k_contact =
    12e-9;  // [s] at most per contact and step on one thread, where too few are there to measure
constexpr double k_contact_share = 0.8;   // the same beside a step without contacts: slow machines are slow in both
constexpr double k_dense_contacts = 2.3;  // per particle in a bed at rest with friction, walls counted: 2.0 to 2.6
// The same of superquadrics, each pair of which is solved: settled ellipsoids (perf/measured/shapes.md).
constexpr double k_shaped_contact = 340e-9, k_shaped_share = 5, k_shaped_contacts = 3.2;

constexpr double k_slice = 0.005;  // of the measurement, at least: to begin a run costs as much as a step of few grains

using Clock = std::chrono::steady_clock;
double since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

/// Steps for about `seconds`; the profile and the rate are those of the second half.
void time_steps(Simulation& simulation, double seconds, Cost& c) {
  const std::int64_t last = simulation.scene().steps;
  double work = 0, begun = 0;  // particle-steps and time of the half that counts
  std::int64_t before = 0;
  bool second = false;
  std::int64_t slice = 10;
  try {
    // The first steps allocate and touch memory: they are not timed.
    if (seconds > 0) simulation.run(std::min<std::int64_t>(2, last - simulation.step()));
    simulation.restart_profile();
    before = simulation.step();
    while (c.spent < seconds && simulation.step() < last) {
      if (!second && c.spent > 0.5 * seconds) {
        second = true;
        begun = c.spent;
        work = 0;
        before = simulation.step();
        simulation.restart_profile();
      }
      const auto begin = Clock::now();
      const std::int64_t n = std::min<std::int64_t>(slice, last - simulation.step());
      simulation.run(n);
      const double took = since(begin);
      c.spent += took;
      if (took < k_slice * seconds) slice *= 2;
      work += static_cast<double>(n) * static_cast<double>(simulation.particles());
    }
  } catch (const Error& e) {
    c.failure = e.what();
  }
  c.last = simulation.step();
  c.steps = c.last - before;
  if (work > 0) c.per_particle_step = (c.spent - begun) / work;
}

/// What a frame and a row cost, as the run makes them (scheduler/run/outputs.cpp); the disk is left out.
void time_outputs(const Simulation& simulation, Cost& c) {
  const OutputSettings& out = simulation.scene().output;
  auto begin = Clock::now();
  FrameRequest request;
  request.coordination = out.coordination;
  request.stress = out.stress;
  request.contacts = out.contacts;
  const Frame frame = simulation.frame(request);
  const PolyData poly = particle_poly(frame, ParticleColumns::of(simulation.scene(), frame));
  c.frame = since(begin);
  begin = Clock::now();
  FrameRequest loads;
  loads.wall_loads = true;
  const Frame walls = simulation.frame(loads);
  volatile double energy = simulation.kinetic_energy();  // is part of a row
  static_cast<void>(energy);
  c.row = since(begin);
  for (const BodyRecord& b : frame.bodies)
    c.shaped += simulation.scene().shapes[static_cast<std::size_t>(b.shape)].kind == ShapeSpec::Kind::superquadric;
  c.shaped /= std::max(1.0, static_cast<double>(frame.v.size()));
  double v2 = 0;
  for (const Vec3& v : frame.v) v2 += norm2(v);
  if (!frame.v.empty()) c.speed = std::sqrt(v2 / static_cast<double>(frame.v.size()));
}

}  // namespace

Cost measure_cost(Simulation& simulation, double seconds) {
  Cost c;
  time_steps(simulation, seconds, c);
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
    time_outputs(simulation, c);
    c.contacts = contacts / n;
  }
  if (c.per_particle_step > 0) {
    // Candidates and forces scale with the contacts, everything else with the particles.
    const auto of = [&](double spheres, double shaped) { return spheres + c.shaped * (shaped - spheres); };
    const double each = c.contacts > 1 ? (force + c.narrow) / contacts / threads
                                       : std::min(of(k_contact_share, k_shaped_share) * c.per_particle_step,
                                                  of(k_contact, k_shaped_contact) / threads);
    c.dense = c.per_particle_step + std::max(0.0, of(k_dense_contacts, k_shaped_contacts) - c.contacts) * each;
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
