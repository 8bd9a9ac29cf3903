// Second half of bed_step.hpp: what reactions and boiling would do at the start of a step, and the cracking of gas on
// its way out after it.
#pragma once

namespace talus::conversion::bed {

template <class S>
typename S::B Step<S>::heat_of(const BedReaction& r, int i) const {
  B q = S::set(r.heat);
  if (r.refers == 0) return q;
  for (int k = 0; k < k_bed_kinds; ++k)
    if (r.by_kind[k] != 0) q = q + S::set(r.by_kind[k]) * (ld(part(w_.sensible, k), i) - S::set(m.sensible0[k]));
  return q - gas_sensible<S>(m, r, ld(T_, i), ld(w_.gas_heat, i));
}

template <class S>
void Step<S>::predict() {
  const B zero = S::set(0), outside = gain_ / most<S>(loss_, S::set(1e-300));
  for (int i = 0; i < n; ++i) {
    st(w_.heat, i, zero);
    st(w_.slope, i, zero);
    st(w_.flow, i, zero);
    // heat by the flows of the start, at most to what is around; the column is free until plateaus()
    const B t = ld(T_, i), beyond = i + 1 < n ? ld(T_, i + 1) : outside;
    B flow = (i + 1 < n ? ld(w_.conductance, i + 1) : loss_) * (beyond - t), hot = beyond;
    if (i > 0) {
      flow = flow + ld(w_.conductance, i) * (ld(T_, i - 1) - t);
      hot = most<S>(hot, ld(T_, i - 1));
    }
    st(w_.plateau, i, least<S>(flow, (hot - t) * ld(w_.capacity, i)));
  }
  for (int s = 0; s < m.solids; ++s)
    if (grows(s))
      for (int i = 0; i < n; ++i) st(made(s), i, zero);
  for (int s = 0; s < m.solids; ++s)
    if (turns(s)) predict(s);
  for (int s = 0; s < m.solids; ++s)  // the capacity is that of the mean of both ends
    if (grows(s) && !turns(s)) {
      const double *more = made(s), *c = part(w_.specific, m.kind[s]);
      for (int i = 0; i < n; ++i) st(w_.capacity, i, ld(w_.capacity, i) + S::set(0.5) * ld(c, i) * ld(more, i));
    }
  if (m.carries != 0)
    for (int i = 1; i < n; ++i) st(w_.flow, i, ld(w_.flow, i) + ld(w_.flow, i - 1));
}

template <class S>
void Step<S>::predict(int s) {
  const B zero = S::set(0), one = S::set(1), tiny = S::set(1e-100), still = S::set(m.still[s]), half = S::set(0.5);
  double* K = w_.upper;
  rates(s, K);
  const int place = m.turns[s];
  double *gone = part(w_.gone, place), *per = part(w_.per, place), *share = part(w_.share, place);
  double *grow = part(w_.grow, place), *released = part(w_.released, place);
  const bool grown = grows(s);
  const double *start = mass(s), *more_of = grown ? made(s) : start, *c = part(w_.specific, m.kind[s]);
  for (int i = 0; i < n; ++i) {
    const B k = ld(K, i), more = grown ? ld(more_of, i) : zero;
    if (!S::any(S::gt(k, zero))) {
      st(gone, i, zero), st(per, i, zero), st(share, i, zero), st(grow, i, zero), st(released, i, zero);
      if (grown) st(w_.capacity, i, ld(w_.capacity, i) + half * ld(c, i) * more);
      continue;
    }
    const auto turns = S::gt(k, tiny);
    const B some = S::select(turns, k, one), above = ld(T_, i) - still, over = most<S>(above, one);
    const B both = one / (some * over);  // one division for two reciprocals
    const B p = S::select(turns, both * over, zero);
    const PowerOfTwo<S> left = power_of_two<S>(k * S::set(-k_per_ln2));
    const B used = S::select(turns, (one - left.scale) - left.more, zero);
    B lost = ld(start, i) * used;
    if (grown) {  // what is made while the step goes on has the mean of the time
      lost = lost + more * S::select(turns, one - used * p, zero);
      st(w_.capacity, i, ld(w_.capacity, i) - half * ld(c, i) * (lost - more));
    } else {
      st(w_.capacity, i, ld(w_.capacity, i) - half * ld(c, i) * lost);
    }
    const B lost_per = lost * p;
    B rise = zero, q = heats(s, i, rise);
    const auto takes = S::lt(q, zero);
    B rises = zero;
    if (S::any(takes)) {
      // d ln(extent) / dT of what takes up heat: the local one, or where the reactant is used up the chord to the
      // temperature at which it stands still, so that the step does not fall below that
      const B depletion = (left.scale + left.more) * (one + half * k);
      const B chord = S::select(S::gt(above, one), both * some, zero);
      rises = S::select(takes, most<S>(rise * ld(w_.inverse, i) * p * depletion, chord), zero);
      // and no more than there is where the shell warms up nevertheless, by the flows of the start: heat that finds
      // nothing to react would come back as debt
      const B there = ld(start, i) + more, warms = ld(w_.plateau, i) + lost_per * q;
      const B limit = (there - lost) * ld(w_.capacity, i) / most<S>(lost * warms, tiny);
      rises = S::select(S::gt(warms, zero), least<S>(rises, limit), rises);
      st(w_.slope, i, ld(w_.slope, i) + least<S>(lost_per * q * rises, zero));
    }
    if (burns(s))
      for (int k2 = 0; k2 < m.chars; ++k2)
        q = q + ld(part(w_.burning, k2), i) *
                    (S::set(m.char_carbon) * yield_of<S>(m.burning[k2], ld(part(w_.monoxide, k2), i)).heat);
    st(gone, i, lost), st(per, i, p), st(share, i, lost_per), st(grow, i, rises), st(released, i, q);
    st(w_.heat, i, ld(w_.heat, i) + lost_per * q);
  }
  for (int r = m.first[s]; r < m.first[s + 1]; ++r)
    if (m.reaction[r].solids > 0) products(m.reaction[r], part(w_.rate, r), share);
  if (m.carries != 0) carry(s, share);
}

template <class S>
TALUS_SHAPES_INLINE typename S::B Step<S>::heats(int s, int i, B& rise) const {
  const B inverse = ld(w_.inverse, i);
  B q = S::set(0);
  for (int r = m.first[s]; r < m.first[s + 1]; ++r) {
    const BedReaction& a = m.reaction[r];
    const B x = ld(part(w_.rate, r), i);
    q = q + heat_of(a, i) * x;
    rise = rise + x * (S::set(a.E) * inverse + S::set(a.n));
  }
  if (!dries(s)) return q;
  const B x = ld(w_.drying, i);
  rise = rise + x * S::set(m.evaporation * 0.018015 / 8.31446261815324) * inverse;
  return q - S::set(m.evaporation) * x;
}

template <class S>
void Step<S>::carry(int s, const double* share) {
  for (int r = m.first[s]; r < m.first[s + 1]; ++r)
    for (int i = 0; i < n; ++i)
      st(w_.flow, i,
         ld(w_.flow, i) +
             ld(share, i) * ld(part(w_.rate, r), i) * gas_capacity<S>(m.reaction[r], ld(T_, i), ld(w_.gas, i)));
  if (dries(s))
    for (int i = 0; i < n; ++i) st(w_.flow, i, ld(w_.flow, i) + ld(share, i) * ld(w_.drying, i) * ld(w_.gas, i));
}

template <class S>
void Step<S>::rates(int s, double* K) {
  const B zero = S::set(0), cold = S::set(m.cold[s]);
  const double *start = mass(s), *more = grows(s) ? made(s) : start;
  double* warmth = w_.sink;  // free until plateaus(): the temperature where there is something, else 0
  for (int i = 0; i < n; ++i) {
    B sum = dries(s) ? ld(w_.drying, i) : zero;
    if (burns(s))
      for (int c = 0; c < m.chars; ++c) sum = sum + ld(part(w_.burning, c), i);
    st(K, i, sum);
    const B there = grows(s) ? ld(start, i) + ld(more, i) : ld(start, i);
    st(warmth, i, S::select(S::gt(there, zero), ld(T_, i), zero));
  }
  for (int r = m.first[s]; r < m.first[s + 1]; ++r) {
    const BedReaction& a = m.reaction[r];
    double* k = part(w_.rate, r);
    const B A = S::set(a.A) * dt_, E = S::set(-k_per_ln2 * a.E);
    for (int i = 0; i < n; ++i) {
      const B t = ld(warmth, i);
      const auto warm = S::gt(t, cold);
      B x = zero;
      if (S::any(warm)) {
        const PowerOfTwo<S> e = power_of_two<S>(E * ld(w_.inverse, i));
        x = A * (e.scale + e.more);
        if (a.n != 0) x = a.n == 1 ? x * t : x * power<S>(ld(T_, i), a.n);
        x = S::select(warm, x, zero);
      }
      st(k, i, x);
      st(K, i, ld(K, i) + x);
    }
  }
}

template <class S>
typename S::B Step<S>::products(const BedReaction& a, const double* rate, const double* share) {
  B total = S::set(0);
  if (a.solids == 0) {
    for (int i = 0; i < n; ++i) total = total + ld(share, i) * ld(rate, i);
    return total;
  }
  for (int y = 0; y < a.solids; ++y) {
    double* more = made(a.solid[y].species);
    const B yield = S::set(a.solid[y].mass);
    for (int i = 0; i < n; ++i) {
      const B x = ld(share, i) * ld(rate, i);
      st(more, i, ld(more, i) + yield * x);
      if (y == 0) total = total + x;
    }
  }
  return total;
}

template <class S>
void Step<S>::dew() {
  const int i = n - 1;
  const B zero = S::set(0), most_of = in(k_in_condensing), t = ld(T_, i);
  dew_heat_ = in(k_in_dew_heat) - (ld(part(w_.sensible, 0), i) - S::set(m.sensible0[0]));
  dew_share_ = S::select(S::gt(most_of, zero), S::set(1) / most<S>(in(k_in_dew)-t, S::set(1e-9)), zero);
  st(w_.heat, i, ld(w_.heat, i) + most_of * dew_heat_);
  st(w_.slope, i, ld(w_.slope, i) - most_of * dew_heat_ * dew_share_);
  st(w_.capacity, i, ld(w_.capacity, i) + S::set(0.5) * ld(part(w_.specific, 0), i) * most_of);
}

template <class S>
void Step<S>::plateaus() {
  const B zero = S::set(0), Tb = S::set(m.boiling), L = S::set(m.evaporation);
  const double *water = mass(m.moisture), *debt = cell(place_.debt);
  B vapour = zero;
  for (int i = 0; i < n; ++i) {
    const B whole = L * ld(water, i);
    B flow = ld(debt, i) + ld(w_.heat, i) - ld(w_.capacity, i) * (Tb - ld(T_, i));
    if (i > 0) flow = flow + ld(w_.conductance, i) * (ld(T_, i - 1) - Tb);
    flow = flow + (i + 1 < n ? ld(w_.conductance, i + 1) * (ld(T_, i + 1) - Tb) : gain_ - loss_ * Tb);
    if (condenses_ && i + 1 == n) flow = flow - in(k_in_condensing)*dew_heat_ * dew_share_ * (Tb - ld(T_, i));
    const B part = clamped<S>(flow, zero, whole);
    // at the plateau part of what there is evaporates; else it is a sink that is known
    const auto stays = S::lt(part, whole);
    st(w_.plateau, i, S::select(stays, part, zero));
    st(w_.sink, i, S::select(stays, zero, whole));
    if (m.carries != 0) {
      vapour = vapour + part * S::set(m.per_evaporation) * ld(w_.gas, i);
      st(w_.flow, i, ld(w_.flow, i) + vapour);
    }
  }
}

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
      if (a.refers != 0) h = h - gas_sensible<S>(m, a, t, integral<S>(m.gas_capacity, t));
      heat = heat + h * x;
    }
    add(k_out_reaction, heat);
    st(debt, i, ld(debt, i) + heat);
  }
}

}  // namespace talus::conversion::bed
