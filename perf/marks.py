#!/usr/bin/env python3
"""The speed marks that need no other code, on one core: interleaved rounds, medians of the ratios, exit 1 below a mark.

  python3 perf/marks.py                       # all groups
  python3 perf/marks.py --only fast,energies --rounds 9

Groups: sizes (512k >= 0.75 of 32k), isa (AVX2 >= 0.8 of AVX-512 at 32k), fast (precision = "fast": speed, and how far its
grains are from those of the exact mode), energies (what output.energies costs; it is off in all marks), radii (one grain
of 20 radii per 10^4 small ones: a step and a rebuild per particle at most 2 x those of the bed without them).
All on the settled bed perf/states/settle32.csv.gz, tiled by the source.
"""
import argparse
import json
import os
import shutil
import subprocess
import sys

import numpy as np

sys.dont_write_bytecode = True
import states  # noqa: E402

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(HERE)


def run(args, tiles=1, steps=600, warm=100, extra=(), scene="settle10m"):
    command = ["taskset", "-c", str(args.core), args.talus, "run", os.path.join(HERE, "scenes", scene + ".toml"), "--threads", "1",
               "--warm", str(warm), "--steps", str(warm + steps), "--quiet", "--json", "--overwrite", "--out",
               os.path.join(args.out, "run"), *extra]
    if scene == "settle10m":
        command += ["--set", f"source.0.tile=[{tiles}, {tiles}, 1]", "--set", f"domain.upper=[{40 * tiles}, {20 * tiles}, 45]"]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"marks.py: {' '.join(command)}\n{done.stderr}")
    return json.loads(done.stdout)


def grains(args, steps, extra):
    """Positions [smallest diameters] by id after some steps, and the kinetic energy."""
    folder = os.path.join(args.out, "run", "vtp")
    shutil.rmtree(folder, ignore_errors=True)
    s = run(args, steps=steps, warm=0, extra=[*extra, "--set", f"output.particles_every={steps * 1e-4:.17g}", "--set",
                                              "output.vtp=true", "--set", "output.vtkhdf=false"])
    last = max(f for f in os.listdir(folder) if f.startswith("particles-") and f.endswith(".vtp"))
    columns = states.read_vtp(os.path.join(folder, last))
    return columns["Points" if "Points" in columns else "points"][np.argsort(columns["id"])], s["kinetic_energy"]


def print_fast_error(args, fast):
    for steps in (100, 1000):
        (x, e), (y, f) = grains(args, steps, []), grains(args, steps, fast)
        d = y - x
        d[:, :2] -= np.rint(d[:, :2] / [40, 20]) * [40, 20]
        d = np.sqrt((d * d).sum(1))
        print(f"fast against exact after {steps} steps: a grain differs by {np.sqrt((d * d).mean()):.1e} (rms), {d.max():.1e} (largest) "
              f"diameters; kinetic energy by {abs(f / e - 1):.1e}")


def radii(args):
    """Costs with coarse grains over those without, per particle: steps as they come, and rebuilds, of which short skins bring many."""
    short = ["--set", "list.verlet_k=20", "--set", "list.floor=0.002"]
    rows = []
    for _ in range(args.rounds):
        pair = []
        for scene in ("radii20", "settle10m"):
            step = run(args, 3, 100, 50, scene=scene)
            lists = run(args, 3, 100, 50, short, scene)
            seconds = {n["name"]: n["seconds"] for n in lists["nodes"]}["rebuild"]
            calls = {n["name"]: n["calls"] for n in lists["nodes"]}["rebuild"]
            pair.append([1e9 / step["particle_steps_per_s"], 1e9 * seconds / (calls * lists["particles"])])
        rows.append(pair)
    r = np.array(rows)
    held = True
    for k, what in enumerate(("step", "rebuild")):
        ratio = r[:, 0, k] / r[:, 1, k]
        value = np.median(ratio)
        held &= bool(value <= 2)
        print(f"{'radii 1:20 / 1:1, ' + what:<30} {np.median(r[:, 0, k]):6.1f} ns / {np.median(r[:, 1, k]):6.1f} ns per particle = {value:.3f} "
              f"({ratio.min():.3f} ... {ratio.max():.3f})  mark <= 2: {'holds' if value <= 2 else 'DOES NOT HOLD'}")
    return held


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--talus", default=os.path.join(ROOT, "build", "talus"))
    p.add_argument("--only", default="sizes,isa,fast,energies,radii")
    p.add_argument("--rounds", type=int, default=5)
    p.add_argument("--core", type=int, default=0)
    p.add_argument("--out", default=os.path.join(ROOT, "build", "marks"))
    args = p.parse_args()
    args.talus = os.path.abspath(args.talus)
    fast, energies = ["--set", "precision=\"fast\""], ["--set", "output.energies=true"]
    # group -> (what, arguments above, arguments below, mark or None): ratio of the rates
    groups = {"sizes": ("512k / 32k", {"tiles": 4, "steps": 40, "warm": 20}, {}, 0.75),
              "isa": ("AVX2 / AVX-512, 32k", {"extra": ["--isa", "avx2"]}, {"extra": ["--isa", "avx512"]}, 0.8),
              "fast": ("fast / exact, 32k", {"extra": fast}, {}, None),
              "energies": ("with energies / without, 32k", {"extra": energies}, {}, None)}
    names = args.only.split(",")
    for name in names:
        if name not in groups and name != "radii":
            p.error(f"unknown group '{name}'; there are {', '.join(groups)}, radii")
    with_radii = "radii" in names
    names = [name for name in names if name != "radii"]
    if with_radii:
        states.csv_path("radii20")  # made if it is not there yet
    rates = {name: [] for name in names}
    for _ in range(args.rounds):
        for name in names:
            _, above, below, _ = groups[name]
            rates[name].append([run(args, **q)["particle_steps_per_s"] for q in (above, below)])
    failed = False
    print(f"settled bed, one core, {args.rounds} interleaved rounds (load average {os.getloadavg()[0]:.1f})")
    for name in names:
        what, _, _, mark = groups[name]
        r = np.array(rates[name])
        ratio = r[:, 0] / r[:, 1]
        value = np.median(ratio)
        verdict = "" if mark is None else f"  mark >= {mark:g}: {'holds' if value >= mark else 'DOES NOT HOLD'}"
        failed |= mark is not None and value < mark
        print(f"{what:<30} {np.median(r[:, 0]) / 1e6:6.2f} M / {np.median(r[:, 1]) / 1e6:6.2f} M = {value:.3f} "
              f"({ratio.min():.3f} ... {ratio.max():.3f}){verdict}")
    if "fast" in names:
        print_fast_error(args, fast)
    if with_radii:
        failed |= not radii(args)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
