// Part "gas": the gas in the voids (core/gas) and the grains. Every gas.every steps the grains are shared among the
// cells, the gas makes a step over that time, and each grain gets the law of its force until the next one; in every
// step the force of that law at the grain's present velocity joins those of its contacts. Where grains have
// temperatures or shells it exchanges heat and species with them (doors.hpp). Invariants: I3 (rows in order), I7.
#include "core/gas/gas.hpp"

#include <xxhash.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "core/base/det_math.hpp"
#include "core/base/error.hpp"
#include "core/gas/drag.hpp"
#include "core/gas/openings.hpp"
#include "core/gas/species.hpp"
#include "scheduler/parts/doors.hpp"
#include "scheduler/parts/gas_coupling.hpp"
#include "scheduler/parts/gas_report.hpp"

namespace talus {

namespace {

constexpr std::uint64_t k_force_seed = 130, k_gas_seed = 133;
constexpr double k_most_drag = 0.5;  // of a step: drag * dt / mass

std::array<bool, 3> wrapped_axes(const Scene& s) {
  std::array<bool, 3> wraps{};
  for (int k = 0; k < 3; ++k)
    wraps[static_cast<std::size_t>(k)] =
        s.domain.periodic(k) && s.gas.lower[k] == s.domain.lower[k] && s.gas.upper[k] == s.domain.upper[k];
  return wraps;
}

class GasPart final : public Part, public GasCells {
 public:
  explicit GasPart(const Rules& rules)
      : scene_(rules.scene),
        gas_(rules.scene.gas, wrapped_axes(rules.scene), rules.scene.gravity),
        grains_(rules.scene),
        thermal_(rules.scene.heat.on) {
    if (thermal_ && scene_.gas.every != scene_.heat.every)
      throw Error(ErrorCode::scene, "gas.every must be heat.every", scene_.file, "the same number of steps");
    for (int k = 0; k < 3; ++k)
      if (gas_.grid().h[k] < gas::k_smallest_cell * rules.r_max)
        throw Error(ErrorCode::scene, "gas.cells: edges of cells are below a third of the largest radius",
                    rules.scene.file, "fewer cells");
  }

  std::string name() const override { return "gas"; }

  void add_columns(Columns& columns) override {
    ColumnInfo i;
    i.name = "gas force";
    i.label = "gas force, next";
    i.unit = "kg/s, m/s, N";
    i.why = "gas";
    i.width = k_width<GasForce>;
    i.saved = true;
    i.optional = true;
    i.hash_seed = k_force_seed;
    columns.add(i, force_, &next_);
    ColumnInfo h;
    h.name = "gas heat";
    h.unit = "W";
    h.why = "gas beside heat";
    h.in = thermal_;
    h.moves = false;
    columns.add(h, heat_);
    ColumnInfo a = h;
    a.name = "gas around";
    a.unit = "W/K, W/m2/K, m/s";
    a.width = k_width<GasAtGrain>;
    columns.add(a, around_);
  }

  std::vector<PartNode> nodes() override {
    std::vector<PartNode> all{{"gas_force",
                               PartNode::When::contacts,
                               {{"v"}, {"gas force"}},
                               {{"force rows"}},
                               1,
                               [this](const PartView& w, const Chunk& c) { push(w, c); }}};
    if (scene_.output.energies)
      all.push_back({"gas_work",
                     PartNode::When::step,
                     {{"v"}, {"v2"}, {"gas force"}},
                     {{"gas work"}},
                     1,
                     [this](const PartView& w, const Chunk&) { add_work(w); }});
    std::vector<Access> reads{{"p"}, {"v"}};
    if (thermal_) reads.push_back({"temperature"});
    all.push_back({"gas_step",
                   PartNode::When::step,
                   reads,
                   {{"gas"}, {"gas force"}, {"gas heat"}, {"gas around"}},
                   scene_.gas.every,
                   [this](const PartView& w, const Chunk&) { step(w); }});
    return all;
  }

