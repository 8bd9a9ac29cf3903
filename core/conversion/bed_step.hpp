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
// in longer ones a shell may use up its reactant and come out too hot.
// Short passes over the shells, each with its constants in registers, everything between them in cache.
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
    evaporated_ = carried_ = reaction_ = with_gas_ = S::set(0);
    radius0_ = S::load(cell(place_.radius0));
    surface_ = S::load(cell(place_.surface));
    capacities();
    geometry();
    film();
    if (m.chars > 0 || m.dries != 0) fronts();
    predict();
    if (m.boils != 0) plateaus();
    solve();
    react();
    book();
    release();
    if (m.secondary < m.reactions) crack();
    finish();
  }

 private:
  // --- access
  // ---------------------------------------------------------------------------------------------------------
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
  bool turns(int s) const { return m.first[s] < m.first[s + 1] || burns(s) || dries(s); }

  // --- state of the step's start
  // --------------------------------------------------------------------------------------

  /// Masses by kind, heat capacities, sensible heats.
  void capacities() {
    for (int i = 0; i < n; ++i) st(w_.capacity, i, S::set(1e-300));
    for (int q = 0; q < k_bed_kinds; ++q) {
      if (m.present[q] == 0) continue;
      double *before = part(w_.before, q), *c = part(w_.specific, q);
      sum_kind(q, before);
      evaluate<S, true, true>(m.capacity[q], T_, n, c, part(w_.sensible, q));
      for (int i = 0; i < n; ++i) st(w_.capacity, i, ld(w_.capacity, i) + ld(before, i) * ld(c, i));
    }
  }
  void sum_kind(int q, double* to) const {
    const int from = m.first_of_kind[q], end = m.first_of_kind[q + 1];
    const double* first = mass(m.of_kind[from]);
    for (int i = 0; i < n; ++i) st(to, i, ld(first, i));
    for (int k = from + 1; k < end; ++k) {
      const double* x = mass(m.of_kind[k]);
      for (int i = 0; i < n; ++i) st(to, i, ld(to, i) + ld(x, i));
    }
  }

  /// Conductances of the inner faces and the grain's size. A face follows the volume within it by one step of Newton
  /// from the step before: its error is the square of a step's relative change.
  void geometry() {
    double* lambda[4] = {w_.heat, w_.slope, w_.flow, w_.next};  // free until later passes
    for (int q = 0; q < 4; ++q)
      if (q == 1 || (q == 0 && m.moisture_density > 0) || (q == 2) || (q == 3 && m.chars > 0))
        evaluate<S, true, false>(m.conductivity[q], T_, n, lambda[q], nullptr);
    const B cube = radius0_ * radius0_ * radius0_, per_cube = S::set(1) / cube, zero = S::set(0), one = S::set(1);
    B volume = zero, below = zero, below_area = zero, wide = zero, conducts = one;
    double* faces = cell(place_.face);
    const double *moist = part(w_.before, 0), *fuel = part(w_.before, 1), *coal = part(w_.before, 2);
    for (int i = 0; i < n; ++i) {
      ByKind<S> k{zero, zero, zero, zero};
      if (m.present[0] != 0) k[0] = ld(moist, i);
      if (m.present[1] != 0) k[1] = ld(fuel, i);
      if (m.present[2] != 0) k[2] = ld(coal, i);
      const Shares<S> shares = shares_of<S>(m, k, per_cube * S::set(m.per_volume[i]), burnt(i));
      const B t = ld(T_, i);
      volume = volume + cube * S::set(m.volume[i]) * most<S>(volume_share<S>(m, shares), S::set(1e-4));
      const B old = ld(faces, i), ball = S::set(4.1887902047863905) * old * old, shell = S::set(3) * ball;
      const B both = one / (shell * t);  // one division for two reciprocals
      st(w_.inverse, i, both * shell);
      const B face = old - (ball * old - volume) * (both * t);
      B wood = ld(lambda[1], i), rest = ld(lambda[2], i);
      if (m.moisture_density > 0) wood = wood + shares.moisture * (ld(lambda[0], i) - wood);
      if (m.chars > 0) rest = shares.char_left * rest + (one - shares.char_left) * ld(lambda[3], i);
      const B share = m.by_mass != 0 ? k[1] / most<S>(k[1] + k[2], S::set(1e-300)) : shares.fuel;
      const B conductivity = most<S>(rest + share * (wood - rest), S::set(m.least_conductivity)), width = face - below;
      st(w_.conductance, i,
         S::set(2) * dt_ * below_area * (conducts * conductivity) / (wide * conductivity + width * conducts));
      st(faces, i, face);
      below = face;
      below_area = S::set(12.566370614359172) * face * face;
      wide = width;
      conducts = conductivity;
      if (i + 1 == n) emissivity_ = emissivity<S>(m, shares);
    }
    st(w_.conductance, 0, zero);
    area_ = below_area;
    inner_ = S::set(2) * area_ * conducts / wide;
  }

  /// Exchange of the surface as gain - loss * T of the outermost shell [J per step]; the surface stores nothing.
  void film() {
    const B radius = ld(cell(place_.face), n - 1), gas = in(k_in_gas), zero = S::set(0);
    const B given = in(k_in_film);
    B mass_film = zero, h = given;
    if (m.chars > 0 || m.dries != 0 || S::any(S::lt(given, zero))) {
      h = film_coefficients<S>(m, S::set(2) * radius, in(k_in_velocity), S::set(0.5) * (gas + surface_), pressure_,
                               mass_film);
      const auto by_law = S::lt(given, zero);
      mass_film = S::select(by_law, mass_film, mass_film * given / h);  // that of mass goes with that of heat
      h = S::select(by_law, h, given);
    }
    if (m.blows != 0) {
      const B loss = S::load(cell(place_.carried));
      const B share = blown<S>(loss / most<S>(h * area_, S::set(1e-300)));
      h = h * share;
      mass_film = mass_film * share;
    }
    mass_film_ = mass_film;
    const B wall = in(k_in_wall), contact = in(k_in_contact), contact_heat = in(k_in_contact_heat);
    const B sigma = S::set(5.670374419e-8) * emissivity_ * in(k_in_sees)*area_;
    // the chord to the wall's temperature: never takes the surface beyond it
    B outer, gain, share, s = surface_;
    for (int k = 0; k < 3; ++k) {
      const B radiation = sigma * (s * s + wall * wall) * (s + wall);
      outer = area_ * h + contact + radiation;
      gain = area_ * (h * gas + in(k_in_flux)) + contact_heat + radiation * wall;
      share = S::set(1) / (inner_ + outer);
      s = most<S>((gain + inner_ * ld(T_, n - 1)) * share, S::set(1));
    }
    surface_ = s;
    surface_gain_ = gain * share;
    surface_slope_ = inner_ * share;
    loss_ = dt_ * (inner_ * outer * share);
    gain_ = dt_ * (inner_ * gain * share);
  }

  /// Evaporation at the wet front and burning at the char front: a shell counts as far as the shells around it let gas
  /// through, and as front while it holds more than a trace. Leaves rates times time.
  void fronts() {
    const B tiny = S::set(1e-300), one = S::set(1), zero = S::set(0), two = S::set(2), trace = S::set(50);
    const B density = gas_density<S>(S::set(0.5) * (in(k_in_gas) + surface_), pressure_, m.gas_molar);
    const B oxidant[3] = {density * in(k_in_oxygen), density * in(k_in_carbon_dioxide), density * in(k_in_steam)};
    B way = one / most<S>(mass_film_ * area_, tiny), wet_open = one, char_open = one;
    const B cube = radius0_ * radius0_ * radius0_;
    const double *faces = cell(place_.face), *coals = part(w_.before, 2);
    for (int i = n; i-- > 0;) {
      const B t = ld(T_, i), face = ld(faces, i), below = i > 0 ? ld(faces, i - 1) : zero;
      const B middle = S::set(0.5) * (face + below), surface = S::set(12.566370614359172) * middle * middle;
      const B half = S::set(0.5) * (face - below) / most<S>(S::set(m.pores) * gas_diffusivity<S>(t) * surface, tiny);
      const B first = cube * S::set(m.volume[i]);
      const B dry0 = most<S>(first * S::set(m.fuel_density), tiny);
      if (m.dries != 0) {
        const B wet = ld(mass(m.moisture), i);
        const B dried = half * two * (one - wet / most<S>(first * S::set(m.moisture_density), tiny));
        const B front = wet_open * least<S>(wet * trace / dry0, one);
        wet_open = wet_open - front;
        B K = zero;
        if (S::any(S::gt(front, zero))) {
          const B drive = most<S>(saturated<S>(m, t) - oxidant[2], zero);
          K = steady<S>(front * drive / (way + dried) * dt_ / most<S>(wet, tiny));
        }
        st(w_.drying, i, K);
      }
      if (m.chars > 0) {
        const B coal = m.present[2] != 0 ? ld(coals, i) : zero;
        const B gone = burnt(i), ash = half * two * gone / most<S>(coal + gone, tiny);
        const B front = char_open * least<S>(coal * trace / most<S>(dry0 + coal + gone, tiny), one);
        char_open = char_open - front;
        for (int c = 0; c < m.chars; ++c) {
          B K = zero;
          const BedChar& r = m.burning[c];
          if (S::any(S::gt(front * oxidant[r.oxidant], zero))) {
            const B kinetic = one / most<S>(arrhenius<S>(r.A, r.n, r.E, t, one / t) * surface, tiny);
            const B flow = front * oxidant[r.oxidant] / (way + ash + kinetic);
            K = steady<S>(flow / yield_of<S>(r, t).oxidant * dt_ / most<S>(coal, tiny));
          }
          st(part(w_.burning, c), i, K);
        }
      }
      way = way + half + half;
    }
  }

  // --- reactions at the step's start
  // ----------------------------------------------------------------------------------

  /// Heat released per kg of a reaction's reactant at the start of the step.
  B heat_of(const BedReaction& r, int i) const {
    B q = S::set(r.heat);
    if (r.refers == 0) return q;
    for (int k = 0; k < k_bed_kinds; ++k)
      if (r.by_kind[k] != 0) q = q + S::set(r.by_kind[k]) * (ld(part(w_.sensible, k), i) - S::set(m.sensible0[k]));
    return q - gas_sensible<S>(m, r, ld(T_, i));
  }

  void predict() {
    const B zero = S::set(0), outside = gain_ / most<S>(loss_, S::set(1e-300));
    for (int i = 0; i < n; ++i) {
      st(w_.heat, i, zero);
      st(w_.slope, i, zero);
      st(w_.flow, i, zero);
      // rise by the flows of the start, at most to what is around; the column is free until plateaus()
      const B t = ld(T_, i), beyond = i + 1 < n ? ld(T_, i + 1) : outside;
      B flow = (i + 1 < n ? ld(w_.conductance, i + 1) : loss_) * (beyond - t), hot = beyond;
      if (i > 0) {
        flow = flow + ld(w_.conductance, i) * (ld(T_, i - 1) - t);
        hot = most<S>(hot, ld(T_, i - 1));
      }
      st(w_.plateau, i, least<S>(flow / ld(w_.capacity, i), hot - t));
    }
    for (int s = 0; s < m.solids; ++s)
      if (m.grows[s] != 0)
        for (int i = 0; i < n; ++i) st(part(w_.made, s), i, zero);
    for (int s = 0; s < m.solids; ++s)
      if (turns(s)) predict(s);
    for (int s = 0; s < m.solids; ++s)  // the capacity is that of the mean of both ends
      if (m.grows[s] != 0 && !turns(s)) {
        const double *made = part(w_.made, s), *c = part(w_.specific, m.kind[s]);
        for (int i = 0; i < n; ++i) st(w_.capacity, i, ld(w_.capacity, i) + S::set(0.5) * ld(c, i) * ld(made, i));
      }
    if (m.carries != 0)
      for (int i = 1; i < n; ++i) st(w_.flow, i, ld(w_.flow, i) + ld(w_.flow, i - 1));
  }

  /// Rate constants times time of the reactions of a solid; their sum.
  void rates(int s, double* K) {
    const B zero = S::set(0), cold = S::set(m.cold[s]);
    for (int i = 0; i < n; ++i) {
      B sum = dries(s) ? ld(w_.drying, i) : zero;
      if (burns(s))
        for (int c = 0; c < m.chars; ++c) sum = sum + ld(part(w_.burning, c), i);
      st(K, i, sum);
    }
    for (int r = m.first[s]; r < m.first[s + 1]; ++r) {
      const BedReaction& a = m.reaction[r];
      double* k = part(w_.rate, r);
      const B A = S::set(a.A) * dt_, E = S::set(-a.E);
      for (int i = 0; i < n; ++i) {
        const B t = ld(T_, i);
        const auto warm = S::gt(t, cold);
        B x = zero;
        if (S::any(warm)) {
          x = A * exponential<S>(E * ld(w_.inverse, i));
          if (a.n != 0) x = a.n == 1 ? x * t : x * power<S>(t, a.n);
          x = S::select(warm, x, zero);
        }
        st(k, i, x);
        st(K, i, ld(K, i) + x);
      }
    }
  }

  /// What becomes of a solid: consumption, heat and its derivative by temperature, products.
  void predict(int s) {
    const B zero = S::set(0), one = S::set(1), tiny = S::set(1e-100), still = S::set(m.still[s]), half = S::set(0.5);
    double* K = w_.upper;
    rates(s, K);
    double *gone = part(w_.gone, s), *per = part(w_.per, s), *grow = part(w_.grow, s), *released = part(w_.released, s);
    const double *start = mass(s), *made = part(w_.made, s), *c = part(w_.specific, m.kind[s]);
    const bool wet = dries(s), char_burns = burns(s), grows = m.grows[s] != 0;
    for (int i = 0; i < n; ++i) {
      const B k = ld(K, i);
      if (!S::any(S::gt(k, zero))) {
        st(gone, i, zero), st(per, i, zero), st(grow, i, zero), st(released, i, zero);
        if (grows) st(w_.capacity, i, ld(w_.capacity, i) + half * ld(c, i) * ld(made, i));
        continue;
      }
      const B t = ld(T_, i), some = most<S>(k, tiny), above = t - still, over = most<S>(above, one);
      const B both = one / (some * over);  // one division for two reciprocals
      const B left = exponential<S>(zero - k), p = both * over;
      B lost = ld(start, i) * (one - left);
      if (grows) {
        const B small = one - k * (half - k * (S::set(1.0 / 6) - k * S::set(1.0 / 24)));
        const B mean = S::select(S::lt(k, S::set(1e-3)), small, (one - left) * p), more = ld(made, i);
        lost = lost + more * (one - mean);
        st(w_.capacity, i, ld(w_.capacity, i) - half * ld(c, i) * (lost - more));
      } else {
        st(w_.capacity, i, ld(w_.capacity, i) - half * ld(c, i) * lost);
      }
      const B inverse = ld(w_.inverse, i);
      B q = zero, rise = zero;
      for (int r = m.first[s]; r < m.first[s + 1]; ++r) {
        const BedReaction& a = m.reaction[r];
        const B x = ld(part(w_.rate, r), i);
        q = q + heat_of(a, i) * x;
        rise = rise + x * (S::set(a.E) * inverse + S::set(a.n));
      }
      if (wet) {
        const B x = ld(w_.drying, i);
        q = q - S::set(m.evaporation) * x;
        rise = rise + x * S::set(m.evaporation * 0.018015 / 8.31446261815324) * inverse;
      }
      // d ln(extent) / dT of what takes up heat: the local one, or where the reactant is used up the chord to the
      // temperature at which it stands still, so that the step does not fall below that
      const B share = lost * p;
      B rises = zero;
      const auto takes = S::lt(q, zero);
      if (S::any(takes)) {
        const B depletion = left * (one + half * k);
        const B chord = S::select(S::gt(above, one), both * some, zero);
        rises = S::select(takes, most<S>(rise * inverse * p * depletion, chord), zero);
        // and no more than there is where the shell warms up nevertheless, by the flows of the start: heat that finds
        // nothing to react would come back as debt
        const B there = grows ? ld(start, i) + ld(made, i) : ld(start, i);
        const B warms = ld(w_.plateau, i) + share * q / ld(w_.capacity, i);
        const B limit = (there - lost) / most<S>(lost * warms, tiny);
        rises = S::select(S::gt(warms, zero), least<S>(rises, limit), rises);
        st(w_.slope, i, ld(w_.slope, i) + least<S>(share * q * rises, zero));
      }
      if (char_burns)
        for (int k2 = 0; k2 < m.chars; ++k2) q = q + ld(part(w_.burning, k2), i) * yield_of<S>(m.burning[k2], t).heat;
      st(gone, i, lost), st(per, i, p), st(grow, i, rises), st(released, i, q);
      st(w_.heat, i, ld(w_.heat, i) + share * q);
    }
    for (int r = m.first[s]; r < m.first[s + 1]; ++r) products(m.reaction[r], part(w_.rate, r), gone, per);
    if (m.carries != 0) {
      for (int r = m.first[s]; r < m.first[s + 1]; ++r)
        for (int i = 0; i < n; ++i)
          st(w_.flow, i,
             ld(w_.flow, i) +
                 ld(gone, i) * ld(per, i) * ld(part(w_.rate, r), i) * gas_capacity<S>(m, m.reaction[r], ld(T_, i)));
      if (wet)
        for (int i = 0; i < n; ++i)
          st(w_.flow, i,
             ld(w_.flow, i) + ld(gone, i) * ld(per, i) * ld(w_.drying, i) * value<S>(m.gas_capacity, ld(T_, i)));
    }
  }

  /// Solids that a reaction makes. Returns its extent over all shells.
  B products(const BedReaction& a, const double* rate, const double* gone, const double* per) {
    B total = S::set(0);
    if (a.solids == 0) {
      for (int i = 0; i < n; ++i) total = total + ld(gone, i) * ld(per, i) * ld(rate, i);
      return total;
    }
    for (int y = 0; y < a.solids; ++y) {
      double* made = part(w_.made, a.solid[y].species);
      const B yield = S::set(a.solid[y].mass);
      for (int i = 0; i < n; ++i) {
        const B x = ld(gone, i) * ld(per, i) * ld(rate, i);
        st(made, i, ld(made, i) + yield * x);
        if (y == 0) total = total + x;
      }
    }
    return total;
  }

  /// Which shells stay at boiling temperature in this step, and which dry out (a sink), from the flows of its start.
  void plateaus() {
    const B zero = S::set(0), Tb = S::set(m.boiling), L = S::set(m.evaporation);
    const double *water = mass(m.moisture), *debt = cell(place_.debt);
    B vapour = zero;
    for (int i = 0; i < n; ++i) {
      const B whole = L * ld(water, i);
      B flow = ld(debt, i) + ld(w_.heat, i) - ld(w_.capacity, i) * (Tb - ld(T_, i));
      if (i > 0) flow = flow + ld(w_.conductance, i) * (ld(T_, i - 1) - Tb);
      flow = flow + (i + 1 < n ? ld(w_.conductance, i + 1) * (ld(T_, i + 1) - Tb) : gain_ - loss_ * Tb);
      const B part = clamped<S>(flow, zero, whole);
      // at the plateau part of what there is evaporates; else it is a sink that is known
      const auto stays = S::lt(part, whole);
      st(w_.plateau, i, S::select(stays, part, zero));
      st(w_.sink, i, S::select(stays, zero, whole));
      if (m.carries != 0) {
        vapour = vapour + part * S::set(1 / m.evaporation) * value<S>(m.gas_capacity, ld(T_, i));
        st(w_.flow, i, ld(w_.flow, i) + vapour);
      }
    }
  }

  // --- temperatures
  // ---------------------------------------------------------------------------------------------------

  /// C (T1 - T) = debt + heat + slope (T1 - T) + flows(T1), by elimination from the centre outwards.
  void solve() {
    const B one = S::set(1), zero = S::set(0), boiling = S::set(m.boiling);
    const double* debt = cell(place_.debt);
    B upper = zero, right = zero, below = zero;
    for (int i = 0; i < n; ++i) {
      const bool last = i + 1 == n;
      const B above = last ? loss_ : ld(w_.conductance, i + 1), own = ld(w_.capacity, i) - ld(w_.slope, i);
      B lower = below;
      if (m.convects != 0 && i > 0) lower = lower + ld(w_.flow, i - 1);
      B diagonal = own + lower + above, next = last ? zero : above;
      B known = own * ld(T_, i) + ld(debt, i) + ld(w_.heat, i);
      if (last) known = known + gain_;
      if (m.boils != 0) {
        const auto stays = S::gt(ld(w_.plateau, i), zero);
        known = S::select(stays, boiling, known - ld(w_.sink, i));
        diagonal = S::select(stays, one, diagonal);
        lower = S::select(stays, zero, lower);
        next = S::select(stays, zero, next);
      }
      const B per = one / (diagonal - lower * upper);
      right = (known + lower * right) * per;
      upper = next * per;
      st(w_.next, i, right);
      st(w_.upper, i, upper);
      below = above;
    }
    B above = right;
    for (int i = n - 1; i-- > 0;) {
      above = ld(w_.next, i) + ld(w_.upper, i) * above;
      st(w_.next, i, above);
    }
    heat_in_ = gain_ - loss_ * right;
    put(k_out_heat_in, heat_in_);
    const B s = surface_gain_ + surface_slope_ * right;
    surface_ = most<S>(s, one);
    put(k_out_contact, dt_ * (in(k_in_contact_heat)-in(k_in_contact)*s));
  }

  // --- books
  // ------------------------------------------------------------------------------------------------------------

  /// Masses at the new temperatures; heat that was released, into `heat`.
  void react() {
    const B zero = S::set(0), one = S::set(1);
    for (int i = 0; i < n; ++i) st(w_.heat, i, zero);
    for (int s = 0; s < m.solids; ++s)
      if (m.grows[s] != 0)
        for (int i = 0; i < n; ++i) st(part(w_.made, s), i, zero);
    for (int s = 0; s < m.solids; ++s) {
      double *x = mass(s), *gone = part(w_.gone, s);
      const double* made = part(w_.made, s);
      const bool grows = m.grows[s] != 0;
      if (!turns(s)) {
        if (grows)
          for (int i = 0; i < n; ++i) st(x, i, ld(x, i) + ld(made, i));
        continue;
      }
      const double *per = part(w_.per, s), *grow = part(w_.grow, s), *released = part(w_.released, s);
      for (int i = 0; i < n; ++i) {
        B there = ld(x, i);
        if (grows) there = there + ld(made, i);
        const B lost = clamped<S>(ld(gone, i) * (one + ld(grow, i) * (ld(w_.next, i) - ld(T_, i))), zero, there);
        st(x, i, there - lost);
        st(gone, i, lost);
        st(w_.heat, i, ld(w_.heat, i) + lost * ld(per, i) * ld(released, i));
      }
      for (int r = m.first[s]; r < m.first[s + 1]; ++r) {
        S::store(w_.total + S::W * r, products(m.reaction[r], part(w_.rate, r), gone, per));
        if (m.carries != 0)
          for (int i = 0; i < n; ++i)
            carried_ = carried_ + ld(gone, i) * ld(per, i) * ld(part(w_.rate, r), i) *
                                      gas_capacity<S>(m, m.reaction[r], ld(T_, i));
      }
      if (dries(s))
        for (int i = 0; i < n; ++i) {
          const B vapour = ld(gone, i) * ld(per, i) * ld(w_.drying, i);
          evaporated_ = evaporated_ + vapour;
          if (m.carries != 0) carried_ = carried_ + vapour * value<S>(m.gas_capacity, ld(T_, i));
        }
      if (burns(s))
        for (int c = 0; c < m.chars; ++c) burn(c, s, gone, per);
    }
  }

  /// Gas that char reaction c of solid s takes and makes.
  void burn(int c, int s, const double* gone, const double* per) {
    const BedChar& r = m.burning[c];
    double* done = cell(place_.burnt);
    for (int i = 0; i < n; ++i) {
      const B x = ld(gone, i) * ld(per, i) * ld(part(w_.burning, c), i);
      if (!S::any(S::gt(x, S::set(0)))) continue;
      const CharGas<S> y = yield_of<S>(r, ld(T_, i));
      st(done, i, ld(done, i) + x);
      add(k_out_oxygen + r.oxidant, x * y.oxidant);
      if (m.carbon_monoxide >= 0) add(k_out_released + m.carbon_monoxide, x * y.carbon_monoxide);
      if (m.carbon_dioxide >= 0 && r.oxidant == 0) add(k_out_released + m.carbon_dioxide, x * y.carbon_dioxide);
      if (m.hydrogen >= 0 && r.oxidant == 2) add(k_out_released + m.hydrogen, x * y.hydrogen);
      for (int e = 0; e < k_bed_elements; ++e)
        if (m.composition[s][e] != 0) add(k_out_gone + e, S::set(m.composition[s][e]) * x);
    }
  }

  /// Heat that each shell took in, its temperature, and the debt.
  void book() {
    const B zero = S::set(0), one = S::set(1), half = S::set(0.5);
    double *debt = cell(place_.debt), *stored = w_.slope, *left = w_.upper;
    B from = zero, mean = zero, all = zero;
    for (int i = 0; i < n; ++i) {
      const B wanted = ld(w_.next, i);
      const B to = i + 1 < n ? ld(w_.conductance, i + 1) * (wanted - ld(w_.next, i + 1)) : zero - heat_in_;
      B heat = ld(debt, i) + (from - to) + ld(w_.heat, i);
      reaction_ = reaction_ + ld(w_.heat, i);
      if (m.convects != 0 && i > 0) {
        const B gas = ld(w_.flow, i - 1) * (ld(w_.next, i - 1) - wanted);
        heat = heat + gas;
        with_gas_ = with_gas_ - gas;
      }
      from = to;
      B T1 = wanted;
      if (m.boils != 0) heat = heat - evaporate(i, heat, wanted, T1);
      T1 = most<S>(T1, one);
      st(w_.next, i, T1);
      st(debt, i, heat);
      st(stored, i, zero), st(left, i, zero);
      const B c = ld(w_.capacity, i);
      all = all + c;
      mean = mean + c * T1;
    }
    put(k_out_mean, mean / all);
    double *after = w_.flow, *h1 = w_.inverse;
    for (int q = 0; q < k_bed_kinds; ++q) {
      if (m.present[q] == 0) continue;
      sum_kind(q, after);
      evaluate<S, false, true>(m.capacity[q], w_.next, n, nullptr, h1);
      const double *before = part(w_.before, q), *h0 = part(w_.sensible, q);
      const B base = S::set(m.sensible0[q]);
      B sum = zero, gone = zero;
      for (int i = 0; i < n; ++i) {
        const B a = ld(before, i), b = ld(after, i), x = ld(h0, i), y = ld(h1, i);
        st(debt, i, ld(debt, i) - half * (a + b) * (y - x));
        gone = gone + (a - b) * (half * (x + y) - base);
        sum = sum + b;
      }
      with_gas_ = with_gas_ + gone;
      put(k_out_moisture + q, sum);
    }
    for (int i = 0; i < n; ++i) st(T_, i, ld(w_.next, i));
  }

  /// Water that evaporates at the boiling temperature from the heat that the shell took in; sets its temperature.
  /// Returns the heat that this takes.
  B evaporate(int i, B heat, B wanted, B& T1) {
    const B zero = S::set(0), C = ld(w_.capacity, i), t = ld(T_, i), Tb = S::set(m.boiling);
    double* water = mass(m.moisture);
    const B wet = ld(water, i), whole = S::set(m.evaporation) * wet;
    const B part = clamped<S>(heat - C * (Tb - t), zero, whole);
    const auto boils = S::gt(part, zero), plateau = S::gt(ld(w_.plateau, i), zero);
    if (!S::any(boils) && !S::any(plateau)) return zero;
    const B moved = t + (heat - part) / C;
    T1 = S::select(boils, S::select(S::lt(part, whole), Tb, moved), S::select(plateau, moved, wanted));
    // a shell that dries out does not become hotter than the system without its plateau lets it
    T1 = S::select(boils, least<S>(T1, most<S>(wanted, Tb)), T1);
    const B vapour = part * S::set(1 / m.evaporation);
    st(water, i, most<S>(wet - vapour, zero));
    evaporated_ = evaporated_ + vapour;
    reaction_ = reaction_ - part;
    if (m.carries != 0) carried_ = carried_ + vapour * value<S>(m.gas_capacity, t);
    return part;
  }

  /// Gas and elements that have left, from the extents.
  void release() {
    for (int r = 0; r < m.secondary; ++r) {
      const BedReaction& a = m.reaction[r];
      const B x = S::load(w_.total + S::W * r);
      for (int y = 0; y < a.gases; ++y) add(k_out_released + a.gas[y].species, S::set(a.gas[y].mass) * x);
      for (int e = 0; e < k_bed_elements; ++e)
        if (a.leaving[e] != 0) add(k_out_gone + e, S::set(a.leaving[e]) * x);
    }
    if (m.vapour < 0) return;
    add(k_out_gone + 4, evaporated_);
    add(k_out_released + m.vapour, evaporated_);
  }

  /// Reactions of gas on its way out, after the step: the time in a shell is the gas it holds over the gas that passes;
  /// the mixture is the same in all shells. Their heat is debt of the shell.
  void crack();

  void finish() {
    const double* faces = cell(place_.face);
    put(k_out_radius, ld(faces, n - 1));
    S::store(cell(place_.surface), surface_);
    S::store(cell(place_.carried), carried_ / dt_);
    put(k_out_surface, surface_);
    add(k_out_reaction, reaction_);
    add(k_out_with_gas, with_gas_);
    put(k_out_mass, (got(k_out_moisture) + got(k_out_fuel)) + (got(k_out_char) + got(k_out_ash)));
    B centre = ld(T_, 0);
    if (n > 1) {  // a parabola through the two innermost shells
      const B r0 = S::set(0.5) * ld(faces, 0), r1 = S::set(0.5) * (ld(faces, 0) + ld(faces, 1));
      centre = centre - (ld(T_, 1) - centre) * (r0 * r0) / (r1 * r1 - r0 * r0);
    }
    put(k_out_centre, centre);
  }

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
  B radius0_, surface_, emissivity_, area_, inner_, mass_film_, surface_gain_, surface_slope_, gain_, loss_, heat_in_,
      carried_, evaporated_, reaction_, with_gas_;
};

