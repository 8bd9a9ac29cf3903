// Exchange of a grain's surface with its surroundings: convection, radiation, a given flux, a contact; or a given
// surface temperature. Who calls it: the grain solvers. Invariant: the heat that enters the outermost shell equals the
// heat that the surroundings give, the surface itself stores none.
#pragma once

#include "core/heat/value.hpp"

namespace talus::heat {

inline constexpr double k_stefan = 5.670374419e-8;  ///< [W/m2/K4]

/// At one instant; every value per lane.
template <class V>
struct Surroundings {
  V film = V(0);                 ///< convective coefficient [W/m2/K]
  V gas_temperature = V(300);    ///< [K]
  V emissivity = V(0);           ///< of the exchange between surface and walls [-]
  V wall_temperature = V(300);   ///< [K]
  V flux = V(0);                 ///< given heat flux into the surface [W/m2]
  V contact_conductance = V(0);  ///< [W/K]
  V contact_temperature = V(300);
  bool given_surface = false;  ///< the same in every lane
  V surface_temperature = V(300);
};

/// Heat into the outermost shell as gain - loss * T_shell [W]; surface = at + slope * T_shell.
template <class V>
struct SurfaceExchange {
  V gain, loss, at, slope;
  V flow(V shell) const { return gain - loss * shell; }
  V surface(V shell) const { return at + slope * shell; }
};

/// Linearised about the surface temperature `about`; `inner` is the conductance from the shell's middle to the surface
/// [W/K].
template <class V>
SurfaceExchange<V> surface_exchange(const Surroundings<V>& s, V area, V inner, V about) {
  if (s.given_surface) return {inner * s.surface_temperature, inner, s.surface_temperature, V(0)};
  const V sigma = V(k_stefan) * s.emissivity * area;
  const V cube = about * about * about, wall2 = s.wall_temperature * s.wall_temperature;
  const V outer = area * s.film + s.contact_conductance + V(4) * sigma * cube;
  const V gain = area * (s.film * s.gas_temperature + s.flux) + s.contact_conductance * s.contact_temperature +
                 sigma * (wall2 * wall2 + V(3) * cube * about);
  const V share = V(1) / (inner + outer);
  return {inner * gain * share, inner * outer * share, gain * share, inner * share};
}

/// The surface temperature that belongs to a shell temperature, from a guess that is near.
template <class V>
V surface_temperature(const Surroundings<V>& s, V area, V inner, V shell, V guess) {
  for (int k = 0; k < 3; ++k) guess = most(surface_exchange(s, area, inner, guess).surface(shell), V(1));
  return guess;
}

}  // namespace talus::heat
