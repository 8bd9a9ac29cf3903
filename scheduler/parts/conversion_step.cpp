// A step of the grains: what is around them, the solver, what came out. See conversion_part.hpp.
#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.hpp"
#include "core/conversion/cell_gases.hpp"
#include "scheduler/parts/conversion_part.hpp"
#include "scheduler/parts/gas_coupling.hpp"
#include "scheduler/parts/heat_bodies.hpp"
#include "scheduler/state/step_failure.hpp"

namespace talus {
using namespace conversion;

namespace {
constexpr Row k_rows = 1024;           // per block
constexpr double k_uptake_more = 1.1;  // film and size change within a step

/// Clausius and Clapeyron's slope of a drying law: pressure of saturation ~ exp(-slope / T) [K].
double slope_of(const BedMatter& m) { return m.evaporation * 0.018015 / 8.31446261815324; }
double saturation(const BedMatter& m, double T, double pressure) {
  return pressure * det::exp(slope_of(m) / m.boiling - slope_of(m) / T);
}

/// At which water boils: beside [gas] that of its cells at first, whatever the grain file says [Pa].
double pressure_around(const PartView& w, const SurroundingsOverTime& file) {
  return w.rules.scene.gas.on ? w.rules.scene.gas.pressure : file.pressure;
}
}  // namespace

/// Rows of one kind and what is around them, [column][row].
struct Conversion::Batch {
  const std::vector<Row>& rows;
  std::size_t stride;
  std::vector<double> in;
  explicit Batch(const std::vector<Row>& r) : rows(r), stride((r.size() + 7) / 8 * 8), in(k_bed_in * stride) {}
  double& at(BedIn column, std::size_t k) { return in[static_cast<std::size_t>(column) * stride + k]; }
  void set(BedIn column, double x) { std::fill_n(&at(column, 0), stride, x); }
};

void Conversion::advance(const PartView& w, Row lo, Row hi) {
  const auto count = static_cast<std::size_t>(hi - lo);
  std::copy_n(row(now_, lo), count * static_cast<std::size_t>(width_), row(next_, lo));
  std::fill_n(book(lo), count * static_cast<std::size_t>(books_width_), 0.0);
  for (std::size_t q = 0; q < k_columns; ++q) std::copy_n(shown_[q].data() + lo, count, shown_next_[q].data() + lo);
  if (heated_)
    std::copy_n(surface_.data() + static_cast<std::ptrdiff_t>(k_width<GrainSurface>) * lo,
                count * static_cast<std::size_t>(k_width<GrainSurface>),
                surface_next_.data() + static_cast<std::ptrdiff_t>(k_width<GrainSurface>) * lo);
  // beside heat it runs at the end of the step, when the new positions are the present ones
  const Column<double>& x = heated_ ? w.rows.p : w.rows.p2;
  std::vector<Row> rows;
  for (const Kind& kind : kinds_) {
    if (!kind.job) continue;
    rows.clear();
    for (Row i = lo; i < hi; ++i)
      if (x[4L * i] < k_far && kind_of(w.rows, i) == &kind) rows.push_back(i);
    if (!rows.empty()) advance(w, kind, rows);
  }
}

void Conversion::advance(const PartView& w, const Kind& kind, const std::vector<Row>& rows) {
  const BedMatter& m = kind.tables->matter();
  Batch in(rows);
  std::vector<double> out(static_cast<std::size_t>(k_out_released + m.gases) * in.stride);
  std::vector<double> scratch(static_cast<std::size_t>(bed_scratch(m)) + 8);
  std::vector<double*> to;
  for (const Row i : rows) to.push_back(row(next_, i));
  surroundings(w, kind, in);
  GrainBatch b;
  b.grains = static_cast<long>(rows.size());
  b.row = to.data();
  b.in = in.in.data();
  b.out = out.data();
  b.stride = static_cast<long>(in.stride);
  b.dt = w.rules.scene.dt * static_cast<double>(s_.every);
  b.pressure = pressure_around(w, kind.job->around);
  b.scratch = reinterpret_cast<double*>((reinterpret_cast<std::uintptr_t>(scratch.data()) + 63) / 64 * 64);
  solver_(m, b);
  for (std::size_t k = 0; k < rows.size(); ++k)
    take(kind, number_of(w.rows, rows[k]), rows[k], out.data() + k, in.stride);
}

/// Those of the grain file at the middle of the step; beside heat, what heat and gas say.
void Conversion::surroundings(const PartView& w, const Kind& kind, Batch& b) const {
  const double dt = w.rules.scene.dt;
  const double t = (static_cast<double>(w.clock.step + 1) - 0.5 * static_cast<double>(s_.every)) * dt;
  const SurroundingsOverTime& a = kind.job->around;
  const double gas = a.temperature.at(t), contact = a.contact_conductance.at(t);
  b.set(k_in_gas, gas);
  b.set(k_in_velocity, a.velocity.at(t));
  b.set(k_in_wall, a.wall_temperature ? a.wall_temperature->at(t) : gas);
  b.set(k_in_sees, a.wall_temperature ? 1 : 0);
  b.set(k_in_flux, a.flux.at(t));
  b.set(k_in_contact, contact);
  b.set(k_in_contact_heat, contact * (a.contact_temperature ? a.contact_temperature->at(t) : gas));
  b.set(k_in_film, a.film ? a.film->at(t) : -1);
  b.set(k_in_oxygen, a.oxygen.at(t));
  b.set(k_in_carbon_dioxide, a.carbon_dioxide.at(t));
  b.set(k_in_steam, a.steam.at(t));
  b.set(k_in_molar, a.molar_at(t));
  b.set(k_in_pressure, pressure_around(w, a));
  if (!heated_) {
    for (std::size_t k = 0; k < b.rows.size() && !shapes_.empty(); ++k)
      for (const BedIn of_grain : {k_in_contact, k_in_contact_heat})
        b.at(of_grain, k) = b.at(of_grain, k) / number_of(w.rows, b.rows[k]);
    return;
  }
  b.set(k_in_apart, 1);
  for (std::size_t k = 0; k < b.rows.size(); ++k) exchanged(w, kind, b.rows[k], k, b);
}

void Conversion::exchanged(const PartView& w, const Kind& kind, Row i, std::size_t k, Batch& b) const {
  const auto* heat = part_as<GrainHeat>(w.parts);
  const double number = number_of(w.rows, i), flow = heat->flow(i) / number,
               conductance = heat->conductance(i) / number;
  b.at(k_in_flow, k) = flow;
  b.at(k_in_partner, k) = conductance;
  b.at(k_in_partner_heat, k) = flow + conductance * heat->before(i);
  const auto* cells = part_as<GasCells>(w.parts);
  const GasNear gas = cells != nullptr ? cells->near(i) : heat->given_gas(w, i);
  b.at(k_in_film, k) = gas.film;
  if (gas.film > 0) b.at(k_in_gas, k) = gas.temperature;
  b.at(k_in_velocity, k) = gas.slip;
  if (cells == nullptr) return;
  b.at(k_in_molar, k) = gas.molar;
  b.at(k_in_pressure, k) = gas.pressure;
  b.at(k_in_oxygen, k) = gas.kept[0];
  b.at(k_in_carbon_dioxide, k) = gas.kept[1];
  b.at(k_in_steam, k) = kind.burns[2] ? gas.kept[2] : gas.steam;
  const BedMatter& m = kind.tables->matter();
  if (m.dries == 0) return;
  const GasSteam steam = cells->steam(i);
  if (!(steam.mass > 0)) return;
  const double dew = 1 / (1 / outermost(kind, i) - det::log(steam.above) / slope_of(m));
  b.at(k_in_condensing, k) = steam.mass / number;
  b.at(k_in_dew, k) = fmin2(dew, m.boiling);
  b.at(k_in_dew_heat, k) = steam.enthalpy + (m.evaporation - m.vapour_to_cells);
}

double Conversion::outermost(const Kind& kind, Row i) const {
  const BedMatter& m = kind.tables->matter();
  return row(now_, i)[bed_row(m).temperature + m.shells - 1];
}

bool Conversion::condenses(const Rows& rows, Row i) const {
  const Kind* kind = kind_of(rows, i);
  return kind != nullptr && kind->tables->matter().dries != 0;
}

/// What the solver says of a row: numbers for files, ledger, the sizes to come.
void Conversion::take(const Kind& kind, double number, Row i, const double* out, std::size_t stride) {
  const auto of = [&](int column) { return out[static_cast<std::size_t>(column) * stride]; };
  for (std::size_t q = 0; q < k_columns; ++q)
    shown_next_[q][static_cast<std::size_t>(i)] = (q < k_shown_masses ? 1 : number) * of(k_shown[q].column);
  double* books = book(i);
  for (std::size_t q = 0; q < k_fixed_books; ++q) books[q] = number * of(k_books[q]);
  for (std::size_t g = 0; g < kind.gases.size(); ++g)
    books[k_fixed_books + kind.gases[g]] = number * of(k_out_released + static_cast<int>(g));
  books[books_width_ - 1] = of(k_out_excess);
  double* own = row(next_, i) + kind.size;
  own[k_radius_from] = own[k_radius_to];
  own[k_radius_to] = of(k_out_radius);
  own[k_mass_from] = own[k_mass_to];
  own[k_mass_to] = number * of(k_out_mass);
  if (!heated_) return;
  const BedMatter& m = kind.tables->matter();
  set_row(surface_next_, i,
          all_of({of(k_out_capacity), of(k_out_inner), of(k_out_conductivity), of(k_out_emissivity),
                  m.blows != 0 ? row(next_, i)[bed_row(m).carried] : 0.0},
                 number));
  outside_[static_cast<std::size_t>(i)] = of(k_out_outside);
  condensed_[static_cast<std::size_t>(i)] = number * of(k_out_condensed);
}

/// Heat must not take less time through a shell that still holds fuel than a step: bed_step.hpp. Grains shrink and
/// become light, so that what held at the start may not hold any more.
void Conversion::judge(const PartView& w) const {
  Row worst = -1;
  double excess = 1;
  for (Row i = 0; i < w.rows.n; ++i) {
    if (!w.rows.is_alive(i)) continue;
    const double x = books_[static_cast<std::size_t>(books_width_) * static_cast<std::size_t>(i + 1) - 1];
    if (!(x <= excess)) excess = x, worst = i;
  }
  if (worst < 0) return;
  const double most = static_cast<double>(s_.every) / excess;
  throw StepFailure({w.rows.id[worst]},
                    fmt::format("the conversion step of {:.6g} s is longer than heat takes through a shell of grain {}",
                                w.rules.scene.dt * static_cast<double>(s_.every), w.rows.id[worst]),
                    most >= 1
                        ? fmt::format("conversion.every = {} at most, or fewer shells", static_cast<std::int64_t>(most))
                        : fmt::format("conversion.every = 1 and time.step = {:.3g} at most, or fewer shells",
                                      most * w.rules.scene.dt));
}

void Conversion::finish(const PartView& w) {
  judge(w);
  totals_before_ = totals_;
  std::vector<double> sum(totals_.size());
  for (Row b = 0; b < w.rows.n; b += k_rows) {
    std::fill(sum.begin(), sum.end(), 0.0);
    for (Row i = b; i < std::min<Row>(w.rows.n, b + k_rows); ++i) {
      if (!w.rows.is_alive(i)) continue;
      const double* x = book(i);
      for (std::size_t q = 0; q < sum.size(); ++q) sum[q] = sum[q] + x[q];
    }
    for (std::size_t q = 0; q < sum.size(); ++q) totals_[q] = totals_[q] + sum[q];
  }
  swap();
  if (w.rows.bodies.in)
    for (Row i = 0; i < w.rows.n; ++i)
      if (w.rows.is_alive(i) && w.rows.body_of(i) >= 0 && kind_of(w.rows, i) != nullptr) share_with_rows(w, i);
  clock_ = &w.clock;
  last_step_ = w.clock.step;
}

/// The rows of a body behind its first one show its temperatures and its surface; it holds all of its mass.
void Conversion::share_with_rows(const PartView& w, Row i) {
  for (Row k = i + 1; k < end_of_grain(w, i); ++k) {
    for (std::size_t q = 0; q < k_shown_masses; ++q)
      shown_[q][static_cast<std::size_t>(k)] = shown_[q][static_cast<std::size_t>(i)];
    if (heated_) set_row(surface_, k, row_of<GrainSurface>(surface_, i));
  }
}

void Conversion::swap() {
  std::swap(now_, next_);
  for (std::size_t q = 0; q < k_columns; ++q) std::swap(shown_[q], shown_next_[q]);
  if (heated_) std::swap(surface_, surface_next_);
}

// --- beside heat and gas ---------------------------------------------------------------------------------------------

void Conversion::step_with_heat(const PartView& w) {
  auto* gas = part_as<GasCells>(w.parts);
  if (gas != nullptr) gas->offer(w, uptakes(w, *gas));
  outside_.assign(static_cast<std::size_t>(w.rows.n), 0.0);
  condensed_ = outside_;
  w.blocks((w.rows.n + k_rows - 1) / k_rows,
           [&](int b) { advance(w, b * k_rows, std::min<Row>(w.rows.n, (b + 1) * k_rows)); });
  finish(w);
  auto* heat = part_as<GrainHeat>(w.parts);
  for (Row i = 0; i < w.rows.n; ++i)
    if (w.rows.is_alive(i) && kind_of(w.rows, i) != nullptr)
      for (Row k = i; k < end_of_grain(w, i); ++k) heat->set_surface(k, outside_[static_cast<std::size_t>(i)]);
  if (gas != nullptr) give(w, *gas);
}

/// What char could take through the film if the gas were nothing but oxidant: an upper bound, as the solver computes
/// film and density of gas. Likewise steam, where it would condense on the outermost shell.
std::vector<GasUptake> Conversion::uptakes(const PartView& w, const GasCells& gas) const {
  std::vector<GasUptake> most(static_cast<std::size_t>(w.rows.n));
  w.blocks((w.rows.n + k_rows - 1) / k_rows, [&](int b) {
    for (Row i = b * k_rows; i < std::min<Row>(w.rows.n, (b + 1) * k_rows); ++i) {
      const auto at = static_cast<std::size_t>(i);
      const Kind* kind = w.rows.is_alive(i) ? kind_of(w.rows, i) : nullptr;
      if (kind == nullptr) continue;
      const BedMatter& m = kind->tables->matter();
      const bool burns = !kind->job->matter.char_reactions.empty() && shown_[k_shown_char][at] > 0;
      const double saturated =
          m.dries != 0 ? saturation(m, outermost(*kind, i), pressure_around(w, kind->job->around)) : k_never;
      const bool wets = m.dries != 0 && outermost(*kind, i) < m.boiling && gas.saturable(i) > saturated;
      if (!burns && !wets) continue;
      const SurroundingsOverTime& a = kind->job->around;
      const GasNear g = gas.near(i);
      const double r = radius_of(w.rows, i), number = number_of(w.rows, i), surface = shown_[k_shown_surface][at];
      const Film f = film_of(a.gas, a.law, 2 * r, g.slip, g.temperature, surface, g.pressure);
      const double density = gas_density(0.5 * (g.temperature + surface), g.pressure, g.molar);
      const double through = number * (f.mass * g.film / f.heat) * (4 * det::k_pi * (r * r)) * density;
      if (burns)
        most[at].oxidant =
            number * (k_uptake_more * kind->shares * (f.mass * g.film / f.heat) * (4 * det::k_pi * (r * r)) * density);
      if (wets) most[at].vapour = through, most[at].saturation = saturated;
    }
  });
  return most;
}

void Conversion::give(const PartView& w, GasCells& gas) {
  for (Row i = 0; i < w.rows.n; ++i) {
    const Kind* kind = w.rows.is_alive(i) ? kind_of(w.rows, i) : nullptr;
    if (kind == nullptr) continue;
    const double* x = book(i);
    GasFractions released{};
    for (std::size_t k = 0; k < released.size(); ++k) released[k] = x[k_fixed_books + kind->gases[k]];
    const double* taken = x + k_books_taken;
    // cell_gases.hpp: what the grain has lost, and what its reactions set free by their extents
    double energy = x[k_books_standard] - x[k_books_reaction] + x[k_books_with_gas];
    for (std::size_t k = 0; k < released.size(); ++k) energy += released[k] * formation_enthalpy(static_cast<int>(k));
    for (std::size_t k = 0; k < 3; ++k) energy -= taken[k] * formation_enthalpy(k_oxidants[k]);
    const double condensed = condensed_[static_cast<std::size_t>(i)];
    gas.give(i, released, {taken[0], taken[1], taken[2] - condensed}, condensed, energy);
  }
  gas.settle();
}

}  // namespace talus
