"""Plots of series.csv: energies, contacts, forces on walls, regions, flow through planes."""
import re

import numpy as np

from .plots import line_plot

MOST_CURVES = 8  # are still told apart


def names(series, kind):
    """Names of the walls, planes or regions that have columns."""
    found = []
    for column in series:
        m = re.fullmatch(kind + r"\.(.*)\.[^.]*", column)
        if m and m.group(1) not in found:
            found.append(m.group(1))
    return found


def over_time(series, title, ylabel, columns, **options):
    """Columns over time; columns: [(name, label)], those that are missing are left out."""
    return line_plot(series["time"], [(label, series[name]) for name, label in columns if name in series], title, "time [s]", ylabel,
                     **options)


def wall_forces(series):
    forces = []
    for name in names(series, "wall"):
        parts = [f"wall.{name}.force_{a}" for a in "xyz"]
        if all(p in series for p in parts):
            total = np.sqrt(sum(series[p] ** 2 for p in parts))
            if np.any(total > 0):
                forces.append((name, total))
    forces.sort(key=lambda f: -np.nanmax(f[1]))
    return line_plot(series["time"], forces[:MOST_CURVES], "Force on walls" if len(forces) <= MOST_CURVES else
                     f"Force on the {MOST_CURVES} most loaded of {len(forces)} walls", "time [s]", "force [N]", zero=True)


def series_plots(s):
    plots = [
        over_time(s, "Particles", "particles", [("particles", "in the domain"), ("inserted", "inserted, total"),
                                                ("removed", "left, total")], zero=True),
        over_time(s, "Kinetic energy (translation)", "energy [J]", [("kinetic_energy", "kinetic")], zero=True),
        over_time(s, "Coordination number", "contacts per particle", [("coordination_number", "Z")], zero=True),
        over_time(s, "Contacts", "contacts", [("contacts", "particle–particle"), ("wall_contacts", "particle–wall")], zero=True),
        over_time(s, "Energies", "energy [J]", [
            ("kinetic_translation", "translation"), ("kinetic_rotation", "rotation"), ("potential", "potential"),
            ("elastic", "elastic"), ("dissipated_damping", "lost, damping"), ("dissipated_friction", "lost, friction"),
            ("dissipated_background", "lost, background"), ("wall_work", "work of walls"),
            ("resized_energy", "changing sizes")]),
        over_time(s, "Energy balance", "residual [J]", [("balance_residual", "residual")]),
        wall_forces(s),
    ]
    return [p for p in plots if p]


def flow_plots(s):
    planes = names(s, "plane")
    rates = [(f"plane.{p}.mass_flow", f"through {p}") for p in planes]
    totals = [(f"plane.{p}.mass", f"through {p}") for p in planes]
    if "mass_flow" in s and np.any(s["removed_mass"] != 0):
        rates.insert(0, ("mass_flow", "leaving the domain"))
        totals.insert(0, ("removed_mass", "left the domain"))
    return [p for p in (over_time(s, "Mass flow", "mass flow [kg/s]", rates, step=True, zero=True),
                        over_time(s, "Mass passed", "mass [kg]", totals, zero=True)) if p]


def region_plots(s):
    """What the scene averages in regions: packing, stress (pressure, all components of each region), agitation, motion."""
    regions = names(s, "region")
    plots = [over_time(s, title, label, [(f"region.{r}.{suffix}", r) for r in regions[:MOST_CURVES]], zero=True)
             for suffix, title, label in [("solid_fraction", "Solid fraction", "solid fraction"),
                                          ("coordination", "Coordination number", "contacts per particle"),
                                          ("granular_temperature", "Granular temperature", "temperature [m²/s²]")]]
    pressures = []
    for r in regions:
        normal = [s.get(f"region.{r}.stress_{a}") for a in ("xx", "yy", "zz")]
        if all(n is not None for n in normal):
            pressures.append((r, sum(normal) / 3))
    plots.append(line_plot(s["time"], pressures[:MOST_CURVES], "Mean normal stress, pressed is negative", "time [s]", "stress [Pa]"))
    for r in regions[:MOST_CURVES]:
        plots.append(over_time(s, f"Stress in {r}", "stress [Pa]", [(f"region.{r}.stress_{a}", a) for a in ("xx", "yy", "zz", "xy", "xz", "yz")]))
        plots.append(over_time(s, f"Mean velocity in {r}", "velocity [m/s]", [(f"region.{r}.velocity_{a}", a) for a in "xyz"]))
    return [p for p in plots if p]
