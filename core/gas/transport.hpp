// Transport of species and enthalpy by a flow over one step: implicit, upwind, per cell
//   m Y - (m Y)_old + dt sum(F Y_upwind + G (Y - Y_neighbour)) = dt source,   the same with h and heat of the grains.
// G = e mu / Pr per length: conduction and diffusion with a Lewis number of 1, where both carry enthalpy as one term.
// The balance of mass makes each new value a mean of the old one, those upwind and what comes in, with weights that are
// not negative: no value leaves the range of the others. Who calls it: gas.cpp. Invariants: solved by sweeps in a fixed
// order along the flow; the new masses and enthalpies follow from fluxes, so that what leaves a cell enters another to
// rounding.
//
// Pressure: of a vessel that no side opens to a given pressure it is that of all gas in it,
//   P = sum(m R_s T) / sum(e V),   and its change does work, e V dP in each cell, at the temperatures of the step's
// end: heat warms such a vessel by its heat capacity at constant volume, and what is blown in is compressed. An open
// side holds the pressure; what the flow's resistance changes it by does no work here (a share of it over P).
#pragma once

#include <vector>

#include "core/gas/exchange.hpp"
#include "core/gas/flow.hpp"
#include "core/gas/grid.hpp"

namespace talus::gas {

/// What a step starts from, and ends with.
struct Content {
  std::vector<GasFractions> mass;   ///< of species [kg]
  std::vector<double> enthalpy;     ///< [J]
  std::vector<double> temperature;  ///< [K]
};

/// What has passed sides and grains in a step.
struct Passed {
  GasFractions in{}, out{}, grains{};  ///< mass through sides, from grains [kg]
  double enthalpy_in = 0, enthalpy_out = 0, enthalpy_grains = 0;
  double heat_grains = 0;    ///< [J]
  double pressure_work = 0;  ///< e V dP [J]
};

/// The pressure of the whole [Pa]; `sealed`: no side is open to a given one, so that it follows from mass and heat.
struct Vessel {
  bool sealed = false;
  double pressure = 0;
};

double sum(const GasFractions& y) noexcept;

/// Advances `content` by dt [s]. `out` gains exchange_temperature and taken; `passed` what has passed. `order`: cells,
/// those upwind first. `vessel` gets the pressure at the end. Error{physics}: a temperature beyond the range of the
/// thermodynamics.
void transport(const Grid& grid, const Flow& flow, const std::vector<Opening>& openings, const FromGrains& grains,
               double dt, const std::vector<int>& order, Vessel& vessel, Content& content, ToGrains& out,
               Passed& passed);

}  // namespace talus::gas
