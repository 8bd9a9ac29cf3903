// One step of many grains at once, a lane per grain: conduction in shells, exchange at the surface, drying, reactions,
// char burning, shrinkage. Who calls it: kernels/conversion (a unit per instruction set). Invariants: I4; a lane's bits
// do not depend on its neighbours (what is skipped where no lane needs it gives zeros); what a face takes from a shell
// it gives to the next; heat, mass and elements close to rounding whatever the linearisation leaves over.
//
// Method: linearly implicit Euler, one pass. Rates, properties and conductances are those of the step's start; each
// solid decays exponentially, so that no rate and no step makes a mass negative; heat that reactions take up grows with
// the temperature as their rate does; one tridiagonal system gives the temperatures. What the heat that a shell took in
// exceeds the sensible heat of its new temperature by is its debt, which the next step works off. First order in time.
// Reactions that are fast and take up much heat want steps no longer than heat takes through a shell (dx^2 rho c / k):
// in longer ones a shell may use up its reactant and come out too hot. k_out_excess says by how much a step is longer.
// Heat that others exchange explicitly comes as a flow (k_in_flow), so that it balances to the bit; the temperature
// that they then see is that of a surface in balance with them, not that of the flow: it never leaves the range of
// both. Short passes over the shells, each with its constants in registers, everything between them in cache.
#pragma once

#include "core/conversion/bed_geometry.hpp"

namespace talus::conversion::bed {

template <class S>
class Step {
 public:
  using B = typename S::B;

  Step(const BedMatter& matter, const GrainBatch& batch) : m(matter), n(matter.shells), w_(matter, batch.scratch) {
    dt_ = S::set(batch.dt);
    pressure_ = batch.pressure;
  }

  /// `row`: the numbers of the lanes, [place][lane]; in, out: columns of these lanes.
  void advance(double* row, const double* in, long in_stride, double* out, long stride) {
    row_ = row;
    in_ = in;
    in_stride_ = in_stride;
    out_ = out;
    stride_ = stride;
    T_ = cell(place_.temperature);
    for (int k = 0; k < k_out_released + m.gases; ++k) put(k, S::set(0));
    evaporated_ = carried_ = outflow_ = reaction_ = with_gas_ = S::set(0);
    radius0_ = S::load(cell(place_.radius0));
    surface_ = S::load(cell(place_.surface));
    condenses_ = m.dries != 0 && S::any(S::gt(this->in(k_in_condensing), S::set(0)));
    capacities();
    boils_ = m.boils != 0 && there_[0];
    geometry();
    judge();
    film();
    if (m.chars > 0 || m.dries != 0) fronts();
    predict();
    if (condenses_) dew();
    if (boils_) plateaus();
    solve();
    react();
    if (condenses_) condense();
    book();
    release();
    if (m.secondary < m.reactions) crack();
    finish();
  }

 private:
  static B ld(const double* column, int i) { return S::load(column + static_cast<long>(S::W) * i); }
  static void st(double* column, int i, B x) { S::store(column + static_cast<long>(S::W) * i, x); }
  double* cell(int place) const { return row_ + static_cast<long>(S::W) * place; }
  double* mass(int s) const { return cell(place_.mass + s * n); }
  double* part(double* columns, int k) const { return columns + static_cast<long>(S::W) * n * k; }
  B in(int k) const { return S::load(in_ + k * in_stride_); }
  B got(int k) const { return S::load(out_ + k * stride_); }
  void put(int k, B x) const { S::store(out_ + k * stride_, x); }
  void add(int k, B x) const { put(k, got(k) + x); }
  B burnt(int i) const { return m.chars > 0 ? ld(cell(place_.burnt), i) : S::set(0); }
  bool burns(int s) const { return m.kind[s] == 2 && m.chars > 0; }
  bool dries(int s) const { return m.dries != 0 && s == m.moisture; }
  bool turns(int s) const { return m.turns[s] >= 0; }
  bool grows(int s) const { return m.grows[s] >= 0; }
  double* made(int s) const { return part(w_.made, m.grows[s]); }
  /// Masses of a kind by shell; `to` is filled where it has several solids.
  const double* of_kind(int q, double* to) const;
  /// A kind is there in some lane; one that is gone for good counts as if it had never been: its terms are all zero.
  bool holds(int q) const;

