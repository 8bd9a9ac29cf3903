// What grains and gas say to each other, per cell: the narrow interface behind which another flow solver could stand.
// Who fills FromGrains: share.hpp (scheduler/parts/gas.cpp, tests). Who reads ToGrains: the same. Invariant: sums over
// grains run in row order.
#pragma once

#include <vector>

#include "core/base/types.hpp"
#include "core/gas/grid.hpp"
#include "core/scene/gas_settings.hpp"

namespace talus::gas {

/// Of the grains, summed over cells by the share of their volume that lies in each.
struct FromGrains {
  std::vector<double> solid;         ///< volume of grains [m3]
  std::vector<double> specific;      ///< a sixth of their surface: gives the Sauter diameter [m2]
  std::vector<double> drag_factor;   ///< drag by their own sizes and velocities / that of the bed's law [-]
  std::vector<Vec3> moment;          ///< volume times velocity, each grain by its share in the drag [m4/s]
  std::vector<double> conductance;   ///< h A to the gas [W/K]
  std::vector<double> heat;          ///< h A T of the grains [W]
  std::vector<GasFractions> source;  ///< mass that grains give [kg/s]; negative: they want it
  std::vector<double> enthalpy;      ///< that comes with it [W]

  explicit FromGrains(int cells = 0) { clear(cells); }
  void clear(int cells);
};

/// Of the gas, per cell.
struct ToGrains {
  std::vector<double> porosity, diameter;  ///< diameter: Sauter mean of the cell's grains [m]; 0 without
  std::vector<Vec3> velocity;              ///< superficial [m/s]
  std::vector<Vec3> gradient;              ///< of the pressure [Pa/m]
  std::vector<double> drag;                ///< on all grains of the cell / (gas - their mean velocity) [kg/s]
  std::vector<double> pressure, temperature, density, viscosity, conductivity, prandtl;
  std::vector<GasFractions> fractions;
  std::vector<double> exchange_temperature;  ///< at which the heat of the last step has passed [K]
  std::vector<GasFractions> taken;           ///< share of the mass wanted that was there [-]

  void resize(int cells);
};

/// Calls use(cell, volume) for every cell that a ball about x (m) of radius r meets; volumes sum to what lies in the
/// grid. Cells are not smaller than r / 3.
inline constexpr double k_smallest_cell = 1.0 / 3;  ///< of the largest radius
void share(const Grid& grid, Vec3 x, double r, std::vector<std::pair<int, double>>& parts);
/// The same of an ellipsoid that lies along the axes of the grid, `reach`: its semi-axes [m].
void share(const Grid& grid, Vec3 x, Vec3 reach, std::vector<std::pair<int, double>>& parts);

}  // namespace talus::gas
