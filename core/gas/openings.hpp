// What lets gas through the sides of the grid: each face of a side takes the last inlet that covers its middle. Who
// calls it: gas.cpp.
#pragma once

#include <vector>

#include "core/gas/flow.hpp"
#include "core/gas/grid.hpp"

namespace talus::gas {

int axis_of(GasSide side) noexcept;
bool is_high(GasSide side) noexcept;

/// Per outer face of the grid. Error{scene}: an inlet covers no face, or lies on a periodic side.
std::vector<Opening> openings_of(const Grid& grid, const GasSettings& settings);

}  // namespace talus::gas