  void appended(const Rows&, Row first, const NewParticles& a) override {
    for (std::size_t k = 0; k < a.size(); ++k) {
      const Row i = first + static_cast<Row>(k);
      set_row(force_, i, GasForce{});
      set_row(next_, i, GasForce{});
    }
  }

  void take_back() override {
    work_ = work_before_;
    if (clock_ == nullptr || clock_->step != gas_step_ + 1) return;
    std::swap(force_, next_);
    gas_.load(before_, "the step before");
  }

  double step_limit(const PartView& w) const override {
    const double e = 0.4, rho = scene_.gas.pressure / (287 * scene_.gas.temperature);
    const double mu = gas::viscosity(scene_.gas.temperature);
    const auto allowed = [&](double mass, GasGrain g) {
      const double mean = g.shape->sphericity * g.diameter;
      return k_most_drag * mass / gas::grain_drag(scene_.gas.drag, e, g.diameter, mean, mu, rho, 0, *g.shape);
    };
    double most = k_never;  // held grains do not move; one that is released later is judged at the next gas step
    for (Row i = 0; i < w.rows.n; ++i)
      if (w.rows.is_alive(i) && w.rows.leads(i) && velocity_of(w.rows, i).inverse_mass > 0)
        most = fmin2(most, allowed(mass_of(w.rules, w.rows, i), grains_.of(w.rows, i)));
    for (const Source& s : scene_.sources) {
      if (s.kind == Source::Kind::file) continue;  // its grains are there
      const double d = s.size.smallest(), density = density_of(s);
      most = fmin2(most, allowed(density * det::k_pi / 6 * (d * d * d), grains_.of(s, d)));
    }
    return most;
  }

  std::vector<PartValue> values(const PartView& w) const override {
    if (gas_.started()) return gas_values(gas_, scene_, axis(), total_force(w));
    return gas_values(fresh(w), scene_, axis(), total_force(w));
  }

  std::vector<std::string> advice(const PartView&) const override { return grains_.advice(); }
  std::vector<PartConcern> concerns() override { return std::exchange(concerns_, {}); }

  // --- what other parts see of it ---
  double heat(Row i) const override { return heat_[static_cast<std::size_t>(i)]; }
  double conductance(Row i) const override { return row_of<GasAtGrain>(around_, i).conductance; }
  GasNear near(Row i) const override;
  void offer(const PartView& w, const std::vector<GasUptake>& uptake) override { matter_.offer(w.rows.n, uptake); }
  double saturable(Row i) const override { return matter_.saturable(i); }
  GasSteam steam(Row i) const override { return matter_.steam(i); }
  void give(Row i, const GasFractions& released, const std::array<double, 3>& taken, double condensed,
            double enthalpy) override {
    matter_.give(i, released, taken, condensed, enthalpy);
  }
  void settle() override { gas_.settle(); }

  double work() const override { return work_.done; }
  std::uint64_t hash() const override {
    std::vector<std::uint8_t> bytes = save();
    std::fill_n(bytes.begin(), sizeof work_, std::uint8_t{0});  // a sum for output, with output.energies alone
    return XXH3_64bits_withSeed(bytes.data(), bytes.size(), k_gas_seed);
  }

  std::optional<GridData> grid(const PartView& w) const override {
    if (gas_.started()) return grid_data(gas_.grid(), gas_.fields());
    const gas::Gas g = fresh(w);
    return grid_data(g.grid(), g.fields());
  }

  std::vector<std::uint8_t> save() const override {
    std::vector<std::uint8_t> bytes(sizeof work_);
    std::memcpy(bytes.data(), &work_, sizeof work_);
    if (!gas_.started()) return bytes;
    const std::vector<std::uint8_t> state = gas_.save();
    bytes.insert(bytes.end(), state.begin(), state.end());
    return bytes;
  }
  void load(std::span<const std::uint8_t> bytes, const std::string& where) override {
    if (bytes.size() < sizeof work_) throw Error(ErrorCode::io, "section 'part gas' has a wrong size", where);
    std::memcpy(&work_, bytes.data(), sizeof work_);
    work_before_ = work_;
    if (bytes.size() > sizeof work_) gas_.load(bytes.subspan(sizeof work_), where);
  }

