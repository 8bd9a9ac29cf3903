// The gas of a bed: its state, one step of it, its balances. Who calls it: scheduler/parts/gas.cpp, tests, whatever
// else knows the grains. A step goes: porosity, flow (pressure, quasi-steady), species, enthalpy (transient), burning.
// What is left out: inertia and convection of momentum (a bed's resistance outweighs them; an empty vessel's does not);
// work of pressure where an open side holds it (transport.hpp).
// Invariants: serial, in a fixed order, + - * / sqrt and det_math alone: the bits depend on the input alone; mass and
// enthalpy follow from fluxes, so that what is stored changes by what passes, to rounding.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/gas/exchange.hpp"
#include "core/gas/flow.hpp"
#include "core/gas/grid.hpp"
#include "core/gas/transport.hpp"

namespace talus::gas {

/// What a run has seen pass, and what is stored; residuals are stored - start - in + out - of the grains - work of
/// pressure.
struct Balance {
  Passed passed;                                   ///< since the start
  GasFractions start{}, stored{};                  ///< masses [kg]
  double start_enthalpy = 0, stored_enthalpy = 0;  ///< [J]
  double mass_residual() const noexcept;
  double enthalpy_residual() const noexcept;
  /// Of C, H, O, N in all species [kg].
  double element_residual(int element) const noexcept;
};

class Gas {
 public:
  /// `periodic`: axes on which the grid wraps. Error{scene}: the settings contradict each other.
  Gas(const GasSettings& settings, std::array<bool, 3> periodic, Vec3 gravity);
  /// Fills the voids that the grains leave with the gas of the settings. Before the first step; not after load().
  void start(const FromGrains& grains);
  bool started() const noexcept { return !content_.mass.empty(); }
  /// One step of dt [s]. Error{physics}.
  void step(const FromGrains& grains, double dt);
  /// Mass [kg] and enthalpy [J] that grains put into a cell between two steps; negative: take from it. At the end of it
  /// settle(). Error{physics}: more is taken than there is; beyond the range of the thermodynamics.
  void give(int cell, const GasFractions& mass, double enthalpy);
  void settle();
  void set_gravity(Vec3 g) noexcept { gravity_ = g; }

  const Grid& grid() const noexcept { return grid_; }
  const GasSettings& settings() const noexcept { return settings_; }
  const ToGrains& fields() const noexcept { return fields_; }
  const Flow& flow() const noexcept { return flow_; }
  const Content& content() const noexcept { return content_; }
  const Balance& balance() const noexcept { return balance_; }
  std::int64_t steps() const noexcept { return steps_; }
  /// Mean pressure on the faces of a side less that of the other end of the axis [Pa]; 0 on a periodic axis.
  double pressure_drop(int axis) const noexcept;
  /// Of the whole [Pa]: transport.hpp; where sides hold it, the mean over the voids.
  double pressure() const noexcept;
  bool sealed() const noexcept { return vessel_.sealed; }

  /// All that later steps depend on. load: Error{io} where it does not fit.
  std::vector<std::uint8_t> save() const;
  void load(std::span<const std::uint8_t> bytes, const std::string& where);

 private:
  void set_porosity(const FromGrains& grains);
  void set_fields();
  void take_pressure();
  void store();
  [[noreturn]] void fail(std::size_t cell, const std::string& what) const;
  std::vector<int> flow_order() const;
  FromGrains at_most_there(const FromGrains& grains, double dt) const;
  double sealed_pressure(const FlowInput& in) const;
  FlowInput flow_input(const FromGrains& grains, double dt) const;

  GasSettings settings_;
  Grid grid_;
  Vec3 gravity_;
  FlowSolver solver_;
  std::vector<Opening> openings_;
  double mean_diameter_ = 0;
  Content content_;
  Flow flow_;
  ToGrains fields_;
  Balance balance_;
  Vessel vessel_;
  std::int64_t steps_ = 0;
  std::vector<char> given_;  ///< cells that grains have given something since settle()
};

}  // namespace talus::gas
