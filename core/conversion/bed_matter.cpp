// See bed_matter.hpp.
#include "core/conversion/bed_matter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <vector>

#include "core/base/det_math.hpp"
#include "core/base/error.hpp"
#include "core/conversion/film.hpp"
#include "core/conversion/kinetics.hpp"

namespace talus::conversion {

/// Deques: what has been handed out stays in place.
struct BedTables::Arrays {
  BedMatter m{};
  std::vector<int> kind, first, of_kind, turns, grows;
  std::vector<std::array<double, k_bed_elements>> compositions;
  std::vector<double> density, volume, per_volume, cold, still;
  std::vector<BedReaction> reactions;
  std::vector<BedChar> chars;
  std::deque<std::vector<BedYield>> yields;
  std::deque<std::vector<BedPiece>> pieces;
  std::deque<std::vector<double>> numbers;

  BedProperty property(const Property& p) {
    std::vector<BedPiece> own;
    for (const auto& piece : p.pieces()) {
      numbers.push_back(piece.power);
      const double* power = numbers.back().data();
      std::vector<double> area;
      for (std::size_t k = 0; k < piece.power.size(); ++k) area.push_back(piece.power[k] / static_cast<double>(k + 2));
      numbers.push_back(std::move(area));
      own.push_back({piece.low, piece.high, static_cast<int>(piece.power.size()), power, numbers.back().data()});
    }
    pieces.push_back(std::move(own));
    return {p.first(), static_cast<int>(pieces.back().size()), pieces.back().data()};
  }
  const BedYield* yields_of(const std::vector<Yield>& list) {
    std::vector<BedYield> own;
    for (const Yield& y : list) own.push_back({static_cast<int>(y.species), y.mass});
    yields.push_back(std::move(own));
    return yields.back().data();
  }
};

namespace {

constexpr double k_cold_rate = 1e-10;  // [1/s]: in an hour less than a part in a million
constexpr double k_trace = 1e-15;      // of a shell's first mass: less than its rounding error

int index_or_none(const std::optional<std::size_t>& i) { return i ? static_cast<int>(*i) : -1; }

/// Temperature at which A T^n exp(-E/T) reaches `rate` [K]; 0 where it is faster at every temperature.
double temperature_of(double A, double n, double E, double rate) {
  if (E <= 0) return 0;
  double T = 300;
  for (int k = 0; k < 60; ++k) {
    const double scale = A * det::pow(T, n) / rate;
    if (scale <= 1) return 1e4;
    T = std::min(E / det::log(scale), 1e4);
  }
  return 0.999 * T;
}

}  // namespace

struct BedBuilder {
  static BedReaction reaction(const Matter& m, const Reaction& r, BedTables::Arrays& a) {
    BedReaction out{};
    out.reactant = static_cast<int>(r.reactant);
    out.A = r.A;
    out.n = r.n;
    out.E = r.E / k_gas_constant;
    out.heat = -r.heat;
    out.standard = r.to_cells - r.heat;
    out.solids = static_cast<int>(r.solids.size());
    out.gases = static_cast<int>(r.gases.size());
    out.solid = a.yields_of(r.solids);
    out.gas = a.yields_of(r.gases);
    const Composition leaving = elements_leaving(m, r);
    std::copy(leaving.begin(), leaving.end(), out.leaving);
    if (!r.of_gas) out.by_kind[static_cast<int>(m.solids[r.reactant].kind)] += 1;
    for (const Yield& y : r.solids) out.by_kind[static_cast<int>(m.solids[y.species].kind)] -= y.mass;
    for (const Yield& y : r.gases) out.gas_mass += y.mass;
    out.takes_gas = r.of_gas ? 1 : 0;
    out.own_capacity = r.gas_capacity ? 1 : 0;
    out.refers = m.reference_temperature && !r.at_reaction ? 1 : 0;
    if (r.gas_capacity) out.gas_capacity = a.property(*r.gas_capacity);
    if (r.gas_capacity && m.reference_temperature)
      out.own_sensible0 = r.gas_capacity->integral(*m.reference_temperature);
    return out;
  }

