// Fills a grain job section by section from checked tables; see grain_file.hpp.
#include "core/conversion/grain_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/count.hpp"
#include "core/base/curve.hpp"
#include "core/base/error.hpp"
#include "core/base/input_file.hpp"
#include "core/conversion/grain_table.hpp"

namespace talus::conversion {
namespace {

/// Errors of the data model get the place in the file.
template <class F>
void placed(const std::string& where, F&& work) {
  try {
    work();
  } catch (const Error& e) {
    throw Error(e.code(), e.what(), where);
  }
}

Composition composition_of(const GrainTable& r) {
  Composition c{};
  double sum = 0;
  for (const auto& [name, share] : r.shares("composition")) {
    const std::string_view names[] = {"C", "H", "O", "ash"};
    std::size_t e = 0;
    while (e < 4 && names[e] != name) ++e;
    if (e == 4) r.fail("composition", fmt::format("'{}' is none of C, H, O, ash", name));
    c[e] = share;
    sum += share;
  }
  if (std::fabs(sum - 1) > 1e-3) r.fail("composition", fmt::format("the shares sum to {:.6g}; must be 1", sum));
  for (double& x : c) x /= sum;
  return c;
}

struct Sections {
  const TomlNode& root;
  std::string name;
  GrainTable one(const char* section) const { return GrainTable(root.find(section), section, section, name); }
  std::vector<GrainTable> many(const char* section) const {
    std::vector<GrainTable> all;
    if (const TomlNode* list = root.find(section))
      for (std::size_t k = 0; k < list->list.size(); ++k)
        all.emplace_back(&list->list[k], section, fmt::format("{}.{}", section, k), name);
    return all;
  }
};

void read_species(const Sections& in, Matter& m) {
  for (const GrainTable& r : in.many("solid")) {
    Solid s{r.text("name"), r.choice<Kind>("kind"), 0, {}};
    if (r.has("composition")) s.composition = composition_of(r);
    bool known = false;
    for (Solid& other : m.solids) {
      if (other.name != s.name) continue;
      if (other.kind != s.kind) r.fail("kind", fmt::format("'{}' of the scheme is of another kind", s.name));
      other.composition = s.composition;
      known = true;
    }
    if (!known) m.solids.push_back(s);
  }
  for (const GrainTable& r : in.many("gas")) {
    Gas g{r.text("name"), {}};
    if (r.has("composition")) g.composition = composition_of(r);
    bool known = false;
    for (Gas& other : m.gases) {
      if (other.name != g.name) continue;
      other.composition = g.composition;
      known = true;
    }
    if (!known) m.gases.push_back(g);
  }
}

template <class List>
std::size_t find(const List& list, const std::string& name) {
  for (std::size_t i = 0; i < list.size(); ++i)
    if (list[i].name == name) return i;
  return list.size();
}

void read_reactions(const Sections& in, Matter& m) {
  for (const GrainTable& r : in.many("reaction")) {
    Reaction x;
    const std::string from = r.text("reactant");
    x.name = r.has("name") ? r.text("name") : "reaction of " + from;
    x.of_gas = find(m.gases, from) < m.gases.size();
    if (!x.of_gas) placed(r.where("reactant"), [&] { x.reactant = m.solid(from); });
    if (x.of_gas) x.reactant = m.gas(from);
    x.A = r.number("A");
    x.n = r.number("n");
    x.E = r.number("E");
    x.heat = r.number("heat");
    for (const auto& [name, mass] : r.shares("products")) {
      const std::size_t gas = find(m.gases, name);
      if (gas < m.gases.size()) {
        x.gases.push_back({gas, mass});
        continue;
      }
      placed(r.where("products"), [&, n = name] { x.solids.push_back({m.solid(n), 0}); });
      if (!(mass > 0)) r.fail("products", fmt::format("the mass of the solid '{}' must be above 0", name));
      x.solids.back().mass = mass;
    }
    m.reactions.push_back(std::move(x));
  }
  for (const GrainTable& r : in.many("char_reaction"))
    m.char_reactions.push_back({r.choice<CharReaction::Oxidant>("oxidant"), r.number("A"), r.number("n"), r.number("E"),
                                r.number("ratio_A"), r.number("ratio_E")});
}

void read_heat_of_pyrolysis(const GrainTable& r, Matter& m, const std::string& scheme) {
  if (!r.has("heat_of_pyrolysis")) return;
  if (scheme == "none" || scheme == "debiagi")
    r.fail("heat_of_pyrolysis", fmt::format("has no effect with scheme = {}; reactions have their own heats", scheme));
  for (Reaction& x : m.reactions) {
    if (x.of_gas) continue;
    double gas = 1;
    for (const Yield& y : x.solids) gas -= y.mass;
    x.heat = gas * r.number("heat_of_pyrolysis");
  }
}

void read_shares(const GrainTable& r, Matter& m) {
  const double moisture = r.number("moisture"), ash = r.number("ash");
  if (moisture > 0) m.solids.push_back({"moisture", Kind::moisture, moisture, {}});
  if (ash > 0) m.solids.push_back({"ash", Kind::ash, ash, {}});
  if (!(moisture + ash < 1)) r.fail("moisture", "moisture and ash leave nothing of the grain");
  double rest = 1 - moisture - ash;
  if (r.has("initial")) {
    double sum = 0;
    for (const auto& [name, share] : r.shares("initial")) {
      placed(r.where("initial"), [&, n = name, of = share] { m.solids[m.solid(n)].initial = of; });
      sum += share;
    }
    if (std::fabs(sum - rest) > 1e-3)
      r.fail("initial",
             fmt::format("the shares sum to {:.6g}; beside moisture and ash they must sum to {:.6g}", sum, rest));
    for (Solid& s : m.solids)
      if (s.name != "moisture" && s.name != "ash") s.initial *= rest / sum;
    return;
  }
  for (Solid& s : m.solids) {
    if (s.kind != Kind::fuel) continue;
    s.initial = rest;
    return;
  }
  m.solids.push_back({"solid", Kind::fuel, rest, {}});
}

void read_properties(const Sections& in, Matter& m) {
  const GrainTable c = in.one("heat_capacity"), k = in.one("conductivity");
  m.heat_capacity[0] = c.property("moisture");
  m.heat_capacity[1] = c.property("fuel");
  m.heat_capacity[2] = c.property_or("char", m.heat_capacity[1]);
  m.heat_capacity[3] = c.property_or("ash", m.heat_capacity[2]);
  m.gas_heat_capacity = c.property("gas");
  m.least_conductivity = k.number("least");
  m.conductivity_by_mass = k.text("weights") == "mass";
  m.conductivity[1] = k.property("fuel");
  m.conductivity_wet = k.property_or("wet", m.conductivity[1]);
  m.conductivity[2] = k.property_or("char", m.conductivity[1]);
  m.conductivity[3] = k.property_or("ash", m.conductivity[2]);
}

void read_material(const Sections& in, Matter& m, const std::string& scheme) {
  const GrainTable r = in.one("material");
  m.density = r.number("density");
  read_species(in, m);
  read_shares(r, m);
  if (scheme != "none") read_heat_of_pyrolysis(r, m, scheme);
  read_reactions(in, m);
  if (r.has("heat_of_pyrolysis") && scheme == "none") read_heat_of_pyrolysis(r, m, scheme);
  if (r.has("reference_temperature")) m.reference_temperature = r.number("reference_temperature");
  const std::vector<double> e = r.numbers("emissivity");
  for (std::size_t k = 0; k < 3; ++k) m.emissivity[k] = e[e.size() == 3 ? k : 0];
  m.porosity = r.number("porosity");
  m.tortuosity_factor = r.number("pore_diffusion");
  m.gas_convection = r.boolean("gas_convection");
  m.blowing = r.boolean("blowing");
  read_properties(in, m);
}

void read_laws(const Sections& in, Matter& m) {
  const GrainTable d = in.one("drying"), s = in.one("shrinkage"), melt = in.one("melting");
  const std::size_t wet = find(m.solids, "moisture");
  if (d.given() && wet == m.solids.size()) d.fail("law", "has no effect without material.moisture");
  const std::string law = d.text("law");
  m.drying.kind = law == "arrhenius" ? Drying::arrhenius : law == "boiling" ? Drying::boiling : Drying::equilibrium;
  if (wet == m.solids.size()) m.drying.kind = Drying::none;
  for (const char* key : {"A", "E"})
    if (d.has(key) && law != "arrhenius") d.fail(key, "has no effect with law = " + law);
  if (d.has("temperature") && law == "arrhenius") d.fail("temperature", "has no effect with law = arrhenius");
  m.drying.A = d.number("A");
  m.drying.E = d.number("E");
  m.drying.temperature = d.number("temperature");
  m.drying.heat = d.number("heat");
  if (m.drying.kind == Drying::arrhenius) {
    if (find(m.gases, "vapour") == m.gases.size()) m.gases.push_back({"vapour", Composition{0, 0, 0, 0, 1}});
    Reaction x{"drying", wet, false, m.drying.A, 0, m.drying.E, m.drying.heat, {}, {{m.gas("vapour"), 1}}};
    // Heat of evaporation holds at every temperature.
    if (m.reference_temperature) x.at_reaction = true;
    m.reactions.push_back(x);
  }
  m.shrinkage = {s.number("drying"), s.number("devolatilisation"), s.number("burn_off")};
  // what was never there has not gone
  const auto begins_with = [&](Kind kind) {
    return std::any_of(m.solids.begin(), m.solids.end(),
                       [&](const Solid& x) { return x.kind == kind && x.initial > 0; });
  };
  if (!begins_with(Kind::moisture)) m.shrinkage.drying = 0;
  if (!begins_with(Kind::fuel)) m.shrinkage.devolatilisation = 0;
  if (!melt.given()) return;
  for (const char* key : {"solidus", "latent_heat"})
    if (!melt.has(key)) melt.missing(key, "required by [melting]");
  m.melting = {melt.number("solidus"), melt.has("liquidus") ? melt.number("liquidus") : melt.number("solidus"),
               melt.number("latent_heat")};
  if (m.melting.liquidus < m.melting.solidus) melt.fail("liquidus", "must not be below solidus");
  if (!m.reactions.empty() || wet < m.solids.size())
    melt.fail("latent_heat", "a grain that melts has neither moisture nor reactions");
}

void read_form(const Sections& in, GrainJob& job) {
  const GrainTable r = in.one("grain");
  job.form.shape = r.choice<heat::Shape>("shape");
  job.form.radius = 0.5 * r.number("diameter");
  if (r.has("length") && job.form.shape != heat::Shape::cylinder)
    r.fail("length", "has no effect without shape = cylinder");
  if (r.has("area") && job.form.shape != heat::Shape::plate) r.fail("area", "has no effect without shape = plate");
  job.form.extent = job.form.shape == heat::Shape::cylinder ? r.number("length")
                    : job.form.shape == heat::Shape::plate  ? 2 * r.number("area")
                                                            : 1;
  job.options.lumped = r.text("level") == "lumped";
  if (job.options.lumped && r.has("shells")) r.fail("shells", "has no effect with level = lumped");
  job.form.shells = job.options.lumped ? 1 : static_cast<std::size_t>(r.integer("shells"));
  job.temperature = r.number("temperature");
}

void read_time(const Sections& in, GrainJob& job) {
  const GrainTable r = in.one("time");
  job.step = r.number("step");
  const double steps = r.number("duration") / job.step;
  if (!(steps <= 1e9)) r.fail("duration", "is more than 1e9 steps");
  job.steps = count_nearest(steps);
  job.output_steps = r.has("output_every") ? count_nearest(r.number("output_every") / job.step) : 1;
  if (job.output_steps < 1) r.fail("output_every", "must not be below time.step");
  job.options.method = r.text("method") == "euler" ? Method::euler : Method::tr_bdf2;
  job.options.iterations = static_cast<int>(r.integer("iterations"));
}

void read_surroundings(const Sections& in, GrainJob& job) {
  const GrainTable r = in.one("surroundings");
  SurroundingsOverTime& a = job.around;
  a.gas = r.text("gas") == "air" ? k_air : k_nitrogen;
  a.law = r.choice<FilmLaw>("law");
  a.temperature = r.series("temperature");
  a.velocity = r.series("velocity");
  a.flux = r.series("flux");
  a.contact_conductance = r.series("contact_conductance");
  a.oxygen = r.series("oxygen");
  a.carbon_dioxide = r.series("carbon_dioxide");
  a.steam = r.series("steam");
  a.rest = r.has("oxygen") ? a.gas.inert : a.gas.molar;
  a.wall_temperature = r.series_if("wall_temperature");
  a.surface_temperature = r.series_if("surface_temperature");
  a.film = r.series_if("film");
  a.contact_temperature = r.series_if("contact_temperature");
  a.pressure = r.number("pressure");
  const Drying drying = job.matter.drying.kind;
  const bool boils = drying == Drying::boiling || drying == Drying::equilibrium;
  constexpr double k_far = 0.1;  // of the atmosphere's pressure: 3 K
  if (boils && !in.one("drying").has("temperature") && std::fabs(a.pressure / k_atmosphere - 1) > k_far) {
    const DryingLaw& law = job.matter.drying;  // Clausius and Clapeyron
    const double at =
        1 / (1 / law.temperature - k_gas_constant / (law.heat * 0.018015) * std::log(a.pressure / k_atmosphere));
    in.one("drying").missing(
        "temperature",
        fmt::format("where surroundings.pressure is no atmosphere: water boils at about {:.0f} K there", at));
  }
  using Oxidant = CharReaction::Oxidant;
  const auto taken = [&](Oxidant oxidant) {
    const auto& all = job.matter.char_reactions;
    return std::any_of(all.begin(), all.end(), [&](const CharReaction& c) { return c.oxidant == oxidant; });
  };
  if (r.has("oxygen") && !taken(Oxidant::oxygen)) r.fail("oxygen", "has no effect without a [[char_reaction]]");
  if (r.has("carbon_dioxide") && !taken(Oxidant::carbon_dioxide))
    r.fail("carbon_dioxide", "has no effect without a [[char_reaction]] with oxidant = CO2");
  if (r.has("steam") && !taken(Oxidant::steam) && drying != Drying::equilibrium)
    r.fail("steam", "has no effect without a [[char_reaction]] with oxidant = H2O, or drying.law = equilibrium");
  for (const char* key : {"velocity", "law"}) r.exclusive("film", key);
  for (const char* key : {"wall_temperature", "flux", "contact_conductance", "film", "velocity"})
    r.exclusive("surface_temperature", key);
  if (r.has("contact_temperature") && !r.has("contact_conductance"))
    r.fail("contact_temperature", "has no effect without contact_conductance");
  if (job.options.lumped && r.has("surface_temperature"))
    r.fail("surface_temperature", "needs grain.level = shells: a lumped grain would follow it at once");
}

}  // namespace

double Series::at(double t) const {
  if (t <= time.front()) return value.front();
  for (std::size_t k = 1; k < time.size(); ++k) {
    if (t >= time[k]) continue;
    return value[k - 1] + (t - time[k - 1]) / (time[k] - time[k - 1]) * (value[k] - value[k - 1]);
  }
  return value.back();
}

double Series::missed(double from, double to) const {
  std::size_t k = 0;
  while (k < time.size() && time[k] <= from) ++k;
  if (k == time.size() || time[k] >= to) return 0;
  return TimeTable{time, value}.mean(0.5 * (from + to), to - from) - 0.5 * (at(from) + at(to));
}

double Series::largest() const {
  double x = value.front();
  for (const double v : value) x = x < v ? v : x;
  return x;
}

Surroundings<double> SurroundingsOverTime::at(double t, double radius, double surface) const {
  Surroundings<double> s;
  s.gas_temperature = temperature.at(t);
  s.film =
      film ? film->at(t) : film_of(gas, law, 2 * radius, velocity.at(t), s.gas_temperature, surface, pressure).heat;
  s.emissivity = wall_temperature ? 1 : 0;
  s.wall_temperature = wall_temperature ? wall_temperature->at(t) : s.gas_temperature;
  s.flux = flux.at(t);
  s.contact_conductance = contact_conductance.at(t);
  s.contact_temperature = contact_temperature ? contact_temperature->at(t) : s.gas_temperature;
  s.given_surface = surface_temperature.has_value();
  if (s.given_surface) s.surface_temperature = surface_temperature->at(t);
  return s;
}

double SurroundingsOverTime::molar_at(double t) const {
  return mixture_molar(oxygen.at(t), carbon_dioxide.at(t), steam.at(t), rest);
}

GasAround<double> SurroundingsOverTime::gas_at(double t, double radius, double surface) const {
  GasAround<double> g;
  g.molar = molar_at(t);
  const double T = temperature.at(t), rho = gas_density(0.5 * (T + surface), pressure, g.molar);
  const Film f = film_of(gas, law, 2 * radius, velocity.at(t), T, surface, pressure);
  // Where the coefficient of heat is given, that of mass goes with it.
  const double still = film ? film->at(t) / f.heat : 1;
  g.film = f.mass * still;
  g.oxygen = rho * oxygen.at(t);
  g.carbon_dioxide = rho * carbon_dioxide.at(t);
  g.steam = rho * steam.at(t);
  g.vapour = g.steam;
  g.pressure = pressure;
  return g;
}

GrainJob parse_grain(std::string_view text, const std::string& name) {
  const TomlNode root = parse_toml_tree(text, name);
  const Sections in{root, name};
  const GrainTable top(&root, "", "", name);
  GrainJob job;
  job.title = top.text("title");
  const std::string scheme = top.text("scheme");
  job.matter.name = scheme;
  if (scheme != "none") add_scheme(job.matter, scheme);
  read_time(in, job);
  read_form(in, job);
  read_material(in, job.matter, scheme);
  read_laws(in, job.matter);
  placed(name, [&] { check_matter(job.matter); });
  read_surroundings(in, job);
  return job;
}

GrainJob load_grain(const std::string& path) {
  return parse_grain(read_input_text(path, {ErrorCode::scene, "grain file", 1u << 20, "give the path of a grain file"}),
                     path);
}

}  // namespace talus::conversion
