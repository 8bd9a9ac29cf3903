// See conversion.hpp. Every `every` steps each grain makes one step of the solver of many grains (kernels/conversion);
// radius and mass then go to what came out in a straight line over the next `every` steps, so that no overlap jumps.
//
//   conversion[c]    new numbers of a chunk's grains, from the present ones into a second buffer; what they gave off
//   conversion_step  the ledger, in blocks of rows; the buffers change places
//
// Invariants: I3 (totals over fixed blocks of rows), I7; a step that fails leaves the present numbers as they were.
#include "scheduler/parts/conversion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/base/error.hpp"
#include "kernels/conversion/grain_batch.hpp"

namespace talus {
namespace {
using namespace conversion;

constexpr std::uint64_t k_seed = 120;  // of its term in the state hash
constexpr Row k_rows = 1024;           // per block of the ledger

/// What converts of a material.
struct Kind {
  std::shared_ptr<const GrainJob> job;
  std::unique_ptr<BedTables> tables;
  int size = 0;                    ///< of the solver's row
  std::vector<std::size_t> gases;  ///< its gases among those of all materials
};

/// Behind the solver's numbers in a row.
enum Own : int { k_radius_from, k_radius_to, k_mass_from, k_mass_to, k_own };

/// Output columns of the solver that particle files show.
struct Shown {
  const char *name, *unit;
  int column;
};
constexpr Shown k_shown[] = {{"mean_temperature", "K", k_out_mean},
                             {"surface_temperature", "K", k_out_surface},
                             {"centre_temperature", "K", k_out_centre},
                             {"grain_mass", "kg", k_out_mass},
                             {"moisture", "kg", k_out_moisture},
                             {"fuel", "kg", k_out_fuel},
                             {"char", "kg", k_out_char},
                             {"ash", "kg", k_out_ash}};
constexpr std::size_t k_columns = std::size(k_shown);
/// Of the solver's output, what the ledger sums: heat, gas taken, elements; then the gases.
constexpr int k_books[] = {k_out_heat_in,  k_out_contact,        k_out_reaction, k_out_with_gas,
                           k_out_oxygen,   k_out_carbon_dioxide, k_out_steam,    k_out_gone,
                           k_out_gone + 1, k_out_gone + 2,       k_out_gone + 3, k_out_gone + 4};
constexpr std::size_t k_fixed_books = std::size(k_books);
constexpr const char* k_elements_of[] = {"carbon", "hydrogen", "oxygen", "ash", "water"};

class Conversion final : public Part {
 public:
  Conversion(const Rules& rules, const ConversionSettings& settings)
      : rules_(rules), s_(settings), solver_(grain_solver(rules.kernels->name)) {
    kinds_.resize(s_.matter.size());
    for (std::size_t k = 0; k < s_.matter.size(); ++k)
      if (s_.matter[k]) add_kind(k);
    width_ = (width_ + k_own + 7) / 8 * 8;
    books_width_ = static_cast<int>(k_fixed_books + gases_.size());
    totals_.assign(static_cast<std::size_t>(books_width_), 0.0);
  }

  std::string name() const override { return "conversion"; }
  bool resizes() const override { return s_.resizes; }

  /// Heat must not take less time through a shell of the smallest grain than a step of conversion: a shell could use up
  /// its reactant at the rate of the step's start and come out too hot (bed_step.hpp).
  double step_limit(const PartView& w) const override {
    double most = k_never;
    for (const Kind& k : kinds_) {
      if (!k.job) continue;
      const BedMatter& m = k.tables->matter();
      const double dx = w.rules.r_min * k.tables->thinnest_shell();
      const int fuel = m.present[1] != 0 ? 1 : 0;  // moist matter where there is nothing else
      const double density = m.fuel_density > 0 ? m.fuel_density : m.moisture_density;
      most = fmin2(most, dx * dx * density * m.capacity[fuel].first / m.conductivity[fuel].first);
    }
    return most / static_cast<double>(s_.every);
  }

  void add_columns(Columns& columns) override {
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
  }

  std::vector<PartNode> nodes() override {
    return {{"conversion",
             PartNode::When::rows,
             {{"conversion"}, {"p2"}},
             {{"next conversion"}, {"conversion ledger"}},
             s_.every,
             [this](const PartView& w, const Chunk& c) { advance(w, c); }},
            {"conversion_step",
             PartNode::When::step,
             {{"next conversion"}, {"conversion ledger"}},
             {{"conversion"}},
             s_.every,
             [this](const PartView& w, const Chunk&) { finish(w); }}};
  }

