// Second half of bed_step.hpp: masses, heat, debt and gas at the new temperatures.
#pragma once

namespace talus::conversion::bed {

template <class S>
void Step<S>::react() {
  const B zero = S::set(0), one = S::set(1), trace = S::set(m.trace) * (radius0_ * radius0_ * radius0_);
  for (int i = 0; i < n; ++i) st(w_.heat, i, zero);
  for (int s = 0; s < m.solids; ++s)
    if (grows(s))
      for (int i = 0; i < n; ++i) st(made(s), i, zero);
  for (int s = 0; s < m.solids; ++s) {
    double* x = mass(s);
    const bool grown = grows(s);
    const double* more = grown ? made(s) : x;
    if (!turns(s)) {
      if (grown)
        for (int i = 0; i < n; ++i) st(x, i, ld(x, i) + ld(more, i));
      continue;
    }
    const int place = m.turns[s];
    const double *gone = part(w_.gone, place), *per = part(w_.per, place), *grow = part(w_.grow, place);
    const double* released = part(w_.released, place);
    double* share = part(w_.share, place);
    for (int i = 0; i < n; ++i) {
      B there = ld(x, i);
      if (grown) there = there + ld(more, i);
      const B p = ld(per, i);
      B lost = clamped<S>(ld(gone, i) * (one + ld(grow, i) * (ld(w_.next, i) - ld(T_, i))), zero, there);
      const auto traces = S::lt(there - lost, trace * S::set(m.volume[i]));
      lost = S::select(traces, S::select(S::gt(p, zero), there, lost), lost);
      st(x, i, there - lost);
      const B lost_per = lost * p;
      st(share, i, lost_per);
      st(w_.heat, i, ld(w_.heat, i) + lost_per * ld(released, i));
    }
    for (int r = m.first[s]; r < m.first[s + 1]; ++r) {
      const B extent = products(m.reaction[r], part(w_.rate, r), share);
      S::store(w_.total + S::W * r, extent);
      outflow_ = outflow_ + S::set(m.reaction[r].gas_mass) * extent;
      if (m.carries != 0)
        for (int i = 0; i < n; ++i)
          carried_ = carried_ +
                     ld(share, i) * ld(part(w_.rate, r), i) * gas_capacity<S>(m.reaction[r], ld(T_, i), ld(w_.gas, i));
    }
    if (dries(s))
      for (int i = 0; i < n; ++i) {
        const B vapour = ld(share, i) * ld(w_.drying, i);
        evaporated_ = evaporated_ + vapour;
        outflow_ = outflow_ + vapour;
        if (m.carries != 0) carried_ = carried_ + vapour * ld(w_.gas, i);
      }
    if (burns(s))
      for (int c = 0; c < m.chars; ++c) burn(c, s, share);
  }
}

template <class S>
void Step<S>::condense() {
  const int i = n - 1;
  const B left = clamped<S>(S::set(1) - (ld(w_.next, i) - ld(T_, i)) * dew_share_, S::set(0), S::set(1));
  const B water = in(k_in_condensing)*left;
  double* x = mass(m.moisture);
  st(x, i, ld(x, i) + water);
  st(w_.heat, i, ld(w_.heat, i) + water * dew_heat_);
  put(k_out_condensed, water);
  add(k_out_steam, water);
  add(k_out_gone + 4, S::set(0) - water);
  add(k_out_standard, S::set(m.evaporation - m.vapour_to_cells) * water);
}

template <class S>
void Step<S>::burn(int c, int s, const double* share) {
  const BedChar& r = m.burning[c];
  double* done = cell(place_.burnt);
  for (int i = 0; i < n; ++i) {
    const B x = ld(share, i) * ld(part(w_.burning, c), i);
    if (!S::any(S::gt(x, S::set(0)))) continue;
    const CharGas<S> y = yield_of<S>(r, ld(part(w_.monoxide, c), i));
    const B carbon = S::set(m.char_carbon) * x;
    add(k_out_standard, carbon * y.heat + S::set(r.to_cells) * x);
    st(done, i, ld(done, i) + x);
    outflow_ = outflow_ + x;
    add(k_out_oxygen + r.oxidant, carbon * y.oxidant);
    if (m.carbon_monoxide >= 0) add(k_out_released + m.carbon_monoxide, carbon * y.carbon_monoxide);
    if (m.carbon_dioxide >= 0 && r.oxidant == 0) add(k_out_released + m.carbon_dioxide, carbon * y.carbon_dioxide);
    if (m.hydrogen >= 0 && r.oxidant == 2) add(k_out_released + m.hydrogen, carbon * y.hydrogen);
    if (m.char_steam != 0) add(k_out_released + m.vapour, S::set(m.char_steam) * x);
    if (m.char_hydrogen != 0) add(k_out_released + m.hydrogen, S::set(m.char_hydrogen) * x);
    for (int e = 0; e < k_bed_elements; ++e)
      if (m.composition[s][e] != 0) add(k_out_gone + e, S::set(m.composition[s][e]) * x);
  }
}

template <class S>
void Step<S>::book() {
  const B zero = S::set(0), one = S::set(1), half = S::set(0.5);
  double *debt = cell(place_.debt), *stored = w_.slope, *left = w_.upper;
  B from = zero, mean = zero, all = zero;
  range_ = {};
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
    if (boils_) heat = heat - evaporate(i, heat, wanted, T1);
    T1 = most<S>(T1, one);
    range_.add(T1);
    st(w_.next, i, T1);
    st(debt, i, heat);
    st(stored, i, zero), st(left, i, zero);
    const B c = ld(w_.capacity, i);
    all = all + c;
    mean = mean + c * T1;
  }
  put(k_out_mean, mean / all);
  for (int q = 0; q < k_bed_kinds; ++q) {
    if (!there_[q]) continue;
    const double *before = part(w_.before, q), *h0 = part(w_.sensible, q), *after = of_kind(q, w_.flow);
    const B base = S::set(m.sensible0[q]);
    B sum = zero, gone = zero;
    if (m.changes[q] != 0)
      each<S, false, true>(m.capacity[q], w_.next, range_, n, nullptr, w_.inverse, [&](int i, B, B y) {
        const B a = ld(before, i), b = ld(after, i), x = ld(h0, i);
        st(debt, i, ld(debt, i) - half * (a + b) * (y - x));
        gone = gone + (a - b) * (half * (x + y) - base);
        sum = sum + b;
      });
    else
      each<S, false, true>(m.capacity[q], w_.next, range_, n, nullptr, w_.inverse, [&](int i, B, B y) {
        const B b = ld(after, i);
        st(debt, i, ld(debt, i) - b * (y - ld(h0, i)));
        sum = sum + b;
      });
    with_gas_ = with_gas_ + gone;
    put(k_out_moisture + q, sum);
  }
  for (int i = 0; i < n; ++i) st(T_, i, ld(w_.next, i));
}

