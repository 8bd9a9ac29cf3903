// See cli_check_time.hpp.
#include "cases/program/cli_check_time.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cases/program/progress.hpp"
#include "core/grains/body.hpp"
#include "scheduler/run/schedule.hpp"

namespace talus::cli {
namespace {

double duration_of(const Scene& scene) { return scene.dt * static_cast<double>(scene.steps); }

/// Time in which a grain falls through the whole domain, 0 without gravity [s].
double fall_time(const Scene& scene) {
  const double g = norm(scene.gravity);
  if (!(g > 0)) return 0;
  double height = 0;  // of the domain along gravity
  for (int k = 0; k < 3; ++k)
    height += std::fabs(scene.gravity[k]) / g * (scene.domain.upper[k] - scene.domain.lower[k]);
  return std::sqrt(2 * height / g);
}

/// Grains of a source that delivers `most` evenly between `start` and `full`, by time t; their integral up to t.
struct Delivery {
  double most, start, full;

  double by(double t) const {
    if (t >= full) return most;
    return t > start ? most * (t - start) / (full - start) : 0;
  }
  double integral(double t) const {
    if (t >= full) return most * (t - 0.5 * (start + full));
    return t > start ? 0.5 * (t - start) * by(t) : 0;
  }
};

double outputs_in(double every, const Scene& scene) {
  return Repeat(every, scene.dt).on() ? duration_of(scene) / std::max(every, scene.dt) + 1 : 0;
}

}  // namespace

Arrivals arrivals_of(const Scene& scene, double from) {
  const double duration = duration_of(scene);
  Arrivals a;
  for (const Source& s : scene.sources) {
    const bool later = s.kind == Source::Kind::stream ||
                       (s.start > 0 && (s.kind == Source::Kind::lattice || s.kind == Source::Kind::random));
    if (!later || s.start >= duration) continue;
    const double density = scene.materials.at(static_cast<std::size_t>(s.material)).density;
    const double lightest = Body{0.5 * s.size.smallest(), density}.mass();
    const double end = std::min(s.end, duration), time = end - s.start;
    double most = HUGE_VAL, flow = 0;  // [particles], [1/s]
    if (s.number > 0) most = std::min(most, static_cast<double>(s.number));
    if (s.mass > 0) most = std::min(most, s.mass / lightest);
    if (s.number_rate > 0) flow = s.number_rate;
    if (s.mass_rate > 0) flow = flow > 0 ? std::min(flow, s.mass_rate / lightest) : s.mass_rate / lightest;
    if (flow > 0) most = std::min(most, flow * time);
    if (!std::isfinite(most)) continue;
    const double full = s.start + (flow > 0 ? most / flow : s.kind == Source::Kind::stream ? time : 0);
    const Delivery d{most, s.start, std::min(full, end)};
    a.most += most;
    if (from < duration) a.mean += (d.integral(duration) - d.integral(from)) / (duration - from) - d.by(from);
  }
  return a;
}

RunTime predict(const Scene& scene, const Cost& cost, double present, const Arrivals& arrivals) {
  RunTime t;
  t.outputs = outputs_in(scene.output.particles_every, scene) * cost.frame +
              outputs_in(scene.output.csv_every, scene) * cost.row;
  const auto steps = static_cast<double>(scene.steps), left = steps - static_cast<double>(cost.last);
  const double work = left * (std::max(present, 0.0) + arrivals.mean);
  t.seconds_loose = cost.spent + work * cost.per_particle_step + t.outputs;
  t.seconds_dense = cost.spent + work * cost.dense + t.outputs;
  const double fallen = fall_time(scene) / scene.dt - static_cast<double>(cost.last);
  t.loose = !(norm2(scene.gravity) > 0) ? 1 : left > 0 ? std::clamp(fallen / left, 0.0, 1.0) : 0;
  t.seconds = t.loose * t.seconds_loose + (1 - t.loose) * t.seconds_dense;
  return t;
}

std::string time_text(const Scene& scene, const RunTime& time, const Cost& cost, int threads) {
  std::string text = fmt::format("{} on {} thread{}: ", duration_text(time.seconds), threads, threads == 1 ? "" : "s");
  if (!cost.stated.empty()) return text + cost.stated;
  if (cost.last >= scene.steps) {
    text += "all its steps were run";
  } else {
    text += fmt::format("{:.3g} ns per particle-step by step {} ({:.2g} contacts per particle)",
                        1e9 * cost.per_particle_step, cost.last, cost.contacts);
    if (time.seconds_dense > 1.05 * time.seconds_loose && time.loose < 1)
      text += fmt::format(", {:.3g} ns in the bed that the grains form within {:.2g} s", 1e9 * cost.dense,
                          fall_time(scene));
  }
  if (time.outputs > 0.05 * time.seconds) text += fmt::format("; {} of it for outputs", duration_text(time.outputs));
  return text;
}

}  // namespace talus::cli
