// Grain files: TOML text -> one grain with its surroundings over time. Who calls it: the command `talus grain`, tests.
// Invariants: every key, type and range comes from grain_keys; an unknown or contradictory key never passes silently;
// errors name file:line:column and what is allowed.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/conversion/film.hpp"
#include "core/conversion/grain.hpp"

namespace talus::conversion {

/// A value over time: straight lines between points, constant beyond.
struct Series {
  std::vector<double> time, value;
  double at(double t) const;
  double largest() const;
  /// Mean over [from, to] less the mean of the two ends: what a step that knows its ends alone would miss. 0 where no
  /// point lies within.
  double missed(double from, double to) const;
};

struct SurroundingsOverTime {
  GasKind gas = k_nitrogen;
  FilmLaw law = FilmLaw::ranz_marshall;
  Series temperature, velocity, flux, contact_conductance, oxygen, carbon_dioxide, steam;
  std::optional<Series> wall_temperature, surface_temperature, film, contact_temperature;
  double pressure = 101325;
  double rest = k_nitrogen.molar;   ///< of what is neither of the three: without oxygen where that is given [kg/mol]
  double molar_at(double t) const;  ///< of the mixture [kg/mol]
  /// At time t for a grain of that radius and surface temperature.
  Surroundings<double> at(double t, double radius, double surface) const;
  GasAround<double> gas_at(double t, double radius, double surface) const;
};

struct GrainJob {
  std::string title;
  Matter matter;
  GrainForm form;
  double temperature = 0;
  StepOptions options;
  double step = 0;
  std::int64_t steps = 0, output_steps = 1;
  SurroundingsOverTime around;
};

/// Error{scene}.
GrainJob parse_grain(std::string_view text, const std::string& name);
GrainJob load_grain(const std::string& path);

}  // namespace talus::conversion
