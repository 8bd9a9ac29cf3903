// Thermodynamics of the gas: ideal, of the eight species. Who uses it: flow, transport, combustion of core/gas.
// Enthalpies contain those of formation at 298.15 K, so that reactions need no heats of their own. Polynomials: NASA,
// seven coefficients in two ranges, from GRI-Mech 3.0 (Smith et al.); tar (benzene): heat capacity of Reid, Prausnitz,
// Poling, held at its value of 1500 K beyond. Invariant (I4): + - * / sqrt alone.
#pragma once

#include <string_view>

#include "core/scene/gas_settings.hpp"

namespace talus::gas {

inline constexpr double k_gas_constant = 8.314462618;       ///< [J/(mol K)]
inline constexpr double k_coldest = 200, k_hottest = 3500;  ///< range of the polynomials [K]

enum Element { k_carbon, k_hydrogen, k_oxygen, k_nitrogen, k_elements };

struct SpeciesInfo {
  std::string_view name;
  double molar_mass;         ///< [kg/mol]
  double atoms[k_elements];  ///< C, H, O, N in a molecule
};
const SpeciesInfo& species(int k) noexcept;

double enthalpy(int species, double temperature) noexcept;       ///< [J/kg]
double heat_capacity(int species, double temperature) noexcept;  ///< [J/(kg K)]

double enthalpy(const GasFractions& y, double temperature) noexcept;       ///< of a mixture [J/kg]
double heat_capacity(const GasFractions& y, double temperature) noexcept;  ///< of a mixture [J/(kg K)]
/// Temperature at which the mixture has the enthalpy [K], by Newton's method from `guess`; not bounded to the range.
double temperature_of(const GasFractions& y, double enthalpy, double guess) noexcept;
double specific_gas_constant(const GasFractions& y) noexcept;  ///< [J/(kg K)]

/// Partial pressure of steam [Pa].
double steam_pressure(const GasFractions& y, double pressure) noexcept;
/// Pressure of saturated steam above water, Murray (1967): within 1 % to 390 K, 10 % to 550 K; from the critical
/// temperature on without bound [Pa].
double saturation_pressure(double temperature) noexcept;

/// Sutherland's law for air, of all mixtures [Pa s].
double viscosity(double temperature) noexcept;
/// From viscosity, heat capacity and a Prandtl number of 0.7 [W/(m K)].
inline constexpr double k_prandtl = 0.7;
double conductivity(const GasFractions& y, double temperature) noexcept;

}  // namespace talus::gas
