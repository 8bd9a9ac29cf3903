#!/usr/bin/env python3
"""Error against run time for heat and conversion within grains: level, shells, method and heat step of one grain; shells and M of a bed.

  python3 perf/grain_cost.py                     # all: some minutes
  python3 perf/grain_cost.py --only grain        # or bed

Writes the table and the picture that perf/measured/grains.md holds (OUT/grain_cost.md, .svg; OUT is build/grain_cost) and prints the table.
One grain: cases/grain/sadhukhan-sphere.toml (dry) and huang.toml (moist) against 80 shells and TR-BDF2 with a fifth of the file's
step. Bed: 128 moist grains of 10 mm on a floor in hot gas against 32 shells and M = 4; the same linearly implicit pass as in any
scene. Errors are the largest over time: of the mass as a share of the first, of the heat as one of what the reference takes in. Times
are user seconds of the process, the best of --rounds (3): they include start-up, and in the bed all contacts."""
import argparse
import csv
import io
import json
import os
import re
import resource
import subprocess
import sys

sys.dont_write_bytecode = True
ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
GRAINS = {"dry": ("sadhukhan-sphere", 0.25), "moist": ("huang", 0.25)}
BED = """title = "128 moist grains in hot gas"
seed = 5
gravity = [0, 0, -0.1]
[domain]
lower = [0, 0, 0]
upper = [0.05, 0.05, 0.12]
boundary = ["periodic", "periodic", "wall"]
[time]
step = 1e-3
duration = 20
[[material]]
name = "wood"
density = 600
grain = "wood.toml"
[contact]
normal_stiffness = 2
restitution = 0.3
friction = 0.4
[[source]]
kind = "random"
number = 128
size = { diameter = 0.01 }
region = { lower = [0, 0, 0.006], upper = [0.05, 0.05, 0.114] }
[conversion]
every = EVERY
shells = SHELLS
gone_below = 0
[output]
csv_every = 0.5
"""
WOOD = """title = "wood"
scheme = "chan"
[time]
step = 0.05
duration = 40
[grain]
diameter = 0.01
temperature = 300
[material]
density = 600
moisture = 0.2
ash = 0.01
[heat_capacity]
fuel = { polynomial = [1500, 1.0] }
char = { polynomial = [808.9, 0.93] }
gas = 2000
[conductivity]
fuel = 0.18
char = 0.12
[drying]
law = "boiling"
[shrinkage]
drying = 0.1
devolatilisation = 0.3
[surroundings]
temperature = 900
wall_temperature = 900
velocity = 1
"""


