// Matter whose reactions release the species of the gas part: what a grain gives to a cell is then what the cell knows,
// and each element of it is there. Who calls it: scheduler/parts/conversion*. Invariant: per reaction the elements of
// its gases are those that leave the solid, to rounding.
#pragma once

#include "core/conversion/matter.hpp"

namespace talus::conversion {

/// The same solids and rates with gases O2, CO2, CO, H2O, H2, CH4, tar (benzene), N2 (those that are needed). Gases
/// with these names, `vapour` too, stay what they are as far as the elements allow; all others are taken apart into
/// mixtures of these with their elements: tar, CO and H2O of what is called tar, else CO, CO2 and CH4, or what else
/// there is with no negative share. Error{scene}: a reaction of gas within the grain; one that would have to make a
/// negative mass of every mixture; ash that leaves; char that burns and is not carbon.
Matter with_cell_gases(const Matter& matter);

}  // namespace talus::conversion
