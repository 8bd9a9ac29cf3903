// How heat, conversion and gas of the same grains work together, all at the ends of the same steps: what each shows the
// others, found by part_as<T>(view.parts). Nodes run in this order:
//
//   laser_step       what beams give each grain
//   gas_step         the gas makes its step with the surface temperatures that grains have; what it gives each grain
//   heat_step        all that reaches the surfaces of grains; lumped grains take it
//   conversion_step  grains with shells take it, and set the temperatures of their surfaces; what they release goes to
//                    the cells, what they take comes from there
//
// Invariant: what one loses another gains, to rounding; all exchange is that of the temperatures at the step's begin.
#pragma once

#include <array>
#include <vector>

#include "core/scene/conversion.hpp"
#include "core/scene/gas_settings.hpp"
#include "scheduler/part.hpp"

namespace talus {

/// The gas around a grain.
struct GasNear {
  double temperature = 0;        ///< [K]
  double film = 0;               ///< coefficient without outflow [W/m2/K]; 0: there is none
  double slip = 0;               ///< speed past the grain, superficial [m/s]
  double steam = 0;              ///< mass fraction
  double molar = 0;              ///< [kg/mol]; like the next of cells alone
  double pressure = 0;           ///< [Pa]
  std::array<double, 3> kept{};  ///< fractions of O2, CO2, H2O that last until the end of the step
};

/// What a grain could take of the gas around it, at most.
struct GasUptake {
  double oxidant = 0;     ///< by its char, of a gas that were nothing but oxidant [kg/s]
  double vapour = 0;      ///< by its cold surface, of a gas that were nothing but steam [kg/s]; 0: nothing condenses
  double saturation = 0;  ///< pressure of saturated steam at its surface [Pa]
};

/// Steam that would condense on a grain until the end of the step if its surface stayed as cold as it is.
struct GasSteam {
  double mass = 0;      ///< [kg]
  double above = 1;     ///< pressure of what lasts over that of saturation
  double enthalpy = 0;  ///< of the steam, above that of formation [J/kg]
};

/// Part "heat": what reaches the surfaces.
class GrainHeat {
 public:
  virtual ~GrainHeat() = default;
  virtual const Column<double>& temperature() const = 0;  ///< of the surface [K]
  /// Of the heat step that ends, for grains with shells: heat into the surface, friction included [W], at the
  /// temperature `before`; the sum of the conductances that it came through [W/K].
  virtual double flow(Row i) const = 0;
  virtual double conductance(Row i) const = 0;
  virtual double before(Row i) const = 0;
  virtual GasNear given_gas(const PartView& w, Row i) const = 0;  ///< that of [heat.gas]
  /// The surface temperature of a grain with shells after the heat step [K].
  virtual void set_surface(Row i, double temperature) = 0;
};

/// The outermost shell of a grain.
struct GrainSurface {
  double capacity = 0;      ///< heat that it takes per rise in a step, with what passes on inwards [J/K]
  double inner = 0;         ///< conductance from the middle of the shell to the surface [W/K]
  double conductivity = 0;  ///< [W/m/K]
  double emissivity = 0;
  double carried = 0;  ///< heat capacity flow of the gas that comes out [W/K]
};

/// Grains of this material have shells: conversion computes them.
bool has_shells(const ConversionScene& scene, std::size_t material);

/// A film's conductance that the heat capacity flow `carried` of gas coming out leaves [W/K].
double thinned(double conductance, double carried);

/// Part "conversion": grains with shells. It owns their heat; what reaches their surface is heat's business.
class GrainInside {
 public:
  virtual ~GrainInside() = default;
  virtual GrainSurface surface(Row i) const = 0;              ///< of a row that has shells
  virtual bool condenses(const Rows& rows, Row i) const = 0;  ///< steam on it: its water has a vapour pressure
};

/// Part "gas".
class GasCells {
 public:
  virtual ~GasCells() = default;
  /// Of the gas step that ends: heat into the grain [W], and the conductance that it came through [W/K].
  virtual double heat(Row i) const = 0;
  virtual double conductance(Row i) const = 0;
  virtual GasNear near(Row i) const = 0;
  /// By row. From then on `kept` is what remains in the cells at the end of the step if all grains take that: no cell
  /// can run out, and none loses steam beyond what its coldest grain holds in balance.
  virtual void offer(const PartView& w, const std::vector<GasUptake>& uptake) = 0;
  virtual double saturable(Row i) const = 0;  ///< the largest partial pressure of steam in its cells [Pa]
  virtual GasSteam steam(Row i) const = 0;    ///< after offer
  /// What a grain has released, taken of O2, CO2, H2O by its char, and condensed in the step [kg]; the enthalpy of all
  /// this, those of formation included [J]. Rows ascend; then settle.
  virtual void give(Row i, const GasFractions& released, const std::array<double, 3>& taken, double condensed,
                    double enthalpy) = 0;
  virtual void settle() = 0;
};

/// Part "laser".
class LaserLight {
 public:
  virtual ~LaserLight() = default;
  virtual double heat(Row i) const = 0;  ///< absorbed by the grain in the heat step that ends [W]
  virtual double absorbed() const = 0;   ///< by all grains since the start [J]
};

}  // namespace talus
