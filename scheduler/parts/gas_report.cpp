// See gas_report.hpp.
#include "scheduler/parts/gas_report.hpp"

#include <fmt/format.h>

#include "core/gas/species.hpp"

namespace talus {

namespace {

constexpr double k_saturated = 1.05;       // the law of saturation is known to some per cent
constexpr double k_pressure_change = 0.1;  // by which water boils 3 K off
constexpr double k_full = 1 + 1e-9;        // of a cell: rounding

constexpr auto k_steam = static_cast<std::size_t>(GasSpecies::h2o);

/// Where steam is farthest above saturation: that of the gas, and that of its grains where none of them takes steam up.
struct Wettest {
  double ratio = 0, gas = 0, grains = 0;  ///< partial pressure / that of saturation; temperatures [K], 0: no grains
  int cell = -1, cells = 0;               ///< cells: above saturation
};

Wettest wettest(const gas::Gas& gas, const gas::FromGrains& from, const std::vector<char>& wetted) {
  Wettest w;
  const gas::ToGrains& f = gas.fields();
  for (std::size_t c = 0; c < f.temperature.size(); ++c) {
    if (!(f.fractions[c][k_steam] > 0)) continue;
    const double grains = from.conductance[c] > 0 && wetted[c] == 0 ? from.heat[c] / from.conductance[c] : 0;
    const double coldest = grains > 0 ? fmin2(grains, f.temperature[c]) : f.temperature[c];
    const double ratio = gas::steam_pressure(f.fractions[c], f.pressure[c]) / gas::saturation_pressure(coldest);
    w.cells += ratio > k_saturated;
    if (ratio > w.ratio) w = {ratio, f.temperature[c], grains, static_cast<int>(c), w.cells};
  }
  return w;
}

/// Temperatures at which the properties of the gas are not known.
void add_temperature(const gas::Gas& gas, std::vector<PartConcern>& all) {
  double worst = gas::k_hottest;
  int cell = -1, cells = 0;
  const std::vector<double>& t = gas.fields().temperature;
  for (std::size_t c = 0; c < t.size(); ++c) {
    cells += t[c] > gas::k_hottest || t[c] < gas::k_coldest;
    if (t[c] > worst || (t[c] < gas::k_coldest && cell < 0)) worst = t[c], cell = static_cast<int>(c);
  }
  if (cell < 0) return;
  const Vec3 x = gas.grid().middle(cell);
  all.push_back(
      {"temperature",
       fmt::format("the gas at ({:.4g}, {:.4g}, {:.4g}) m has {:.4g} K: its properties are known from {} to {} "
                   "K, heat capacities of the ends count beyond, and what is hot does not dissociate",
                   x.x, x.y, x.z, worst, gas::k_coldest, gas::k_hottest),
       worst, gas::k_hottest, cells});
}

/// A pressure that wet grains do not know of, or that inlets without an outlet have made.
void add_pressure(const gas::Gas& gas, const Scene& scene, std::vector<PartConcern>& all) {
  const bool wet = scene.conversion.on, blown = gas.sealed() && !scene.gas.inlets.empty();
  const double change = __builtin_fabs(gas.pressure() / scene.gas.pressure - 1);
  if (!(wet || blown) || !(change > k_pressure_change)) return;
  const char* why = wet ? "grains go on to boil at the temperature of their files" : "inlets give it a flow alone";
  const char* cure = gas.sealed() ? "a side that is open ([[gas.inlet]] kind = \"pressure\") holds it"
                                  : "gas.pressure should be that of the sides that are open";
  all.push_back({"pressure",
                 fmt::format("the gas has come to {:.4g} Pa, from {:.4g} Pa: {}; {}", gas.pressure(),
                             scene.gas.pressure, why, cure),
                 change, k_pressure_change, 1});
}

/// More than there is room for: forms of bodies in small cells, deep overlaps.
void add_solid(const gas::Gas& gas, const gas::FromGrains& from, std::vector<PartConcern>& all) {
  const double room = gas.grid().volume;
  double worst = k_full * room;
  int cell = -1, cells = 0;
  for (std::size_t c = 0; c < from.solid.size(); ++c) {
    cells += from.solid[c] > k_full * room;
    if (from.solid[c] > worst) worst = from.solid[c], cell = static_cast<int>(c);
  }
  if (cell < 0) return;
  const Vec3 x = gas.grid().middle(cell);
  all.push_back(
      {"solid",
       fmt::format("the cell of the gas at ({:.4g}, {:.4g}, {:.4g}) m gets {:.4g} of its volume of grains: it "
                   "counts as gas.least_porosity; larger cells",
                   x.x, x.y, x.z, worst / room),
       worst / room, 1, cells});
}

}  // namespace

std::vector<PartValue> gas_values(const gas::Gas& gas, const Scene& scene, int axis, Vec3 force) {
  const gas::Balance& b = gas.balance();
  double element = 0, low = k_never, high = 0;
  for (int k = 0; k < gas::k_elements; ++k) element = fmax2(element, __builtin_fabs(b.element_residual(k)));
  for (const double t : gas.fields().temperature) low = fmin2(low, t), high = fmax2(high, t);
  const bool started = gas.started();
  std::vector<PartValue> out{{"gas.mass_in", "kg", gas::sum(b.passed.in)},
                             {"gas.mass_out", "kg", gas::sum(b.passed.out)},
                             {"gas.mass_residual", "kg", b.mass_residual()},
                             {"gas.element_residual", "kg", element},
                             {"gas.enthalpy_residual", "J", b.enthalpy_residual()},
                             {"gas.pressure", "Pa", gas.pressure()},
                             {"gas.pressure_work", "J", b.passed.pressure_work},
                             {"gas.pressure_drop", "Pa", started ? gas.pressure_drop(axis) : 0},
                             {"gas.temperature_min", "K", started ? low : scene.gas.temperature},
                             {"gas.temperature_max", "K", started ? high : scene.gas.temperature},
                             {"gas.force_x", "N", force.x},
                             {"gas.force_y", "N", force.y},
                             {"gas.force_z", "N", force.z},
                             {"gas.iterations", "-", static_cast<double>(gas.flow().iterations)}};
  if (scene.heat.on) {
    out.push_back({"gas.enthalpy", "J", b.stored_enthalpy});
    out.push_back({"gas.heat_from_grains", "J", b.passed.heat_grains});
    out.push_back({"gas.enthalpy_in", "J", b.passed.enthalpy_in});
    out.push_back({"gas.enthalpy_out", "J", b.passed.enthalpy_out});
  }
  if (scene.conversion.on) {
    out.push_back({"gas.mass_from_grains", "kg", gas::sum(b.passed.grains)});
    out.push_back({"gas.enthalpy_from_grains", "J", b.passed.enthalpy_grains});
    for (std::size_t k = 0; k < k_gas_species; ++k)
      out.push_back({"gas.out_" + std::string(gas::species(static_cast<int>(k)).name), "kg", b.passed.out[k]});
  }
  return out;
}

std::vector<PartConcern> gas_concerns(const gas::Gas& gas, const Scene& scene, const gas::FromGrains& from,
                                      const std::vector<char>& wetted) {
  std::vector<PartConcern> all;
  if (const Wettest w = wettest(gas, from, wetted); w.ratio > k_saturated) {
    const Vec3 x = gas.grid().middle(w.cell);
    all.push_back(
        {"saturation",
         fmt::format("steam at ({:.4g}, {:.4g}, {:.4g}) m has {:.3g} times the pressure of saturation (gas of "
                     "{:.4g} K{}): it does not condense here, which would warm what is cold and wet it",
                     x.x, x.y, x.z, w.ratio, w.gas,
                     w.grains > 0 ? fmt::format(", grains of {:.4g} K", w.grains) : std::string()),
         w.ratio, k_saturated, w.cells});
  }
  add_temperature(gas, all);
  add_pressure(gas, scene, all);
  add_solid(gas, from, all);
  return all;
}

}  // namespace talus
