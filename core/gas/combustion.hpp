// Burning of CO, H2, CH4 and tar in the gas of a cell. Who calls it: gas.cpp, after transport. Rates in mol/(m3 s) of
// the fuel, concentrations in mol/m3, as published (global rates of one step):
//   CO + 1/2 O2 -> CO2         1.3e8 exp(-125.5 kJ/mol / RT) [CO] [H2O]^0.5 [O2]^0.5         Howard et al. (1973)
//   H2 + 1/2 O2 -> H2O         1.8e10 exp(-146.4 kJ/mol / RT) [H2] [O2]^0.5                  Marinov et al. (1996)
//   CH4 + 3/2 O2 -> CO + 2 H2O 1.585e10 exp(-202.5 kJ/mol / RT) [CH4]^0.7 [O2]^0.8           Dryer and Glassman (1973)
//   tar + 9/2 O2 -> 6 CO + 3 H2O  7.59e6 exp(-125.5 kJ/mol / RT) [tar]^-0.1 [O2]^1.85      Westbrook and Dryer (1981),
// of benzene (the first of two steps); its order in tar is held at 0 below 0.1 mol/m3. Enthalpy contains heats of
// formation, so that burning leaves it as it is. Invariants: elements and mass are kept by the stoichiometry; no
// fraction turns negative; the temperature lies between that before and that of complete burning, however long the
// step.
#pragma once

#include "core/scene/gas_settings.hpp"

namespace talus::gas {

/// Rate of reaction r (CO, H2, CH4, tar) at concentrations c [mol/(m3 s)].
double burning_rate(int r, const GasFractions& concentration, double temperature) noexcept;

/// Burns for `dt` [s] at constant enthalpy and pressure [Pa]. `mass` [kg] of the cell, its enthalpy [J], a guess of its
/// temperature [K]; returns the temperature after it. Steps within follow the change of temperature.
double burn(GasFractions& mass, double enthalpy, double temperature, double pressure, double dt) noexcept;

}  // namespace talus::gas
