// One step in time of a grain: conduction in shells, exchange at the surface, melting, drying, reactions, char burning,
// shrinkage, coupled and implicit. Who calls it: core/conversion/grain.hpp, tests. Invariants: what a face takes from a
// shell it gives to the next, bit for bit; heat, mass and elements close to rounding whatever the iteration leaves
// over; no branch on a value.
//
// Method: TR-BDF2 (two stages, second order, L-stable) or backward Euler. The unknown of a stage is the heat Q that
// each shell takes in; its temperature is a function of Q that has plateaus where something melts or boils. Rate
// constants enter as integrals over the stage with the weights of the same method, so that stiff reactions are L-stable
// too.
#pragma once

#include <utility>

#include "core/conversion/around.hpp"
#include "core/conversion/kinetics.hpp"
#include "core/conversion/mixture.hpp"
#include "core/heat/tridiagonal.hpp"

namespace talus::conversion {

using heat::Surroundings;

enum class Method { euler, tr_bdf2 };

struct StepOptions {
  Method method = Method::tr_bdf2;
  int iterations = 3;   ///< of a stage
  bool lumped = false;  ///< no gradient: one shell without inner resistance
};

inline constexpr double k_trace_capacity = 1e-3;  ///< of a kilogram at first [J/K]: a millionth of a solid's

template <class V>
class GrainStep {
 public:
  GrainStep(const Matter& matter, const StepOptions& options, std::size_t shells);

  /// Fills the rate constants and the surface temperature of a state that has just been set up.
  void start(GrainState<V>& g, const Surroundings<V>& s);
  /// Advances by dt [s]; `before` and `after` are the surroundings at both ends.
  void advance(GrainState<V>& g, V dt, const Surroundings<V>& before, const Surroundings<V>& after,
               const GasAround<V>& gas) {
    advance(g, dt, before, after, gas, options_.method);
  }
  void advance(GrainState<V>& g, V dt, const Surroundings<V>& before, const Surroundings<V>& after,
               const GasAround<V>& gas, Method method);
  /// Mass that leaves the grain [kg/s], mean of the last step.
  V outflow() const { return outflow_; }

 private:
  struct Stage {
    V duration, implicit;  ///< [s]: of the stage, of its end's share
    V first, second;       ///< [s]: shares of the flows at the step's start and middle
  };
  void share_rates(const Stage& w, const std::vector<V>& a, const std::vector<V>& b);
  void stage(GrainState<V>& g, const Stage& w, const Surroundings<V>& end, const GasAround<V>& gas);
  void reactions(GrainState<V>& g, const Stage& w, const GasAround<V>& gas);
  void secondary(const Stage& w, double pressure);
  void char_and_drying(const GrainState<V>& g, const Stage& w, const GasAround<V>& gas);
  void conductances(const GrainState<V>& g, const Surroundings<V>& s);
  void linearise(const GrainState<V>& g);
  void solve(const GrainState<V>& g, const Stage& w);
  void temperatures(const GrainState<V>& g);
  void commit(GrainState<V>& g, const Stage& w);
  void burn(GrainState<V>& g, std::size_t i);
  struct Taken {
    V sensible, capacity, temperature;
    V share = V(1);  ///< of further heat that raises the temperature
    V boiled = V(0), liquid = V(0);
  };
  Taken taken(const GrainState<V>& g, std::size_t i, V Q) const;
  V given(const GrainState<V>& g, const Stage& w, std::size_t i) const;
  V gas_exchange(std::size_t i) const;
  void rates(std::vector<V>& k, const std::vector<V>& T) const;

  const Matter& matter_;
  Routes routes_;
  Mixture<V> mixture_;
  StepOptions options_;
  std::size_t n_, moisture_;  ///< moisture_: index of the solid, or none
  bool has_moisture_ = false, boils_ = false, melts_ = false;

  // of the stage's end, as iterated
  heat::Shells<V> shells_;
  std::vector<V> T1_, Q_, mass1_, burnt1_, latent_, boiled_, rate1_, kt_, end_time_;
  std::vector<ShellChange<V>> change_;
  std::vector<Extra<V>> extra_;
  std::vector<V> flow_;  ///< [shell], heat capacity of the gas that leaves it outwards during the stage [J/K]
  // conduction: face i lies below shell i; the last is the surface
  std::vector<V> G_, face0_, faceg_, face_;
  heat::SurfaceExchange<V> surface_{};
  V surface_T_ = V(0), outflow_ = V(0), stage_gas_ = V(0);  ///< [kg/s]
  V stage_capacity_ = V(0);                                 ///< of that gas [W/K]
  // linearisation
  std::vector<V> capacity_, taken_, tau_, slope_, lower_, diagonal_, upper_, right_, plain_, straight_, liquid1_,
      volume_;
};

}  // namespace talus::conversion

#include "core/conversion/step_fronts_impl.hpp"
#include "core/conversion/step_impl.hpp"
