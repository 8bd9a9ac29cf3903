// The part as the engine sees it: columns, nodes, comings and goings, numbers of the series, bytes of a checkpoint.
#include "scheduler/parts/heat.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "core/base/error.hpp"
#include "core/rules/adhesion.hpp"
#include "core/rules/laws/law.hpp"
#include "scheduler/parts/heat_scene.hpp"

namespace talus {
namespace {

constexpr std::uint64_t k_seed = 110;  // of its terms in the state hash, and those after it
constexpr double k_hot = 5000;         // temperatures that friction may bring [K]

double reduced_modulus(double young_a, double poisson_a, double young_b, double poisson_b) {
  return 1 / ((1 - poisson_a * poisson_a) / young_a + (1 - poisson_b * poisson_b) / young_b);
}

HeatPair pair_of(const Rules& rules, int a, int b) {
  const Scene& scene = rules.scene;
  const Material &m = scene.materials[static_cast<std::size_t>(a)], &k = scene.materials[static_cast<std::size_t>(b)];
  const MatterHeat &g = scene.heat.matter[static_cast<std::size_t>(a)],
                   &h = scene.heat.matter[static_cast<std::size_t>(b)];
  HeatPair p;
  if (law_of(scene).adhesion != nullptr) {
    p.radius = HeatPair::Radius::neck;
    p.kappa = adhesion_length(scene, a, b);
  }
  if (!(g.young > 0 && h.young > 0)) return p;
  const double real = reduced_modulus(g.young, m.poisson, h.young, k.poisson);
  if (!rules.law.info->wants_reff) {  // a spring knows no modulus
    p.radius = HeatPair::Radius::force;
    p.kn = scene.contact.normal_stiffness;
    p.e_star = real;
  } else {
    const double softer = reduced_modulus(m.young, m.poisson, k.young, k.poisson) / real;
    p.scale = scene.heat.softening == HeatSoftening::load ? det::cbrt(softer) : det::pow(softer, 0.2);
  }
  return p;
}

/// Lowest temperature that the scene gives: without friction no grain is ever colder.
double coldest(const HeatScene& h) {
  double T = h.temperature;
  for (const SourceHeat& s : h.sources) T = fmin2(T, s.temperature);
  for (const WallHeat& w : h.walls)
    if (w.temperature.given()) T = fmin2(T, w.temperature.least());
  if (h.gas.on) T = fmin2(T, h.gas.temperature.least());
  if (h.radiation.enclosure.given()) T = fmin2(T, h.radiation.enclosure.least());
  return T;
}

/// Sum of value(i) over living rows in blocks of 1024 (I3).
template <class F>
double sum_rows(const Rows& rows, F value) {
  double total = 0;
  for (Row b = 0; b < rows.n; b += 1024) {
    double part = 0;
    for (Row i = b; i < std::min<Row>(rows.n, b + 1024); ++i)
      if (rows.is_alive(i)) part = part + value(static_cast<std::size_t>(i));
    total = total + part;
  }
  return total;
}

class Heat final : public Part, public GrainHeat {
 public:
  explicit Heat(const Rules& rules) : rules_(rules), s_(rules) {}

  std::string name() const override { return "heat"; }
  const Column<double>& temperature() const override { return s_.temperature; }
  double flow(Row i) const override { return s_.flow[static_cast<std::size_t>(i)]; }
  double conductance(Row i) const override { return s_.conductance[static_cast<std::size_t>(i)]; }
  double before(Row i) const override { return s_.next_temperature[static_cast<std::size_t>(i)]; }
  GasNear given_gas(const PartView& w, Row i) const override { return talus::given_gas(s_, w, i); }
  void set_surface(Row i, double T) override { s_.temperature[static_cast<std::size_t>(i)] = T; }