 private:
  struct Work {
    double done = 0, power = 0;  ///< [J]; of the last step [W]
  };

  /// What the first gas step will start from.
  gas::Gas fresh(const PartView& w) const {
    gas::Gas g(scene_.gas, wrapped_axes(scene_), w.clock.gravity);
    g.start(grains_in_cells(w));
    return g;
  }

  gas::FromGrains grains_in_cells(const PartView& w) const {
    GasShares shares(grains_);
    gas::FromGrains from(gas_.grid().cells());
    shares.find(w, gas_.grid());
    shares.give(w, from);
    return from;
  }

  int axis() const { return scene_.gas.inlets.empty() ? 2 : gas::axis_of(scene_.gas.inlets.front().side); }

  void push(const PartView& w, const Chunk& c) {
    if (gas_.started() && w.clock.step >= scene_.relax.steps) push_grains(w, c, force_);
  }

  double density_of(const Source& s) const {
    const Material& m = scene_.materials[static_cast<std::size_t>(s.material)];
    return s.shape < 0 ? m.density : scene_.shapes[static_cast<std::size_t>(s.shape)].body->density_of(m);
  }

  /// Sum of of(row) over the living, in blocks of 1024 rows (I3).
  template <class Of>
  static double sum_rows(const Rows& rows, const Of& of) {
    double total = 0;
    for (Row b = 0; b < rows.n; b += 1024) {
      double part = 0;
      for (Row i = b; i < std::min<Row>(rows.n, b + 1024); ++i)
        if (rows.is_alive(i)) part = part + of(i);
      total = total + part;
    }
    return total;
  }

  /// Power at n with the velocity between n-1/2 and n+1/2, by the trapezium rule over [n-1, n].
  void add_work(const PartView& w) {
    work_before_ = work_;
    if (!gas_.started() || w.clock.step < scene_.relax.steps) return;
    const double power = sum_rows(w.rows, [&](Row i) {
      const double *u = velocity_of(w.rows, i, true).v, *v = velocity_of(w.rows, i).v;
      const Vec3 f = row_of<GasForce>(force_, i).at(u);
      return 0.5 * (f.x * (u[0] + v[0]) + f.y * (u[1] + v[1]) + f.z * (u[2] + v[2]));
    });
    work_.done += 0.5 * scene_.dt * (work_.power + power);
    work_.power = power;
  }

  void step(const PartView& w) {
    shares_.find(w, gas_.grid());
    from_.clear(gas_.grid().cells());
    shares_.give(w, from_);
    if (!gas_.started()) gas_.start(from_);
    shares_.weigh(w, scene_.gas, gas_.grid(), gas_.fields(), from_);
    before_ = gas_.save();
    gas_.set_gravity(w.clock.gravity);
    if (thermal_) offer_heat(w);
    gas_.step(from_, scene_.dt * static_cast<double>(scene_.gas.every));
    std::swap(force_, next_);
    clock_ = &w.clock;
    gas_step_ = w.clock.step;
    for (Row i = 0; i < w.rows.n; ++i) {
      set_row(force_, i, GasForce{});  // of the dead, too: the buffer holds what was two gas steps ago
      if (!w.rows.is_alive(i) || !w.rows.leads(i)) continue;
      const GasForce f = shares_.force(w, gas_.grid(), from_, gas_.fields(), i);
      check_drag(w, i, f.drag);
      set_row(force_, i, f);
      if (thermal_) take_heat(i);
    }
    concerns_ = gas_concerns(gas_, scene_, from_, wetted(w));
  }

  void check_drag(const PartView& w, Row i, double drag) const {
    const double m = mass_of(w.rules, w.rows, i);
    if (drag * scene_.dt <= k_most_drag * m || !(velocity_of(w.rows, i).inverse_mass > 0)) return;
    throw Error(ErrorCode::physics,
                "time.step is too long for the drag on grain " + std::to_string(w.rows.id[static_cast<std::size_t>(i)]),
                "step " + std::to_string(w.clock.step), "at most " + at_most(k_most_drag * m / drag) + " s");
  }

