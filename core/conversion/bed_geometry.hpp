// Properties, shares, faces and laws of gas of bed_step.hpp, and its working arrays. Included by it alone.
#pragma once

#include "core/conversion/bed_math.hpp"
#include "core/conversion/bed_matter.hpp"

namespace talus::conversion::bed {

template <class S>
TALUS_SHAPES_INLINE typename S::B value(const BedProperty& p, typename S::B T) {
  using B = typename S::B;
  B sum = S::set(p.first);
  for (int q = 0; q < p.pieces; ++q) {
    const BedPiece& a = p.piece[q];
    const B x = clamped<S>(T, S::set(a.low), S::set(a.high)) - S::set(a.low);
    B slope = S::set(a.power[a.powers - 1]);
    for (int k = a.powers - 1; k > 0; --k) slope = slope * x + S::set(a.power[k - 1]);
    sum = sum + slope * x;
  }
  return sum;
}

/// Of all shells: value, integral over temperature, or both.
template <class S, bool Value, bool Integral>
void evaluate(const BedProperty& p, const double* T, int n, double* value, double* integral) {
  using B = typename S::B;
  const B first = S::set(p.first);
  for (int i = 0; i < n; ++i) {
    if constexpr (Value) S::store(value + S::W * i, first);
    if constexpr (Integral) S::store(integral + S::W * i, first * S::load(T + S::W * i));
  }
  for (int q = 0; q < p.pieces; ++q) {
    const BedPiece& a = p.piece[q];
    const B low = S::set(a.low), high = S::set(a.high);
    const B last = S::set(a.power[a.powers - 1]), last_area = S::set(a.area[a.powers - 1]);
    for (int i = 0; i < n; ++i) {
      const B t = S::load(T + S::W * i), up = most<S>(t, low), x = least<S>(up, high) - low;
      B slope = last, area = last_area;
      for (int k = a.powers - 1; k > 0; --k) {
        slope = slope * x + S::set(a.power[k - 1]);
        if constexpr (Integral) area = area * x + S::set(a.area[k - 1]);
      }
      const B rise = slope * x;
      if constexpr (Value) S::store(value + S::W * i, S::load(value + S::W * i) + rise);
      if constexpr (Integral)
        S::store(integral + S::W * i, S::load(integral + S::W * i) + (area * x * x + rise * (most<S>(t, high) - high)));
    }
  }
}
/// Coldest and hottest shell, lane by lane.
template <class S>
struct Range {
  typename S::B low = S::set(1e300), high = S::set(-1e300);
  void add(typename S::B t) { low = least<S>(low, t), high = most<S>(high, t); }
};

/// take(i, value, integral) for each shell. What most matter has, a constant or one straight line, goes without arrays
/// on the way, and without the ends of the line where all shells lie between them; the others leave value and integral
/// in `values` and `integrals` first. Same bits.
template <class S, bool Value, bool Integral, class F>
TALUS_SHAPES_INLINE void each(const BedProperty& p, const double* T, const Range<S>& range, int n, double* values,
                              double* integrals, F take) {
  using B = typename S::B;
  const B first = S::set(p.first);
  if (p.pieces == 0) {
    for (int i = 0; i < n; ++i) take(i, first, first * S::load(T + S::W * i));
  } else if (p.pieces == 1 && p.piece->powers == 1) {
    const BedPiece& a = *p.piece;
    const B low = S::set(a.low), high = S::set(a.high), slope = S::set(*a.power), area = S::set(*a.area);
    if (!S::any(S::lt(range.low, low)) && !S::any(S::gt(range.high, high))) {
      for (int i = 0; i < n; ++i) {
        const B t = S::load(T + S::W * i), x = t - low;
        take(i, first + slope * x, Integral ? first * t + area * x * x : first);
      }
      return;
    }
    for (int i = 0; i < n; ++i) {
      const B t = S::load(T + S::W * i), x = least<S>(most<S>(t, low), high) - low, rise = slope * x;
      B integral = first;
      if constexpr (Integral) integral = first * t + (area * x * x + rise * (most<S>(t, high) - high));
      take(i, first + rise, integral);
    }
  } else {
    evaluate<S, Value, Integral>(p, T, n, values, integrals);
    for (int i = 0; i < n; ++i)
      take(i, Value ? S::load(values + S::W * i) : first, Integral ? S::load(integrals + S::W * i) : first);
  }
}
template <class S>
typename S::B integral(const BedProperty& p, typename S::B T) {
  alignas(64) double at[S::W], h[S::W];
  S::store(at, T);
  evaluate<S, false, true>(p, at, 1, nullptr, h);
  return S::load(h);
}

template <class S>
struct ByKind {
  typename S::B k[k_bed_kinds];
  typename S::B& operator[](int q) { return k[q]; }
  const typename S::B& operator[](int q) const { return k[q]; }
};

/// Shares of the fuel and the moisture that are left, and of the char that was not burnt; see Mixture.
template <class S>
struct Shares {
  typename S::B fuel, moisture, char_left;
};
template <class S>
TALUS_SHAPES_INLINE Shares<S> shares_of(const BedMatter& m, const ByKind<S>& k, typename S::B per_volume,
                                        typename S::B burnt) {
  const auto zero = S::set(0), one = S::set(1);
  Shares<S> s{zero, zero, one};
  s.fuel = k[1] * (S::set(m.per_fuel_density) * per_volume);
  s.moisture = k[0] * (S::set(m.per_moisture_density) * per_volume);
  if (m.chars > 0) {
    const auto all = k[2] + burnt;
    s.char_left = S::select(S::gt(burnt, zero), k[2] / most<S>(all, S::set(1e-300)), one);
  }
  return s;
}
template <class S>
TALUS_SHAPES_INLINE typename S::B volume_share(const BedMatter& m, const Shares<S>& s) {
  const auto one = S::set(1);
  return (one - S::set(m.shrink[0]) * (one - s.moisture)) * (one - S::set(m.shrink[1]) * (one - s.fuel)) *
         (one - S::set(m.shrink[2]) * ((one - s.fuel) * (one - s.char_left)));
}
template <class S>
TALUS_SHAPES_INLINE typename S::B emissivity(const BedMatter& m, const Shares<S>& s) {
  const auto one = S::set(1);
  const auto rest = s.char_left * S::set(m.emissivity[1]) + (one - s.char_left) * S::set(m.emissivity[2]);
  return s.fuel * S::set(m.emissivity[0]) + (one - s.fuel) * rest;
}

template <class S>
TALUS_SHAPES_INLINE typename S::B arrhenius(double A, double n, double E, typename S::B T, typename S::B inverse) {
  const auto e = power_of_two<S>(S::set(-k_per_ln2 * E) * inverse);
  const auto k = S::set(A) * (e.scale + e.more);
  return n == 0 ? k : n == 1 ? k * T : k * power<S>(T, n);
}
/// Of the gas that a reaction makes; `gas`: that of any gas.
template <class S>
TALUS_SHAPES_INLINE typename S::B gas_capacity(const BedReaction& r, typename S::B T, typename S::B gas) {
  return r.own_capacity != 0 ? value<S>(r.gas_capacity, T) : S::set(r.gas_mass) * gas;
}
/// Sensible heat of the gas that a reaction makes, less that of the gas that it takes; `gas`: integral for any gas.
template <class S>
TALUS_SHAPES_INLINE typename S::B gas_sensible(const BedMatter& m, const BedReaction& r, typename S::B T,
                                               typename S::B gas) {
  const bool own = r.own_capacity != 0;
  if (own && r.takes_gas == 0) return integral<S>(r.gas_capacity, T) - S::set(r.own_sensible0);
  const auto rise = gas - S::set(m.gas_sensible0);
  if (!own) return S::set(r.gas_mass - r.takes_gas) * rise;
  return (integral<S>(r.gas_capacity, T) - S::set(r.own_sensible0)) - S::set(r.takes_gas) * rise;
}

template <class S>
TALUS_SHAPES_INLINE typename S::B gas_density(typename S::B T, double pressure, double molar) {
  return S::set(pressure * molar / 8.31446261815324) / T;
}
template <class S>
TALUS_SHAPES_INLINE typename S::B gas_density(typename S::B T, typename S::B pressure, typename S::B molar) {
  return S::set(1 / 8.31446261815324) * pressure * molar / T;
}
template <class S>
TALUS_SHAPES_INLINE typename S::B gas_diffusivity(typename S::B T, typename S::B per_pressure) {
  const auto x = T * S::set(1.0 / 298), root = S::sqrt(x);
  return S::set(2.07e-5 * 101325) * per_pressure * (x * root * S::sqrt(root));
}
template <class S>
TALUS_SHAPES_INLINE typename S::B saturated(const BedMatter& m, typename S::B T, double pressure) {
  const double slope = m.evaporation * 0.018015 / 8.31446261815324;
  return gas_density<S>(T, pressure, 0.018015) * exponential<S>(S::set(slope / m.boiling) - S::set(slope) / T);
}
/// B / (exp(B) - 1), the share of a film's coefficient that a net outflow leaves.
template <class S>
TALUS_SHAPES_INLINE typename S::B blown(typename S::B x) {
  const auto b = clamped<S>(x, S::set(1e-6), S::set(600));
  return b / (exponential<S>(b) - S::set(1));
}
template <class S>
TALUS_SHAPES_INLINE typename S::B steady(typename S::B x) {
  const auto y = least<S>(x, S::set(2)), one = S::set(1);
  return y * (one + y * (S::set(0.5) + y * S::set(1.0 / 3)));
}

template <class S>
TALUS_SHAPES_INLINE typename S::B sutherland(double at_ice, double constant, typename S::B T) {
  const auto x = T * S::set(1 / 273.15);
  return S::set(at_ice * (273.15 + constant)) * x * S::sqrt(x) / (T + S::set(constant));
}
template <class S>
TALUS_SHAPES_INLINE typename S::B transfer_number(int law, typename S::B Re, typename S::B Pr) {
  const auto some = most<S>(Re, S::set(1e-30)), two = S::set(2);
  if (law == 0) return two + S::set(0.6) * S::sqrt(Re) * power<S>(Pr, 1.0 / 3);
  if (law == 1) return two + (S::set(0.4) * S::sqrt(Re) + S::set(0.06) * power<S>(some, 2.0 / 3)) * power<S>(Pr, 0.4);
  return two + S::set(1.1) * power<S>(some, 0.6) * power<S>(Pr, 1.0 / 3);
}
/// Heat transfer coefficient [W/m2/K] and that of mass [m/s] of a grain of diameter d at the film's temperature T.
template <class S>
typename S::B film_coefficients(const BedMatter& m, typename S::B d, typename S::B u, typename S::B T,
                                typename S::B pressure, typename S::B& mass_film) {
  using B = typename S::B;
  const B mu = sutherland<S>(m.viscosity, m.viscosity_S, T);
  const B k = sutherland<S>(m.gas_conductivity, m.gas_conductivity_S, T);
  const B cp = S::set(m.gas_heat) + S::set(m.gas_heat_slope) * (T - S::set(300));
  const B rho = gas_density<S>(T, pressure, S::set(m.gas_molar)), per = S::set(1) / d;
  const B Re = rho * u * d / mu;
  mass_film = S::set(0);
  if (m.chars > 0 || m.dries != 0) {
    const B D = gas_diffusivity<S>(T, S::set(1) / pressure);
    mass_film = transfer_number<S>(m.film_law, Re, mu / (rho * D)) * D * per;
  }
  return transfer_number<S>(m.film_law, Re, mu * cp / k) * k * per;
}

template <class S>
struct CharGas {
  typename S::B oxidant, carbon_monoxide, carbon_dioxide, hydrogen, heat;
};
/// Share of the carbon that oxygen turns into CO; 0 with other oxidants.
template <class S>
TALUS_SHAPES_INLINE typename S::B monoxide_share(const BedChar& r, typename S::B inverse) {
  if (r.oxidant != 0) return S::set(0);
  const auto e = power_of_two<S>(S::set(-k_per_ln2 * r.ratio_E) * inverse);
  const auto ratio = S::set(r.ratio_A) * (e.scale + e.more);
  return ratio / (S::set(1) + ratio);
}
/// As char_yield of around.hpp, per kg of carbon; x: monoxide_share.
template <class S>
TALUS_SHAPES_INLINE CharGas<S> yield_of(const BedChar& r, typename S::B x) {
  using B = typename S::B;
  constexpr double per_kg = 1 / 0.012011;
  const B none = S::set(0), one = S::set(1);
  if (r.oxidant == 0) {
    const B rest = one - x;
    return {S::set(0.0319988 * per_kg) * (one - S::set(0.5) * x), S::set(0.0280104 * per_kg) * x,
            S::set(0.0440098 * per_kg) * rest, none, S::set(110.5e3 * per_kg) * x + S::set(393.5e3 * per_kg) * rest};
  }
  if (r.oxidant == 1)
    return {S::set(0.0440098 * per_kg), S::set(2 * 0.0280104 * per_kg), none, none,
            S::set((2 * 110.5e3 - 393.5e3) * per_kg)};
  return {S::set(0.01801528 * per_kg), S::set(0.0280104 * per_kg), none, S::set(0.00201588 * per_kg),
          S::set((110.5e3 - 241.8e3) * per_kg)};
}

/// Working arrays of a vector, [..][shell][lane]: of the shells; by kind (sensible, before, specific); by solid that
/// something makes (made) or consumes (gone, per, their product share, grow, released); by reaction; `total`: extents
/// of the reactions over all shells.
template <class S>
struct Work {
  BedRow place;
  double *capacity, *conductance, *drying, *heat, *slope, *flow, *plateau, *sink, *next, *upper, *inverse;
  double *gas, *gas_heat;
  double *sensible, *before, *specific;
  double *made, *gone, *per, *share, *grow, *released;
  double *burning, *monoxide, *rate, *total;
  Work(const BedMatter& m, double* from) : place(bed_row(m)) {
    const auto take = [&](long columns) {
      double* at = from;
      from += columns * m.shells * S::W;
      return at;
    };
    for (double** x : {&capacity, &conductance, &drying, &heat, &slope, &flow, &plateau, &sink, &next, &upper, &inverse,
                       &gas, &gas_heat})
      *x = take(1);
    for (double** x : {&sensible, &before, &specific}) *x = take(k_bed_kinds);
    made = take(m.growing);
    for (double** x : {&gone, &per, &share, &grow, &released}) *x = take(m.turning);
    burning = take(m.chars);
    monoxide = take(m.chars);
    rate = take(m.reactions);
    total = from;
  }
};

}  // namespace talus::conversion::bed
