#!/usr/bin/env python3
"""Is a furnace steady, and do its books close? Block means of a run over its last three residence times.

  python3 cases/grates/steady.py results/furnace-steady               # tables and verdict; exit 1 where it is not steady
  python3 cases/grates/steady.py results/furnace-steady --until 150   # as if the run had ended at 150 s
  python3 cases/grates/steady.py results/furnace-steady --write       # puts the tables on FURNACE.md

Residence time: mean number of grains over grains fed per second (Little), in the window itself. Three blocks of one
residence time each, ten batches per block; intervals of 95 % from the spread of all batches about a straight line,
widened by the correlation of neighbours. Held:
  1. what is stored: last and first block differ by no more than both intervals together, or by 3 % of the mean;
  2. what flows: in and out differ by no more than the interval of their difference, or by 3 % of what flows in;
     an interval beyond a fifth of the mean tells nothing, so that both fail there;
  3. books: residuals since the start of the run below 1e-9 of what went through.
"""
import argparse
import csv
import math
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "..", "perf"))
sys.dont_write_bytecode = True
from page_table import write_table  # noqa: E402

SMALL, WIDE, BOOKS, BLOCKS, BATCHES = 0.03, 0.2, 1e-9, 3, 10
T_975 = {1: 12.71, 2: 4.303, 3: 3.182, 4: 2.776, 5: 2.571, 6: 2.447, 7: 2.365, 8: 2.306, 9: 2.262, 12: 2.179, 15: 2.131, 20: 2.086, 25: 2.060}
C, H, O = 12.011, 1.00794, 15.9994
ATOMS = {"O2": (0, 0, 2), "CO2": (1, 0, 2), "CO": (1, 0, 1), "H2O": (0, 2, 1), "H2": (0, 2, 0), "CH4": (1, 4, 0), "tar": (6, 6, 0), "N2": (0, 0, 0)}


def share(species, element):
    c, h, o = ATOMS[species]
    whole = c * C + h * H + o * O
    return (c * C, h * H, o * O)[element] / whole if whole else 0


def read(folder, until):
    with open(os.path.join(folder, "series.csv"), encoding="utf-8") as f:
        rows = [{k: float(v) for k, v in r.items() if v} for r in csv.DictReader(line for line in f if not line.startswith("#"))]
    for r in rows:
        r["bed"] = r["conversion.mass"]
        r["to_gas"] = sum(r["conversion.released_" + s] for s in ATOMS) - sum(r[f"conversion.{k}_taken"] for k in ("oxygen", "carbon_dioxide", "steam"))
        r["fed_mass"] = r["bed"] + r["removed_mass"] + r["to_gas"]  # and what was there at the start
        r["carbon_given"] = r["conversion.gone_carbon"]  # less what came with CO2 and steam that char took
        r["hydrogen_given"] = r["conversion.gone_hydrogen"] + share("H2O", 1) * r["conversion.gone_water"]
        r["heat_given"] = r["gas.enthalpy_from_grains"] + r["gas.heat_from_grains"]
        if "gas.out_O2" in r:
            r["carbon_out"], r["hydrogen_out"] = (sum(share(s, e) * r["gas.out_" + s] for s in ATOMS) for e in (0, 1))
            r["heat_out"] = r["gas.enthalpy_out"] - r["gas.enthalpy_in"]
    return [r for r in rows if until is None or r["time"] <= until + 1e-9]


def quantile(freedom):
    return T_975[max((k for k in T_975 if k <= freedom), default=1)]


class Batches:
    """Means of equal stretches of time. Their spread is that about a straight line, so that a drift does not hide in it."""

    def __init__(self, x):
        self.x, n = x, len(x)
        mean, middle = sum(x) / n, (n - 1) / 2
        slope = sum((k - middle) * v for k, v in enumerate(x)) / sum((k - middle) ** 2 for k in range(n))
        rest = [v - mean - slope * (k - middle) for k, v in enumerate(x)]
        square = sum(v * v for v in rest)
        next_to = max(0.0, sum(a * b for a, b in zip(rest, rest[1:])) / square) if square > 0 else 0.0
        self.worth = (1 - next_to) / (1 + next_to)  # of a batch, whose neighbours tell much the same
        self.spread = math.sqrt(square / (n - 2))

    def mean(self, block=None):
        """Mean of a block or of all, and half of its interval of 95 %."""
        x = self.x if block is None else self.x[BATCHES * block:BATCHES * (block + 1)]
        freedom = max(1, int((len(self.x) - 2) * self.worth))
        return sum(x) / len(x), quantile(freedom) * self.spread / math.sqrt(max(1.0, len(x) * self.worth))