  /// The gas takes heat implicitly, at the temperatures that surfaces have now.
  void offer_heat(const PartView& w) {
    const auto* grains = part_as<GrainHeat>(w.parts);
    const auto* inside = part_as<GrainInside>(w.parts);
    for (Row i = 0; i < w.rows.n; ++i) {
      if (!w.rows.is_alive(i) || !w.rows.leads(i)) continue;
      const auto at = static_cast<std::size_t>(i);
      const double t = grains->temperature()[at];
      GasAtGrain a = shares_.around(w, scene_.gas, gas_.fields(), i);
      if (inside != nullptr && has_shells(scene_.conversion, w.rules.has.materials ? w.rows.material[i] : 0))
        a.conductance = thinned(a.conductance, inside->surface(i).carried);
      set_row(around_, i, a);
      shares_.each(i, [&](std::size_t c, double, double weight) {
        from_.conductance[c] += weight * a.conductance;
        from_.heat[c] += weight * a.conductance * t;
      });
      heat_[at] = t;
    }
  }

  /// What the cells have lost to row i in the step, by the conductance that it offered.
  void take_heat(Row i) {
    const auto q = static_cast<std::size_t>(i);
    const double t = heat_[q], conductance = row_of<GasAtGrain>(around_, i).conductance;
    double power = 0;
    shares_.each(i, [&](std::size_t c, double, double weight) {
      power += weight * conductance * (gas_.fields().exchange_temperature[c] - t);
    });
    heat_[q] = power;
  }

  /// Cells whose steam condenses on some grain.
  std::vector<char> wetted(const PartView& w) const {
    std::vector<char> cells(static_cast<std::size_t>(gas_.grid().cells()), 0);
    if (const auto* inside = part_as<GrainInside>(w.parts))
      for (Row i = 0; i < w.rows.n; ++i)
        if (w.rows.is_alive(i) && inside->condenses(w.rows, i))
          shares_.each(i, [&](std::size_t c, double, double) { cells[c] = 1; });
    return cells;
  }

  Vec3 total_force(const PartView& w) const {
    Vec3 total;
    if (!gas_.started()) return total;
    for (int k = 0; k < 3; ++k)
      total[k] = sum_rows(w.rows, [&](Row i) { return row_of<GasForce>(force_, i).at(velocity_of(w.rows, i).v)[k]; });
    return total;
  }

  const Scene& scene_;
  gas::Gas gas_;
  gas::FromGrains from_;
  const GasGrains grains_;
  GasShares shares_{grains_};
  GasMatter matter_{gas_, shares_, scene_.dt* static_cast<double>(scene_.gas.every)};
  const bool thermal_;
  Column<double> force_, next_;  ///< GasForce of this and the last gas step
  Column<double> heat_;          ///< [W]
  Column<double> around_;        ///< GasAtGrain
  Work work_, work_before_;
  const Clock* clock_ = nullptr;      ///< of the run, known from the first gas step on
  std::int64_t gas_step_ = -1;        ///< step of the last gas step
  std::vector<std::uint8_t> before_;  ///< the gas before it
  std::vector<PartConcern> concerns_;
};

GasNear GasPart::near(Row i) const {
  const GasAtGrain a = row_of<GasAtGrain>(around_, i);
  const gas::ToGrains& f = gas_.fields();
  GasNear n;
  n.film = a.film, n.slip = a.slip;
  double moles = 0;  // of a kilogram, times the gas constant
  shares_.each(i, [&](std::size_t c, double, double weight) {
    n.temperature += weight * f.temperature[c];
    n.pressure += weight * f.pressure[c];
    n.steam += weight * f.fractions[c][GasMatter::k_taken[2]];
    moles += weight * gas::specific_gas_constant(f.fractions[c]);
    matter_.add_kept(c, weight, n.kept);
  });
  if (moles > 0) n.molar = gas::k_gas_constant / moles;
  return n;
}

}  // namespace

std::unique_ptr<Part> make_gas(const Rules& rules) {
  return rules.scene.gas.on ? std::make_unique<GasPart>(rules) : nullptr;
}

}  // namespace talus
