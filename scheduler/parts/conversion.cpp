// See conversion.hpp. Every `every` steps each grain makes one step of the solver of many grains (kernels/conversion);
// radius and mass then go to what came out in a straight line over the next `every` steps, so that no overlap jumps.
//
//   conversion[c]    new numbers of a chunk's grains, from the present ones into a second buffer; what they gave off
//   conversion_step  the ledger, in blocks of rows; the buffers change places. Beside the part heat it does all, after
//                    the heat step (doors.hpp)
#include "scheduler/parts/conversion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/base/error.hpp"
#include "core/conversion/cell_gases.hpp"
#include "core/grains/body.hpp"
#include "scheduler/parts/conversion_part.hpp"
#include "scheduler/parts/gas_coupling.hpp"

namespace talus {
using namespace conversion;

namespace {

constexpr std::uint64_t k_seed = 120;  // of its term in the state hash
constexpr Row k_rows = 1024;           // per block of the ledger
constexpr const char* k_elements_of[] = {"carbon", "hydrogen", "oxygen", "ash", "water"};

}  // namespace

const Conversion::Shown Conversion::k_shown[k_columns] = {{"mean_temperature", "K", k_out_mean},
                                                          {"surface_temperature", "K", k_out_surface},
                                                          {"centre_temperature", "K", k_out_centre},
                                                          {"grain_mass", "kg", k_out_mass},
                                                          {"moisture", "kg", k_out_moisture},
                                                          {"fuel", "kg", k_out_fuel},
                                                          {"char", "kg", k_out_char},
                                                          {"ash", "kg", k_out_ash}};
const int Conversion::k_books[k_fixed_books] = {
    k_out_heat_in, k_out_contact,  k_out_reaction, k_out_with_gas, k_out_oxygen,   k_out_carbon_dioxide, k_out_steam,
    k_out_gone,    k_out_gone + 1, k_out_gone + 2, k_out_gone + 3, k_out_gone + 4, k_out_standard};

Conversion::Conversion(const Rules& rules, const ConversionSettings& settings)
    : rules_(rules),
      s_(settings),
      solver_(grain_solver(rules.kernels->name)),
      heated_(rules.scene.heat.on),
      cells_(rules.scene.gas.on) {
  if (heated_ && s_.every != rules.scene.heat.every)
    throw Error(ErrorCode::scene, "conversion.every must be heat.every", rules.scene.file, "the same number of steps");
  if (rules.has.bodies) shapes_ = equal_spheres(rules.scene);
  kinds_.resize(s_.matter.size());
  for (std::size_t k = 0; k < s_.matter.size(); ++k)
    if (s_.matter[k]) add_kind(k);
  width_ = (width_ + k_own + 7) / 8 * 8;
  totals_.assign(k_fixed_books + gases_.size(), 0.0);
  books_width_ = static_cast<int>(totals_.size()) + 1;
}

void Conversion::add_kind(std::size_t k) {
  Kind& kind = kinds_[k];
  kind.job = s_.matter[k];
  const Material& m = rules_.scene.materials[k];
  if (!(std::fabs(kind.job->matter.density - m.density) <= 1e-9 * m.density))
    throw Error(ErrorCode::scene,
                fmt::format("material '{}' has {:g} kg/m3, the grain that describes it {:g}", m.name, m.density,
                            kind.job->matter.density),
                "conversion", "the same density in both");
  if (kind.job->form.shape != heat::Shape::sphere)
    throw Error(ErrorCode::scene, fmt::format("the grain file of material '{}' is of no sphere", m.name), "conversion",
                "grain.shape = \"sphere\": grains of a bed are spheres, or bodies of a [[shape]], which convert as "
                "spheres of their volume and surface");
  if (kind.job->around.surface_temperature)
    throw Error(ErrorCode::scene, "the surface temperature of grains in a bed cannot be given", "conversion",
                "temperature and film of the gas");
  if (heated_) check_surroundings(kind, m.name);
  if (cells_) {
    auto job = std::make_shared<GrainJob>(*kind.job);
    job->matter = with_cell_gases(kind.job->matter);
    kind.job = std::move(job);
  }
  const Matter& matter = kind.job->matter;
  kind.tables = std::make_unique<BedTables>(matter, s_.shells, kind.job->around.gas, kind.job->around.law);
  kind.size = bed_row(kind.tables->matter()).size;
  width_ = std::max(width_, kind.size);
  int taking[3] = {};
  for (const CharReaction& r : matter.char_reactions) ++taking[static_cast<int>(r.oxidant)];
  for (int q = 0; q < 3; ++q) {
    kind.burns[q] = taking[q] > 0;
    kind.shares = std::max(kind.shares, static_cast<double>(taking[q]));
  }
  for (const Gas& g : matter.gases) {
    const auto at = std::find(gases_.begin(), gases_.end(), g.name);
    kind.gases.push_back(static_cast<std::size_t>(at - gases_.begin()));
    if (at == gases_.end()) gases_.push_back(g.name);
  }
}

/// Beside heat its sections say what reaches the surface; what the grain's file says of that would have no effect.
void Conversion::check_surroundings(const Kind& kind, const std::string& material) const {
  const SurroundingsOverTime& a = kind.job->around;
  const auto refuse = [&](const char* key, const char* cure) {
    throw Error(ErrorCode::scene,
                fmt::format("the grain of material '{}': surroundings.{} has no effect beside [heat]", material, key),
                "conversion", cure);
  };
  if (a.wall_temperature) refuse("wall_temperature", "heat.radiation.enclosure in the scene");
  if (std::any_of(a.flux.value.begin(), a.flux.value.end(), [](double q) { return q != 0; }))
    refuse("flux", "heat.wall with a flux in the scene");
  if (a.contact_conductance.largest() > 0) refuse("contact_conductance", "contacts of grains conduct by themselves");
  const Matter& m = kind.job->matter;
  const bool takes = !m.char_reactions.empty() || m.drying.kind == Drying::equilibrium;
  if (takes && !cells_ && !rules_.scene.heat.gas.on)
    throw Error(
        ErrorCode::scene,
        fmt::format("the grain of material '{}' burns or dries through a film of gas, and there is no gas", material),
        "conversion", "[gas] or [heat.gas]");
}

/// Heat must not take less time through a shell of the smallest grain than a step of conversion: a shell could use up
/// its reactant at the rate of the step's start and come out too hot (bed_step.hpp).
double Conversion::step_limit(const PartView& w) const {
  double most = k_never;
  const double smallest =
      shapes_.empty() ? w.rules.r_min : smallest_of_equal_spheres(w.rules.scene, shapes_, w.rules.r_min);
  for (const Kind& k : kinds_) {
    if (!k.job) continue;
    const BedMatter& m = k.tables->matter();
    const double dx = smallest * k.tables->thinnest_shell();
    const int fuel = m.present[1] != 0 ? 1 : 0;  // moist matter where there is nothing else
    const double density = m.fuel_density > 0 ? m.fuel_density : m.moisture_density;
    if (density > 0) most = fmin2(most, dx * dx * density * m.capacity[fuel].first / m.conductivity[fuel].first);
  }
  return most / static_cast<double>(s_.every);
}

void Conversion::add_columns(Columns& columns) {
  ColumnInfo i;
  i.name = "conversion";
  i.label = "shells of grains, next";
  i.why = "conversion";
  i.width = width_;
  i.saved = true;
  i.hash_seed = k_seed;
  columns.add(i, now_, &next_);
  for (std::size_t k = 0; k < k_columns; ++k) {
    ColumnInfo o;
    o.name = k_shown[k].name;
    o.unit = k_shown[k].unit;
    o.why = "conversion";
    o.saved = o.output = true;
    columns.add(o, shown_[k], &shown_next_[k]);
  }
  ColumnInfo b;
  b.name = "conversion ledger";
  b.why = "conversion";
  b.width = books_width_;
  b.moves = false;
  columns.add(b, books_);
  ColumnInfo f;
  f.name = "grain surface";
  f.label = "grain surface, next";
  f.unit = "J/K, W/K, W/m/K, -, W/K";
  f.why = "conversion beside heat";
  f.width = k_width<GrainSurface>;
  f.saved = true;
  f.in = heated_;
  columns.add(f, surface_, &surface_next_);
}

std::vector<PartNode> Conversion::nodes() {
  if (heated_)
    return {{"conversion_step",
             PartNode::When::step,
             {{"conversion"}, {"p"}, {"heat flow"}, {"heat conductance"}, {"temperature"}},
             {{"conversion"}, {"conversion ledger"}, {"temperature"}, {"gas"}},
             s_.every,
             [this](const PartView& w, const Chunk&) { step_with_heat(w); }}};
  return {{"conversion",
           PartNode::When::rows,
           {{"conversion"}, {"p2"}},
           {{"next conversion"}, {"conversion ledger"}},
           s_.every,
           [this](const PartView& w, const Chunk& c) { advance(w, c.lo, c.hi); }},
          {"conversion_step",
           PartNode::When::step,
           {{"next conversion"}, {"conversion ledger"}},
           {{"conversion"}},
           s_.every,
           [this](const PartView& w, const Chunk&) { finish(w); }}};
}

void Conversion::appended(const Rows& rows, Row first, const NewParticles& a) {
  for (std::size_t k = 0; k < a.size(); ++k) {
    const Row i = first + static_cast<Row>(k);
    const Kind* kind = kind_of(rows, i);
    std::fill_n(row(now_, i), width_, 0.0);
    if (kind == nullptr) continue;
    const double radius = radius_of(rows, i), number = number_of(rows, i);
    double* own = row(now_, i);
    const double T =
        heated_ ? rules_.scene.heat.sources[static_cast<std::size_t>(a.source[k])].temperature : kind->job->temperature;
    kind->tables->begin(radius, T, own);
    own[kind->size + k_radius_from] = own[kind->size + k_radius_to] = radius;
    const BedTotals t = bed_totals(kind->job->matter, kind->tables->matter(), own);
    own[kind->size + k_mass_from] = own[kind->size + k_mass_to] = number * t.mass;
    check_mass(rows, i, number * t.mass);
    std::copy_n(own, width_, row(next_, i));
    const double shown[k_columns] = {t.mean, t.mean, t.mean, t.mass, t.moisture, t.fuel, t.char_mass, t.ash};
    const Row end = rows.body_of(i) < 0 ? i + 1 : i + rows_of(rows, i);
    for (Row at = i; at < end; ++at) {
      for (std::size_t q = 0; q < k_columns; ++q) {
        const double x = q < k_shown_masses ? shown[q] : (at == i ? number * shown[q] : 0.0);
        shown_[q][static_cast<std::size_t>(at)] = shown_next_[q][static_cast<std::size_t>(at)] = x;
      }
      if (heated_)
        for (Column<double>* c : {&surface_, &surface_next_})
          set_row(*c, at, all_of(first_surface(*kind, own, radius, T), number));
    }
    add(come_, t, number);
  }
}

GrainSurface Conversion::first_surface(const Kind& kind, const double* own, double radius, double T) const {
  const Matter& m = kind.job->matter;
  const BedMatter& b = kind.tables->matter();
  const BedRow at = bed_row(b);
  GrainSurface s;
  for (int k = 0; k < b.solids; ++k)
    s.capacity += own[at.mass + (k + 1) * b.shells - 1] * m.heat_capacity[static_cast<std::size_t>(b.kind[k])].at(T);
  const double k = (b.moisture_density > 0 ? m.conductivity_wet : m.conductivity[b.fuel_density > 0 ? 1 : 2]).at(T);
  s.conductivity = fmax2(k, m.least_conductivity);
  s.inner = 2 * s.conductivity * b.shells * (4 * det::k_pi * radius);
  s.emissivity = m.emissivity[0];
  return s;
}

double Conversion::radius_of(const Rows& rows, Row i) const {
  const std::int32_t b = rows.body_of(i);
  if (b < 0) return rows.p[4L * i + 3];
  return rows.bodies.scale(b) *
         shapes_[static_cast<std::size_t>(rows.bodies.shape[static_cast<std::size_t>(b)])].radius;
}

/// A shape may say its own density or mass, which its shells would not have.
void Conversion::check_mass(const Rows& rows, Row i, double mass) const {
  const std::int32_t b = rows.body_of(i);
  if (b < 0 || std::fabs(rows.bodies.mass(b) - mass) <= 1e-9 * mass) return;
  const auto shape = static_cast<std::size_t>(rows.bodies.shape[static_cast<std::size_t>(b)]);
  throw Error(ErrorCode::scene,
              fmt::format("a body of shape '{}' has {:g} kg, the grain that describes its matter {:g} kg",
                          rules_.scene.shapes[shape].name, rows.bodies.mass(b), mass),
              rules_.scene.file, "no density and no mass in the [[shape]] of a body that converts");
}

GrainSurface Conversion::surface(Row i) const { return row_of<GrainSurface>(surface_, i); }

void Conversion::removed(const Rows& rows, Row i) {
  if (const Kind* kind = kind_of(rows, i))
    add(come_, bed_totals(kind->job->matter, kind->tables->matter(), row(now_, i)), -number_of(rows, i));
}

void Conversion::take_back() {
  if (clock_ == nullptr || last_step_ < 0 || clock_->step - 1 != last_step_) return;
  swap();
  totals_ = totals_before_;
  last_step_ = -1;
}

void Conversion::sizes(const PartView& w, const Chunk&, const RowSizes& s) const {
  const double share = static_cast<double>(w.clock.step % s_.every + 1) / static_cast<double>(s_.every);
  for (Row i = s.lo; i < s.hi; ++i) {
    const Kind* kind = w.rows.is_alive(i) ? kind_of(w.rows, i) : nullptr;
    if (kind == nullptr) continue;
    const double* own = row(now_, i) + kind->size;
    const double to = own[k_radius_to], mass = own[k_mass_from], end = own[k_mass_to];
    const std::int32_t b = w.rows.body_of(i);  // of a body the scale
    const double unit =
        b < 0 ? 1 : shapes_[static_cast<std::size_t>(w.rows.bodies.shape[static_cast<std::size_t>(b)])].radius;
    // from the size that it has: of a grain that was held until now not that of the last step of conversion
    double& size = s.radius[i - s.lo];
    const auto left = static_cast<double>(s_.every - w.clock.step % s_.every);  // steps, this one too
    size = left > 1 ? size + (to / unit - size) / left : to / unit;
    s.mass[i - s.lo] = share < 1 ? mass + share * (end - mass) : end;
    const double first = row(now_, i)[bed_row(kind->tables->matter()).radius0];
    // fuel without ash ends at nothing, whatever its size: a grain of no mass cannot be moved
    const double whole = number_of(w.rows, i) * Body{first, kind->job->matter.density}.mass();
    constexpr double k_nothing = 1e-6;  // of its first mass
    if (share == 1 && (to < s_.gone_below * first || end < k_nothing * whole)) s.radius[i - s.lo] = 0;
  }
}

std::vector<std::uint8_t> Conversion::save() const {
  std::vector<double> all = totals_;
  all.insert(all.end(), {come_.heat, come_.mass, come_.moisture, come_.fuel, come_.char_mass, come_.ash});
  all.insert(all.end(), come_.elements, come_.elements + k_bed_elements);
  std::vector<std::uint8_t> bytes(all.size() * sizeof(double));
  std::memcpy(bytes.data(), all.data(), bytes.size());
  return bytes;
}

void Conversion::load(std::span<const std::uint8_t> bytes, const std::string& where) {
  std::vector<double> all(totals_.size() + 6 + k_bed_elements);
  if (bytes.size() != all.size() * sizeof(double))
    throw Error(ErrorCode::io, "section 'part conversion' has a wrong size", where);
  std::memcpy(all.data(), bytes.data(), bytes.size());
  const double* at = all.data();
  for (double& x : totals_) x = *at++;
  for (double* x : {&come_.heat, &come_.mass, &come_.moisture, &come_.fuel, &come_.char_mass, &come_.ash}) *x = *at++;
  for (double& x : come_.elements) x = *at++;
}

void Conversion::add(BedTotals& to, const BedTotals& t, double sign) {
  to.heat += sign * t.heat;
  to.mass += sign * t.mass;
  to.moisture += sign * t.moisture;
  to.fuel += sign * t.fuel;
  to.char_mass += sign * t.char_mass;
  to.ash += sign * t.ash;
  for (int e = 0; e < k_bed_elements; ++e) to.elements[e] += sign * t.elements[e];
}

std::vector<PartValue> Conversion::values(const PartView& w) const {
  BedTotals now;
  for (Row b = 0; b < w.rows.n; b += k_rows) {
    BedTotals part;
    for (Row i = b; i < std::min<Row>(w.rows.n, b + k_rows); ++i)
      if (const Kind* kind = w.rows.is_alive(i) ? kind_of(w.rows, i) : nullptr)
        add(part, bed_totals(kind->job->matter, kind->tables->matter(), row(now_, i)), number_of(w.rows, i));
    add(now, part, 1);
  }
  const auto book = [&](int column) {
    return totals_[static_cast<std::size_t>(std::find(std::begin(k_books), std::end(k_books), column) - k_books)];
  };
  const double heat = now.heat - come_.heat - book(k_out_heat_in) - book(k_out_reaction) + book(k_out_with_gas);
  double released = 0;
  for (std::size_t g = 0; g < gases_.size(); ++g) released += totals_[k_fixed_books + g];
  const double taken = book(k_out_oxygen) + book(k_out_carbon_dioxide) + book(k_out_steam);
  std::vector<PartValue> out{{"conversion.mass", "kg", now.mass},
                             {"conversion.moisture", "kg", now.moisture},
                             {"conversion.fuel", "kg", now.fuel},
                             {"conversion.char", "kg", now.char_mass},
                             {"conversion.ash", "kg", now.ash},
                             {"conversion.heat", "J", now.heat},
                             {"conversion.heat_in", "J", book(k_out_heat_in)},
                             {"conversion.heat_of_reaction", "J", book(k_out_reaction)},
                             {"conversion.oxygen_taken", "kg", book(k_out_oxygen)},
                             {"conversion.heat_residual", "J", heat},
                             {"conversion.mass_residual", "kg", now.mass - come_.mass + released - taken}};
  for (int e = 0; e < k_bed_elements; ++e)
    out.push_back({fmt::format("conversion.{}_residual", k_elements_of[e]), "kg",
                   now.elements[e] - come_.elements[e] + book(k_out_gone + e)});
  if (cells_) {
    out.push_back({"conversion.carbon_dioxide_taken", "kg", book(k_out_carbon_dioxide)});
    out.push_back({"conversion.steam_taken", "kg", book(k_out_steam)});
    // what its reactions have added to the heats of grains and the enthalpy of the gas, less
    double formation = book(k_out_standard);
    for (std::size_t g = 0; g < gases_.size(); ++g) formation += totals_[k_fixed_books + g] * formation_of(gases_[g]);
    formation -= book(k_out_oxygen) * formation_of("O2") + book(k_out_carbon_dioxide) * formation_of("CO2") +
                 book(k_out_steam) * formation_of("H2O");
    out.push_back({"conversion.formation", "J", -formation});
  }
  for (int e = 0; e < k_bed_elements && cells_; ++e)
    out.push_back({fmt::format("conversion.gone_{}", k_elements_of[e]), "kg", book(k_out_gone + e)});
  for (std::size_t g = 0; g < gases_.size(); ++g)
    out.push_back({"conversion.released_" + gases_[g], "kg", totals_[k_fixed_books + g]});
  return out;
}

std::vector<std::string> Conversion::advice(const PartView&) const {
  std::vector<std::string> lines;
  for (std::size_t k = 0; k < shapes_.size(); ++k)
    lines.push_back(
        fmt::format("{}: a body of scale 1 that converts is {:.4g} spheres of radius {:.4g} m, three times its "
                    "volume over its surface",
                    rules_.scene.shapes[k].name, shapes_[k].number, shapes_[k].radius));
  if (!heated_) return lines;
  for (std::size_t k = 0; k < kinds_.size(); ++k)
    if (kinds_[k].job)
      lines.push_back(fmt::format(
          "{}: {} shells; of the surroundings in its grain file {} and the laws of its film count, the rest is that of "
          "{}",
          rules_.scene.materials[k].name, s_.shells, cells_ ? "the pressure" : "the oxidants, the pressure",
          cells_ ? "[heat] and the cells of [gas]" : "[heat]"));
  return lines;
}

std::unique_ptr<Part> make_conversion(const Rules& rules, const ConversionSettings& settings) {
  return std::make_unique<Conversion>(rules, settings);
}

}  // namespace talus
