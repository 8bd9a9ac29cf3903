// Gas in the voids of a bed, as parsed: plain data. Filled by core/scene/sections/gas.cpp or by tests; read by core/gas
// and the part in scheduler/parts/gas.cpp. SI units.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/types.hpp"
#include "core/base/words.hpp"

namespace talus {

/// Species of the gas, in this order everywhere. Tar counts as benzene, C6H6.
enum class GasSpecies : int { o2, co2, co, h2o, h2, ch4, tar, n2 };
inline constexpr int k_gas_species = 8;
using GasFractions = std::array<double, k_gas_species>;  ///< by mass, or masses [kg]
inline constexpr GasFractions k_air{0.233, 0, 0, 0, 0, 0, 0, 0.767};

TALUS_WORDS(GasDrag, ergun, gidaspow, di_felice, beetstra)
TALUS_WORDS(GasNusselt, gunn, whitaker, ranz_marshall, wakao)
TALUS_WORDS(GasSide, left, right, front, back, bottom, top)

/// What lets gas through a side of the grid, or through a rectangle of it.
struct GasInlet {
  TALUS_MEMBER_WORDS(Kind, flow, pressure)
  GasSide side = GasSide::bottom;
  Kind kind = Kind::flow;
  Vec3 lower{-1e30, -1e30, -1e30}, upper{1e30, 1e30, 1e30};  ///< faces with their middle in it [m]
  double velocity = 0;      ///< flow: into the grid, superficial, at its temperature and the reference pressure [m/s]
  double pressure = -1;     ///< pressure: outside of the side [Pa]; negative: that of the gas at the start
  double temperature = -1;  ///< of what comes in [K]; negative: that of the gas at the start
  GasFractions fractions = k_air;
  bool own_fractions = false;  ///< they were given; else those of the gas at the start
};

struct GasSettings {
  bool on = false;
  Vec3 lower{}, upper{};  ///< of the grid [m]
  std::array<int, 3> cells{1, 1, 1};
  std::int64_t every = 100;  ///< steps between two gas steps
  GasDrag drag = GasDrag::gidaspow;
  GasNusselt nusselt = GasNusselt::gunn;
  double pressure = 101325;        ///< of the gas at the start; reference [Pa]
  double temperature = 300;        ///< of the gas at the start [K]
  GasFractions fractions = k_air;  ///< of the gas at the start
  double most_porosity = 0.95;     ///< emptier cells resist as this one with grains of the mean size
  double least_porosity = 0.2;     ///< fuller cells resist and hold as much gas as this one
  bool combustion = false;
  std::vector<GasInlet> inlets;
};

}  // namespace talus