  void add_columns(Columns& columns) override {
    const auto info = [](const char* name, const char* unit, const char* why, bool saved, std::uint64_t seed) {
      ColumnInfo i;
      i.name = name;
      i.unit = unit;
      i.why = why;
      i.saved = saved;
      i.moves = saved;
      i.hash_seed = seed;
      return i;
    };
    ColumnInfo temperature = info("temperature", "K", "heat", true, k_seed);
    temperature.output = true;
    columns.add(temperature, s_.temperature, &s_.next_temperature);
    columns.add(info("enthalpy", "J", "heat", true, k_seed + 1), s_.enthalpy, &s_.next_enthalpy);
    ColumnInfo molten = info("molten", "-", "material.heat.latent_heat", true, 0);
    molten.in = s_.molten.any;
    molten.output = s_.molten.any;
    columns.add(molten, s_.molten.share, &s_.molten.next);
    ColumnInfo size = info("radii of expansion", "m", "material.heat.expansion", true, k_seed + 3);
    size.in = s_.sizes.any;
    size.width = 2;
    columns.add(size, s_.sizes.radii, &s_.sizes.next);
    columns.add(info("heat flow", "W", "heat", false, 0), s_.flow);
    columns.add(info("heat conductance", "W/K", "heat", false, 0), s_.conductance);
    ColumnInfo loss = info("heat of friction", "J", "heat.friction", true, k_seed + 2);
    loss.in = s_.scene.friction;
    columns.add(loss, s_.loss);
    ColumnInfo held = info("held temperature", "", "source.hold_temperature", true, 0);
    held.in = s_.any_held;
    columns.add(held, s_.held);
  }

  std::vector<PartNode> nodes() override {
    std::vector<PartNode> all{{"heat_contacts",
                               PartNode::When::contacts,
                               {{"temperature", true}, {"contacts"}, {"p", true}},
                               {{"heat flow"}, {"heat conductance"}},
                               s_.scene.every,
                               [this](const PartView& w, const Chunk& c) { heat_contacts(s_, w, c); }},
                              {"heat_step",
                               PartNode::When::step,
                               {{"heat flow"}, {"heat conductance"}, {"p"}, {"walls"}, {"wall history"}},
                               {{"temperature"}, {"enthalpy"}},
                               s_.scene.every,
                               [this](const PartView& w, const Chunk&) { heat_step(s_, w); }}};
    if (!s_.scene.lasers.empty()) all[1].reads.push_back({"laser heat"});
    if (s_.molten.any) all[1].writes.push_back({"molten"});
    if (s_.sizes.any) all[1].writes.push_back({"radii of expansion"});
    if (std::find(s_.shells.begin(), s_.shells.end(), 1) != s_.shells.end())
      for (PartNode& n : all) n.reads.push_back({"grain surface", true});
    if (s_.scene.friction)
      all.push_back({"heat_friction",
                     PartNode::When::rows,
                     {{"energy rows"}},
                     {{"heat of friction"}},
                     1,
                     [this](const PartView& w, const Chunk& c) { add_losses(w, c); }});
    return all;
  }