def timed(command, cwd, rounds):
    """Output and the least user seconds of some runs."""
    best, out = None, ""
    for _ in range(rounds):
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        run = subprocess.run(command, cwd=cwd, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        if run.returncode:
            sys.exit(f"grain_cost.py: {' '.join(command)}: {run.stderr.strip()}")
        spent = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
        best, out = spent if best is None else min(best, spent), run.stdout
    return out, best


def columns(text):
    rows = list(csv.DictReader(io.StringIO(text)))
    return {k: [float(r[k]) for r in rows] for k in rows[0]}


def at(c, name, t):
    x, y = c["time"], c[name]
    for k in range(1, len(x)):
        if t <= x[k]:
            return y[k - 1] + (t - x[k - 1]) / (x[k] - x[k - 1]) * (y[k] - y[k - 1])
    return y[-1]


def grain(args, name, shells, step, method):
    with open(os.path.join(ROOT, "cases", "grain", name + ".toml")) as f:
        text = f.read()
    size = 'level = "lumped"' if shells == 1 else f"shells = {shells}"
    for key, value in (("shells", size), ("step", f'step = {step}\nmethod = "{method}"'), ("output_every", "output_every = 5")):
        text, n = re.subn(rf"(?m)^{key} = .*$", value, text)
        assert n == 1, key
    path = os.path.join(args.out, "grain.toml")
    with open(path, "w") as f:
        f.write(text)
    out, seconds = timed([args.talus, "grain", path], args.out, args.rounds)
    return columns(out), seconds


def grain_rows(args):
    rows = []
    for kind, (name, step) in GRAINS.items():
        reference, _ = grain(args, name, 80, step / 5, "tr_bdf2")
        times = [t for t in reference["time"] if t > 0]
        for method in ("tr_bdf2", "euler"):
            for shells in (1, 5, 10, 20, 40):
                for h in (4 * step, step, step / 4):
                    c, seconds = grain(args, name, shells, h, method)
                    error = {k: max(abs(at(c, k, t) - at(reference, k, t)) for t in times) for k in ("mean_temperature", "mass")}
                    rows.append({"what": kind, "shells": shells, "method": method, "step": h,
                                 "temperature": error["mean_temperature"], "mass": error["mass"] / reference["mass"][0],
                                 "seconds": seconds})
    return rows


def bed(args, shells, every):
    for name, text in (("wood.toml", WOOD), ("bed.toml", BED.replace("EVERY", str(every)).replace("SHELLS", str(shells)))):
        with open(os.path.join(args.out, name), "w") as f:
            f.write(text)
    _, seconds = timed([args.talus, "run", "bed.toml", "--out", "bed", "--overwrite", "--quiet", "--threads", "1"], args.out, args.rounds)
    with open(os.path.join(args.out, "bed", "series.csv")) as f:
        return columns(f.read()), seconds


def bed_rows(args):
    reference, _ = bed(args, 32, 4)
    times, rows = [t for t in reference["time"] if t > 0], []
    top = max(abs(x) for x in reference["conversion.heat_in"])
    for shells in (1, 5, 10, 20):
        for every in (10, 25, 50, 100, 200):
            c, seconds = bed(args, shells, every)
            error = {k: max(abs(at(c, k, t) - at(reference, k, t)) for t in times) for k in ("conversion.heat_in", "conversion.mass")}
            rows.append({"what": "bed", "shells": shells, "every": every, "step": every * 1e-3, "heat": error["conversion.heat_in"] / top,
                         "mass": error["conversion.mass"] / reference["conversion.mass"][0], "seconds": seconds})
    return rows


def table(grains, beds):
    lines = []
    if grains:
        lines += ["| grain | level | method | step [s] | mean temperature [K] | mass | user [ms] |", "|---|---|---|---|---|---|---|"]
        for r in grains:
            level = "lumped" if r["shells"] == 1 else f"{r['shells']} shells"
            lines.append(f"| {r['what']} | {level} | {r['method']} | {r['step']:g} | {r['temperature']:.2g} | {r['mass']:.2g} | "
                         f"{1000 * r['seconds']:.0f} |")
    if beds:
        lines += ["", "| shells | M | heat step [s] | heat taken in | mass | user [s] |", "|---|---|---|---|---|---|"]
        lines += [f"| {r['shells']} | {r['every']} | {r['step']:g} | {r['heat']:.2g} | {r['mass']:.2g} | {r['seconds']:.2f} |" for r in beds]
    return "\n".join(lines)


def draw(grains, beds, path):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    plt.rcParams.update({"svg.hashsalt": "talus", "font.size": 9})
    fig, axes = plt.subplots(1, 3, figsize=(13, 4.2))
    for ax, kind in zip(axes, GRAINS):
        for method, line in (("tr_bdf2", "-"), ("euler", "--")):
            for k, shells in enumerate((1, 5, 10, 20, 40)):
                some = [r for r in grains if (r["what"], r["method"], r["shells"]) == (kind, method, shells)]
                ax.plot([r["seconds"] for r in some], [r["mass"] for r in some], line + "o", color=f"C{k}", ms=4,
                        label=("lumped" if shells == 1 else f"{shells} shells") if line == "-" else None)
        ax.set_title(f"one grain, {kind} (dashed: Euler)")
    for k, shells in enumerate((1, 5, 10, 20)):
        some = [r for r in beds if r["shells"] == shells]
        axes[2].plot([r["seconds"] for r in some], [r["mass"] for r in some], "-o", color=f"C{k}", ms=4, label=f"{shells} shells")
    axes[2].set_title("bed of 128 grains, M = 10 to 200")
    for ax in axes:
        ax.set_xscale("log"), ax.set_yscale("log"), ax.set_xlabel("user time [s]"), ax.legend(fontsize=7)
    axes[0].set_ylabel("largest error of the mass, share of the first")
    fig.tight_layout()
    fig.savefig(path)


def rows_of(args, part, measure):
    """Measured now, or where --only leaves the part out those of the last time, if there are any."""
    path = os.path.join(args.out, part + ".json")
    if args.only in (None, part):
        rows = measure(args)
        with open(path, "w") as f:
            json.dump(rows, f)
        return rows
    if not os.path.exists(path):
        return []
    with open(path) as f:
        return json.load(f)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--talus", default=os.path.join(ROOT, "build", "talus"))
    parser.add_argument("--out", default=os.path.join(ROOT, "build", "grain_cost"))
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--only", choices=("grain", "bed"))
    args = parser.parse_args()
    args.talus = os.path.abspath(args.talus)
    os.makedirs(args.out, exist_ok=True)
    grains, beds = rows_of(args, "grain", grain_rows), rows_of(args, "bed", bed_rows)
    text = table(grains, beds)
    print(text)
    with open(os.path.join(args.out, "grain_cost.md"), "w") as f:
        f.write(text + "\n")
    if grains and beds:
        draw(grains, beds, os.path.join(args.out, "grain_cost.svg"))


if __name__ == "__main__":
    main()
