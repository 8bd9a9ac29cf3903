// The stages of step.hpp in the order of their use. Included by step.hpp only.
#pragma once

namespace talus::conversion {

template <class V>
GrainStep<V>::GrainStep(const Matter& matter, const StepOptions& options, std::size_t shells)
    : matter_(matter), routes_(matter), mixture_(matter), options_(options), n_(shells), moisture_(0) {
  const std::size_t solids = matter.solids.size(), reactions = matter.reactions.size();
  for (std::size_t s = 0; s < solids; ++s) {
    if (matter.solids[s].kind != Kind::moisture) continue;
    moisture_ = s;
    has_moisture_ = true;
  }
  boils_ = has_moisture_ && (matter.drying.kind == Drying::boiling || matter.drying.kind == Drying::equilibrium);
  melts_ = matter.melting.latent > 0;
  for (std::vector<V>* x : {&T1_, &Q_, &burnt1_, &latent_, &boiled_, &flow_, &capacity_, &taken_, &tau_, &slope_,
                            &lower_, &diagonal_, &upper_, &right_, &plain_, &straight_, &liquid1_, &volume_})
    x->assign(n_, V(0));
  for (std::vector<V>* x : {&G_, &face0_, &faceg_, &face_}) x->assign(n_ + 1, V(0));
  mass1_.assign(solids * n_, V(0));
  for (std::vector<V>* x : {&rate1_, &kt_, &end_time_}) x->assign(reactions * n_, V(0));
  ShellChange<V> change;
  change.mass.assign(solids, V(0));
  change.released.assign(matter.gases.size(), V(0));
  change.burnt.assign(matter.char_reactions.size(), V(0));
  change_.assign(n_, change);
  Extra<V> extra;
  if (!matter.char_reactions.empty()) {
    extra.burning.assign(matter.char_reactions.size(), V(0));
    extra.burning_heat = extra.burning;
  }
  extra_.assign(n_, extra);
  shells_.resize(n_);
}

template <class V>
void GrainStep<V>::rates(std::vector<V>& k, const std::vector<V>& T) const {
  for (std::size_t r = 0; r < matter_.reactions.size(); ++r) {
    const Reaction& reaction = matter_.reactions[r];
    for (std::size_t i = 0; i < n_; ++i)
      k[r * n_ + i] = arrhenius(reaction.A, reaction.n, reaction.E, most(T[i], V(1)));
  }
}

template <class V>
void GrainStep<V>::start(GrainState<V>& g, const Surroundings<V>& s) {
  g.rate.assign(matter_.reactions.size() * n_, V(0));
  rates(g.rate, g.temperature);
  g.surface = s.given_surface ? s.surface_temperature : g.temperature[n_ - 1];
}

/// Conductances of the faces [W/K] and the exchange of the surface, for masses and temperatures of the stage's end.
template <class V>
void GrainStep<V>::conductances(const GrainState<V>& g, const Surroundings<V>& s) {
  std::vector<V>& half = plain_;  // resistance of half a shell, times area [m2 K/W]
  V emissivity = V(0);
  for (std::size_t i = 0; i < n_; ++i) {
    const auto m = mixture_.by_kind([&](std::size_t k) { return mass1_[k * n_ + i]; });
    const auto shares = mixture_.shares(m, g.m0(Kind::moisture, i), g.m0(Kind::fuel, i), burnt1_[i]);
    volume_[i] = g.volume0[i] * most(mixture_.volume_share(shares), V(1e-4));
    half[i] = V(0.5) / mixture_.conductivity(m, shares, T1_[i]);
    emissivity = mixture_.emissivity(shares);
  }
  shells_.set(volume_);
  for (std::size_t i = 0; i < n_; ++i) half[i] = half[i] * shells_.thickness(i);
  for (std::size_t i = 1; i < n_; ++i) G_[i] = shells_.area[i] / (half[i - 1] + half[i]);
  const V area = shells_.area[n_];
  const V inner = options_.lumped ? V(1e15) : area / half[n_ - 1];
  Surroundings<V> own = s;
  own.emissivity = s.emissivity * emissivity;
  if (matter_.blowing && !s.given_surface) {
    const V loss = most(stage_capacity_, V(0));
    own.film = s.film * blown(loss / most(s.film * area, V(1e-300)));
  }
  surface_T_ = heat::surface_temperature(own, area, inner, T1_[n_ - 1], surface_T_);
  surface_ = heat::surface_exchange(own, area, inner, surface_T_);
}

template <class V>
void GrainStep<V>::advance(GrainState<V>& g, V dt, const Surroundings<V>& before, const Surroundings<V>& after,
                           const GasAround<V>& gas, Method method) {
  shells_.shape = g.shells.shape;
  shells_.factor = g.shells.factor;
  surface_T_ = g.surface;
  const V gas0 = [&] {
    V sum = V(0);
    for (const V& x : g.released) sum = sum + x;
    return sum;
  }();
  if (method == Method::euler) {
    for (V& f : face0_) f = V(0);
    for (V& f : faceg_) f = V(0);
    const std::vector<V> rate0 = g.rate;
    share_rates({dt, dt, V(0), V(0)}, rate0, rate0);
    stage(g, {dt, dt, V(0), V(0)}, after, gas);
  } else {
    // flows at the start of the step
    mass1_ = g.mass;
    T1_ = g.temperature;
    for (std::size_t i = 0; i < n_; ++i) burnt1_[i] = g.m0(Kind::char_, i);
    stage_gas_ = outflow_;
    conductances(g, before);
    for (std::size_t i = 1; i < n_; ++i) face0_[i] = G_[i] * (T1_[i - 1] - T1_[i]);
    face0_[n_] = V(0) - surface_.flow(T1_[n_ - 1]);
    // gamma = 2 - sqrt(2); weights of the middle and of the end
    constexpr double gamma = 0.58578643762690495, d = 0.29289321881345248, w = 0.35355339059327376;
    Surroundings<V> middle = after;
    const V u = V(gamma);
    const auto between = [&](V a, V b) { return a + u * (b - a); };
    middle.film = between(before.film, after.film);
    middle.gas_temperature = between(before.gas_temperature, after.gas_temperature);
    middle.wall_temperature = between(before.wall_temperature, after.wall_temperature);
    middle.flux = between(before.flux, after.flux);
    middle.contact_conductance = between(before.contact_conductance, after.contact_conductance);
    middle.contact_temperature = between(before.contact_temperature, after.contact_temperature);
    middle.surface_temperature = between(before.surface_temperature, after.surface_temperature);
    const std::vector<V> rate0 = g.rate;
    for (V& f : faceg_) f = V(0);
    share_rates({V(gamma) * dt, V(d) * dt, V(d) * dt, V(0)}, rate0, rate0);
    stage(g, {V(gamma) * dt, V(d) * dt, V(d) * dt, V(0)}, middle, gas);
    faceg_ = face_;
    share_rates({V(1 - gamma) * dt, V(d) * dt, V(w - d) * dt, V(w - d) * dt}, rate0, g.rate);
    stage(g, {V(1 - gamma) * dt, V(d) * dt, V(w - d) * dt, V(w - d) * dt}, after, gas);
  }
  V gas1 = V(0);
  for (const V& x : g.released) gas1 = gas1 + x;
  outflow_ = (gas1 - gas0) / dt;
  g.time = g.time + dt;
}

/// Splits the time of a stage between rate constants that are known and those of its end. Where a known one is fast
/// against the stage its share goes to the end: a reaction that takes up heat would otherwise run on whatever it cools.
template <class V>
void GrainStep<V>::share_rates(const Stage& w, const std::vector<V>& a, const std::vector<V>& b) {
  for (std::size_t k = 0; k < kt_.size(); ++k) {
    const V x = w.duration * most(a[k], b[k]);
    const V known = V(1) / (V(1) + x * x);
    kt_[k] = known * (w.first * a[k] + w.second * b[k]);
    end_time_[k] = w.duration - known * (w.first + w.second);
  }
}

template <class V>
void GrainStep<V>::stage(GrainState<V>& g, const Stage& w, const Surroundings<V>& end, const GasAround<V>& gas) {
  T1_ = g.temperature;
  mass1_ = g.mass;
  for (std::size_t i = 0; i < n_; ++i) {
    burnt1_[i] = g.m0(Kind::char_, i);
    Q_[i] = g.debt[i];
    boiled_[i] = flow_[i] = V(0);
    liquid1_[i] = g.liquid[i];
  }
  stage_gas_ = outflow_;
  conductances(g, end);
  for (int k = 0; k < options_.iterations; ++k) {
    reactions(g, w, gas);
    conductances(g, end);
    linearise(g);
    solve(g, w);
    temperatures(g);
  }
  reactions(g, w, gas);
  commit(g, w);
}

/// Masses at the stage's end for the temperatures T1_, and the heat of the reactions.
template <class V>
void GrainStep<V>::reactions(GrainState<V>& g, const Stage& w, const GasAround<V>& gas) {
  rates(rate1_, T1_);
  char_and_drying(g, w, gas);
  std::vector<V> kt(matter_.reactions.size()), late(matter_.reactions.size());
  for (std::size_t i = 0; i < n_; ++i) {
    const Ends<V> ends{g.temperature[i], T1_[i], mixture_.sensible(g.temperature[i]), mixture_.sensible(T1_[i])};
    for (std::size_t r = 0; r < kt.size(); ++r) {
      late[r] = end_time_[r * n_ + i] * rate1_[r * n_ + i];
      kt[r] = kt_[r * n_ + i] + late[r];
    }
    react(
        matter_, routes_, kt, late, ends, extra_[i], [&](std::size_t s) { return g.m(s, i); }, change_[i]);
  }
  secondary(w, gas.pressure);
  V passed = V(0), carried = V(0);
  for (std::size_t i = 0; i < n_; ++i) {
    for (const V& x : change_[i].released) passed = passed + x;
    passed = passed + change_[i].dried;
    V burnt = g.m0(Kind::char_, i);
    for (const V& b : change_[i].burnt) {
      passed = passed + b;
      burnt = burnt + b;
    }
    burnt1_[i] = burnt;
    if (boils_) {
      V& m = change_[i].mass[moisture_];
      boiled_[i] = least(boiled_[i], m);
      m = m - boiled_[i];
    }
    passed = passed + boiled_[i];
    carried =
        carried + change_[i].gas_capacity + (change_[i].dried + boiled_[i]) * matter_.gas_heat_capacity.at(T1_[i]);
    flow_[i] = carried;
    for (std::size_t s = 0; s < matter_.solids.size(); ++s) mass1_[s * n_ + i] = change_[i].mass[s];
  }
  stage_gas_ = passed / w.duration;
  stage_capacity_ = carried / w.duration;
}

/// Temperature as a straight line in the heat taken in, T = tau + slope Q, about the present iterate.
template <class V>
void GrainStep<V>::linearise(const GrainState<V>& g) {
  for (std::size_t i = 0; i < n_; ++i) {
    const Taken t = taken(g, i, Q_[i]);
    capacity_[i] = t.capacity;
    slope_[i] = t.share / t.capacity;
    tau_[i] = t.temperature - slope_[i] * Q_[i];
  }
}

/// Where a shell stands that has taken in the heat Q since the stage's start: temperature, latent parts, slope.
template <class V>
typename GrainStep<V>::Taken GrainStep<V>::taken(const GrainState<V>& g, std::size_t i, V Q) const {
  const auto m = mixture_.by_kind([&](std::size_t s) { return V(0.5) * (g.m(s, i) + mass1_[s * n_ + i]); });
  const auto h0 = mixture_.sensible(g.temperature[i]);
  const auto until = [&](const ByKind<V>& h) {
    V sum = V(0);
    for (std::size_t k = 0; k < k_kinds; ++k) sum = sum + m[k] * (h[k] - h0[k]);
    return sum;
  };
  Taken t;
  t.sensible = until(mixture_.sensible(T1_[i]));
  // fuel without ash burns to nothing: what is left keeps a trace of heat capacity, and the debt what it does not hold
  t.capacity = most(mixture_.capacity(m, T1_[i]), V(k_trace_capacity * matter_.density) * g.volume0[i]);
  t.share = V(1);
  V latent = V(0);
  if (boils_) {
    const V L = V(matter_.drying.heat), Tb = V(matter_.drying.temperature);
    const V start = until(mixture_.sensible(Tb)), whole = L * (mass1_[moisture_ * n_ + i] + boiled_[i]);
    const V part = clamped(Q - start, V(0), whole);
    t.boiled = part / L;
    latent = part;
    const auto inside = both(less(V(0), part), less(part, whole));
    t.share = select(inside, V(0), t.share);
    t.temperature = select(inside, Tb, T1_[i] + (Q - t.sensible - latent) / t.capacity);
  } else {
    t.temperature = T1_[i] + (Q - t.sensible) / t.capacity;
  }
  if (melts_) {
    const Melting& melt = matter_.melting;
    V mass = V(0);
    for (const V& x : m) mass = mass + x;
    const V heat = mass * V(melt.latent);
    const V start = until(mixture_.sensible(V(melt.solidus)));
    const V whole = heat + until(mixture_.sensible(V(melt.liquidus))) - start;
    const V before = g.liquid[i] * heat;
    const V y = Q - start + before;
    const V share = clamped(y, V(0), whole) / whole;
    const auto inside = both(less(V(0), y), less(y, whole));
    t.liquid = share;
    t.share = select(inside, V(1) - heat / whole, V(1));
    const V free = T1_[i] + (Q - t.sensible - (share * heat - before)) / t.capacity;
    t.temperature = melt.liquidus > melt.solidus ? free : select(inside, V(melt.solidus), free);
  }
  return t;
}

template <class V>
void GrainStep<V>::solve(const GrainState<V>& g, const Stage& w) {
  std::vector<V>&on = plain_, &next = taken_;  // coefficients of the own temperature and the next one's
  std::vector<V>& below = latent_;
  for (std::size_t i = 0; i < n_; ++i) {
    const bool last = i + 1 == n_;
    const V in = w.implicit * G_[i], out = w.implicit * (last ? surface_.loss : G_[i + 1]);
    const V gas = i > 0 ? gas_exchange(i) : V(0);
    below[i] = i > 0 ? in + gas : V(0);
    next[i] = last ? V(0) : out;
    on[i] = change_[i].slope - below[i] - out;
    right_[i] = given(g, w, i) + change_[i].heat - change_[i].slope * T1_[i];
    if (last) right_[i] = right_[i] + w.implicit * surface_.gain;
  }
  for (std::size_t i = 0; i < n_; ++i) {
    diagonal_[i] = V(1) - on[i] * slope_[i];
    right_[i] = right_[i] + on[i] * tau_[i];
    if (i > 0) {
      lower_[i] = V(0) - below[i] * slope_[i - 1];
      right_[i] = right_[i] + below[i] * tau_[i - 1];
    }
    if (i + 1 < n_) {
      upper_[i] = V(0) - next[i] * slope_[i + 1];
      right_[i] = right_[i] + next[i] * tau_[i + 1];
    }
  }
  heat::solve_tridiagonal(lower_, diagonal_, upper_, right_);
  for (std::size_t i = 0; i < n_; ++i) {
    Q_[i] = right_[i];
    straight_[i] = tau_[i] + slope_[i] * right_[i];
  }
}

/// Heat that does not depend on the unknown: flows of earlier times and what the iteration before left over [J].
template <class V>
V GrainStep<V>::given(const GrainState<V>& g, const Stage& w, std::size_t i) const {
  return w.first * (face0_[i] - face0_[i + 1]) + w.second * (faceg_[i] - faceg_[i + 1]) + g.debt[i];
}

/// Heat capacity of the gas that comes from the shell below [J/K].
template <class V>
V GrainStep<V>::gas_exchange(std::size_t i) const {
  if (!matter_.gas_convection) return V(0);
  return most(flow_[i - 1], V(0));
}

template <class V>
void GrainStep<V>::temperatures(const GrainState<V>& g) {
  for (std::size_t i = 0; i < n_; ++i) {
    const Taken t = taken(g, i, Q_[i]);
    T1_[i] = most(t.temperature, V(1));
    boiled_[i] = t.boiled;
    liquid1_[i] = t.liquid;
  }
}

/// Books the stage: flows as they were solved for, masses and temperatures as they came out, the rest as debt.
template <class V>
void GrainStep<V>::commit(GrainState<V>& g, const Stage& w) {
  for (std::size_t i = 1; i < n_; ++i) face_[i] = G_[i] * (straight_[i - 1] - straight_[i]);
  face_[n_] = V(0) - surface_.flow(straight_[n_ - 1]);
  g.heat_in = g.heat_in - (w.first * face0_[n_] + w.second * faceg_[n_] + w.implicit * face_[n_]);
  for (std::size_t i = 0; i < n_; ++i) {
    ShellChange<V>& c = change_[i];
    const V gas = i > 0 ? gas_exchange(i) * (straight_[i - 1] - straight_[i]) : V(0);
    const V Q = given(g, w, i) + w.implicit * (face_[i] - face_[i + 1]) + gas + c.heat;
    const V evaporation = boils_ ? V(matter_.drying.heat) * boiled_[i] : V(0);
    const auto h0 = mixture_.sensible(g.temperature[i]), h1 = mixture_.sensible(T1_[i]);
    V stored = V(0), left = V(0), total = V(0);
    for (std::size_t s = 0; s < matter_.solids.size(); ++s) {
      const std::size_t k = static_cast<std::size_t>(matter_.solids[s].kind);
      const V m0 = g.m(s, i), m1 = mass1_[s * n_ + i];
      stored = stored + V(0.5) * (m0 + m1) * (h1[k] - h0[k]);
      left = left + (m0 - m1) * (V(0.5) * (h0[k] + h1[k]));
      total = total + V(0.5) * (m0 + m1);
      g.m(s, i) = m1;
    }
    if (melts_) {
      stored = stored + (liquid1_[i] - g.liquid[i]) * total * V(matter_.melting.latent);
      g.liquid[i] = liquid1_[i];
    }
    g.debt[i] = Q - stored - evaporation;
    g.temperature[i] = T1_[i];
    g.heat_of_reaction = g.heat_of_reaction + c.heat - evaporation;
    g.heat_with_gas = g.heat_with_gas + left - gas;
    for (std::size_t k = 0; k < g.released.size(); ++k) g.released[k] = g.released[k] + c.released[k];
    for (std::size_t e = 0; e < k_elements; ++e) g.gone[e] = g.gone[e] + c.gone[e];
    if (has_moisture_) {
      const V vapour = c.dried + boiled_[i];
      g.gone[water] = g.gone[water] + boiled_[i];
      if (matter_.vapour) g.released[*matter_.vapour] = g.released[*matter_.vapour] + vapour;
    }
    burn(g, i);
  }
  g.shells.face = shells_.face;
  g.shells.area = shells_.area;
  g.rate = rate1_;
  g.surface = surface_.surface(T1_[n_ - 1]);
}

/// Products of the char that burnt in a shell, and what they took from outside.
template <class V>
void GrainStep<V>::burn(GrainState<V>& g, std::size_t i) {
  for (std::size_t c = 0; c < matter_.char_reactions.size(); ++c) {
    const CharReaction& r = matter_.char_reactions[c];
    const CharYield<V> y = char_yield(r, T1_[i]);
    const V burnt = change_[i].burnt[c];
    g.m0(Kind::char_, i) = g.m0(Kind::char_, i) + burnt;
    const V carbon = V(matter_.char_carbon) * burnt;
    const auto add = [&](const std::optional<std::size_t>& gas, V mass) {
      if (gas) g.released[*gas] = g.released[*gas] + mass;
    };
    add(matter_.carbon_monoxide, carbon * y.carbon_monoxide);
    add(matter_.carbon_dioxide, carbon * y.carbon_dioxide);
    add(matter_.hydrogen, carbon * y.hydrogen);
    if (matter_.char_steam > 0) add(matter_.vapour, V(matter_.char_steam) * burnt);
    if (matter_.char_hydrogen > 0) add(matter_.hydrogen, V(matter_.char_hydrogen) * burnt);
    V& from = r.oxidant == CharReaction::Oxidant::oxygen           ? g.oxygen_taken
              : r.oxidant == CharReaction::Oxidant::carbon_dioxide ? g.carbon_dioxide_taken
                                                                   : g.steam_taken;
    from = from + carbon * y.oxidant;
  }
}

}  // namespace talus::conversion
