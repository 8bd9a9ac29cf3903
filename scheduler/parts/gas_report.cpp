// See gas_report.hpp.
#include "scheduler/parts/gas_report.hpp"

#include <fmt/format.h>

#include "core/gas/species.hpp"

namespace talus {

namespace {

constexpr double k_saturated = 1.05;       // the law of saturation is known to some per cent
constexpr double k_pressure_change = 0.1;  // by which water boils 3 K off

constexpr auto k_steam = static_cast<std::size_t>(GasSpecies::h2o);

/// Where steam is farthest above saturation.
struct Wettest {
  double ratio = 0, gas = 0, grains = 0;  ///< partial pressure / that of saturation; temperatures [K], 0: no grains
  int cell = -1, cells = 0;               ///< cells: above saturation
};

Wettest wettest(const gas::Gas& gas, const gas::FromGrains& from) {
  Wettest w;
  const gas::ToGrains& f = gas.fields();
  for (std::size_t c = 0; c < f.temperature.size(); ++c) {
    if (!(f.fractions[c][k_steam] > 0)) continue;
    const double grains = from.conductance[c] > 0 ? from.heat[c] / from.conductance[c] : 0;
    const double coldest = grains > 0 ? fmin2(grains, f.temperature[c]) : f.temperature[c];
    const double ratio = gas::steam_pressure(f.fractions[c], f.pressure[c]) / gas::saturation_pressure(coldest);
    w.cells += ratio > k_saturated;
    if (ratio > w.ratio) w = {ratio, f.temperature[c], grains, static_cast<int>(c), w.cells};
  }
  return w;
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
  }
  if (scene.conversion.on) {
    out.push_back({"gas.mass_from_grains", "kg", gas::sum(b.passed.grains)});
    out.push_back({"gas.enthalpy_from_grains", "J", b.passed.enthalpy_grains});
  }
  return out;
}

std::vector<PartConcern> gas_concerns(const gas::Gas& gas, const Scene& scene, const gas::FromGrains& from) {
  std::vector<PartConcern> all;
  if (const Wettest w = wettest(gas, from); w.ratio > k_saturated) {
    const Vec3 x = gas.grid().middle(w.cell);
    all.push_back(
        {"saturation",
         fmt::format("steam at ({:.4g}, {:.4g}, {:.4g}) m has {:.3g} times the pressure of saturation (gas of "
                     "{:.4g} K{}): it does not condense here, which would warm what is cold and wet it",
                     x.x, x.y, x.z, w.ratio, w.gas,
                     w.grains > 0 ? fmt::format(", grains of {:.4g} K", w.grains) : std::string()),
         w.ratio, k_saturated, w.cells});
  }
  const double change = gas.pressure() / scene.gas.pressure - 1;
  if (scene.conversion.on && __builtin_fabs(change) > k_pressure_change)
    all.push_back(
        {"pressure",
         fmt::format("the gas has come to {:.4g} Pa, from {:.4g} Pa: grains go on to boil and to breathe at the "
                     "temperature and pressure of their files; a side that is open ([[gas.inlet]] kind = "
                     "\"pressure\") holds it",
                     gas.pressure(), scene.gas.pressure),
         __builtin_fabs(change), k_pressure_change, 1});
  return all;
}

}  // namespace talus
