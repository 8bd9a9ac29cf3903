// Gas around a grain as its reactions see it, and laws of gas: diffusivity, density, saturation. Who calls it: drying
// and char reactions of the grain solver, the command. Invariant: no library functions, so that bits hold.
#pragma once

#include "core/conversion/matter.hpp"
#include "core/heat/surface.hpp"

namespace talus::conversion {

template <class V>
struct GasAround {
  V film = V(0);                                         ///< mass transfer coefficient [m/s]
  V oxygen = V(0), carbon_dioxide = V(0), steam = V(0);  ///< concentrations [kg/m3]
  V vapour = V(0);                                       ///< of water, for drying [kg/m3]
  double pressure = 101325;                              ///< [Pa]
  double molar = 0.029;                                  ///< of the mixture [kg/mol]
};

inline constexpr double k_atmosphere = 101325;  // [Pa]

/// Binary diffusivity of small molecules in air, 2.07e-5 (T/298)^1.75 (1 atm)/p [m2/s] (Fuller's exponent).
template <class V>
V gas_diffusivity(V T, double pressure) {
  return V(2.07e-5 * (k_atmosphere / pressure)) * power(T / V(298), 1.75);
}

/// Density of gas of molar mass `molar` [kg/mol] at the pressure [kg/m3].
template <class V>
V gas_density(V T, double pressure, double molar) {
  return V(pressure * molar / k_gas_constant) / T;
}

/// Density of saturated water vapour [kg/m3], Clausius and Clapeyron through the law's boiling point at the pressure.
template <class V>
V saturated_vapour(V T, const DryingLaw& law, double pressure) {
  const double slope = law.heat * 0.018015 / k_gas_constant;
  return gas_density(T, pressure, 0.018015) * exponential(V(slope / law.temperature) - V(slope) / T);
}

/// Share of a film's coefficient that a net outflow leaves: B / (exp(B) - 1) for B >= 0.
template <class V>
V blown(V B) {
  const V b = clamped(B, V(1e-6), V(600));
  return b / (exponential(b) - V(1));
}

/// Per kg of char (carbon): gas taken and made [kg], heat released [J].
template <class V>
struct CharYield {
  V oxidant, carbon_monoxide, carbon_dioxide, hydrogen, heat;
};

/// C + (1 - x/2) O2 -> x CO + (1 - x) CO2 with x / (1 - x) = A exp(-E/RT); C + CO2 -> 2 CO; C + H2O -> CO + H2. Heats
/// from formation at 298 K: CO 110.5, CO2 393.5, H2O 241.8 kJ/mol.
template <class V>
CharYield<V> char_yield(const CharReaction& r, V T) {
  constexpr double per_kg = 1 / 0.012011;  // mol
  const V none = V(0);
  switch (r.oxidant) {
    case CharReaction::Oxidant::oxygen: {
      const V ratio = V(r.ratio_A) * exponential(V(-r.ratio_E / k_gas_constant) / T);
      const V x = ratio / (V(1) + ratio), rest = V(1) - x;
      return {V(0.0319988 * per_kg) * (V(1) - V(0.5) * x), V(0.0280104 * per_kg) * x, V(0.0440098 * per_kg) * rest,
              none, V(110.5e3 * per_kg) * x + V(393.5e3 * per_kg) * rest};
    }
    case CharReaction::Oxidant::carbon_dioxide:
      return {V(0.0440098 * per_kg), V(2 * 0.0280104 * per_kg), none, none, V((2 * 110.5e3 - 393.5e3) * per_kg)};
    case CharReaction::Oxidant::steam:
      return {V(0.01801528 * per_kg), V(0.0280104 * per_kg), none, V(0.00201588 * per_kg),
              V((110.5e3 - 241.8e3) * per_kg)};
  }
  return {none, none, none, none, none};
}

}  // namespace talus::conversion
