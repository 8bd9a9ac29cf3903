#!/usr/bin/env python3
"""A bed of wet wood in hot nitrogen: fronts, mass loss, balances.

  python3 cases/packed_bed/drying.py --make            # generated/drying.csv, the grains
  talus run cases/packed_bed/drying.toml --out out/drying
  python3 cases/packed_bed/drying.py out/drying        # table, drying.svg in the folder

Needs python3-numpy; for the picture python3-matplotlib.
"""
import argparse
import csv
import os
import sys

import numpy as np

sys.dont_write_bytecode = True
HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.dirname(HERE))
import case_files  # noqa: E402
from frames import whole_frames  # noqa: E402

PITCH, DIAMETER, ACROSS, HIGH = 0.01, 0.0098, 3, 30  # [m], [m], grains


def make():
    case_files.fixed_lattice(os.path.join(HERE, "generated", "drying.csv"), ACROSS, HIGH, PITCH, DIAMETER)


def series(folder):
    with open(os.path.join(folder, "series.csv")) as f:
        rows = [r for r in csv.reader(line for line in f if not line.startswith("#"))]
    return {name: np.array([float(r[k]) for r in rows[1:]]) for k, name in enumerate(rows[0])}


def layers(folder):
    """[(time, height, {column: mean over the layer})]."""
    out = []
    for t, x, columns in whole_frames(folder):
        z = np.unique(np.round(x[:, 2], 6))
        at = [np.abs(x[:, 2] - h) < 1e-5 for h in z]
        out.append((t, z, {name: np.array([v[q].mean() for q in at]) for name, v in columns.items() if v.ndim == 1}))
    return out


def front(z, value, first):
    """Height below which half of the layer's first value has gone [m]; nan before the lowest layer has come so far."""
    gone = np.where(value < 0.5 * first)[0]
    return z[gone[-1]] + 0.5 * PITCH if len(gone) else float("nan")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", help="of a finished run")
    parser.add_argument("--make", action="store_true", help="write the grains")
    parser.add_argument("--picture", help="where to write it; default: drying.svg in the folder")
    parser.add_argument("--no-picture", action="store_true")
    args = parser.parse_args()
    if args.make:
        make()
    if not args.folder:
        return 0 if args.make else parser.error("a folder, or --make")
    s, bed = series(args.folder), layers(args.folder)
    first = bed[0][2]
    print("   t [s]  mass  water   wood  drying front [mm]  pyrolysis front [mm]  lowest, highest mean T of a layer [K]")
    for t, z, c in bed:
        k = int(np.argmin(np.abs(s["time"] - t)))
        share = [s["conversion." + q][k] / max(s["conversion." + q][0], 1e-300) for q in ("mass", "moisture", "fuel")]
        T = c["mean_temperature"]
        print(f"{t:8.0f} {share[0]:5.3f}  {share[1]:5.3f}  {share[2]:5.3f} {1e3 * front(z, c['moisture'], first['moisture']):18.0f} "
              f"{1e3 * front(z, c['fuel'], first['fuel']):21.0f} {T.min():14.0f} {T.max():8.0f}")
    balances(s)
    if not args.no_picture:
        picture(args.picture or os.path.join(args.folder, "drying.svg"), s, bed)
    return 0


def balances(s):
    came = s["gas.mass_from_grains"][-1]
    print(f"mass that grains lost {1e3 * (s['conversion.mass'][0] - s['conversion.mass'][-1]):.6f} g, that the gas got "
          f"{1e3 * came:.6f} g")
    for name, unit, scale in (("conversion.mass_residual", "kg", came), ("gas.mass_residual", "kg", came),
                              ("gas.element_residual", "kg", came),
                              ("gas.enthalpy_residual", "J", abs(s["gas.enthalpy_from_grains"][-1])),
                              ("conversion.heat_residual", "J", abs(s["conversion.heat_in"][-1]))):
        print(f"{name}: {s[name][-1]:.1e} {unit}, {abs(s[name][-1]) / scale:.1e} of what went through")
    # grains and gas together: what they hold and what reactions have set free changes by what passes the ends alone
    held = sum(s[name] for name in ("conversion.heat", "conversion.formation", "gas.enthalpy"))
    passed = s["gas.enthalpy"] - s["gas.enthalpy_from_grains"] - s["gas.heat_from_grains"] - s["gas.enthalpy_residual"]
    error = (held - held[0]) - (passed - passed[0])
    print(f"energy of grains and gas: {np.abs(error).max():.1e} J off, {np.abs(error).max() / scale_of(s):.1e} of what went "
          "through")


def scale_of(s):
    return abs(s["gas.enthalpy_from_grains"][-1]) + abs(s["conversion.heat_in"][-1])


def picture(path, s, bed):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    fig, (left, right) = plt.subplots(1, 2, figsize=(10, 4))
    for name, label in (("mass", "mass"), ("moisture", "water"), ("fuel", "wood"), ("char", "char")):
        whole = s["conversion." + (name if name != "char" else "mass")][0]
        left.plot(s["time"], s["conversion." + name] / whole, label=label + (" (of all mass)" if name == "char" else ""))
    left.set(xlabel="time [s]", ylabel="share of the first value")
    shown = [b for b in bed if b[0] > 0][:: max(1, (len(bed) - 1) // 5)]
    for t, z, c in shown:
        line, = right.plot(c["mean_temperature"], 1e3 * z, label=f"{t:.0f} s")
        right.plot(c["centre_temperature"], 1e3 * z, ":", color=line.get_color())
    right.set(xlabel="temperature [K] (mean; dots: centre)", ylabel="height [mm]")
    for axes in (left, right):  # above, where it covers no curve
        axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncol=5, frameon=False, fontsize=9, handlelength=1.4, columnspacing=1.2)
    fig.tight_layout()
    fig.savefig(path, bbox_inches="tight", dpi=110)


if __name__ == "__main__":
    sys.exit(main())
