#!/usr/bin/env python3
"""The speed marks that need no other code, on one core: interleaved rounds, medians of the ratios, exit 1 below a mark.

  python3 perf/marks.py                       # all groups
  python3 perf/marks.py --only fast,energies --rounds 9

Groups: sizes (512k >= 0.75 of 32k), isa (AVX2 >= 0.8 of AVX-512 at 32k), fast (precision = "fast": speed, and how far its
kinetic energy is from the exact mode's), energies (what output.energies costs; it is off in all marks).
All on the settled bed perf/states/settle32.csv.gz, tiled by the source.
"""
import argparse
import json
import os
import subprocess
import sys

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(HERE)


def run(args, tiles=1, steps=600, warm=100, extra=()):
    command = ["taskset", "-c", str(args.core), args.talus, "run", os.path.join(HERE, "scenes", "settle10m.toml"), "--threads", "1",
               "--warm", str(warm), "--steps", str(warm + steps), "--quiet", "--json", "--overwrite", "--out",
               os.path.join(args.out, "run"), "--set", f"source.0.tile=[{tiles}, {tiles}, 1]", "--set",
               f"domain.upper=[{40 * tiles}, {20 * tiles}, 45]", *extra]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"marks.py: {' '.join(command)}\n{done.stderr}")
    return json.loads(done.stdout)


def energy(args, steps, extra):
    return run(args, steps=steps, warm=0, extra=extra)["kinetic_energy"]


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--talus", default=os.path.join(ROOT, "build", "talus"))
    p.add_argument("--only", default="sizes,isa,fast,energies")
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
        if name not in groups:
            p.error(f"unknown group '{name}'; there are {', '.join(groups)}")
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
        for steps in (100, 1000):
            exact = energy(args, steps, [])
            print(f"kinetic energy after {steps} steps: fast differs from exact by {abs(energy(args, steps, fast) / exact - 1):.1e}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
