// Properties of a shell from what is in it: sensible heat, capacity, conductivity, emissivity, volume. Who calls it:
// the grain solver. Invariant: capacity is the derivative of sensible heat at fixed masses.
#pragma once

#include "core/conversion/state.hpp"

namespace talus::conversion {

/// Masses of a shell by kind [kg].
template <class V>
using ByKind = std::array<V, k_kinds>;

template <class V>
class Mixture {
 public:
  explicit Mixture(const Matter& matter) : m_(matter) {}

  /// Masses by kind; mass(s) gives that of a solid.
  template <class Mass>
  ByKind<V> by_kind(const Mass& mass) const {
    ByKind<V> sum{};
    for (V& x : sum) x = V(0);
    for (std::size_t s = 0; s < m_.solids.size(); ++s) {
      V& x = sum[static_cast<std::size_t>(m_.solids[s].kind)];
      x = x + mass(s);
    }
    return sum;
  }
  /// Sensible heat per kg by kind [J/kg]; differences between temperatures count, and between kinds where heats of
  /// reaction refer to a temperature: then zero lies there.
  ByKind<V> sensible(V T) const {
    ByKind<V> h;
    for (std::size_t k = 0; k < k_kinds; ++k) {
      h[k] = m_.heat_capacity[k].integral(T);
      if (m_.reference_temperature) h[k] = h[k] - V(m_.heat_capacity[k].integral(*m_.reference_temperature));
    }
    return h;
  }
  V capacity(const ByKind<V>& mass, V T) const {
    V sum = V(0);
    for (std::size_t k = 0; k < k_kinds; ++k) sum = sum + mass[k] * m_.heat_capacity[k].at(T);
    return sum;
  }

  /// Share of the fuel that is left, of the moisture, of the char that was not burnt.
  struct Shares {
    V fuel, moisture, char_left, char_of_rest;
  };
  Shares shares(const ByKind<V>& m, V moisture0, V fuel0, V burnt) const {
    const V tiny = V(1e-300), c = m[at(Kind::char_)], a = m[at(Kind::ash)];
    const V left = select(less(tiny, c + burnt), c / most(c + burnt, tiny), V(1));
    return {ratio(m[at(Kind::fuel)], fuel0), ratio(m[at(Kind::moisture)], moisture0), left,
            select(less(tiny, c + a), c / most(c + a, tiny), V(0))};
  }
  V conductivity(const ByKind<V>& m, const Shares& s, V T) const {
    const V f = m[at(Kind::fuel)], c = m[at(Kind::char_)];
    const V fuel = m_.conductivity_by_mass ? f / most(f + c, V(1e-300)) : s.fuel;
    const V dry = m_.conductivity[at(Kind::fuel)].at(T);
    const V wood = dry + s.moisture * (m_.conductivity_wet.at(T) - dry);
    const V rest = s.char_left * m_.conductivity[at(Kind::char_)].at(T) +
                   (V(1) - s.char_left) * m_.conductivity[at(Kind::ash)].at(T);
    return most(fuel * wood + (V(1) - fuel) * rest, V(m_.least_conductivity));
  }
  V emissivity(const Shares& s) const {
    const V rest = s.char_left * V(m_.emissivity[1]) + (V(1) - s.char_left) * V(m_.emissivity[2]);
    return s.fuel * V(m_.emissivity[0]) + (V(1) - s.fuel) * rest;
  }
  /// Share of what was fuel that is now ash: of what has become char, what has burnt. A first trace of char that burns
  /// as it is made is no burnt-out shell.
  static V burnt_out(const Shares& s) { return (V(1) - s.fuel) * (V(1) - s.char_left); }
  V volume_share(const Shares& s) const {
    const Shrinkage& k = m_.shrinkage;
    return (V(1) - V(k.drying) * (V(1) - s.moisture)) * (V(1) - V(k.devolatilisation) * (V(1) - s.fuel)) *
           (V(1) - V(k.burn_off) * burnt_out(s));
  }

 private:
  static constexpr std::size_t at(Kind k) { return static_cast<std::size_t>(k); }
  /// part / whole; 0 where there was none
  static V ratio(V part, V whole) {
    return select(less(V(0), whole), part / select(less(V(0), whole), whole, V(1)), V(0));
  }
  const Matter& m_;
};

}  // namespace talus::conversion