  static void species(const Matter& m, BedTables::Arrays& a) {
    BedMatter& b = a.m;
    b.moisture = -1;
    for (std::size_t s = 0; s < m.solids.size(); ++s) {
      const Solid& x = m.solids[s];
      const int kind = static_cast<int>(x.kind);
      a.kind.push_back(kind);
      a.compositions.push_back(*x.composition);
      a.density.push_back(m.density * x.initial);
      b.present[kind] = 1;
      b.trace += k_trace * a.density.back();
      if (x.kind == Kind::fuel) b.fuel_density += a.density.back();
      if (x.kind == Kind::moisture) {
        b.moisture = static_cast<int>(s);
        b.moisture_density = a.density.back();
      }
    }
    for (int k = 0; k < k_bed_kinds; ++k) {
      b.first_of_kind[k] = static_cast<int>(a.of_kind.size());
      for (std::size_t s = 0; s < m.solids.size(); ++s)
        if (a.kind[s] == k) a.of_kind.push_back(static_cast<int>(s));
    }
    b.first_of_kind[k_bed_kinds] = static_cast<int>(a.of_kind.size());
    b.per_fuel_density = b.fuel_density > 0 ? 1 / b.fuel_density : 0;
    b.per_moisture_density = b.moisture_density > 0 ? 1 / b.moisture_density : 0;
    b.solids = static_cast<int>(m.solids.size());
    b.gases = static_cast<int>(m.gases.size());
    b.vapour = index_or_none(m.vapour);
    b.carbon_monoxide = index_or_none(m.carbon_monoxide);
    b.carbon_dioxide = index_or_none(m.carbon_dioxide);
    b.hydrogen = index_or_none(m.hydrogen);
  }

  static void reactions(const Matter& m, BedTables::Arrays& a) {
    for (std::size_t s = 0; s < m.solids.size(); ++s) {
      a.first.push_back(static_cast<int>(a.reactions.size()));
      double cold = 1e4, still = 1e4;
      for (const Reaction& r : m.reactions) {
        if (r.of_gas || r.reactant != s) continue;
        a.reactions.push_back(reaction(m, r, a));
        const BedReaction& x = a.reactions.back();
        cold = std::min(cold, temperature_of(x.A, x.n, x.E, k_cold_rate));
        still = std::min(still, temperature_of(x.A, x.n, x.E, 0.01));
      }
      a.cold.push_back(cold);
      a.still.push_back(still);
    }
    a.first.push_back(static_cast<int>(a.reactions.size()));
    a.m.secondary = a.first.back();
    for (const Reaction& r : m.reactions)
      if (r.of_gas) a.reactions.push_back(reaction(m, r, a));
    a.m.reactions = static_cast<int>(a.reactions.size());
    for (const CharReaction& r : m.char_reactions)
      a.chars.push_back({static_cast<int>(r.oxidant), r.A, r.n, r.E / k_gas_constant, r.ratio_A,
                         r.ratio_E / k_gas_constant, r.to_cells});
    a.m.chars = static_cast<int>(a.chars.size());
  }

