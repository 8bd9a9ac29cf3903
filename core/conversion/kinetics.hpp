// What reactions do in one shell during a stage: masses, heat, gas. Who calls it: core/conversion/step.hpp. Invariants:
// masses stay >= 0 for every rate and step (consumption is exponential, production within the stage included); what a
// reactant loses is what its products gain, to rounding.
#pragma once

#include <vector>

#include "core/conversion/state.hpp"

namespace talus::conversion {

/// exp(-K) and (1 - exp(-K)) / K for K >= 0.
template <class V>
struct Decay {
  V left, mean;
};
template <class V>
Decay<V> decay(V K) {
  const V left = exponential(V(0) - K);
  const V small = V(1) - K * (V(0.5) - K * (V(1.0 / 6) - K * V(1.0 / 24)));
  const auto tiny = less(K, V(1e-3));
  return {left, select(tiny, small, (V(1) - left) / select(tiny, V(1), K))};
}

/// K for which decay() takes away the share x of what is there, for x up to about 1: a flow that does not depend on how
/// much is left.
template <class V>
V steady(V x) {
  const V y = least(x, V(2));
  return y * (V(1) + y * (V(0.5) + y * V(1.0 / 3)));
}

template <class V>
V arrhenius(double A, double n, double E, V T) {
  const V k = V(A) * exponential(V(-E / k_gas_constant) / T);
  return n == 0 ? k : n == 1 ? k * T : k * power(T, n);
}

/// d ln k / dT of such a rate [1/K].
template <class V>
V arrhenius_slope(double n, double E, V T) {
  return (V(E / k_gas_constant) / T + V(n)) / T;
}

/// Both ends of a stage in one shell: temperatures, sensible heats of the kinds of solid [J/kg].
template <class V>
struct Ends {
  V T0, T1;
  std::array<V, k_kinds> h0, h1;
  V mean(Kind k) const { return V(0.5) * (h0[static_cast<std::size_t>(k)] + h1[static_cast<std::size_t>(k)]); }
};

/// Heat capacity of the gas that a reaction makes per kg of its reactant [J/K/kg].
template <class V>
V gas_capacity(const Matter& matter, const Reaction& r, V T) {
  if (r.gas_capacity) return r.gas_capacity->at(T);
  V mass = V(0);
  for (const Yield& y : r.gases) mass = mass + V(y.mass);
  return mass * matter.gas_heat_capacity.at(T);
}
template <class V>
V gas_sensible(const Matter& matter, const Property& capacity, V T) {
  return capacity.integral(T) - V(capacity.integral(*matter.reference_temperature));
}

/// Heat that a reaction releases per kg of its reactant [J/kg].
template <class V>
V heat_released(const Matter& matter, const Reaction& r, const Ends<V>& e) {
  V q = V(-r.heat);
  if (!matter.reference_temperature || r.at_reaction) return q;
  const auto mean = [&](const Property& c) {
    return V(0.5) * (gas_sensible(matter, c, e.T0) + gas_sensible(matter, c, e.T1));
  };
  q = q + (r.of_gas ? mean(matter.gas_heat_capacity) : e.mean(matter.solids[r.reactant].kind));
  for (const Yield& y : r.solids) q = q - V(y.mass) * e.mean(matter.solids[y.species].kind);
  if (r.gas_capacity) return q - mean(*r.gas_capacity);
  V mass = V(0);
  for (const Yield& y : r.gases) mass = mass + V(y.mass);
  return q - mass * mean(matter.gas_heat_capacity);
}

/// Extents that belong to no reaction of the list: evaporation and char reactions, each as a rate constant times time.
template <class V>
struct Extra {
  V drying = V(0), drying_slope = V(0);  ///< [-], d ln / dT [1/K]
  std::vector<V> burning, burning_heat;  ///< [char reaction]: [-], heat released per kg of char [J/kg]
};

/// Of one shell and stage.
template <class V>
struct ShellChange {
  std::vector<V> mass;      ///< [solid] at the end [kg]
  std::vector<V> released;  ///< [gas], kg
  std::vector<V> burnt;     ///< [char reaction], kg of char
  std::array<V, k_elements> gone;
  V gas_capacity;  ///< heat capacity of what was released [J/K]
  V dried;         ///< evaporated [kg]
  V heat, slope;   ///< released [J]; its derivative by temperature, never positive [J/K]
};

/// Elements that leave the solid per kg of a reaction's reactant.
inline Composition elements_leaving(const Matter& matter, const Reaction& r) {
  Composition c{};
  if (!r.of_gas) c = *matter.solids[r.reactant].composition;
  for (const Yield& y : r.solids)
    for (std::size_t e = 0; e < k_elements; ++e) c[e] -= y.mass * (*matter.solids[y.species].composition)[e];
  return c;
}

/// Which reactions a solid takes part in as reactant, and what leaves with each.
struct Routes {
  explicit Routes(const Matter& matter) : of_solid(matter.solids.size()) {
    for (std::size_t r = 0; r < matter.reactions.size(); ++r) {
      const Reaction& reaction = matter.reactions[r];
      if (reaction.of_gas)
        secondary.push_back(r);
      else
        of_solid[reaction.reactant].push_back(r);
      leaving.push_back(elements_leaving(matter, reaction));
      const double scale = 100 * reaction.A * det::pow(300, reaction.n);
      still.push_back(reaction.E / (k_gas_constant * det::log(scale > 3 ? scale : 3)));
    }
  }
  std::vector<std::vector<std::size_t>> of_solid;
  std::vector<std::size_t> secondary;
  std::vector<Composition> leaving;
  std::vector<double> still;  ///< temperature below which a reaction does next to nothing in a second [K]
};

/// kt[r]: integral of the rate constant over the stage; `late`: the part of it that grows with the temperature of the
/// end; m0(s): mass at the start.
template <class V, class Mass>
void react(const Matter& matter, const Routes& routes, const std::vector<V>& kt, const std::vector<V>& late,
           const Ends<V>& ends, const Extra<V>& extra, const Mass& m0, ShellChange<V>& out) {
  const std::size_t solids = matter.solids.size();
  for (V& g : out.released) g = V(0);
  for (V& e : out.gone) e = V(0);
  for (V& b : out.burnt) b = V(0);
  out.dried = out.heat = out.slope = out.gas_capacity = V(0);
  for (std::size_t s = 0; s < solids; ++s) out.mass[s] = V(0);  // production until the solid's turn comes
  for (std::size_t s = 0; s < solids; ++s) {
    const Kind kind = matter.solids[s].kind;
    const bool wet = kind == Kind::moisture, burns = kind == Kind::char_ && !extra.burning.empty();
    const V start = m0(s), made = out.mass[s], there = start + made;
    V K = V(0);
    for (const std::size_t r : routes.of_solid[s]) K = K + kt[r];
    if (wet) K = K + extra.drying;
    if (burns)
      for (const V& b : extra.burning) K = K + b;
    const Decay<V> d = decay(K);
    const V left = start * d.left + made * d.mean;
    out.mass[s] = left;
    const V share = (there - left) / most(K, V(1e-300));
    const V depletion = d.left / d.mean;
    for (const std::size_t r : routes.of_solid[s]) {
      const Reaction& reaction = matter.reactions[r];
      const V x = share * kt[r];
      for (const Yield& y : reaction.solids) out.mass[y.species] = out.mass[y.species] + V(y.mass) * x;
      for (const Yield& y : reaction.gases) out.released[y.species] = out.released[y.species] + V(y.mass) * x;
      for (std::size_t e = 0; e < k_elements; ++e) out.gone[e] = out.gone[e] + V(routes.leaving[r][e]) * x;
      out.gas_capacity = out.gas_capacity + x * gas_capacity(matter, reaction, ends.T1);
      const V q = heat_released(matter, reaction, ends);
      out.heat = out.heat + q * x;
      // Derivative by temperature of heat that is taken up: the local one, or where the reactant is used up the chord
      // to the temperature at which the reaction stands still, so that the iteration does not fall below it.
      const V by_T = share * late[r] * arrhenius_slope(reaction.n, reaction.E, ends.T1) * depletion;
      const V above = ends.T1 - V(routes.still[r]);
      const V chord = select(less(V(1), above), x / most(above, V(1)), V(0));
      out.slope = out.slope + least(q * most(by_T, chord), V(0));
    }
    if (wet) {
      out.dried = share * extra.drying;
      out.gone[water] = out.gone[water] + out.dried;
      out.heat = out.heat - V(matter.drying.heat) * out.dried;
      out.slope = out.slope - V(matter.drying.heat) * out.dried * extra.drying_slope * depletion;
    }
    if (burns) {
      for (std::size_t c = 0; c < extra.burning.size(); ++c) {
        const V x = share * extra.burning[c];
        out.burnt[c] = out.burnt[c] + x;
        out.heat = out.heat + extra.burning_heat[c] * x;
        for (std::size_t e = 0; e < k_elements; ++e)
          out.gone[e] = out.gone[e] + V((*matter.solids[s].composition)[e]) * x;
      }
    }
  }
}

}  // namespace talus::conversion
