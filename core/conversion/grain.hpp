// One grain: matter, shape and shells, its state and balances. Who calls it: the command, tests, later the parts that
// put grains into a bed. Invariant: residuals are those of the whole run since the grain was made.
#pragma once

#include "core/conversion/step.hpp"

namespace talus::conversion {

struct GrainForm {
  heat::Shape shape = heat::Shape::sphere;
  double radius = 0;  ///< half thickness of a plate [m]
  double extent = 1;  ///< area of both faces of a plate [m2], length of a cylinder [m]
  std::size_t shells = 20;
};

template <class V>
struct Totals {
  V mass, moisture, fuel, char_, ash;  ///< [kg]
  V heat;                              ///< sensible, latent and debt [J]
  V mean;                              ///< temperature, weighted by heat capacity [K]
  std::array<V, k_elements> elements;  ///< [kg]
};

template <class V>
class Grain {
 public:
  Grain(const Matter& matter, const GrainForm& form, V temperature, const StepOptions& options)
      : matter_(matter), mixture_(matter_), step_(matter_, options, form.shells) {
    const std::size_t n = form.shells;
    state.shells.shape = form.shape;
    state.shells.factor = heat::shape_factor(form.shape, form.extent);
    state.shells.resize(n);
    state.volume0 = heat::equal_shells(form.shape, state.shells.factor, V(form.radius), n);
    state.shells.set(state.volume0);
    state.temperature.assign(n, temperature);
    state.debt.assign(n, V(0));
    state.liquid.assign(n, molten(matter.melting, temperature));
    state.mass.assign(matter.solids.size() * n, V(0));
    state.initial.assign(k_kinds * n, V(0));
    state.released.assign(matter.gases.size(), V(0));
    for (V& x : state.gone) x = V(0);
    for (std::size_t s = 0; s < matter.solids.size(); ++s) {
      for (std::size_t i = 0; i < n; ++i) {
        state.m(s, i) = V(matter.density * matter.solids[s].initial) * state.volume0[i];
        const Kind kind = matter.solids[s].kind;
        if (kind == Kind::moisture || kind == Kind::fuel) state.m0(kind, i) = state.m0(kind, i) + state.m(s, i);
      }
    }
    state.surface = temperature;
    start_ = totals();
  }
  Grain(const Grain&) = delete;
  Grain& operator=(const Grain&) = delete;

  void begin(const Surroundings<V>& s) { step_.start(state, s); }
  void advance(V dt, const Surroundings<V>& before, const Surroundings<V>& after, const GasAround<V>& gas) {
    step_.advance(state, dt, before, after, gas);
  }
  void advance_by(Method method, V dt, const Surroundings<V>& before, const Surroundings<V>& after,
                  const GasAround<V>& gas) {
    step_.advance(state, dt, before, after, gas, method);
  }
  V outflow() const { return step_.outflow(); }
  const Totals<V>& at_start() const { return start_; }
  const Matter& matter() const { return matter_; }

  /// Temperature at the centre: a parabola through the two innermost shells.
  V centre() const {
    if (state.size() < 2) return state.temperature[0];
    const V a = state.shells.middle(0), b = state.shells.middle(1);
    const V T0 = state.temperature[0], T1 = state.temperature[1];
    return T0 - (T1 - T0) * (a * a) / (b * b - a * a);
  }
  /// Temperature at a share x of the radius, linear between the shells' middles.
  V at(double x) const {
    const V r = V(x) * state.shells.radius();
    V T = state.temperature[0];
    for (std::size_t i = 1; i < state.size(); ++i) {
      const V a = state.shells.middle(i - 1), b = state.shells.middle(i);
      const V u = clamped((r - a) / (b - a), V(0), V(1));
      T = T + u * (state.temperature[i] - state.temperature[i - 1]);
    }
    return T;
  }

  Totals<V> totals() const {
    Totals<V> t{};
    t.mass = t.moisture = t.fuel = t.char_ = t.ash = t.heat = t.mean = V(0);
    for (V& e : t.elements) e = V(0);
    V capacity = V(0);
    for (std::size_t i = 0; i < state.size(); ++i) {
      const auto m = mixture_.by_kind([&](std::size_t s) { return state.m(s, i); });
      const auto h = mixture_.sensible(state.temperature[i]);
      V mass = V(0);
      for (std::size_t k = 0; k < k_kinds; ++k) {
        t.heat = t.heat + m[k] * h[k];
        mass = mass + m[k];
      }
      t.heat = t.heat + state.debt[i] + state.liquid[i] * mass * V(matter_.melting.latent);
      const V c = mixture_.capacity(m, state.temperature[i]);
      capacity = capacity + c;
      t.mean = t.mean + c * state.temperature[i];
      t.moisture = t.moisture + m[0];
      t.fuel = t.fuel + m[1];
      t.char_ = t.char_ + m[2];
      t.ash = t.ash + m[3];
      t.mass = t.mass + mass;
      for (std::size_t s = 0; s < matter_.solids.size(); ++s)
        for (std::size_t e = 0; e < k_elements; ++e)
          t.elements[e] = t.elements[e] + V((*matter_.solids[s].composition)[e]) * state.m(s, i);
    }
    t.mean = t.mean / capacity;
    return t;
  }

  /// Heat that is not accounted for [J]: stored now less stored then, less what crossed the surface and reactions gave.
  V heat_residual() const {
    return totals().heat - start_.heat - state.heat_in - state.heat_of_reaction + state.heat_with_gas;
  }
  /// The same for an element [kg].
  V element_residual(std::size_t e) const { return totals().elements[e] - start_.elements[e] + state.gone[e]; }
  /// The same for mass [kg]: released gas, less what char reactions took from outside.
  V mass_residual() const {
    V sum = totals().mass - start_.mass;
    for (const V& x : state.released) sum = sum + x;
    return sum - state.oxygen_taken - state.carbon_dioxide_taken - state.steam_taken;
  }

  GrainState<V> state;

 private:
  /// What is liquid at first: none of it at a melting point, a share between solidus and liquidus.
  static V molten(const Melting& m, V T) {
    const V solidus = V(m.solidus), width = most(V(m.liquidus - m.solidus), V(1e-300));
    return clamped((T - solidus) / width, V(0), V(1));
  }

  Matter matter_;
  Mixture<V> mixture_;
  GrainStep<V> step_;
  Totals<V> start_{};
};

}  // namespace talus::conversion
