#!/usr/bin/env python3
"""What lumped heat costs a dense bed, and the error of its step: M contact steps per heat step.

  python3 perf/heat_cost.py                      # cost at M = 100, then error against M: some minutes
  python3 perf/heat_cost.py --only cost --every 100 --rounds 9 --mark 1.03
  python3 perf/heat_cost.py --only error --wanted 1e-3

Cost: settle32 (perf/scenes) with and without [heat], in turn on one thread; seconds of the steps after --warm; the median of the
ratios of each round with its quartiles; exit 1 above --mark. Friction does not heat. Error: the same bed in gas that is 300 K
warmer from the start on, 4000 steps; the largest difference of a grain's temperature at twenty times to the run with M = 1, as a
share of 300 K. `--wanted`: the largest M of the table whose error is below it. Then the same with heat.error, which chooses M: the
error beside the wanted one, and the shortest and longest heat steps. Needs python3-numpy; OUT is build/heat_cost.
"""
import argparse
import csv
import json
import os
import statistics
import subprocess
import sys

sys.dont_write_bytecode = True
HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(HERE)
sys.path.insert(0, os.path.join(ROOT, "cases"))
sys.path.insert(0, HERE)

HEAT = """
[heat]
temperature = 300
every = {every}
capacity = 1
conductivity = {conductivity}
"""
# conduction and film reach some 6 % of their limit in a heat step of M = 100
ERROR = """
[heat.gas]
temperature = 600
film = {film}

[output]
particles_every = {interval}
coordination = false
csv_every = {interval}
"""
STEPS, TIMES, STEP = 4000, 20, 1e-4


def scene(args, name, more):
    with open(os.path.join(HERE, "scenes", "settle32.toml")) as f:
        text = f.read().replace('"../../build/states/', '"' + os.path.join(ROOT, "build", "states") + "/")
    path = os.path.join(args.out, name + ".toml")
    with open(path, "w") as f:
        f.write(text + more)
    return path


def run(args, name, path, steps, warm=0):
    out = os.path.join(args.out, name)
    command = [args.talus, "run", path, "--out", out, "--overwrite", "--quiet", "--threads", "1", "--steps", str(steps)]
    if warm:
        command += ["--warm", str(warm)]
    r = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    if r.returncode != 0:
        raise SystemExit(f"heat_cost.py: {' '.join(command)}\n{r.stderr.strip()}")
    with open(os.path.join(out, "summary.json")) as f:
        return json.load(f)


def cost(args):
    plain = scene(args, "plain", "")
    heat = scene(args, "heat", HEAT.format(every=args.every, conductivity=0.1))
    ratios, rates = [], {"plain": [], "heat": []}
    for k in range(args.rounds):
        seconds = {}
        for name, path in (("plain", plain), ("heat", heat))[:: 1 if k % 2 == 0 else -1]:
            s = run(args, name, path, args.steps + args.warm, args.warm)
            rates[name].append(s["particle_steps_per_s"])
            seconds[name] = 1 / s["particle_steps_per_s"]
        ratios.append(seconds["heat"] / seconds["plain"])
    median = statistics.median(ratios)
    low, _, high = statistics.quantiles(ratios, n=4) if len(ratios) > 1 else (median, median, median)
    print(f"load average {os.getloadavg()[0]:.2f}")
    for name in rates:
        print(f"{name:6} {statistics.median(rates[name]) / 1e6:6.2f} million particle-steps/s (median of {args.rounds})")
    print(f"heat with M = {args.every}: {median:.4f} of the time without, quartiles {low:.4f} to {high:.4f}")
    return median <= args.mark


def temperatures(folder):
    from frames import whole_frames
    return {round(t / STEP): c["temperature"][c["id"].argsort()] for t, _, c in whole_frames(folder)}


def error(args):
    import numpy as np
    interval = STEPS // TIMES * STEP

    def bed(m, wanted=None):
        name = f"m{m}" if wanted is None else f"error{wanted}"
        chosen = "" if wanted is None else f"error = {wanted}\n"
        more = HEAT.format(every=m, conductivity=0.5) + chosen + ERROR.format(film=1.5, interval=repr(interval))
        s = run(args, name, scene(args, name, more), STEPS)
        return temperatures(os.path.join(args.out, name)), s

    def largest(found):
        return max(np.abs(found[n] - reference[n]).max() for n in reference if n in found)

    best, (reference, _) = None, bed(1)
    print("    M   error [share of the step of 300 K]   million particle-steps/s")
    for m in (10, 20, 50, 100, 200):
        found, s = bed(m)
        off = largest(found) / 300
        print(f"{m:5} {off:24.2e} {s['particle_steps_per_s'] / 1e6:28.2f}")
        if off <= args.wanted:
            best = m
    if best:
        print(f"error {args.wanted:g}: M = {best}")
    else:
        print(f"error {args.wanted:g}: below M = 10")
    print("\nheat.error [K]   error [K]   heat steps of   million particle-steps/s")
    for wanted in (3, 1, 0.3, 0.1, 0.03):
        found, s = bed(2, wanted)
        with open(os.path.join(args.out, f"error{wanted}", "series.csv")) as f:
            lengths = [float(row["heat.steps"]) for row in csv.DictReader(f)]
        print(f"{wanted:14g} {largest(found):11.2e} {min(lengths):7.0f} to {max(lengths):3.0f}"
              f" {s['particle_steps_per_s'] / 1e6:26.2f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--talus", default=os.path.join(ROOT, "build", "talus"))
    parser.add_argument("--out", default=os.path.join(ROOT, "build", "heat_cost"))
    parser.add_argument("--only", choices=("cost", "error"))
    parser.add_argument("--every", type=int, default=100)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--steps", type=int, default=1000)
    parser.add_argument("--warm", type=int, default=200)
    parser.add_argument("--mark", type=float, default=1e9, help="exit 1 above this ratio")
    parser.add_argument("--wanted", type=float, default=1e-3, help="error for which M is looked for")
    args = parser.parse_args()
    os.makedirs(args.out, exist_ok=True)
    state = os.path.join(ROOT, "build", "states", "settle32.csv.gz")
    if not os.path.exists(state):
        subprocess.run([sys.executable, os.path.join(HERE, "states.py"), "settle32"], check=True)
    good = True
    if args.only != "error":
        good = cost(args)
    if args.only != "cost":
        error(args)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
