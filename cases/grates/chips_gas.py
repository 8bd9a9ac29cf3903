#!/usr/bin/env python3
"""Rods of wood in given gas beside the same in gas on a grid: the second table of CHIPS.md, and the balances.

  python3 cases/grates/chips_gas.py results/chips results/chips-gas
"""
import argparse
import csv
import os
import sys

MASSES = ("fuel", "moisture", "char")


def series(folder):
    with open(os.path.join(folder, "series.csv")) as f:
        rows = list(csv.DictReader(r for r in f if not r.startswith("#")))
    return [{k: float(v) for k, v in r.items() if v} for r in rows]


def gone(rows, what, share):
    """When so much of what the grains of the start held has gone, less what the feed brings [s]."""
    first = rows[0]["conversion." + what]
    for a, b in zip(rows, rows[1:]):
        x, y = a["conversion." + what], b["conversion." + what]
        if y <= (1 - share) * first:
            return a["time"] + (x - (1 - share) * first) / (x - y) * (b["time"] - a["time"])
    return float("nan")


def common(rows):
    last = rows[-1]
    return {
        "grains fed, left": f"{last['inserted']:.0f}, {last['removed']:.0f}",
        "wood, water, char at the end [g]": ", ".join(f"{1e3 * last['conversion.' + k]:.2f}" for k in MASSES),
        "a quarter of the water, of the wood gone [s]": ", ".join(f"{gone(rows, k, 0.25):.2f}" for k in ("moisture", "fuel")),
        "oxygen that char has taken [mg]": f"{1e6 * last['conversion.oxygen_taken']:.1f}",
    }


def of_gas(rows):
    last, late = rows[-1], rows[len(rows) // 2:]
    mean = lambda key: sum(r[key] for r in late) / len(late)  # noqa: E731
    return {
        "mass from grains, of the air that came in [g]": f"{1e3 * last['gas.mass_from_grains']:.3f}, {1e3 * last['gas.mass_in']:.3f}",
        "oxygen that left, of that which came in": f"{last['gas.out_O2'] / (0.233 * last['gas.mass_in']):.2f}",
        "carbon monoxide, tar that left [mg]": f"{1e6 * last['gas.out_CO']:.1f}, {1e6 * last['gas.out_tar']:.1f}",
        "hottest cell at the end, at most [K]": f"{last['gas.temperature_max']:.0f}, {max(r['gas.temperature_max'] for r in rows):.0f}",
        "force of the gas on all grains over their weight, second half": f"{mean('gas.force_z') / (9.81 * mean('conversion.mass')):.4f}",
    }


def balances(rows):
    """Largest residuals of the run, each over what it is the rest of."""
    worst = lambda key: max(abs(r[key]) for r in rows)  # noqa: E731
    last = rows[-1]
    through = last["gas.mass_in"] + last["gas.mass_from_grains"]
    passed = max(abs(r["gas.enthalpy_from_grains"]) for r in rows)
    elements = max(worst(f"conversion.{e}_residual") for e in ("carbon", "hydrogen", "oxygen", "ash", "water"))
    return {
        "mass of the gas, over what came": worst("gas.mass_residual") / through,
        "elements of the gas, over what came": worst("gas.element_residual") / through,
        "enthalpy of the gas, over that from grains": worst("gas.enthalpy_residual") / passed,
        "mass of the grains": worst("conversion.mass_residual") / rows[0]["conversion.mass"],
        "elements of the grains": elements / rows[0]["conversion.mass"],
        "heat of the grains": worst("conversion.heat_residual") / max(abs(r["conversion.heat"]) for r in rows),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("given", help="folder of a run of chips.toml")
    parser.add_argument("cells", help="folder of a run of chips-gas.toml")
    parser.add_argument("--until", type=float, default=1e9, dest="end", help="of both runs [s]")
    args = parser.parse_args()
    given, cells = ([r for r in series(f) if r["time"] <= args.end + 1e-9] for f in (args.given, args.cells))
    print(f"| at {cells[-1]['time']:g} s | given gas | gas of cells |\n|---|---|---|")
    a, b = common(given), common(cells)
    for what in a:
        print(f"| {what} | {a[what]} | {b[what]} |")
    for what, x in of_gas(cells).items():
        print(f"| {what} | | {x} |")
    print("\n| largest residual in the gas of cells | |\n|---|---|")
    for what, x in balances(cells).items():
        print(f"| {what} | {x:.0e} |")
    return 0


if __name__ == "__main__":
    sys.exit(main())
