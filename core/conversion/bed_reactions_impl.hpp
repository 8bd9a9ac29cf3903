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
  return q - gas_sensible<S>(m, r, ld(T_, i));
}

template <class S>
void Step<S>::predict() {
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
  double *gone = part(w_.gone, place), *per = part(w_.per, place);
  double *grow = part(w_.grow, place), *released = part(w_.released, place);
  const bool wet = dries(s), char_burns = burns(s), grown = grows(s);
  const double *start = mass(s), *more_of = grown ? made(s) : start, *c = part(w_.specific, m.kind[s]);
  for (int i = 0; i < n; ++i) {
    const B k = ld(K, i);
    if (!S::any(S::gt(k, zero))) {
      st(gone, i, zero), st(per, i, zero), st(grow, i, zero), st(released, i, zero);
      if (grown) st(w_.capacity, i, ld(w_.capacity, i) + half * ld(c, i) * ld(more_of, i));
      continue;
    }
    const B t = ld(T_, i), some = most<S>(k, tiny), above = t - still, over = most<S>(above, one);
    const B both = one / (some * over);  // one division for two reciprocals
    const B left = exponential<S>(zero - k), p = both * over;
    B lost = ld(start, i) * (one - left);
    if (grown) {
      const B small = one - k * (half - k * (S::set(1.0 / 6) - k * S::set(1.0 / 24)));
      const B mean = S::select(S::lt(k, S::set(1e-3)), small, (one - left) * p), more = ld(more_of, i);
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
      const B there = grown ? ld(start, i) + ld(more_of, i) : ld(start, i);
      const B warms = ld(w_.plateau, i) + share * q / ld(w_.capacity, i);
      const B limit = (there - lost) / most<S>(lost * warms, tiny);
      rises = S::select(S::gt(warms, zero), least<S>(rises, limit), rises);
      st(w_.slope, i, ld(w_.slope, i) + least<S>(share * q * rises, zero));
    }
    if (char_burns)
      for (int k2 = 0; k2 < m.chars; ++k2)
        q = q + ld(part(w_.burning, k2), i) * (S::set(m.char_carbon) * yield_of<S>(m.burning[k2], t).heat);
    st(gone, i, lost), st(per, i, p), st(grow, i, rises), st(released, i, q);
    st(w_.heat, i, ld(w_.heat, i) + share * q);
  }
  for (int r = m.first[s]; r < m.first[s + 1]; ++r)
    if (m.reaction[r].solids > 0) products(m.reaction[r], part(w_.rate, r), gone, per);
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

template <class S>
void Step<S>::rates(int s, double* K) {
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

template <class S>
typename S::B Step<S>::products(const BedReaction& a, const double* rate, const double* gone, const double* per) {
  B total = S::set(0);
  if (a.solids == 0) {
    for (int i = 0; i < n; ++i) total = total + ld(gone, i) * ld(per, i) * ld(rate, i);
    return total;
  }
  for (int y = 0; y < a.solids; ++y) {
    double* more = made(a.solid[y].species);
    const B yield = S::set(a.solid[y].mass);
    for (int i = 0; i < n; ++i) {
      const B x = ld(gone, i) * ld(per, i) * ld(rate, i);
      st(more, i, ld(more, i) + yield * x);
      if (y == 0) total = total + x;
    }
  }
  return total;
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
