// See combustion.hpp. Each reaction in turn, implicit in its extent: xi = dt * rate(concentrations after xi). The rate
// falls with xi while temperature is held, so that there is one root, between nothing and the reactant that ends first.
#include "core/gas/combustion.hpp"

#include "core/base/det_math.hpp"
#include "core/base/types.hpp"
#include "core/gas/species.hpp"

namespace talus::gas {

namespace {

constexpr int O2 = 0, CO = 2, H2O = 3, H2 = 4, CH4 = 5, TAR = 6;
constexpr int k_reactions = 4;
constexpr int k_fuel[k_reactions] = {CO, H2, CH4, TAR};
constexpr double k_change[k_reactions][k_gas_species] = {
    // O2, CO2, CO, H2O, H2, CH4, tar, N2 per fuel [mol]
    {-0.5, 1, -1, 0, 0, 0, 0, 0},
    {-0.5, 0, 0, 1, -1, 0, 0, 0},
    {-1.5, 0, 1, 2, 0, -1, 0, 0},
    {-4.5, 0, 6, 3, 0, 0, -1, 0},
};
constexpr double k_most_heating = 20;  // of one step within [K]
constexpr int k_most_steps = 4000;

double arrhenius(double factor, double energy, double t) { return factor * det::exp(-energy / (k_gas_constant * t)); }

/// x^y, 0 at 0.
double power(double x, double y) { return x > 0 ? det::pow(x, y) : 0; }

/// The part of a rate that the temperature alone decides.
double rate_constant(int r, double t) {
  switch (r) {
    case 0:
      return arrhenius(1.3e8, 125520, t);
    case 1:
      return arrhenius(1.8e10, 146450, t);
    case 2:
      return arrhenius(1.585e10, 202506, t);
    default:
      return arrhenius(7.59e6, 125520, t);
  }
}

double rate_of(int r, double constant, const GasFractions& c) {
  const auto at = [&](int k) { return fmax2(0, c[static_cast<std::size_t>(k)]); };
  if (!(at(O2) > 0) || !(at(k_fuel[r]) > 0)) return 0;
  switch (r) {
    case 0:
      return constant * at(CO) * __builtin_sqrt(at(H2O) * at(O2));
    case 1:
      return constant * at(H2) * __builtin_sqrt(at(O2));
    case 2:
      return constant * power(at(CH4), 0.7) * power(at(O2), 0.8);
    default: {
      // the published order of -0.1 would let the rate rise without bound as tar runs out
      const double tar = fmax2(at(TAR), 0.1);
      return constant * power(tar, -0.1) * fmin2(1, at(TAR) / 0.1) * power(at(O2), 1.85);
    }
  }
}

}  // namespace

double burning_rate(int r, const GasFractions& c, double t) noexcept { return rate_of(r, rate_constant(r, t), c); }

namespace {

/// Of the x where a falling rate(x) equals x, between 0 and high: rate(x) > x up to `low`, rate(x) < x from `high` on,
/// with a margin of 1e-13, twenty times what rates are rounded by.
struct Bracket {
  double low, high;
};
template <class Rate>
Bracket bracket(const Rate& rate, double now, double high) {
  constexpr double close = 1e-13;
  double a = 0, b = high, at_a = now, at_b = rate(high) - high;
  if (at_b > 0) return {0, high};  // nothing known
  for (int q = 0, side = 0; q < 40 && b - a > 2 * close * b; ++q) {
    const double x = fmax2(a + close * b, fmin2((a * at_b - b * at_a) / (at_b - at_a), b - close * b));
    const double y = rate(x) - x;
    if (y > 0) {
      a = x, at_a = y;
      if (side == 1) at_b *= 0.5;  // the same side again: the other end counts half
      side = 1;
    } else {
      b = x, at_b = y;
      if (side == -1) at_a *= 0.5;
      side = -1;
    }
  }
  return {a - close * b, b + close * b};
}

/// Extent of reaction r over tau, per volume [mol/m3], by halving; a bracket spares most of the rates.
double extent(int r, const GasFractions& c, double t, double tau) {
  double most = 1e300;
  for (int k = 0; k < k_gas_species; ++k)
    if (k_change[r][k] < 0) most = fmin2(most, c[static_cast<std::size_t>(k)] / -k_change[r][k]);
  if (!(most > 0)) return 0;
  const double constant = rate_constant(r, t), now = tau * rate_of(r, constant, c);
  if (!(now > 0)) return 0;
  const auto rate = [&](double x) {
    GasFractions after = c;
    for (int k = 0; k < k_gas_species; ++k)
      if (k_change[r][k] < 0) after[static_cast<std::size_t>(k)] += k_change[r][k] * x;
    return tau * rate_of(r, constant, after);
  };
  double low = 0, high = fmin2(most, now);
  const Bracket known = bracket(rate, now, high);
  for (int q = 0; q < 60 && high - low > 1e-14 * high; ++q) {
    const double middle = 0.5 * (low + high);
    const bool more = middle <= known.low || (middle < known.high && rate(middle) > middle);
    (more ? low : high) = middle;
  }
  return low;
}

/// All reactions in turn over tau; masses after it.
GasFractions burnt(const GasFractions& mass, double t, double volume, double tau) {
  GasFractions moles;
  for (int k = 0; k < k_gas_species; ++k)
    moles[static_cast<std::size_t>(k)] = mass[static_cast<std::size_t>(k)] / species(k).molar_mass;
  GasFractions change{};
  for (int r = 0; r < k_reactions; ++r) {
    GasFractions c;
    for (std::size_t k = 0; k < c.size(); ++k) c[k] = (moles[k] + change[k]) / volume;
    const double xi = extent(r, c, t, tau) * volume;
    for (std::size_t k = 0; k < c.size(); ++k) change[k] += k_change[r][k] * xi;
  }
  GasFractions after = mass;
  for (int k = 0; k < k_gas_species; ++k) {
    double& m = after[static_cast<std::size_t>(k)];
    m = fmax2(0, m + change[static_cast<std::size_t>(k)] * species(k).molar_mass);
  }
  return after;
}

}  // namespace

double burn(GasFractions& mass, double h, double t, double pressure, double dt) noexcept {
  const auto temperature = [&](const GasFractions& m, double guess) {
    double total = 0;
    for (const double x : m) total += x;
    GasFractions y = m;
    for (double& x : y) x /= total;
    return temperature_of(y, h / total, guess);
  };
  const auto moles = [](const GasFractions& m) {
    double n = 0;
    for (int k = 0; k < k_gas_species; ++k) n += m[static_cast<std::size_t>(k)] / species(k).molar_mass;
    return n;
  };
  double left = dt, tau = dt;
  for (int q = 0; q < k_most_steps && left > 0; ++q) {
    tau = fmin2(tau, left);
    const double volume = moles(mass) * k_gas_constant * t / pressure;
    const GasFractions after = burnt(mass, t, volume, tau);
    const double hot = temperature(after, t);
    if (hot - t > k_most_heating && q < k_most_steps - 1 && tau > 1e-9 * dt) {
      tau *= 0.5;
      continue;
    }
    const bool slow = hot - t < 0.25 * k_most_heating;
    mass = after;
    t = hot;
    left -= tau;
    if (slow) tau *= 2;
  }
  return t;
}

}  // namespace talus::gas
