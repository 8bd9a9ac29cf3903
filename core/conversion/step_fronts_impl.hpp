// What gas does in the shells of step.hpp: reactions on its way out, and the fronts to which it has to come, of drying
// and of burning char. Included by step.hpp only.
#pragma once

namespace talus::conversion {

/// Reactions of gas on its way out: the time in a shell is the gas it holds over the gas that passes.
template <class V>
void GrainStep<V>::secondary(const Stage& w, double pressure) {
  if (routes_.secondary.empty()) return;
  std::vector<V> passing(matter_.gases.size(), V(0));
  for (std::size_t i = 0; i < n_; ++i) {
    ShellChange<V>& c = change_[i];
    const std::vector<V> before = passing;
    V all = V(0);
    for (std::size_t k = 0; k < passing.size(); ++k) {
      passing[k] = passing[k] + c.released[k];
      all = all + passing[k];
    }
    const V held = gas_density(T1_[i], pressure, 0.03) * V(matter_.porosity) * volume_[i];
    const V time = held * w.duration / most(all, V(1e-300));
    const auto h1 = mixture_.sensible(T1_[i]);
    const Ends<V> ends{T1_[i], T1_[i], h1, h1};
    for (const std::size_t r : routes_.secondary) {
      const Reaction& reaction = matter_.reactions[r];
      const V there = most(passing[reaction.reactant], V(0));
      const V x = there * (V(1) - decay(rate1_[r * n_ + i] * time).left);
      passing[reaction.reactant] = passing[reaction.reactant] - x;
      for (const Yield& y : reaction.gases) passing[y.species] = passing[y.species] + V(y.mass) * x;
      for (const Yield& y : reaction.solids) c.mass[y.species] = c.mass[y.species] + V(y.mass) * x;
      for (std::size_t e = 0; e < k_elements; ++e) c.gone[e] = c.gone[e] + V(routes_.leaving[r][e]) * x;
      c.heat = c.heat + heat_released(matter_, reaction, ends) * x;
    }
    // what this shell adds to the passing gas or takes from it
    for (std::size_t k = 0; k < passing.size(); ++k) c.released[k] = passing[k] - before[k];
  }
}

/// Evaporation at the wet front and burning at the char front: a shell counts as far as the shells around it let gas
/// through, and as front while it holds more than a trace. The front stands where what is left of the shell ends.
template <class V>
void GrainStep<V>::char_and_drying(const GrainState<V>& g, const Stage& w, const GasAround<V>& gas) {
  const bool dries = has_moisture_ && matter_.drying.kind == Drying::equilibrium;
  if (!dries && matter_.char_reactions.empty()) return;
  const V area = shells_.area[n_], tiny = V(1e-300);
  using heat::square_root;
  const auto surface = [&](V r) { return most(heat::area_of(shells_.shape, r, shells_.factor), tiny); };
  const V blow = !matter_.blowing
                     ? V(0)
                     : stage_gas_ / most(gas_density(surface_T_, gas.pressure, gas.molar) * gas.film * area, tiny);
  V way = V(1) / most(gas.film * blown(most(blow, V(0))) * area, tiny);  // resistance to here [s/m3]
  V wet_open = V(1), char_open = V(1);
  for (std::size_t i = n_; i-- > 0;) {
    Extra<V>& extra = extra_[i];
    const V T = T1_[i], outer = shells_.face[i + 1];
    const V pores = V(matter_.porosity * matter_.tortuosity_factor) * gas_diffusivity(T, gas.pressure);
    const V below = heat::volume_of(shells_.shape, shells_.face[i], shells_.factor);
    // share `left` of what was there, of which the rest has shrunk by the share `shrinks` of its volume
    const auto front_at = [&](V left, double shrinks) {
      const V l = clamped(left, V(0), V(1)), core = l / (V(1) - V(shrinks) * (V(1) - l)) * volume_[i];
      return least(heat::radius_of(shells_.shape, below + core, shells_.factor), outer);
    };
    // through what lies before a front at r: exact for spheres and plates
    const auto before = [&](V r) { return (outer - r) / most(pores * surface(square_root(outer * r)), tiny); };
    const V dry0 = most(g.m0(Kind::fuel, i), tiny);
    if (dries) {
      const V m = g.m(moisture_, i),
              dried = before(front_at(m / most(g.m0(Kind::moisture, i), tiny), matter_.shrinkage.drying));
      const V front = wet_open * least(m / (V(0.02) * dry0), V(1));
      wet_open = wet_open - front;
      const V drive = most(saturated_vapour(T, matter_.drying, gas.pressure) - gas.vapour, V(0));
      extra.drying = steady(front * drive / (way + dried) * w.duration / most(m, tiny));
      extra.drying_slope = V(matter_.drying.heat * 0.018015 / k_gas_constant) / (T * T);
    }
    V char_mass = V(0), fuel = V(0);
    for (std::size_t s = 0; s < matter_.solids.size(); ++s)
      if (matter_.solids[s].kind == Kind::char_)
        char_mass = char_mass + g.m(s, i);
      else if (matter_.solids[s].kind == Kind::fuel)
        fuel = fuel + g.m(s, i);
    // what has not burnt out: Mixture::burnt_out
    const V burnt = g.m0(Kind::char_, i), gone = burnt / most(char_mass + burnt, tiny) * (V(1) - fuel / dry0);
    const V at = front_at(V(1) - gone, matter_.shrinkage.burn_off), ash = before(at);
    const V solid0 = most(g.m0(Kind::fuel, i) + char_mass + burnt, tiny);
    const V front = char_open * least(char_mass / (V(0.02) * solid0), V(1));
    char_open = char_open - front;
    for (std::size_t c = 0; c < matter_.char_reactions.size(); ++c) {
      const CharReaction& r = matter_.char_reactions[c];
      const CharYield<V> y = char_yield(r, T);
      const V around = r.oxidant == CharReaction::Oxidant::oxygen           ? gas.oxygen
                       : r.oxidant == CharReaction::Oxidant::carbon_dioxide ? gas.carbon_dioxide
                                                                            : gas.steam;
      const V kinetic = V(1) / most(arrhenius(r.A, r.n, r.E, T) * surface(at), tiny);
      const V oxidant = front * around / (way + ash + kinetic);  // [kg/s]
      extra.burning[c] = steady(oxidant / (V(matter_.char_carbon) * y.oxidant) * w.duration / most(char_mass, tiny));
      extra.burning_heat[c] = V(matter_.char_carbon) * y.heat;
    }
    way = way + shells_.thickness(i) / most(pores * surface(shells_.middle(i)), tiny);
  }
}

}  // namespace talus::conversion