class Window:
    def __init__(self, rows):
        self.rows, end = rows, rows[-1]["time"]
        self.tau = end / 4
        for _ in range(30):
            inside = [r for r in rows if r["time"] >= end - BLOCKS * self.tau - 1e-9]
            fed = (inside[-1]["inserted"] - inside[0]["inserted"]) / (inside[-1]["time"] - inside[0]["time"])
            self.tau = min(end / BLOCKS, sum(r["particles"] for r in inside) / len(inside) / fed)
        self.start, self.end = end - BLOCKS * self.tau, end

    def at(self, t):
        return min(self.rows, key=lambda r: abs(r["time"] - t))

    def edges(self):
        return [self.start + self.tau * k / BATCHES for k in range(BLOCKS * BATCHES + 1)]

    def stored(self, of):
        e = self.edges()
        parts = [[of(r) for r in self.rows if a - 1e-9 <= r["time"] < b - 1e-9] for a, b in zip(e, e[1:])]
        return Batches([sum(p) / len(p) for p in parts])

    def flow(self, of):
        ends = [self.at(t) for t in self.edges()]
        return Batches([(of(b) - of(a)) / (b["time"] - a["time"]) for a, b in zip(ends, ends[1:])])


def one(name):
    return lambda r: r[name]


STORED = [("grains", "-", 1, one("particles")), ("mass of the bed", "g", 1e3, one("bed")), ("water", "mg", 1e6, one("conversion.moisture")),
          ("wood", "mg", 1e6, one("conversion.fuel")), ("char", "mg", 1e6, one("conversion.char")), ("ash", "mg", 1e6, one("conversion.ash")),
          ("heat of the grains", "J", 1, one("conversion.heat")), ("mean surface", "K", 1, one("heat.mean"))]
FLOWS = [("grains fed", "1/s", 1, one("inserted")), ("grains that left", "1/s", 1, one("removed")), ("mass fed", "mg/s", 1e6, one("fed_mass")),
         ("mass of grains that left", "mg/s", 1e6, one("removed_mass")), ("mass given to the gas", "mg/s", 1e6, one("to_gas")),
         ("water evaporated", "mg/s", 1e6, one("conversion.gone_water")), ("oxygen that char took", "mg/s", 1e6, one("conversion.oxygen_taken")),
         ("carbon given to the gas", "mg/s", 1e6, one("carbon_given")), ("carbon that left as gas", "mg/s", 1e6, one("carbon_out")),
         ("hydrogen given to the gas", "mg/s", 1e6, one("hydrogen_given")), ("hydrogen that left as gas", "mg/s", 1e6, one("hydrogen_out")),
         *[(f"{s} that left", "mg/s", 1e6, one("gas.out_" + s)) for s in ATOMS],
         ("heat from walls", "W", 1, one("heat.in_by_walls")), ("heat by radiation", "W", 1, one("heat.in_by_radiation")),
         ("heat from the gas", "W", 1, one("heat.in_by_gas")), ("enthalpy given to the gas", "W", 1, one("heat_given")),
         ("enthalpy that left with gas, less that of the air", "W", 1, one("heat_out"))]
PAIRS = [("grains", one("inserted"), one("removed")), ("mass of solids", one("fed_mass"), lambda r: r["removed_mass"] + r["to_gas"]),
         ("carbon of the gas", one("carbon_given"), one("carbon_out")), ("hydrogen of the gas", one("hydrogen_given"), one("hydrogen_out")),
         ("mass of the gas", lambda r: r["gas.mass_in"] + r["gas.mass_from_grains"], one("gas.mass_out")),
         ("enthalpy of the gas", one("heat_given"), one("heat_out"))]


def has(rows, of):
    try:
        of(rows[0])
    except KeyError:
        return False
    return True


