// [gas] and [[gas.inlet]]: keys of the part in scheduler/parts/gas.cpp.
#include <fmt/format.h>

#include <algorithm>

#include "core/scene/sections/parts.hpp"

namespace talus {
namespace {

constexpr KeyRange k_temperature{200, 3500}, k_pressure{1e3, 1e8};

const Keys<GasSettings> k_gas(
    {"gas", false, "gas in the voids between the grains, on a regular grid; absent: there is none"},
    fixed_by("the gas of the checkpoint follows from it"),
    {
        key("lower", &GasSettings::lower, "m", k_coordinate, "lower corner of the grid", "[0, 0, 0]")
            .absent("(that of the domain)"),
        key("upper", &GasSettings::upper, "m", k_coordinate,
            "upper corner; the grid wraps where it spans a periodic axis of the domain; grains outside feel no gas",
            "[0.1, 0.1, 0.3]")
            .absent("(that of the domain)"),
        other_key<GasSettings>(
            "cells", KeyType::cells, "-", {1, 1000},
            "cells per axis, with edges of two to four grain diameters and at least a third of the "
            "largest radius. Grains share their volume exactly among the cells they meet; clumps by their spheres, "
            "superquadrics by the ellipsoid along the axes that reaches as far, both scaled to their volume. Frames "
            "gain gas.pvd, the series gas.mass_in and gas.mass_out [kg] through the sides, "
            "gas.mass_residual, gas.element_residual [kg] and gas.enthalpy_residual [J] (stored less "
            "start, passed and the work of pressure), gas.pressure [Pa] (mean), gas.pressure_work [J] (void times "
            "change of the pressure, where no side is open to a given one), gas.pressure_drop [Pa] along the axis of "
            "the first inlet, "
            "gas.temperature_min and _max [K], gas.force_x, _y, _z on all grains [N], gas.iterations "
            "of the flow in the last gas step; beside [heat] gas.enthalpy (formation included), what of it has passed "
            "sides "
            "(gas.enthalpy_in, gas.enthalpy_out) and gas.heat_from_grains [J]; beside [conversion] "
            "gas.mass_from_grains [kg], gas.enthalpy_from_grains [J] and what of each species has left through the "
            "sides, "
            "gas.out_O2 and so on [kg]",
            "[4, 4, 12]")
            .required(),
        key("every", &GasSettings::every, "-", {1, 1e9},
            "steps between two gas steps; the flow is quasi-steady, heat and species are transient", "200")
            .acts(),
        key("drag", &GasSettings::drag,
            "drag on the grains, beside the force of the pressure gradient: ergun (dense beds only), gidaspow (ergun "
            "below "
            "a porosity of 0.7, Wen and Yu above 0.9, a smooth step between), di_felice, beetstra (porosity 0.4 to "
            "0.9). Of bodies that are no spheres Ergun sees 6 volumes over surface, the others the sphere of equal "
            "volume with Ganser's (1993) factors of the sphericity where a grain is alone; beetstra is for spheres. "
            "What the gas loses and what grains get is one sum in each cell: forces on all grains are pressure "
            "drop times area, less the weight of the gas and what cells above most_porosity resist",
            "\"di_felice\""),
        key("nusselt", &GasSettings::nusselt,
            "heat transfer to grains, which have temperatures beside [heat]; every must be heat.every then. Mass goes "
            "with it. Bodies that are no spheres: the law of the sphere of equal volume, on their true surface. The "
            "series gains gas.enthalpy [J], gas.heat_from_grains [J], beside [conversion] "
            "gas.mass_from_grains [kg], gas.enthalpy_from_grains [J]",
            "\"whitaker\"")
            .with("[heat]\ntemperature = 300\ncapacity = 800\nconductivity = 1\nevery = 100\n"),
        key("pressure", &GasSettings::pressure, "Pa", k_pressure, "at the start, and of open sides", "101325"),
        key("temperature", &GasSettings::temperature, "K", k_temperature, "at the start, and of what comes in", "300"),
        other_key<GasSettings>("fractions", KeyType::numbers, "-", {0, 1},
                               "by mass, of O2, CO2, CO, H2O, H2, CH4, tar (as benzene), N2; their sum is 1",
                               "[0.233, 0, 0, 0, 0, 0, 0, 0.767]")
            .absent("(air)"),
        key("combustion", &GasSettings::combustion,
            "CO, H2, CH4 and tar burn in the gas, at global rates (Howard 1973, Marinov 1996, Dryer and Glassman 1973, "
            "Westbrook and Dryer 1981)",
            "true"),
        key("most_porosity", &GasSettings::most_porosity, "-", {0.5, 0.999},
            "cells that are emptier resist the flow as this porosity of grains of the mean size", "0.9"),
        key("least_porosity", &GasSettings::least_porosity, "-", {0.05, 0.45},
            "cells that are fuller resist and hold gas as this porosity", "0.25"),
    });

const Keys<GasInlet> k_inlet(
    {"gas.inlet", true,
     "lets gas through a side of the grid, or through a rectangle of it; the rest is closed. Where several meet, the "
     "last one counts. With no inlet of kind pressure the vessel is sealed: its pressure follows from mass and "
     "temperatures, and heats what it compresses"},
    fixed_by("the gas of the checkpoint has flown through it"),
    {
        key("side", &GasInlet::side, "of the grid: left and right (x), front and back (y), bottom and top (z)",
            "\"bottom\"")
            .required(),
        key("kind", &GasInlet::kind, "flow: a given velocity; pressure: a given pressure outside", "\"pressure\""),
        key("velocity", &GasInlet::velocity, "m/s", k_finite,
            "into the grid, superficial, at the inlet's temperature and gas.pressure; negative: out", "0.5")
            .only("kind=flow")
            .needed("flow", "(required by flow)"),
        key("pressure", &GasInlet::pressure, "Pa", k_pressure,
            "outside, at the height of the lowest point of the grid; above, the gas outside (of this pressure, "
            "temperature and composition) weighs less by rho g z, as still gas does. Equal pressures at bottom and top "
            "are one atmosphere: gas as heavy rests, lighter gas rises as in a chimney",
            "101325")
            .only("kind=pressure")
            .absent("(gas.pressure)"),
        key("temperature", &GasInlet::temperature, "K", k_temperature, "of what comes in", "600")
            .absent("(gas.temperature)"),
        other_key<GasInlet>("fractions", KeyType::numbers, "-", {0, 1}, "of what comes in, as gas.fractions",
                            "[0.233, 0, 0, 0, 0, 0, 0, 0.767]")
            .absent("(gas.fractions)"),
        key("lower", &GasInlet::lower, "m", k_coordinate, "of the rectangle: faces with their middle in it",
            "[0, 0, 0]")
            .absent("(the whole side)"),
        key("upper", &GasInlet::upper, "m", k_coordinate, "of the rectangle", "[0.05, 0.1, 0]")
            .absent("(the whole side)"),
    });

void read_fractions(const SceneTable& r, GasFractions& y) {
  const std::vector<double> given = r.numbers("fractions");
  if (given.size() != y.size()) r.fail("fractions", "must be eight: O2, CO2, CO, H2O, H2, CH4, tar, N2");
  double sum = 0;
  for (std::size_t k = 0; k < y.size(); ++k) sum += y[k] = given[k];
  if (sum < 1 - 1e-9 || sum > 1 + 1e-9) r.fail("fractions", fmt::format("must have the sum 1, not {:.10g}", sum));
  for (double& x : y) x /= sum;
}

void read_inlet(const SceneTable& r, GasSettings& gas) {
  GasInlet i;
  k_inlet.read(r, i);
  if (r.has("fractions")) {
    read_fractions(r, i.fractions);
    i.own_fractions = true;
  }
  gas.inlets.push_back(i);
}

double smallest_edge(const GasSettings& g) {
  double h = 1e300;
  for (int k = 0; k < 3; ++k) h = std::min(h, (g.upper[k] - g.lower[k]) / g.cells[static_cast<std::size_t>(k)]);
  return h;
}

/// Beside heat and conversion: the same steps; one gas alone; around grains that take and give gas there is some.
void check_beside(const SceneTable& root, const SceneTable& r, const Scene& scene) {
  const GasSettings& gas = scene.gas;
  if (scene.conversion.on && !scene.heat.on)
    root.fail("gas", "needs [heat] beside [conversion]: grains and gas exchange heat through their surfaces");
  if (!scene.heat.on) {
    if (r.has("nusselt")) r.fail("nusselt", "has no effect without [heat]: grains have no temperature");
    return;
  }
  if (scene.heat.gas.on) root.section("heat").fail("gas", "cannot be had beside [gas], which says what the gas is");
  if (gas.every != scene.heat.every)
    r.fail("every", fmt::format("must be heat.every ({}): grains and gas exchange at the end of the same steps",
                                scene.heat.every));
  if (!scene.conversion.on) return;
  for (int k = 0; k < 3; ++k)
    if (gas.lower[k] != scene.domain.lower[k] || gas.upper[k] != scene.domain.upper[k])
      r.fail(r.has("lower") ? "lower" : "upper",
             "the grid must fill the domain beside [conversion]: grains outside "
             "would have no gas to burn in");
}

void read(const SceneTable& root, Scene& scene) {
  if (!root.has("gas")) return;
  const SceneTable r = root.section("gas");
  GasSettings& gas = scene.gas;
  gas.on = true;
  gas.lower = scene.domain.lower;
  gas.upper = scene.domain.upper;
  k_gas.read(r, gas);
  if (r.has("fractions")) read_fractions(r, gas.fractions);
  const std::vector<std::int64_t> cells = r.integers("cells");
  for (std::size_t k = 0; k < 3; ++k) gas.cells[k] = static_cast<int>(cells[k]);
  for (int k = 0; k < 3; ++k) {
    if (!(gas.upper[k] > gas.lower[k])) r.fail("upper", "must be larger than 'lower' on every axis");
    if (gas.lower[k] < scene.domain.lower[k] || gas.upper[k] > scene.domain.upper[k])
      r.fail(gas.lower[k] < scene.domain.lower[k] ? "lower" : "upper", "must lie within the domain");
  }
  if (cells[0] * cells[1] * cells[2] > 1000000) r.fail("cells", "must be at most a million in all");
  double radius = 0;
  for (const Source& s : scene.sources) radius = std::max(radius, 0.5 * s.size.largest());
  if (smallest_edge(gas) < radius / 3)
    r.fail("cells", fmt::format("must be larger: an edge of {:.4g} m is below a third of the largest radius, {:.4g} m",
                                smallest_edge(gas), radius));
  for (const SceneTable& i : r.sections("inlet")) read_inlet(i, gas);
  check_beside(root, r, scene);
}

}  // namespace

const PartSections& gas_sections() {
  static const PartSections all{{&k_gas, &k_inlet}, read};
  return all;
}

}  // namespace talus