  void appended(const Rows& rows, Row first, const NewParticles& a) override {
    for (std::size_t k = 0; k < a.size(); ++k) {
      const Row i = first + static_cast<Row>(k);
      const Kind* kind = kind_of(rows, i);
      std::fill_n(row(now_, i), width_, 0.0);
      if (kind == nullptr) continue;
      const double radius = rows.p[4L * i + 3];
      double* own = row(now_, i);
      kind->tables->begin(radius, kind->job->temperature, own);
      own[kind->size + k_radius_from] = own[kind->size + k_radius_to] = radius;
      const BedTotals t = bed_totals(kind->job->matter, kind->tables->matter(), own);
      own[kind->size + k_mass_from] = own[kind->size + k_mass_to] = t.mass;
      std::copy_n(own, width_, row(next_, i));
      const double shown[k_columns] = {t.mean, t.mean, t.mean, t.mass, t.moisture, t.fuel, t.char_mass, t.ash};
      for (std::size_t q = 0; q < k_columns; ++q)
        shown_[q][static_cast<std::size_t>(i)] = shown_next_[q][static_cast<std::size_t>(i)] = shown[q];
      add(come_, t, 1);
    }
  }
  void removed(const Rows& rows, Row i) override {
    if (const Kind* kind = kind_of(rows, i))
      add(come_, bed_totals(kind->job->matter, kind->tables->matter(), row(now_, i)), -1);
  }
  void take_back() override {
    if (clock_ == nullptr || last_step_ < 0 || clock_->step - 1 != last_step_) return;
    swap();
    totals_ = totals_before_;
    last_step_ = -1;
  }

  void sizes(const PartView& w, const Chunk& c, const RowSizes& s) const override {
    const double share = static_cast<double>(w.clock.step % s_.every + 1) / static_cast<double>(s_.every);
    for (Row i = s.lo; i < s.hi; ++i) {
      const Kind* kind = w.rows.is_alive(i) ? kind_of(w.rows, i) : nullptr;
      if (kind == nullptr) continue;
      const double* own = row(now_, i) + kind->size;
      const double from = own[k_radius_from], to = own[k_radius_to], mass = own[k_mass_from], end = own[k_mass_to];
      s.radius[i - s.lo] = share < 1 ? from + share * (to - from) : to;
      s.mass[i - s.lo] = share < 1 ? mass + share * (end - mass) : end;
      const double first = row(now_, i)[bed_row(kind->tables->matter()).radius0];
      if (share == 1 && to < s_.gone_below * first) s.radius[i - s.lo] = 0;
    }
  }

  std::vector<PartValue> values(const PartView& w) const override;

  std::vector<std::uint8_t> save() const override {
    std::vector<double> all = totals_;
    all.insert(all.end(), {come_.heat, come_.mass, come_.moisture, come_.fuel, come_.char_mass, come_.ash});
    all.insert(all.end(), come_.elements, come_.elements + k_bed_elements);
    std::vector<std::uint8_t> bytes(all.size() * sizeof(double));
    std::memcpy(bytes.data(), all.data(), bytes.size());
    return bytes;
  }
  void load(std::span<const std::uint8_t> bytes, const std::string& where) override {
    std::vector<double> all(totals_.size() + 6 + k_bed_elements);
    if (bytes.size() != all.size() * sizeof(double))
      throw Error(ErrorCode::io, "section 'part conversion' has a wrong size", where);
    std::memcpy(all.data(), bytes.data(), bytes.size());
    const double* at = all.data();
    for (double& x : totals_) x = *at++;
    for (double* x : {&come_.heat, &come_.mass, &come_.moisture, &come_.fuel, &come_.char_mass, &come_.ash}) *x = *at++;
    for (double& x : come_.elements) x = *at++;
  }

