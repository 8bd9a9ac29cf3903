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
/// negative mass of every mixture; ash that leaves; char that burns and holds more oxygen than
/// steam takes. Char that some reaction makes alone of a fuel, as in schemes of parallel reactions, gets the elements
/// of that fuel: carbon alone would have to come from the gas of the other reactions. Its carbon burns, the rest leaves
/// as steam and hydrogen with it.
///
/// Energy: what leaves a grain as gas carries what the grain has lost with it. A reaction of extent x [kg] then frees
/// x times a constant of its own, of grain and gas together, whatever the temperatures: their sum less those constants
/// is conserved. The constants (`to_cells`) are such that the gas comes at the temperature of the grain: heats of
/// reaction hold at matter.reference_temperature; without one at that at which the rate constant is 0.01 1/s; heat of
/// evaporation at boiling, char as graphite at 298.15 K. Capacities of released gases are those of the species.
Matter with_cell_gases(const Matter& matter);

/// Enthalpy of formation of a species of the gas part, 0 to 7 or by name [J/kg].
double formation_enthalpy(int species);
double formation_of(const std::string& species);
/// The species of CharReaction::Oxidant.
inline constexpr int k_oxidants[3] = {0, 1, 3};

}  // namespace talus::conversion
