// The state of one grain (or of a batch of lanes): shells with temperature and masses, and what has crossed the
// surface. Who calls it: the grain solver. Invariant: heat stored in a shell = sum of m h(T) + latent + debt exactly;
// the debt is what an iteration left over and goes into the next stage.
#pragma once

#include <array>
#include <vector>

#include "core/conversion/matter.hpp"
#include "core/heat/shells.hpp"

namespace talus::conversion {

template <class V>
struct GrainState {
  heat::Shells<V> shells;
  std::vector<V> volume0;      ///< initial volumes [m3]
  std::vector<V> temperature;  ///< [K]
  std::vector<V> debt;         ///< [J]
  std::vector<V> liquid;       ///< molten share
  std::vector<V> mass;         ///< [solid][shell], kg
  std::vector<V> initial;      ///< [kind][shell]: initial moisture and fuel, char formed so far, kg
  std::vector<V> rate;         ///< [reaction][shell]: rate constants at the state [1/s]
  V surface = V(0);            ///< surface temperature [K]
  V time = V(0);

  std::vector<V> released;  ///< [gas], kg since the start
  V oxygen_taken = V(0);    ///< O2 that came from outside [kg]
  V steam_taken = V(0), carbon_dioxide_taken = V(0);
  std::array<V, k_elements> gone{};  ///< elements that left with gas, less those taken from outside [kg]
  V heat_in = V(0);                  ///< through the surface [J]
  V heat_of_reaction = V(0);         ///< released (+) by reactions and evaporation, J
  V heat_with_gas = V(0);            ///< sensible heat of solids that became gas [J]

  std::size_t size() const { return temperature.size(); }
  V& m(std::size_t solid, std::size_t shell) { return mass[solid * size() + shell]; }
  const V& m(std::size_t solid, std::size_t shell) const { return mass[solid * size() + shell]; }
  const V& m0(Kind kind, std::size_t shell) const { return initial[static_cast<std::size_t>(kind) * size() + shell]; }
  V& m0(Kind kind, std::size_t shell) { return initial[static_cast<std::size_t>(kind) * size() + shell]; }
};

}  // namespace talus::conversion
