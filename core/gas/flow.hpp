// Pressure and velocity of the gas in a bed, quasi-steady: per face
//   -dp/dx + rho g = R (U - e V) + R' U,   U superficial, V velocity of the grains, e porosity,
// with R of the drag law (Ergun: Darcy and Forchheimer) times the grains' drag factor, and per cell the balance of mass
// over a step
//   e V p / (R_s T) - m_old + dt sum(rho U A) = dt source.
// R' is that of the packing of the largest porosity where a cell is emptier: without it the gas of an empty cell would
// have no resistance at all. Who calls it: gas.cpp. Invariants: the linear systems are symmetric and positive definite,
// solved serially in a fixed order, so that the bits depend on the input alone.
#pragma once

#include <memory>
#include <vector>

#include "core/gas/grid.hpp"
#include "core/scene/gas_settings.hpp"

namespace talus::gas {

/// What lets gas through a face of a side.
struct Opening {
  enum class Kind { closed, flow, pressure } kind = Kind::closed;
  double flux = 0;            ///< flow: mass per time into the grid [kg/s]
  double pressure = 0;        ///< outside, at the lowest point of the grid [Pa]
  double gas_constant_t = 0;  ///< R_s T of what comes in [J/kg]
  double enthalpy = 0;        ///< of what comes in [J/kg]
  GasFractions fractions{};
};

/// What the flow of one step depends on.
struct FlowInput {
  GasDrag drag = GasDrag::ergun;
  double reference = 101325;  ///< pressure [Pa]
  double dt = 0;              ///< [s]
  double most_porosity = 0.95, mean_diameter = 0;
  Vec3 gravity;
  std::vector<double> porosity, diameter, viscosity, drag_factor;
  std::vector<double> gas_constant_t;  ///< R_s T [J/kg]: density = p / (R_s T)
  std::vector<double> mass, source;    ///< before the step [kg]; of grains [kg/s]
  std::vector<Vec3> solid_velocity;    ///< mean by the shares in the drag [m/s]
  std::vector<Opening> outer;          ///< per outer face
};

/// Along the axis on inner faces, outward on outer ones.
struct Flow {
  std::vector<double> pressure;                ///< [Pa]
  std::vector<double> inner, outer;            ///< superficial velocity [m/s]
  std::vector<double> inner_flux, outer_flux;  ///< [kg/s]
  std::vector<double> outer_pressure;          ///< on outer faces [Pa]
  std::vector<double> resistance;              ///< R of cells [Pa s/m2]
  std::vector<Vec3> velocity, gradient;        ///< of cells: means over the halves that belong to their faces; the
                                               ///< gradient that grains feel, without what empty cells resist
  int iterations = 0;
  double change = 0;  ///< of the velocities in the last iteration, relative to the largest
};

class FlowSolver {
 public:
  explicit FlowSolver(const Grid& grid);
  ~FlowSolver();
  FlowSolver(FlowSolver&&) noexcept;
  /// `flow` holds what the iteration begins with. Error{physics}: it does not end.
  void solve(const FlowInput& in, Flow& flow);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace talus::gas