template <class S>
typename S::B Step<S>::evaporate(int i, typename S::B heat, typename S::B wanted, typename S::B& T1) {
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
  const B vapour = part * S::set(m.per_evaporation);
  st(water, i, most<S>(wet - vapour, zero));
  evaporated_ = evaporated_ + vapour;
  outflow_ = outflow_ + vapour;
  reaction_ = reaction_ - part;
  if (m.carries != 0) carried_ = carried_ + vapour * ld(w_.gas, i);
  return part;
}

template <class S>
void Step<S>::release() {
  for (int r = 0; r < m.secondary; ++r) {
    const BedReaction& a = m.reaction[r];
    const B x = S::load(w_.total + S::W * r);
    add(k_out_standard, S::set(a.standard) * x);
    for (int y = 0; y < a.gases; ++y) add(k_out_released + a.gas[y].species, S::set(a.gas[y].mass) * x);
    for (int e = 0; e < k_bed_elements; ++e)
      if (a.leaving[e] != 0) add(k_out_gone + e, S::set(a.leaving[e]) * x);
  }
  if (m.vapour < 0) return;
  add(k_out_standard, S::set(m.vapour_to_cells - m.evaporation) * evaporated_);
  add(k_out_gone + 4, evaporated_);
  add(k_out_released + m.vapour, evaporated_);
}

template <class S>
void Step<S>::finish() {
  const double* faces = cell(place_.face);
  put(k_out_radius, ld(faces, n - 1));
  S::store(cell(place_.surface), surface_);
  S::store(cell(place_.carried), carried_ / dt_);
  S::store(cell(place_.outflow), outflow_ / dt_);
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

}  // namespace talus::conversion::bed