  void appended(const Rows& rows, Row first, const NewParticles& a) override {
    for (std::size_t k = 0; k < a.size(); ++k) {
      const Row i = first + static_cast<Row>(k);
      const auto at = static_cast<std::size_t>(i), source = static_cast<std::size_t>(a.source[k]);
      const SourceHeat& h = s_.scene.sources[source];
      const std::size_t m = rules_.has.materials ? rows.material[i] : 0;
      if (s_.shells[m] != 0 && h.held)
        throw Error(
            ErrorCode::scene,
            fmt::format("source {} holds the temperature of grains that convert, which follow their shells", source),
            rules_.scene.file, "hold_temperature = false");
      // the heat of grains with shells is conversion's
      const double E = s_.shells[m] != 0 ? 0 : mass_of(rules_, rows, i) * s_.matter[m].enthalpy.at(h.temperature);
      s_.temperature[at] = s_.next_temperature[at] = h.temperature;
      s_.enthalpy[at] = s_.next_enthalpy[at] = E;
      if (s_.molten.any)
        s_.molten.share[at] = s_.molten.next[at] =
            s_.matter[m].enthalpy.molten(s_.matter[m].enthalpy.at(h.temperature));
      if (s_.sizes.any) {
        const double r = rows.p[4L * i + 3], sizes[] = {r, r / (1 + s_.matter[m].expansion * h.temperature)};
        for (Column<double>* c : {&s_.sizes.radii, &s_.sizes.next}) std::copy_n(sizes, 2, c->data() + 2L * i);
      }
      if (s_.any_held) s_.held[at] = static_cast<std::int16_t>(h.held ? source + 1 : 0);
      s_.totals.sources += E;
    }
  }
  void removed(const Rows&, Row i) override { s_.totals.removed += s_.enthalpy[static_cast<std::size_t>(i)]; }
  void take_back() override {
    if (s_.clock == nullptr || s_.last_step < 0 || s_.clock->step - 1 != s_.last_step) return;
    std::swap(s_.temperature, s_.next_temperature);
    std::swap(s_.enthalpy, s_.next_enthalpy);
    std::swap(s_.molten.share, s_.molten.next);
    std::swap(s_.sizes.radii, s_.sizes.next);
    s_.totals = s_.totals_before;
    s_.pace.steps = s_.pace.steps_before;
    s_.pace.error = s_.pace.error_before;
    s_.last_step = -1;
  }

  std::vector<PartValue> values(const PartView& w) const override;
  bool resizes() const override { return s_.sizes.any; }
  void sizes(const PartView& w, const Chunk&, const RowSizes& s) const override {
    const auto left = static_cast<double>(s_.pace.steps - w.clock.step % s_.pace.steps);  // steps, this one too
    for (Row i = s.lo; i < s.hi; ++i) {
      if (!w.rows.is_alive(i) || !(s_.matter[static_cast<std::size_t>(s_.material(w, i))].expansion > 0)) continue;
      // from the radius that it has: of a grain that was held until now not that of the last heat step
      const double to = s_.sizes.radii[2 * static_cast<std::size_t>(i)];
      double& r = s.radius[i - s.lo];
      r = left > 1 ? r + (to - r) / left : to;
    }
  }

  std::vector<std::string> advice(const PartView& w) const override { return heat_advice(s_, w); }
  std::vector<PartConcern> concerns() override { return std::exchange(s_.pace.concerns, {}); }

  std::pair<std::string, std::string> contact_column() const override { return {"heat_flow", "W"}; }
  double of_contact(const PartView& w, Row i, Row j, int wall, double overlap) const override {
    return j < 0 ? heat_of_wall(s_, w, i, wall, overlap) : heat_of_pair(s_, w, i, j, overlap);
  }

  std::vector<std::uint8_t> save() const override {
    std::vector<double> all{static_cast<double>(s_.wall_flow.size()), static_cast<double>(s_.source_flow.size())};
    const HeatTotals& t = s_.totals;
    for (const double x : {t.sources, t.removed, t.walls, t.gas, t.radiation, t.friction, t.held, t.inside})
      all.push_back(x);
    for (const auto* list : {&s_.wall_flow, &s_.wall_heat, &s_.source_flow})
      all.insert(all.end(), list->begin(), list->end());
    if (s_.scene.error > 0) all.insert(all.end(), {static_cast<double>(s_.pace.steps), s_.pace.error});
    std::vector<std::uint8_t> bytes(all.size() * sizeof(double));
    std::memcpy(bytes.data(), all.data(), bytes.size());
    return bytes;
  }
  void load(std::span<const std::uint8_t> bytes, const std::string& where) override;
  std::uint64_t hash() const override {
    return s_.scene.error > 0 ? static_cast<std::uint64_t>(s_.pace.steps) * 0x9e3779b97f4a7c15ULL : 0;
  }

 private:
  void add_losses(const PartView& w, const Chunk& c) {
    if (w.clock.step <= w.rules.scene.relax.steps) return;  // as the ledger counts
    for (Row i = c.lo; i < c.hi; ++i) {
      const double* e = w.energy.data() + 4L * i;
      double& loss = s_.loss[static_cast<std::size_t>(i)];
      loss = loss + (e[1] + e[2]);
    }
  }
  void add_conductivities(const PartView& w, std::vector<PartValue>& out) const;

