// See cell_gases.hpp. Elements are those of a mixture per kg of the reactant: C, H, O; water counts as H2O.
#include "core/conversion/cell_gases.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/det_math.hpp"
#include "core/base/error.hpp"
#include "core/gas/species.hpp"

namespace talus::conversion {
namespace {

constexpr int k_parts = 3;  // C, H, O
using Elements = std::array<double, k_parts>;
constexpr double k_weight[k_parts] = {12.011e-3, 1.00794e-3, 15.9994e-3};  // as core/gas [kg/mol]
constexpr double k_rounding = 1e-9;                                        // negative masses that are none [kg/kg]

constexpr int O2 = 0, CO2 = 1, CO = 2, H2O = 3, H2 = 4, CH4 = 5, TAR = 6;
/// Mixtures of three that hold any elements; the first without a negative share counts.
constexpr int k_mixtures[][k_parts] = {{CO, CO2, CH4},  {TAR, CO, H2O}, {CO, H2O, CH4}, {CO, CO2, H2},  {CO2, H2O, CH4},
                                       {CO, H2, CH4},   {TAR, CO, CO2}, {TAR, CO, CH4}, {CO2, H2O, H2}, {CO, H2O, H2},
                                       {TAR, H2O, CH4}, {TAR, CO, H2},  {CO, CO2, H2O}, {O2, CO2, H2O}};

/// Mass of an element in a kg of a species.
double share(int species, int element) {
  const gas::SpeciesInfo& s = gas::species(species);
  return s.atoms[element] * k_weight[element] / s.molar_mass;
}

int species_of(const std::string& name) {
  if (name == "vapour") return H2O;
  for (int k = 0; k < k_gas_species; ++k)
    if (gas::species(k).name == name) return k;
  return -1;
}

/// Masses of three species with these elements [kg]; false where they hold no such mixture.
bool solve(const int* of, const Elements& e, std::array<double, k_parts>& mass) {
  double a[k_parts][k_parts + 1];
  for (int r = 0; r < k_parts; ++r) {
    for (int c = 0; c < k_parts; ++c) a[r][c] = share(of[c], r);
    a[r][k_parts] = e[static_cast<std::size_t>(r)];
  }
  for (int c = 0; c < k_parts; ++c) {
    int best = c;
    for (int r = c + 1; r < k_parts; ++r)
      if (std::fabs(a[r][c]) > std::fabs(a[best][c])) best = r;
    if (std::fabs(a[best][c]) < 1e-12) return false;
    std::swap(a[c], a[best]);
    for (int r = 0; r < k_parts; ++r) {
      if (r == c) continue;
      const double f = a[r][c] / a[c][c];
      for (int q = c; q <= k_parts; ++q) a[r][q] -= f * a[c][q];
    }
  }
  for (int r = 0; r < k_parts; ++r) mass[static_cast<std::size_t>(r)] = a[r][k_parts] / a[r][r];
  return true;
}

/// Adds a mixture with these elements to `to`, of which nothing may become negative; with `nearest` the one that
/// changes least, else the first that fits.
bool add_mixture(const Elements& e, bool tar_first, bool nearest, GasFractions& to) {
  double least = 1e300;
  GasFractions found{};
  constexpr int n = static_cast<int>(std::size(k_mixtures));
  for (int q = 0; q < n; ++q) {
    const int* of = k_mixtures[tar_first && q < 2 ? 1 - q : q];
    std::array<double, k_parts> mass{};
    if (!solve(of, e, mass)) continue;
    GasFractions y = to;
    double change = 0, low = 0;
    for (int k = 0; k < k_parts; ++k) {
      const auto s = static_cast<std::size_t>(of[k]);
      y[s] += mass[static_cast<std::size_t>(k)];
      change += std::fabs(mass[static_cast<std::size_t>(k)]);
      low = std::min(low, y[s]);
      y[s] = std::max(y[s], 0.0);
    }
    if (low < -k_rounding || change >= least) continue;
    least = nearest ? change : 0;
    found = y;
  }
  if (least < 1e300) to = found;
  return least < 1e300;
}

/// What leaves the solids in a reaction, per kg of its reactant.
Elements leaving(const Matter& m, const Reaction& r) {
  Composition e = *m.solids[r.reactant].composition;
  for (const Yield& y : r.solids)
    for (std::size_t k = 0; k < k_elements; ++k) e[k] -= y.mass * (*m.solids[y.species].composition)[k];
  if (std::fabs(e[ash_element]) > 1e-12)
    throw Error(ErrorCode::scene, fmt::format("ash leaves with the gas of '{}'", r.name), "reaction",
                "products that hold the ash of the reactant");
  const double water_h = share(H2O, 1);
  return {e[carbon], e[hydrogen] + water_h * e[water], e[oxygen] + (1 - water_h) * e[water]};
}

GasFractions gases_of(const Matter& m, const Reaction& r) {
  const Elements e = leaving(m, r);
  GasFractions y{};
  bool others = false, tar = false;
  for (const Yield& g : r.gases) {
    const int k = species_of(m.gases[g.species].name);
    const bool own = k >= 0 && k < TAR && g.mass > 0;
    if (own) y[static_cast<std::size_t>(k)] += g.mass;
    others = others || !own;
    tar = tar || k == TAR;
  }
  Elements rest = e;
  for (int k = 0; k < k_gas_species; ++k)
    for (int q = 0; q < k_parts; ++q) rest[static_cast<std::size_t>(q)] -= y[static_cast<std::size_t>(k)] * share(k, q);
  if (!add_mixture(rest, tar, !others, y))
    throw Error(
        ErrorCode::scene,
        fmt::format("'{}' would release {:.4g} kg of C, {:.4g} of H, {:.4g} of O per kg, of which no mixture of "
                    "CO, CO2, H2O, H2, CH4 and tar consists",
                    r.name, e[0], e[1], e[2]),
        "reaction", "products, or compositions of its solids, that leave such a mixture");
  return y;
}

constexpr double k_standard = 298.15;  // of the enthalpies of formation [K]
constexpr double k_slow = 0.01;        // rate at the temperature of reaction [1/s]

double above_standard(const GasFractions& y, double T) { return gas::enthalpy(y, T) - gas::enthalpy(y, k_standard); }

/// Sensible heat of a solid, as the solver counts it [J/kg].
double sensible(const Matter& m, Kind kind, double T) {
  const Property& c = m.heat_capacity[static_cast<std::size_t>(kind)];
  return c.integral(T) - (m.reference_temperature ? c.integral(*m.reference_temperature) : 0);
}

/// Where its rate constant is k_slow [K].
double temperature_of(const Reaction& r) {
  double T = 600;
  for (int k = 0; k < 60; ++k) {
    const double scale = r.A * det::pow(T, r.n) / k_slow;
    if (!(scale > 1) || !(r.E > 0)) return 600;
    T = std::clamp(r.E / (k_gas_constant * det::log(scale)), k_standard, 2000.0);
  }
  return T;
}

/// Heat capacity of a mixture: the polynomial of fourth degree through five temperatures.
Property capacity_of(const GasFractions& y) {
  constexpr int n = 5;
  constexpr double low = 300, high = 1700;
  double c[n];
  for (int k = 0; k < n; ++k) c[k] = gas::heat_capacity(y, low + (high - low) * k / (n - 1));
  for (int j = 1; j < n; ++j)  // Newton's divided differences, then their polynomial about `low`
    for (int k = n - 1; k >= j; --k) c[k] = (c[k] - c[k - 1]) / ((high - low) * j / (n - 1));
  std::vector<double> a{c[n - 1]};
  for (int k = n - 2; k >= 0; --k) {
    const double at = (high - low) * k / (n - 1);
    a.push_back(0);
    for (std::size_t q = a.size() - 1; q > 0; --q) a[q] = a[q - 1] - at * a[q];
    a[0] = c[k] - at * a[0];
  }
  return Property::polynomial(a, low, low, high);
}

/// See cell_gases.hpp.
void set_heats(Matter& m, Reaction& r, const GasFractions& y) {
  r.gas_capacity = capacity_of(y);
  if (m.reference_temperature && !r.at_reaction) {
    r.to_cells = above_standard(y, *m.reference_temperature);
    return;
  }
  const double T = temperature_of(r);
  r.to_cells = above_standard(y, T) - sensible(m, m.solids[r.reactant].kind, T);
  for (const Yield& s : r.solids) r.to_cells += s.mass * sensible(m, m.solids[s.species].kind, T);
}

/// A reaction that makes char alone of its reactant, as in schemes of parallel reactions: char then has the elements of
/// the reactant, since carbon alone would have to come from the gas of the others.
void complete_char(Matter& m) {
  for (const Reaction& r : m.reactions) {
    if (r.of_gas || r.gases.size() + r.solids.size() != 1 || r.solids.size() != 1) continue;
    if (m.solids[r.solids[0].species].kind != Kind::char_ || m.solids[r.reactant].kind != Kind::fuel) continue;
    const Composition c = *m.solids[r.reactant].composition;
    for (Solid& s : m.solids)
      if (s.kind == Kind::char_) s.composition = c;
    return;
  }
}

}  // namespace

double formation_enthalpy(int species) { return gas::enthalpy(species, k_standard); }
double formation_of(const std::string& species) {
  const int k = species_of(species);
  return k < 0 ? 0 : formation_enthalpy(k);
}

void settle_char(Matter& m) {
  if (m.char_reactions.empty()) return;
  const Solid* first = nullptr;
  for (const Solid& s : m.solids) {
    if (s.kind != Kind::char_) continue;
    if (first == nullptr) first = &s;
    const Composition &c = *s.composition, &d = *first->composition;
    const double steam = c[oxygen] / share(H2O, 2), rest = c[hydrogen] - steam * share(H2O, 1);
    if (!(c[carbon] > 0) || c[ash_element] != 0 || c[water] != 0 || c != d || rest < -k_rounding)
      throw Error(ErrorCode::scene,
                  fmt::format("'{}' burns, and is not carbon, hydrogen and oxygen of its steam alone", s.name),
                  "char_reaction", "char of one composition, { C = 1 } or with at most 7.9 kg of O per kg of H");
    m.char_carbon = c[carbon];
    m.char_steam = steam;
    m.char_hydrogen = std::max(rest, 0.0);
  }
}

Matter with_cell_gases(const Matter& matter) {
  Matter m = matter;
  complete_char(m);
  for (const Reaction& r : m.reactions)
    if (r.of_gas)
      throw Error(ErrorCode::scene, fmt::format("'{}' is a reaction of gas within the grain", r.name), "reaction",
                  "none of them beside [gas], where tar burns in the cells");
  settle_char(m);
  std::vector<GasFractions> gases;
  for (const Reaction& r : m.reactions) gases.push_back(gases_of(m, r));
  m.gases.clear();
  for (int k = 0; k < k_gas_species; ++k) {
    Composition c{};
    for (int q = 0; q < k_parts; ++q) c[static_cast<std::size_t>(q)] = share(k, q);
    m.gases.push_back({std::string(gas::species(k).name), c});
  }
  for (std::size_t r = 0; r < m.reactions.size(); ++r) {
    const GasFractions y = gases[r];
    m.reactions[r].gases.clear();
    for (std::size_t k = 0; k < y.size(); ++k)
      if (y[k] > 0) m.reactions[r].gases.push_back({k, y[k]});
    set_heats(m, m.reactions[r], y);
  }
  for (CharReaction& r : m.char_reactions) r.to_cells = -sensible(m, Kind::char_, k_standard);
  GasFractions steam{};
  steam[H2O] = 1;
  m.drying.to_cells = above_standard(steam, m.drying.temperature) - sensible(m, Kind::moisture, m.drying.temperature);
  if (m.vapour || m.char_steam > 0) m.vapour = H2O;
  if (m.carbon_monoxide) m.carbon_monoxide = CO;
  if (m.carbon_dioxide) m.carbon_dioxide = CO2;
  if (m.hydrogen || m.char_hydrogen > 0) m.hydrogen = H2;
  return m;
}

}  // namespace talus::conversion
