// What `talus check` says of heat: Biot numbers, and how long a heat step may be.
#include <fmt/format.h>

#include <algorithm>

#include "core/heat/convection.hpp"
#include "core/heat/radiation.hpp"
#include "scheduler/parts/heat.hpp"

namespace talus {
namespace {

std::string as_steps(const PartView& w, double n) {
  return n >= 1 ? fmt::format("{}", static_cast<std::int64_t>(n))
                : fmt::format("1 and time.step = {:.3g} s", n * w.rules.scene.dt);
}

/// Largest coefficient that a grain of diameter d sees from gas and enclosure at the start [W/m2/K].
double coefficient(const HeatScene& h, const HeatMatter& m, double d) {
  double film = 0;
  if (h.gas.on) {
    const GasHeat& g = h.gas;
    const heat::GasAt at{g.temperature(0), g.velocity,     g.density,
                         g.viscosity,      g.conductivity, g.viscosity * g.capacity / g.conductivity,
                         g.porosity};
    film = g.film >= 0 ? g.film : heat::film_coefficient(g.law, at, {}, d);
  }
  const double hot = h.radiation.enclosure.given() ? h.radiation.enclosure.most()
                     : h.radiation.grains          ? h.temperature
                                                   : 0;
  if (hot > 0) film += heat::k_stefan * m.emissivity * heat::radiant_slope(h.temperature, hot);
  return film;
}

/// What radiation allows once grains are as hot as the enclosure; empty where the present step keeps it.
std::string when_hot(const HeatState& s, const PartView& w, std::size_t m, double smallest) {
  const double hot = s.scene.radiation.enclosure.given() ? s.scene.radiation.enclosure.most() : 0;
  if (!(hot > 0) || !(smallest > 0)) return {};
  const double h = heat::k_stefan * s.matter[m].emissivity * heat::radiant_slope(hot, hot);
  const double capacity =
      w.rules.scene.materials[m].density * s.matter[m].enthalpy.capacity().at(hot) * smallest / 3;  // [J/K/m2]
  const double steps = capacity / h / w.rules.scene.dt;
  if (!(steps < static_cast<double>(s.pace.steps))) return {};
  return fmt::format("{}: once the smallest grain is as hot as the enclosure ({:.4g} K), radiation alone allows {}",
                     w.rules.scene.materials[m].name, hot, as_steps(w, steps));
}

}  // namespace

std::vector<std::string> heat_advice(const HeatState& s, const PartView& w) {
  std::vector<std::string> lines;
  std::vector<double> radius(s.matter.size(), 0.0), contacts(s.matter.size(), 0.0), smallest(s.matter.size(), k_never);
  double excess = 0;
  const auto* inside = part_as<GrainInside>(w.parts);
  for (Row i = 0; i < w.rows.n; ++i) {
    if (!w.rows.is_alive(i) || !w.rows.leads(i)) continue;
    const auto at = static_cast<std::size_t>(i), m = static_cast<std::size_t>(s.material(w, i));
    excess = std::max(excess, s.excess(w, inside, i));
    if (s.shells[m] != 0) continue;  // conversion's
    const double r = heat_size(w, i);
    radius[m] = std::max(radius[m], r);
    smallest[m] = std::min(smallest[m], r);
    contacts[m] = std::max(contacts[m], s.conductance[at] / s.surface(w, i));
  }
  for (std::size_t m = 0; m < s.matter.size(); ++m) {
    if (!(radius[m] > 0)) continue;
    const double k = s.matter[m].conductivity.at(s.scene.temperature);
    const double h = std::max(coefficient(s.scene, s.matter[m], 2 * radius[m]), contacts[m]);
    const double biot = k > 0 ? h * radius[m] / (3 * k) : k_never;
    lines.push_back(fmt::format(
        "{}: Bi = h R/(3 k) = {:.2g} of the largest grain (h = {:.3g} W/m2/K): {}", w.rules.scene.materials[m].name,
        biot, h,
        biot <= 0.1 ? "one temperature per grain is enough"
                    : fmt::format("its inside lags behind, errors of about {:.0f} %; it would need shells, {} or more",
                                  std::min(100.0, 60 * biot), biot < 3 ? 10 : 20)));
    if (std::string line = when_hot(s, w, m, smallest[m]); !line.empty()) lines.push_back(std::move(line));
  }
  if (s.scene.error > 0)
    lines.push_back(fmt::format(
        "error = {:.3g} K: heat steps of {} to {} steps, `every` times a power of two as the temperatures let it",
        s.scene.error, s.scene.every, s.scene.every_most > 0 ? s.scene.every_most : k_heat_growth * s.scene.every));
  const std::string now =
      fmt::format("{} {} ({:.3g} s)", s.scene.error > 0 ? "the present one has" : "every =", s.pace.steps, s.dt(w));
  if (excess > 0) {
    const double most = static_cast<double>(s.pace.steps) / excess;
    lines.push_back(fmt::format("{}; by what grains exchange now at most {}, for errors of about 1 % of a change {}",
                                now, as_steps(w, most), as_steps(w, 0.02 * most)));
  } else {
    lines.push_back(now + "; the largest that is allowed is known after the first heat step");
  }
  return lines;
}

}  // namespace talus