  const Rules& rules_;
  HeatState s_;
};

void Heat::load(std::span<const std::uint8_t> bytes, const std::string& where) {
  const auto fail = [&] { throw Error(ErrorCode::io, "section 'part heat' has a wrong size", where); };
  std::vector<double> all(bytes.size() / sizeof(double));
  if (bytes.size() % sizeof(double) != 0 || all.size() < 10) fail();
  std::memcpy(all.data(), bytes.data(), bytes.size());
  const double* at = all.data() + 2;
  HeatTotals& t = s_.totals;
  for (double* x : {&t.sources, &t.removed, &t.walls, &t.gas, &t.radiation, &t.friction, &t.held, &t.inside})
    *x = *at++;
  const std::size_t paced = s_.scene.error > 0 ? 2 : 0;
  if (all.size() != 10 + 2 * static_cast<std::size_t>(all[0]) + static_cast<std::size_t>(all[1]) + paced) fail();
  if (paced > 0) s_.pace.steps = static_cast<std::int64_t>(all[all.size() - 2]), s_.pace.error = all.back();
  std::int64_t length = s_.scene.every;
  while (length < s_.pace.steps) length *= 2;
  if (length != s_.pace.steps)
    throw Error(ErrorCode::scene,
                fmt::format("the present heat step has {} steps, no power of two times heat.every", s_.pace.steps),
                where, "heat.every as before");
  // a scene that names other walls than before begins their sums anew
  if (all[0] != static_cast<double>(s_.wall_flow.size()) || all[1] != static_cast<double>(s_.source_flow.size()))
    return;
  for (auto* list : {&s_.wall_flow, &s_.wall_heat, &s_.source_flow})
    for (double& x : *list) x = *at++;
}

std::vector<PartValue> Heat::values(const PartView& w) const {
  const HeatTotals& t = s_.totals;
  double low = k_never, high = 0;
  for (Row i = 0; i < w.rows.n; ++i)
    if (w.rows.is_alive(i)) {
      low = fmin2(low, s_.temperature[static_cast<std::size_t>(i)]);
      high = fmax2(high, s_.temperature[static_cast<std::size_t>(i)]);
    }
  const double all = sum_rows(w.rows, [&](std::size_t i) { return s_.enthalpy[i]; });
  const double sum =
      sum_rows(w.rows, [&](std::size_t i) { return w.rows.leads(static_cast<Row>(i)) ? s_.temperature[i] : 0.0; });
  const auto* laser = part_as<LaserLight>(w.parts);
  const double in = t.sources - t.removed + t.walls + t.gas + t.radiation + t.friction + t.held + t.inside +
                    (laser != nullptr ? laser->absorbed() : 0.0);
  const bool any = w.rows.alive > 0;
  std::vector<PartValue> out{{"heat.total", "J", all},
                             {"heat.in_by_sources", "J", t.sources - t.removed},
                             {"heat.in_by_walls", "J", t.walls},
                             {"heat.in_by_gas", "J", t.gas},
                             {"heat.in_by_radiation", "J", t.radiation},
                             {"heat.in_by_friction", "J", t.friction},
                             {"heat.in_by_held", "J", t.held},
                             {"heat.residual", "J", all - in},
                             {"heat.lowest", "K", any ? low : 0.0},
                             {"heat.mean", "K", any ? sum / static_cast<double>(w.rows.grains()) : 0.0},
                             {"heat.highest", "K", high}};
  if (laser != nullptr) out.push_back({"heat.in_by_laser", "J", laser->absorbed()});
  if (s_.molten.any)
    out.push_back({"heat.molten", "kg", sum_rows(w.rows, [&](std::size_t i) {
                     return mass_of(rules_, w.rows, static_cast<Row>(i)) * s_.molten.share[i];
                   })});
  if (s_.scene.error > 0) {
    out.push_back({"heat.steps", "", static_cast<double>(s_.pace.steps)});
    out.push_back({"heat.step_error", "K", s_.pace.error});
  }
  if (part_as<GrainInside>(w.parts) != nullptr) out.push_back({"heat.into_shells", "J", -t.inside});
  for (std::size_t k = 0; k < s_.scene.walls.size(); ++k)
    out.push_back({"heat.flow." + s_.scene.walls[k].wall, "W", s_.wall_flow[k]});
  for (std::size_t k = 0; k < s_.scene.sources.size(); ++k)
    if (s_.scene.sources[k].held) out.push_back({"heat.flow.source_" + std::to_string(k), "W", s_.source_flow[k]});
  add_conductivities(w, out);
  return out;
}

/// Of the bed between two sides of the domain that have temperatures: mean flow, over area and gradient.
void Heat::add_conductivities(const PartView& w, std::vector<PartValue>& out) const {
  for (int axis = 0; axis < 3; ++axis) {
    const std::string side = std::string("domain_") + "xyz"[axis];
    std::size_t at[2] = {s_.scene.walls.size(), s_.scene.walls.size()};
    for (std::size_t k = 0; k < s_.scene.walls.size(); ++k) {
      if (!s_.scene.walls[k].temperature.given()) continue;
      if (s_.scene.walls[k].wall == side + "_lower") at[0] = k;
      if (s_.scene.walls[k].wall == side + "_upper") at[1] = k;
    }
    if (at[0] == s_.scene.walls.size() || at[1] == s_.scene.walls.size()) continue;
    const double now = static_cast<double>(w.clock.step) * w.rules.scene.dt, length = w.rules.size[axis];
    const double area = w.rules.size[(axis + 1) % 3] * w.rules.size[(axis + 2) % 3];
    const double fall = s_.scene.walls[at[0]].temperature(now) - s_.scene.walls[at[1]].temperature(now);
    const double flow = 0.5 * (s_.wall_flow[at[0]] - s_.wall_flow[at[1]]);
    out.push_back(
        {std::string("heat.conductivity_") + "xyz"[axis], "W/m/K", fall != 0 ? flow * length / (area * fall) : 0.0});
  }
}

}  // namespace

HeatState::HeatState(const Rules& rules) : scene(rules.scene.heat) {
  pace.steps = scene.every;
  if (rules.has.bodies) sizes.areas = areas_of_shapes(rules.scene);
  const double cold = coldest(scene);
  for (const MatterHeat& m : scene.matter) {
    HeatMatter q;
    const heat::Property capacity = heat::Property::of(m.capacity);
    q.enthalpy =
        m.latent_heat > 0 ? heat::Enthalpy(capacity, m.solidus, m.liquidus, m.latent_heat) : heat::Enthalpy(capacity);
    molten.any = molten.any || q.enthalpy.melts();
    q.conductivity = heat::Property::of(m.conductivity);
    q.emissivity = m.emissivity;
    q.expansion = m.expansion;
    sizes.any = sizes.any || m.expansion > 0;
    q.least_capacity = capacity.least_on(cold, k_hot);
    matter.push_back(q);
  }
  for (std::size_t k = 0; k < matter.size(); ++k)
    shells.push_back(talus::has_shells(rules.scene.conversion, k) ? 1 : 0);
  const int n = static_cast<int>(matter.size());
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) pairs.push_back(pair_of(rules, a, b));
  for (const SourceHeat& s : scene.sources) any_held = any_held || s.held;
  wall_flow.assign(scene.walls.size(), 0.0);
  wall_heat.assign(scene.walls.size(), 0.0);
  if (any_held) source_flow.assign(scene.sources.size(), 0.0);
}

std::unique_ptr<Part> make_heat(const Rules& rules) {
  if (!rules.scene.heat.on) return nullptr;
  refuse_odd_heat(rules);
  return std::make_unique<Heat>(rules);
}

}  // namespace talus