 private:
  double* row(Column<double>& c, Row i) const { return c.data() + static_cast<std::ptrdiff_t>(width_) * i; }
  const double* row(const Column<double>& c, Row i) const { return c.data() + static_cast<std::ptrdiff_t>(width_) * i; }
  const Kind* kind_of(const Rows& rows, Row i) const {
    const Kind& k = kinds_[rules_.has.materials ? rows.material[i] : 0];
    return k.job ? &k : nullptr;
  }
  static void add(BedTotals& to, const BedTotals& t, double sign) {
    to.heat += sign * t.heat;
    to.mass += sign * t.mass;
    to.moisture += sign * t.moisture;
    to.fuel += sign * t.fuel;
    to.char_mass += sign * t.char_mass;
    to.ash += sign * t.ash;
    for (int e = 0; e < k_bed_elements; ++e) to.elements[e] += sign * t.elements[e];
  }

  void add_kind(std::size_t k) {
    Kind& kind = kinds_[k];
    kind.job = s_.matter[k];
    const Material& m = rules_.scene.materials[k];
    const Matter& matter = kind.job->matter;
    if (!(std::fabs(matter.density - m.density) <= 1e-9 * m.density))
      throw Error(ErrorCode::scene,
                  fmt::format("material '{}' has {:g} kg/m3, the grain that describes it {:g}", m.name, m.density,
                              matter.density),
                  "conversion", "the same density in both");
    if (kind.job->around.surface_temperature)
      throw Error(ErrorCode::scene, "the surface temperature of grains in a bed cannot be given", "conversion",
                  "temperature and film of the gas");
    kind.tables = std::make_unique<BedTables>(matter, s_.shells, kind.job->around.gas, kind.job->around.law);
    kind.size = bed_row(kind.tables->matter()).size;
    width_ = std::max(width_, kind.size);
    for (const Gas& g : matter.gases) {
      const auto at = std::find(gases_.begin(), gases_.end(), g.name);
      kind.gases.push_back(static_cast<std::size_t>(at - gases_.begin()));
      if (at == gases_.end()) gases_.push_back(g.name);
    }
  }

  void advance(const PartView& w, const Chunk& c) {
    const auto count = static_cast<std::size_t>(c.hi - c.lo);
    std::copy_n(row(now_, c.lo), count * static_cast<std::size_t>(width_), row(next_, c.lo));
    std::fill_n(books_.data() + static_cast<std::ptrdiff_t>(books_width_) * c.lo,
                count * static_cast<std::size_t>(books_width_), 0.0);
    for (std::size_t q = 0; q < k_columns; ++q)
      std::copy_n(shown_[q].data() + c.lo, count, shown_next_[q].data() + c.lo);
    std::vector<Row> rows;
    for (std::size_t k = 0; k < kinds_.size(); ++k) {
      if (!kinds_[k].job) continue;
      rows.clear();
      for (Row i = c.lo; i < c.hi; ++i)
        if (w.rows.p2[4L * i] < k_far && kind_of(w.rows, i) == &kinds_[k]) rows.push_back(i);
      if (!rows.empty()) advance(w, kinds_[k], rows);
    }
  }

  void advance(const PartView& w, const Kind& kind, const std::vector<Row>& rows) {
    const BedMatter& m = kind.tables->matter();
    const std::size_t stride = (rows.size() + 7) / 8 * 8;
    std::vector<double> in(k_bed_in * stride), out(static_cast<std::size_t>(k_out_released + m.gases) * stride);
    std::vector<double> scratch(static_cast<std::size_t>(bed_scratch(m)) + 8);
    std::vector<double*> to;
    for (const Row i : rows) to.push_back(row(next_, i));
    surroundings(w, kind, in, stride);
    GrainBatch b;
    b.grains = static_cast<long>(rows.size());
    b.row = to.data();
    b.in = in.data();
    b.out = out.data();
    b.stride = static_cast<long>(stride);
    b.dt = w.rules.scene.dt * static_cast<double>(s_.every);
    b.pressure = kind.job->around.pressure;
    b.scratch = reinterpret_cast<double*>((reinterpret_cast<std::uintptr_t>(scratch.data()) + 63) / 64 * 64);
    solver_(m, b);
    for (std::size_t k = 0; k < rows.size(); ++k) take(kind, rows[k], out.data() + k, stride);
  }