def books(rows):
    r = rows[-1]
    through, fed = r["gas.mass_in"] + r["gas.mass_from_grains"], r["fed_mass"]
    out = [(f"{e} of the grains", r[f"conversion.{e}_residual"], fed) for e in ("carbon", "hydrogen", "oxygen", "ash", "water")]
    out += [("mass of the grains", r["conversion.mass_residual"], fed), ("heat of the grains", r["conversion.heat_residual"], abs(r["conversion.heat_in"])),
            ("elements of the gas", r["gas.element_residual"], through), ("mass of the gas", r["gas.mass_residual"], through),
            ("enthalpy of the gas", r["gas.enthalpy_residual"], abs(r["gas.enthalpy_from_grains"])),
            ("heat from gas to grains, both books", r["heat.in_by_gas"] + r["gas.heat_from_grains"], abs(r["heat.in_by_gas"])),
            ("heat to surfaces, both books", r["heat.into_shells"] - r["conversion.heat_in"], abs(r["conversion.heat_in"])),
            ("mass from grains to gas, both books", r["to_gas"] - r["gas.mass_from_grains"], r["gas.mass_from_grains"])]
    for k, e in enumerate(("carbon", "hydrogen")):
        got = sum(share(s, k) * r["conversion.released_" + s] for s in ATOMS)
        got -= share("CO2", k) * r["conversion.carbon_dioxide_taken"] + share("H2O", k) * r["conversion.steam_taken"]
        out.append((f"{e} from grains to gas, both books", got - r[e + "_given"], r[e + "_given"]))
    return out


def show(mean, half, factor):
    mean, half = mean * factor, half * factor
    half = half if half > 1e-9 * abs(mean) else 0.0
    digits = 0 if not half > 0 else max(0, min(6, 1 - math.floor(math.log10(half))))
    return f"{mean:.{digits}f} ± {half:.{digits}f}" if half > 0 else f"{mean:.4g}"


def tables(rows):
    """Lines of the page; whether all is held."""
    w, good = Window(rows), True
    lines = [f"Residence time {w.tau:.1f} s; blocks from {w.start:.1f} to {w.end:.1f} s.", "",
             "| stored | " + " | ".join(f"block {b + 1}" for b in range(BLOCKS)) + " | last less first | held |", "|---" * (BLOCKS + 3) + "|"]
    for name, unit, factor, of in STORED:
        batches = w.stored(of)
        m = [batches.mean(b) for b in range(BLOCKS)]
        change, allowed = m[-1][0] - m[0][0], max(math.hypot(m[0][1], m[-1][1]), SMALL * abs(m[0][0] + m[-1][0]) / 2)
        held = abs(change) <= allowed <= WIDE * abs(m[0][0] + m[-1][0]) / 2
        good = good and held
        lines.append(f"| {name} [{unit}] | " + " | ".join(show(*x, factor) for x in m) + f" | {change * factor:+.3g} of ± {allowed * factor:.3g} | {'yes' if held else 'NO'} |")
    lines += ["", "| flow | " + " | ".join(f"block {b + 1}" for b in range(BLOCKS)) + " | all three |", "|---" * (BLOCKS + 2) + "|"]
    for name, unit, factor, of in FLOWS:
        if has(rows, of):
            batches = w.flow(of)
            lines.append(f"| {name} [{unit}] | " + " | ".join(show(*batches.mean(b), factor) for b in (*range(BLOCKS), None)) + " |")
    lines += ["", "| in = out over the three blocks | out less in, of what came in | allowed | held |", "|---|---|---|---|"]
    for name, come, go in PAIRS:
        if not (has(rows, come) and has(rows, go)):
            continue
        into, (change, half) = w.flow(come).mean()[0], w.flow(lambda r, a=come, b=go: b(r) - a(r)).mean()
        held = abs(change) <= max(half, SMALL * abs(into)) <= WIDE * abs(into)
        good = good and held
        lines.append(f"| {name} | {100 * change / into:+.2f} % | {100 * max(half / abs(into), SMALL):.1f} % | {'yes' if held else 'NO'} |")
    lines += ["", "| books since the start | residual / what went through | below 1e-9 |", "|---|---|---|"]
    for name, residual, through in books(rows):
        if through == 0 == residual:
            continue  # nothing of it yet
        held = abs(residual) <= BOOKS * through
        good = good and held
        lines.append(f"| {name} | {residual / (through or 1):.1e} | {'yes' if held else 'NO'} |")
    return lines + ["", "Steady, and the books close." if good else "NOT steady, or books that do not close."], good


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", help="of a run, also of one that goes on")
    parser.add_argument("--until", type=float, help="leave out what comes later [s]")
    parser.add_argument("--write", action="store_true", help="put the tables on FURNACE.md")
    args = parser.parse_args()
    rows = read(args.folder, args.until)
    if len(rows) < 2 * BLOCKS * BATCHES:
        parser.error(f"{args.folder}: {len(rows)} rows are too few")
    lines, good = tables(rows)
    print("\n".join(lines))
    if args.write:
        write_table(os.path.join(HERE, "FURNACE.md"), "steady", lines)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
