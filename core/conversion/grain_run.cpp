// See grain_run.hpp.
#include "core/conversion/grain_run.hpp"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "core/base/error.hpp"

namespace talus::conversion {
namespace {

using Oxidant = CharReaction::Oxidant;

/// Beside oxygen.
std::vector<Oxidant> others_taken(const GrainJob& job) {
  std::vector<Oxidant> all;
  for (const Oxidant o : {Oxidant::carbon_dioxide, Oxidant::steam})
    for (const CharReaction& c : job.matter.char_reactions)
      if (c.oxidant == o) {
        all.push_back(o);
        break;
      }
  return all;
}

std::string head_of(const GrainJob& job) {
  std::string s =
      "time,mass,mean_temperature,surface_temperature,centre_temperature,half_radius_temperature,radius,moisture,fuel,"
      "char,ash,heat_in,heat_residual,mass_residual,carbon_residual,hydrogen_residual,oxygen_residual,ash_residual,"
      "water_residual,oxygen_taken";
  for (const auto oxidant : others_taken(job))
    s += oxidant == Oxidant::steam ? ",steam_taken" : ",carbon_dioxide_taken";
  for (const auto& g : job.matter.gases) s += ",released_" + g.name;
  return s + "\n";
}

std::string row_of(const Grain<double>& g, const std::vector<Oxidant>& others) {
  const auto t = g.totals();
  const auto& s = g.state;
  std::string row;
  const auto put = [&](double x) { row += fmt::format("{}{:.10g}", row.empty() ? "" : ",", x); };
  for (const double x : {s.time, t.mass, t.mean, s.surface, g.centre(), g.at(0.5), s.shells.radius(), t.moisture,
                         t.fuel, t.char_, t.ash, s.heat_in, g.heat_residual(), g.mass_residual()})
    put(x);
  for (std::size_t e = 0; e < k_elements; ++e) put(g.element_residual(e));
  put(s.oxygen_taken);
  for (const Oxidant o : others) put(o == Oxidant::steam ? s.steam_taken : s.carbon_dioxide_taken);
  for (const double x : s.released) put(x);
  return row + "\n";
}

/// What cannot be right ends the run.
void check_state(const Grain<double>& g) {
  for (std::size_t i = 0; i < g.state.size(); ++i) {
    const double T = g.state.temperature[i];
    if (std::isfinite(T) && T < 1e4 && T > 1) continue;
    throw Error(ErrorCode::physics, fmt::format("shell {} has {:.4g} K", i, T), fmt::format("t = {:g} s", g.state.time),
                "a smaller time.step or time.method = \"euler\"");
  }
}

constexpr double k_overshoot = 1e-3;  // of the range, that is accepted
constexpr double k_no_heat = 1e-9;    // share of what comes in that reactions may give without being heard

/// Temperatures that a step may not leave where nothing but its surroundings heats or cools it [K].
struct Reach {
  double bottom, top;
  Reach(const Grain<double>& g, const Surroundings<double>& before, const Surroundings<double>& after)
      : bottom(g.state.surface), top(g.state.surface) {
    for (const double T : g.state.temperature) add(T);
    for (const auto* s : {&before, &after}) {
      if (s->given_surface) add(s->surface_temperature);
      if (s->given_surface) continue;
      if (s->film > 0) add(s->gas_temperature);
      if (s->emissivity > 0) add(s->wall_temperature);
      if (s->contact_conductance > 0) add(s->contact_temperature);
      if (s->flux > 0) top = 1e300;
      if (s->flux < 0) bottom = 0;
    }
  }
  void add(double T) { bottom = std::fmin(bottom, T), top = std::fmax(top, T); }
  bool holds(double T) const { return T < top + 1e-6 && T > bottom - 1e-6; }
  bool holds(const Grain<double>& g) const {
    for (const double T : g.state.temperature)
      if (!holds(T)) return false;
    return holds(g.state.surface);
  }
};

/// TR-BDF2 may overshoot in a step that is long against what changes in it; such a step is made anew by backward Euler,
/// which does not.
void advance(Grain<double>& g, const GrainJob& job, const Surroundings<double>& before,
             const Surroundings<double>& after, const GasAround<double>& gas) {
  if (job.options.method == Method::euler) return g.advance(job.step, before, after, gas);
  Reach reach(g, before, after);
  const GrainState<double> kept = g.state;
  g.advance(job.step, before, after, gas);
  const double released = g.state.heat_of_reaction - kept.heat_of_reaction;
  const bool reacts = !job.matter.reactions.empty() || !job.matter.char_reactions.empty();
  if (reacts && std::fabs(released) > k_no_heat * std::fabs(g.state.heat_in - kept.heat_in)) return;
  if (released < 0) reach.bottom = 0;  // dries
  if (reach.holds(g)) return;
  g.state = kept;
  g.advance_by(Method::euler, job.step, before, after, gas);
  // left over by its iterations, where a surface radiates to walls far hotter and the step is long beyond measure
  const double some = k_overshoot * (reach.top - reach.bottom);
  reach.top += some;
  reach.bottom -= some;
  if (!reach.holds(g))
    throw Error(ErrorCode::physics,
                fmt::format("the surface would overshoot what is around it: {:.4g} K", g.state.surface),
                fmt::format("t = {:g} s", g.state.time), "a smaller time.step, or more time.iterations");
}

}  // namespace

std::string grain_table(const GrainJob& job) {
  Grain<double> g(job.matter, job.form, job.temperature, job.options);
  const auto around = [&](double t) { return job.around.at(t, g.state.shells.radius(), g.state.surface); };
  auto before = around(0);
  g.begin(before);
  before = around(0);
  const std::vector<Oxidant> others = others_taken(job);
  std::string text = head_of(job) + row_of(g, others);
  for (std::int64_t n = 1; n <= job.steps; ++n) {
    const double t = static_cast<double>(n) * job.step;
    const auto gas = job.around.gas_at(t, g.state.shells.radius(), g.state.surface);
    before = around(t - job.step);
    auto after = around(t);
    const double missed = job.around.flux.missed(t - job.step, t);  // all heat of a pulse within the step
    before.flux += missed;
    after.flux += missed;
    advance(g, job, before, after, gas);
    check_state(g);
    if (n % job.output_steps == 0 || n == job.steps) text += row_of(g, others);
  }
  return text;
}

}  // namespace talus::conversion