template <class S>
void Step<S>::crack() {
  const B zero = S::set(0), one = S::set(1);
  B passing[k_bed_gases], all = zero;
  for (int g = 0; g < m.gases; ++g) {
    passing[g] = most<S>(got(k_out_released + g), zero);
    all = all + passing[g];
  }
  const B cube = radius0_ * radius0_ * radius0_;
  double* debt = cell(place_.debt);
  for (int i = 0; i < n; ++i) {
    const B t = ld(T_, i), part = S::set((i + 0.5) / n);  // of the gas passes here
    const B held = gas_density<S>(t, 101325, 0.03) * S::set(m.porosity * m.volume[i]) * cube;
    const B time = held * dt_ / most<S>(all * part, S::set(1e-300));
    B heat = zero;
    for (int r = m.secondary; r < m.reactions; ++r) {
      const BedReaction& a = m.reaction[r];
      const B K = arrhenius<S>(a.A, a.n, a.E, t, one / t) * time;
      const B x = passing[a.reactant] * part * (one - exponential<S>(zero - K));
      passing[a.reactant] = passing[a.reactant] - x;
      add(k_out_released + a.reactant, zero - x);
      for (int y = 0; y < a.gases; ++y) {
        passing[a.gas[y].species] = passing[a.gas[y].species] + S::set(a.gas[y].mass) * x;
        add(k_out_released + a.gas[y].species, S::set(a.gas[y].mass) * x);
      }
      for (int y = 0; y < a.solids; ++y) {
        double* to = mass(a.solid[y].species);
        const B more = S::set(a.solid[y].mass) * x;
        st(to, i, ld(to, i) + more);
        add(k_out_moisture + m.kind[a.solid[y].species], more);
      }
      for (int e = 0; e < k_bed_elements; ++e)
        if (a.leaving[e] != 0) add(k_out_gone + e, S::set(a.leaving[e]) * x);
      B h = S::set(a.heat);
      for (int k = 0; k < k_bed_kinds; ++k) {
        if (a.by_kind[k] == 0) continue;
        const B solid = S::set(a.by_kind[k]) * (integral<S>(m.capacity[k], t) - S::set(m.sensible0[k]));
        if (a.refers != 0) h = h + solid;
        add(k_out_with_gas, solid * x);  // solids that form bring their sensible heat along
      }
      if (a.refers != 0) h = h - gas_sensible<S>(m, a, t);
      heat = heat + h * x;
    }
    add(k_out_reaction, heat);
    st(debt, i, ld(debt, i) + heat);
  }
}

}  // namespace talus::conversion::bed
