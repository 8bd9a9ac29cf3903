// What the gas says of itself: columns of the series, and what a gas step warns of. Who calls it:
// scheduler/parts/gas.cpp.
#pragma once

#include <vector>

#include "core/gas/gas.hpp"
#include "scheduler/part.hpp"

namespace talus {

/// Columns of the series; `axis`: that of the pressure drop; `force`: on all grains [N].
std::vector<PartValue> gas_values(const gas::Gas& gas, const Scene& scene, int axis, Vec3 force);

/// Of the gas step that ends: steam that is above saturation beside gas or grains of its cell and does not condense; a
/// pressure at which wet grains would not boil where their file says; cells that get more grains than they hold.
/// `from`: what the step was made with; `wetted`: cells with grains that steam condenses on.
std::vector<PartConcern> gas_concerns(const gas::Gas& gas, const Scene& scene, const gas::FromGrains& from,
                                      const std::vector<char>& wetted);

}  // namespace talus