  static void properties(const Matter& m, BedTables::Arrays& a) {
    BedMatter& b = a.m;
    for (int k = 0; k < k_bed_kinds; ++k) {
      const auto at = static_cast<std::size_t>(k);
      b.capacity[k] = a.property(m.heat_capacity[at]);
      b.conductivity[k] = a.property(k == 0 ? m.conductivity_wet : m.conductivity[at]);
      if (m.reference_temperature) b.sensible0[k] = m.heat_capacity[at].integral(*m.reference_temperature);
    }
    b.gas_capacity = a.property(m.gas_heat_capacity);
    if (m.reference_temperature) b.gas_sensible0 = m.gas_heat_capacity.integral(*m.reference_temperature);
    b.least_conductivity = m.least_conductivity;
    b.by_mass = m.conductivity_by_mass ? 1 : 0;
    b.convects = m.gas_convection ? 1 : 0;
    b.blows = m.blowing ? 1 : 0;
    b.carries = m.gas_convection || m.blowing || b.secondary < b.reactions ? 1 : 0;
    b.asks_gas = b.carries;
    for (const BedReaction& r : a.reactions)
      if (r.refers != 0) b.asks_gas = 1;
    std::copy(m.emissivity.begin(), m.emissivity.end(), b.emissivity);
    b.porosity = m.porosity;
    b.pores = m.porosity * m.tortuosity_factor;
    const bool equilibrium = m.drying.kind == Drying::equilibrium;
    b.boils = b.moisture >= 0 && (equilibrium || m.drying.kind == Drying::boiling) ? 1 : 0;
    b.dries = b.moisture >= 0 && equilibrium ? 1 : 0;
    b.boiling = m.drying.temperature;
    b.evaporation = m.drying.heat;
    b.per_evaporation = 1 / m.drying.heat;
    b.vapour_to_cells = m.drying.to_cells;
    b.char_carbon = m.char_carbon;
    b.char_steam = m.char_steam;
    b.char_hydrogen = m.char_hydrogen;
    b.shrink[0] = m.shrinkage.drying;
    b.shrink[1] = m.shrinkage.devolatilisation;
    b.shrink[2] = m.shrinkage.burn_off;
  }
};

/// Which solids are consumed and which are made; kinds that never change need no account of their own.
void count_changes(BedTables::Arrays& a) {
  BedMatter& b = a.m;
  std::vector<bool> made(a.kind.size(), false);
  for (const BedReaction& r : a.reactions)
    for (int y = 0; y < r.solids; ++y) made[static_cast<std::size_t>(r.solid[y].species)] = true;
  for (std::size_t s = 0; s < a.kind.size(); ++s) {
    const bool moist = static_cast<int>(s) == b.moisture;
    const bool turns = a.first[s] < a.first[s + 1] || (a.kind[s] == 2 && b.chars > 0) || (b.dries != 0 && moist);
    a.turns.push_back(turns ? b.turning++ : -1);
    a.grows.push_back(made[s] ? b.growing++ : -1);
    if (turns || made[s] || (b.boils != 0 && moist)) b.changes[a.kind[s]] = 1;
    if (made[s]) b.grown[a.kind[s]] = 1;
  }
}

BedRow bed_row(const BedMatter& m) {
  BedRow r{};
  const int n = m.shells;
  r.debt = n;
  r.face = 2 * n;
  r.mass = 3 * n;
  r.burnt = r.mass + m.solids * n;
  r.radius0 = r.burnt + (m.chars > 0 ? n : 0);
  r.surface = r.radius0 + 1;
  r.carried = r.radius0 + 2;
  r.outflow = r.radius0 + 3;
  r.size = (r.radius0 + 4 + 7) / 8 * 8;
  return r;
}

long bed_work(const BedMatter& m) {
  return static_cast<long>(m.shells) * (3 * k_bed_kinds + 13 + 2 * m.chars + m.reactions + m.growing + 5L * m.turning) +
         m.reactions;
}
long bed_scratch(const BedMatter& m) { return 8 * (bed_work(m) + bed_row(m).size); }

BedTables::BedTables(const Matter& matter, int shells, const GasKind& gas, FilmLaw law)
    : a_(std::make_unique<Arrays>()) {
  const auto refuse = [](const std::string& what, const std::string& cure) {
    throw Error(ErrorCode::scene, what, "grains in a bed", cure);
  };
  if (matter.melting.latent > 0) refuse("matter that melts is for single grains only", "no [melting]");
  if (shells < 1 || shells > k_bed_shells)
    refuse(fmt::format("{} shells", shells), fmt::format("1 to {}", k_bed_shells));
  if (matter.solids.size() > k_bed_solids || matter.gases.size() > k_bed_gases)
    refuse(fmt::format("{} solids and {} gases", matter.solids.size(), matter.gases.size()),
           fmt::format("at most {} and {}", k_bed_solids, k_bed_gases));
  BedMatter& b = a_->m;
  b.shells = shells;
  BedBuilder::species(matter, *a_);
  BedBuilder::reactions(matter, *a_);
  BedBuilder::properties(matter, *a_);
  count_changes(*a_);
  const double n3 = static_cast<double>(shells) * shells * shells;
  for (int i = 0; i < shells; ++i) a_->volume.push_back(4.0 / 3.0 * det::k_pi * (3.0 * i * i + 3.0 * i + 1) / n3);
  for (const double v : a_->volume) a_->per_volume.push_back(1 / v);
  b.kind = a_->kind.data();
  b.of_kind = a_->of_kind.data();
  b.turns = a_->turns.data();
  b.grows = a_->grows.data();
  b.per_volume = a_->per_volume.data();
  b.composition = reinterpret_cast<const double(*)[k_bed_elements]>(a_->compositions.data());
  b.density = a_->density.data();
  b.volume = a_->volume.data();
  b.reaction = a_->reactions.data();
  b.first = a_->first.data();
  b.cold = a_->cold.data();
  b.still = a_->still.data();
  b.burning = a_->chars.data();
  b.gas_molar = gas.molar;
  b.viscosity = gas.viscosity;
  b.viscosity_S = gas.viscosity_S;
  b.gas_conductivity = gas.conductivity;
  b.gas_conductivity_S = gas.conductivity_S;
  b.gas_heat = gas.heat_capacity;
  b.gas_heat_slope = gas.heat_capacity_slope;
  b.film_law = static_cast<int>(law);
}
BedTables::~BedTables() = default;
const BedMatter& BedTables::matter() const { return a_->m; }

double BedTables::thinnest_shell() const {
  double inside = 0, face = 0, least = 1;
  for (int k = 0; k < matter().shells; ++k) {
    inside += matter().volume[k];
    const double next = det::cbrt(inside * (0.75 / 3.141592653589793));
    least = std::min(least, next - face);
    face = next;
  }
  return least;
}

void BedTables::begin(double radius, double temperature, double* row) const {
  const BedMatter& m = a_->m;
  const BedRow at = bed_row(m);
  const int n = m.shells;
  std::fill(row, row + at.size, 0.0);
  for (int i = 0; i < n; ++i) {
    row[at.temperature + i] = temperature;
    row[at.face + i] = radius * (i + 1) / n;
    for (int s = 0; s < m.solids; ++s)
      row[at.mass + s * n + i] = m.density[s] * (m.volume[i] * (radius * radius * radius));
  }
  row[at.radius0] = radius;
  row[at.surface] = temperature;
}

BedTotals bed_totals(const Matter& matter, const BedMatter& m, const double* row) {
  const BedRow at = bed_row(m);
  const int n = m.shells;
  BedTotals t;
  double capacity = 0;
  for (int i = 0; i < n; ++i) {
    const double T = row[at.temperature + i];
    for (int s = 0; s < m.solids; ++s) {
      const double x = row[at.mass + s * n + i];
      const auto kind = static_cast<std::size_t>(m.kind[s]);
      t.heat += x * (matter.heat_capacity[kind].integral(T) - m.sensible0[kind]);
      const double c = x * matter.heat_capacity[kind].at(T);
      capacity += c;
      t.mean += c * T;
      t.mass += x;
      (kind == 0 ? t.moisture : kind == 1 ? t.fuel : kind == 2 ? t.char_mass : t.ash) += x;
      for (int e = 0; e < k_bed_elements; ++e) t.elements[e] += m.composition[s][e] * x;
    }
    t.heat += row[at.debt + i];
  }
  t.mean /= capacity;
  return t;
}

}  // namespace talus::conversion