  /// Those of the grain file at the middle of the step.
  void surroundings(const PartView& w, const Kind& kind, std::vector<double>& in, std::size_t stride) const {
    const double dt = w.rules.scene.dt;
    const double t = (static_cast<double>(w.clock.step + 1) - 0.5 * static_cast<double>(s_.every)) * dt;
    const SurroundingsOverTime& a = kind.job->around;
    const auto set = [&](BedIn column, double x) {
      std::fill_n(in.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(column) * stride), stride, x);
    };
    const double gas = a.temperature.at(t), contact = a.contact_conductance.at(t);
    set(k_in_gas, gas);
    set(k_in_velocity, a.velocity.at(t));
    set(k_in_wall, a.wall_temperature ? a.wall_temperature->at(t) : gas);
    set(k_in_sees, a.wall_temperature ? 1 : 0);
    set(k_in_flux, a.flux.at(t));
    set(k_in_contact, contact);
    set(k_in_contact_heat, contact * (a.contact_temperature ? a.contact_temperature->at(t) : gas));
    set(k_in_film, a.film ? a.film->at(t) : -1);
    set(k_in_oxygen, a.oxygen.at(t));
    set(k_in_carbon_dioxide, a.carbon_dioxide.at(t));
    set(k_in_steam, a.steam.at(t));
  }

  /// What the solver says of a row: numbers for files, ledger, the sizes to come.
  void take(const Kind& kind, Row i, const double* out, std::size_t stride) {
    const auto of = [&](int column) { return out[static_cast<std::size_t>(column) * stride]; };
    for (std::size_t q = 0; q < k_columns; ++q) shown_next_[q][static_cast<std::size_t>(i)] = of(k_shown[q].column);
    double* books = books_.data() + static_cast<std::ptrdiff_t>(books_width_) * i;
    for (std::size_t q = 0; q < k_fixed_books; ++q) books[q] = of(k_books[q]);
    for (std::size_t g = 0; g < kind.gases.size(); ++g)
      books[k_fixed_books + kind.gases[g]] = of(k_out_released + static_cast<int>(g));
    double* own = row(next_, i) + kind.size;
    own[k_radius_from] = own[k_radius_to];
    own[k_radius_to] = of(k_out_radius);
    own[k_mass_from] = own[k_mass_to];
    own[k_mass_to] = of(k_out_mass);
  }

  void finish(const PartView& w) {
    totals_before_ = totals_;
    std::vector<double> sum(totals_.size());
    for (Row b = 0; b < w.rows.n; b += k_rows) {
      std::fill(sum.begin(), sum.end(), 0.0);
      for (Row i = b; i < std::min<Row>(w.rows.n, b + k_rows); ++i) {
        if (!w.rows.is_alive(i)) continue;
        const double* x = books_.data() + static_cast<std::ptrdiff_t>(books_width_) * i;
        for (std::size_t q = 0; q < sum.size(); ++q) sum[q] = sum[q] + x[q];
      }
      for (std::size_t q = 0; q < sum.size(); ++q) totals_[q] = totals_[q] + sum[q];
    }
    swap();
    clock_ = &w.clock;
    last_step_ = w.clock.step;
  }
  void swap() {
    std::swap(now_, next_);
    for (std::size_t q = 0; q < k_columns; ++q) std::swap(shown_[q], shown_next_[q]);
  }

  const Rules& rules_;
  const ConversionSettings s_;
  const GrainSolver solver_;
  std::vector<Kind> kinds_;
  std::vector<std::string> gases_;
  int width_ = 0, books_width_ = 0;
  Column<double> now_, next_, books_;
  Column<double> shown_[k_columns], shown_next_[k_columns];
  std::vector<double> totals_, totals_before_;  ///< as k_books, then gases
  BedTotals come_;                              ///< with grains, less what went with them
  const Clock* clock_ = nullptr;
  std::int64_t last_step_ = -1;
};

std::vector<PartValue> Conversion::values(const PartView& w) const {
  BedTotals now;
  for (Row b = 0; b < w.rows.n; b += k_rows) {
    BedTotals part;
    for (Row i = b; i < std::min<Row>(w.rows.n, b + k_rows); ++i)
      if (const Kind* kind = w.rows.is_alive(i) ? kind_of(w.rows, i) : nullptr)
        add(part, bed_totals(kind->job->matter, kind->tables->matter(), row(now_, i)), 1);
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
  for (std::size_t g = 0; g < gases_.size(); ++g)
    out.push_back({"conversion.released_" + gases_[g], "kg", totals_[k_fixed_books + g]});
  return out;
}

}  // namespace

std::unique_ptr<Part> make_conversion(const Rules& rules, const ConversionSettings& settings) {
  return std::make_unique<Conversion>(rules, settings);
}

}  // namespace talus