  // bed_surface_impl.hpp
  /// Masses by kind, heat capacities, sensible heats.
  void capacities();
  /// Conductances of the inner faces and the grain's size. A face follows the volume within it by one step of Newton
  /// from the step before: its error is the square of a step's relative change.
  void geometry();
  /// How much longer the step is than heat takes through a shell that still holds fuel.
  void judge();
  /// Exchange of the surface as gain - loss * T of the outermost shell [J per step]; the surface stores nothing.
  void film();
  /// Evaporation at the wet front and burning at the char front: a shell counts as far as the shells around it let gas
  /// through, and as front while it holds more than a trace. Leaves rates times time.
  void fronts();

  // bed_reactions_impl.hpp
  /// Heat released per kg of a reaction's reactant at the start of the step.
  B heat_of(const BedReaction& r, int i) const;
  /// Rises of temperature by the flows of the start, then each solid.
  void predict();
  /// Rate constants times time of the reactions of a solid, 0 where nothing of it is left; their sum.
  void rates(int s, double* K);
  /// What becomes of a solid: consumption, heat and its derivative by temperature, products.
  void predict(int s);
  /// Heat of its reactions and its drying in shell i, weighed by their rates; what they rise with temperature, to rise.
  B heats(int s, int i, B& rise) const;
  /// Gas that its reactions send through the shells, into `flow`.
  void carry(int s, const double* share);
  /// Solids that a reaction makes. Returns its extent over all shells.
  B products(const BedReaction& a, const double* rate, const double* share);
  /// Water that comes to the outermost shell from the gas: its heat falls along the chord to the dew point, so that the
  /// shell does not get beyond it, however much there is.
  void dew();
  /// Which shells stay at boiling temperature in this step, and which dry out (a sink), from the flows of its start.
  void plateaus();

  // bed_solve_impl.hpp
  /// C (T1 - T) = debt + heat + slope (T1 - T) + flows(T1), by elimination from the centre outwards.
  void solve();

  // bed_books_impl.hpp
  /// Masses at the new temperatures; of a solid of which less than a trace would remain all reacts. Heat that was
  /// released, into `heat`.
  void react();
  /// Gas that char reaction c of solid s takes and makes.
  void burn(int c, int s, const double* share);
  /// The water that came, and its heat.
  void condense();
  /// Heat that each shell took in, its temperature, and the debt.
  void book();
  /// Water that evaporates at the boiling temperature from the heat that the shell took in; sets its temperature.
  /// Returns the heat that this takes.
  B evaporate(int i, B heat, B wanted, B& T1);
  /// Gas and elements that have left, from the extents.
  void release();
  /// Reactions of gas on its way out, after the step: the time in a shell is the gas it holds over the gas that passes;
  /// the mixture is the same in all shells. Their heat is debt of the shell.
  void crack();
  void finish();

  const BedMatter& m;
  const int n;
  const Work<S> w_;
  const BedRow place_ = w_.place;
  B dt_;
  double pressure_;
  double *row_ = nullptr, *T_ = nullptr;
  const double* in_ = nullptr;
  double* out_ = nullptr;
  long in_stride_ = 0, stride_ = 0;
  bool there_[k_bed_kinds] = {}, boils_ = false, condenses_ = false;  ///< in some lane
  Range<S> range_;  ///< of the temperatures that properties are asked for at
  B radius0_, surface_, emissivity_, area_, inner_, mass_film_, surface_gain_, surface_slope_, around_gain_,
      around_loss_, gain_, loss_, heat_in_, dew_heat_, dew_share_, carried_, outflow_, evaporated_, reaction_,
      with_gas_;
};

}  // namespace talus::conversion::bed

#include "core/conversion/bed_books_impl.hpp"
#include "core/conversion/bed_reactions_impl.hpp"
#include "core/conversion/bed_solve_impl.hpp"
#include "core/conversion/bed_surface_impl.hpp"
