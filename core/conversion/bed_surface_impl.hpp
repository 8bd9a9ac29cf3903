// Second half of bed_step.hpp: what the grain is at the start of a step (heat capacities, faces, conductances), the
// exchange of its surface, and the fronts at which it dries and burns.
#pragma once

namespace talus::conversion::bed {

template <class S>
void Step<S>::capacities() {
  range_ = {};
  for (int i = 0; i < n; ++i) {
    st(w_.capacity, i, S::set(1e-300));
    range_.add(ld(T_, i));
  }
  for (int q = 0; q < k_bed_kinds; ++q) {
    if (!(there_[q] = holds(q))) continue;
    double *before = part(w_.before, q), *specific = part(w_.specific, q), *sensible = part(w_.sensible, q);
    const double* masses = of_kind(q, before);
    each<S, true, true>(m.capacity[q], T_, range_, n, specific, sensible, [&](int i, B c, B h) {
      const B x = ld(masses, i);
      st(before, i, x), st(specific, i, c), st(sensible, i, h);
      st(w_.capacity, i, ld(w_.capacity, i) + x * c);
    });
  }
  if (m.asks_gas != 0)
    each<S, true, true>(m.gas_capacity, T_, range_, n, w_.gas, w_.gas_heat,
                        [&](int i, B c, B h) { st(w_.gas, i, c), st(w_.gas_heat, i, h); });
}

template <class S>
bool Step<S>::holds(int q) const {
  if (q == 0 && condenses_) return true;
  if (m.present[q] == 0 || m.changes[q] == 0 || m.grown[q] != 0) return m.present[q] != 0;
  B most_of = S::set(0);
  for (int k = m.first_of_kind[q]; k < m.first_of_kind[q + 1]; ++k)
    for (int i = 0; i < n; ++i) most_of = most<S>(most_of, ld(mass(m.of_kind[k]), i));
  return S::any(S::gt(most_of, S::set(0)));
}

template <class S>
const double* Step<S>::of_kind(int q, double* to) const {
  const int from = m.first_of_kind[q], end = m.first_of_kind[q + 1];
  const double* first = mass(m.of_kind[from]);
  if (end - from == 1) return first;
  for (int i = 0; i < n; ++i) st(to, i, ld(first, i));
  for (int k = from + 1; k < end; ++k) {
    const double* x = mass(m.of_kind[k]);
    for (int i = 0; i < n; ++i) st(to, i, ld(to, i) + ld(x, i));
  }
  return to;
}

template <class S>
void Step<S>::geometry() {
  double* lambda[4] = {w_.heat, w_.slope, w_.flow, w_.next};  // free until later passes
  for (int q = 0; q < 4; ++q)
    if (q == 1 || (q == 0 && m.moisture_density > 0) || (q == 2) || (q == 3 && m.chars > 0))
      each<S, true, false>(m.conductivity[q], T_, range_, n, lambda[q], nullptr,
                           [&](int i, B k, B) { st(lambda[q], i, k); });
  const B cube = radius0_ * radius0_ * radius0_, per_cube = S::set(1) / cube, zero = S::set(0), one = S::set(1);
  B volume = zero, below = zero, below_area = zero, wide = zero, conducts = one;
  double* faces = cell(place_.face);
  const double *moist = part(w_.before, 0), *fuel = part(w_.before, 1), *coal = part(w_.before, 2);
  const bool wet = m.moisture_density > 0, mixes = m.chars > 0;
  for (int i = 0; i < n; ++i) {
    ByKind<S> k{zero, zero, zero, zero};
    if (there_[0]) k[0] = ld(moist, i);
    if (there_[1]) k[1] = ld(fuel, i);
    if (there_[2]) k[2] = ld(coal, i);
    const Shares<S> shares = shares_of<S>(m, k, per_cube * S::set(m.per_volume[i]), burnt(i));
    const B t = ld(T_, i);
    volume = volume + cube * S::set(m.volume[i]) * most<S>(volume_share<S>(m, shares), S::set(1e-4));
    const B old = ld(faces, i), ball = S::set(4.1887902047863905) * old * old, shell = S::set(3) * ball;
    const B both = one / (shell * t);  // one division for two reciprocals
    st(w_.inverse, i, both * shell);
    const B face = old - (ball * old - volume) * (both * t);
    B wood = ld(lambda[1], i), rest = ld(lambda[2], i);
    if (wet) wood = wood + shares.moisture * (ld(lambda[0], i) - wood);
    if (mixes) rest = shares.char_left * rest + (one - shares.char_left) * ld(lambda[3], i);
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
  put(k_out_inner, inner_);
  put(k_out_conductivity, conducts);
  put(k_out_emissivity, emissivity_);
}

template <class S>
void Step<S>::film() {
  const B radius = ld(cell(place_.face), n - 1), gas = in(k_in_gas), zero = S::set(0);
  const B given = in(k_in_film);
  B mass_film = zero, h = given;
  if (m.chars > 0 || m.dries != 0 || S::any(S::lt(given, zero))) {
    h = film_coefficients<S>(m, S::set(2) * radius, in(k_in_velocity), S::set(0.5) * (gas + surface_),
                             in(k_in_pressure), mass_film);
    const auto by_law = S::lt(given, zero);
    mass_film = S::select(by_law, mass_film, mass_film * given / h);  // that of mass goes with that of heat
    h = S::select(by_law, h, given);
  }
  if (m.blows != 0) {
    const B loss = S::load(cell(place_.carried));
    h = h * blown<S>(loss / most<S>(h * area_, S::set(1e-300)));
    if (m.chars > 0 || m.dries != 0) {  // of the mass that comes out, as of a single grain
      const B through = gas_density<S>(surface_, in(k_in_pressure), in(k_in_molar)) * mass_film * area_;
      mass_film = mass_film * blown<S>(S::load(cell(place_.outflow)) / most<S>(through, S::set(1e-300)));
    }
  }
  mass_film_ = mass_film;
  h = h * (S::set(1) - in(k_in_apart));
  const B wall = in(k_in_wall), contact = in(k_in_contact), contact_heat = in(k_in_contact_heat);
  const B sigma = S::set(5.670374419e-8) * emissivity_ * in(k_in_sees)*area_;
  // the chord to the wall's temperature: never takes the surface beyond it
  B outer, gain, share, s = surface_;
  for (int k = 0; k < 3; ++k) {
    const B radiation = sigma * (s * s + wall * wall) * (s + wall);
    outer = area_ * h + contact + radiation;
    gain = area_ * (h * gas + in(k_in_flux)) + contact_heat + in(k_in_flow) + radiation * wall;
    share = S::set(1) / (inner_ + outer);
    s = most<S>((gain + inner_ * ld(T_, n - 1)) * share, S::set(1));
  }
  surface_ = s;
  around_gain_ = gain - in(k_in_flow) + in(k_in_partner_heat);
  around_loss_ = inner_ + outer + in(k_in_partner);
  surface_gain_ = gain * share;
  surface_slope_ = inner_ * share;
  loss_ = dt_ * (inner_ * outer * share);
  gain_ = dt_ * (inner_ * gain * share);
}

/// A front stands where what is left of its shell ends. `left`: share of what was there; the rest has shrunk by the
/// share `shrinks` of its volume. below3, face3: cubes of the faces.
template <class S>
typename S::B front_at(typename S::B below3, typename S::B face3, typename S::B face, typename S::B left,
                       double shrinks) {
  const auto one = S::set(1), l = clamped<S>(left, S::set(0), one);
  const auto core = l / (one - S::set(shrinks) * (one - l));
  return least<S>(power<S>(most<S>(below3 + core * (face3 - below3), S::set(1e-60)), 1.0 / 3), face);
}

template <class S>
void Step<S>::fronts() {
  const B tiny = S::set(1e-300), one = S::set(1), zero = S::set(0), trace = S::set(50),
          sphere = S::set(12.566370614359172);
  const B least_part = S::set(1e-60), per_pressure = one / in(k_in_pressure);  // products of three stay numbers
  const B density = gas_density<S>(S::set(0.5) * (in(k_in_gas) + surface_), in(k_in_pressure), in(k_in_molar));
  const B oxidant[3] = {density * in(k_in_oxygen), density * in(k_in_carbon_dioxide), density * in(k_in_steam)};
  B way = one / most<S>(mass_film_ * area_, tiny), wet_open = one, char_open = one;
  const B cube = radius0_ * radius0_ * radius0_, per_fuel = S::set(m.per_fuel_density) / cube;
  const double *faces = cell(place_.face), *fuels = part(w_.before, 1), *coals = part(w_.before, 2);
  for (int i = n; i-- > 0;) {
    const B t = ld(T_, i), face = ld(faces, i), below = i > 0 ? ld(faces, i - 1) : zero;
    const B middle = S::set(0.5) * (face + below), face3 = face * face * face, below3 = below * below * below;
    const B pores = S::set(m.pores) * gas_diffusivity<S>(t, per_pressure) * sphere;
    const B first = cube * S::set(m.volume[i]), dry0 = most<S>(first * S::set(m.fuel_density), tiny);
    const B coal = m.chars > 0 && there_[2] ? ld(coals, i) : zero, gone = burnt(i);
    const B char0 = most<S>(coal + gone, least_part);
    // one division for the reciprocals of a passage, what there was of char, and all of the shell
    const B passage = most<S>(pores * middle * middle, least_part), whole = dry0 + char0;
    const B chars = char0 * whole, all = one / (passage * chars);
    if (m.dries != 0) {
      const B wet = ld(mass(m.moisture), i);
      const B front = wet_open * least<S>(wet * trace / dry0, one);
      wet_open = wet_open - front;
      B K = zero;
      if (S::any(S::gt(front, zero))) {
        // wetter than at first: the front is the face
        const B at =
            front_at<S>(below3, face3, face, wet / most<S>(first * S::set(m.moisture_density), tiny), m.shrink[0]);
        const B dried = (face - at) / most<S>(pores * face * at, least_part);
        const B drive = most<S>(saturated<S>(m, t, pressure_) - oxidant[2], zero);
        K = steady<S>(front * drive / (way + dried) * dt_ / most<S>(wet, tiny));
      }
      st(w_.drying, i, K);
    }
    if (m.chars > 0) {
      const B shared = all * passage;
      const B front = char_open * least<S>(coal * trace * (shared * char0), one);
      char_open = char_open - front;
      B at = face, ash = zero;
      if (S::any(S::gt(front, zero))) {
        const B fuel = there_[1] ? ld(fuels, i) * (per_fuel * S::set(m.per_volume[i])) : zero;  // Mixture::burnt_out
        at = front_at<S>(below3, face3, face, one - gone * (shared * whole) * (one - fuel), m.shrink[2]);
        ash = (face - at) / most<S>(pores * face * at, least_part);
      }
      for (int c = 0; c < m.chars; ++c) {
        B K = zero, x = zero;
        const BedChar& r = m.burning[c];
        if (S::any(S::gt(front * oxidant[r.oxidant], zero))) {
          x = monoxide_share<S>(r, ld(w_.inverse, i));
          const B rate = arrhenius<S>(r.A, r.n, r.E, t, ld(w_.inverse, i)) * sphere * at * at;
          const B flow = front * oxidant[r.oxidant] / (way + ash + one / most<S>(rate, tiny));
          K = steady<S>(flow / (S::set(m.char_carbon) * yield_of<S>(r, x).oxidant) * dt_ / most<S>(coal, tiny));
        }
        st(part(w_.burning, c), i, K);
        st(part(w_.monoxide, c), i, x);
      }
    }
    way = way + (face - below) * (all * chars);
  }
}

template <class S>
void Step<S>::judge() {
  if (!there_[1]) return;
  const B zero = S::set(0), cube = radius0_ * radius0_ * radius0_;
  const double* fuel = part(w_.before, 1);
  const B some = S::set(0.05 * m.fuel_density) * cube;
  B flow = zero, holds = S::set(1);
  for (int i = 1; i < n; ++i) {
    const auto left = S::gt(ld(fuel, i), S::set(m.volume[i]) * some);
    const B g = S::select(left, ld(w_.conductance, i), zero), c = ld(w_.capacity, i);
    const auto worse = S::gt(g * holds, flow * c);
    flow = S::select(worse, g, flow);
    holds = S::select(worse, c, holds);
  }
  put(k_out_excess, flow / holds);
}

}  // namespace talus::conversion::bed
