#!/usr/bin/env python3
"""Solid fraction of ellipsoids that have been poured, over their aspect: the maximum near 1.5, beside published values.

Grains of equal volume without friction fall into a box that is periodic in x and y and come to rest. The fraction is that of
the middle half of the bed; the part of an ellipsoid below a plane is exact. Mean over seeds with its 95 % interval (Student).

Published: Donev et al., Science 303, 990 (2004): jammed disordered spheres 0.64, spheroids with an aspect near 1.5 up to 0.68 to
0.71. Man et al., PRL 94, 198001 (2005): ellipsoids of 1.25 : 1 : 0.8 in large containers 0.74. A narrow box or a slow fall orders
spheres on the floor and lies above.

Usage: python3 perf/shape_packings.py [--grains 800] [--seeds 3] [--shapes 1,1.5,0.67] [--talus PATH] [--json FILE] [--write]
Minutes per shape at 800 grains; --write puts the table on perf/measured/shapes.md.
"""
import argparse
import json
import os
import statistics
import subprocess
import sys

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(HERE, "..", "cases"))
from bodies import rotation  # noqa: E402
from frames import PvdFrames  # noqa: E402
from page_table import write_table  # noqa: E402

RADIUS = 1e-3  # of the sphere of equal volume [m]
PUBLISHED = {"1": "0.64", "0.67": "0.68-0.71", "1.5": "0.68-0.71", "1.25:1:0.8": "0.74"}
STUDENT = {2: 12.71, 3: 4.303, 4: 3.182, 5: 2.776, 6: 2.571, 8: 2.365, 10: 2.262}
SCENE = """
title = "Ellipsoids of {name} at rest"
seed = {seed}
gravity = [0, 0, -9.81]
[domain]
lower = [0, 0, 0]
upper = [{side}, {side}, {height}]
boundary = ["periodic", "periodic", "wall"]
[time]
step = 8e-6
duration = {duration}
[[material]]
name = "m"
density = 2500
[contact]
normal_stiffness = 2000
restitution = 0.5
friction = 0
[[shape]]
name = "egg"
kind = "superquadric"
semi_axes = [{axes[0]:.9g}, {axes[1]:.9g}, {axes[2]:.9g}]
[[source]]
kind = "random"
number = {grains}
shape = "egg"
velocity_jitter = 0.1
region = {{ lower = [0, 0, 0], upper = [{side}, {side}, {height}] }}
[output]
particles_every = {duration}
"""


def axes_of(name):
    """Semi-axes of the volume of a sphere; a number is the aspect of a spheroid about its axis."""
    ratio = [float(v) for v in name.split(":")] if ":" in name else [1, 1, float(name)]
    scale = RADIUS / np.prod(ratio) ** (1 / 3)
    return [scale * v for v in ratio]


def below(z, centre, half):
    """Part of an ellipsoid of half height `half` below the plane z."""
    t = np.clip((z - centre) / half, -1, 1)
    return (2 + 3 * t - t**3) / 4


def fraction(folder, side):
    """Of the middle half of the bed, and the largest speed [m/s]."""
    frames = PvdFrames(os.path.join(folder, "bodies.pvd"))
    centres, columns, _ = frames.read(len(frames) - 1)
    axes = columns["semi_axes"]
    up = np.array([rotation(q)[2] for q in columns["orientation"]])  # z component of each axis
    half = np.sqrt(np.sum((axes * up) ** 2, axis=1))
    volume = 4 / 3 * np.pi * np.prod(axes, axis=1)
    z = centres[:, 2]
    top = np.sort(z + half)[int(0.95 * len(z))]
    low, high = 0.25 * top, 0.75 * top
    inside = below(high, z, half) - below(low, z, half)
    return float(np.sum(volume * inside) / (side**2 * (high - low))), float(np.max(np.linalg.norm(columns["velocity"], axis=1)))


def measure(args, name, seed):
    axes = axes_of(name)
    side = max(8.0 * 2 * RADIUS, 3.2 * max(axes), (args.grains / 18) ** (1 / 3) * 2 * RADIUS)
    height = args.grains * (2 * max(axes)) ** 3 / (0.35 * side**2)
    os.makedirs(args.out, exist_ok=True)
    scene = os.path.join(args.out, "bed.toml")
    with open(scene, "w", encoding="utf-8") as f:
        f.write(SCENE.format(name=name, seed=seed, side=side, height=height, axes=axes, grains=args.grains,
                             duration=args.duration + (2 * height / 9.81) ** 0.5))
    folder = os.path.join(args.out, "run")
    done = subprocess.run([args.talus, "run", scene, "--quiet", "--overwrite", "--out", folder, "--threads", str(args.threads)],
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"shape_packings.py: {done.stdout[-1000:]}")
    return fraction(folder, side)


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--talus", default=os.path.join(HERE, "..", "build", "talus"))
    p.add_argument("--grains", type=int, default=800)
    p.add_argument("--seeds", type=int, default=3)
    p.add_argument("--shapes", default="0.33,0.5,0.67,0.8,1,1.25,1.5,2,3,1.25:1:0.8")
    p.add_argument("--duration", type=float, default=0.25, help="after the fall of the highest grain [s]")
    p.add_argument("--threads", type=int, default=1)
    p.add_argument("--out", default=os.path.join(HERE, "..", "build", "shape_packings"))
    p.add_argument("--json", help="all fractions to a file")
    p.add_argument("--write", action="store_true", help="the table on perf/measured/shapes.md")
    args = p.parse_args()
    print(f"{'shape':>12} {'fraction':>9} {'+-':>7} {'published':>9}  fastest grain [m/s]")
    found, lines = {}, ["| aspect | solid fraction | published | grains, seeds |", "|---|---|---|---|"]
    for name in args.shapes.split(","):
        runs = [measure(args, name, seed) for seed in range(1, args.seeds + 1)]
        values = [v for v, _ in runs]
        n = len(values)
        wide = STUDENT.get(n, 2.2) * statistics.stdev(values) / n**0.5 if n > 1 else float("nan")
        known = PUBLISHED.get(name)
        print(f"{name:>12} {statistics.mean(values):>9.4f} {wide:>7.4f} {known if known else '':>9}  "
              f"{max(v for _, v in runs):.1e}", flush=True)
        found[name] = values
        lines.append(f"| {name} | {statistics.mean(values):.3f} ± {wide:.3f} | {known or ''} | {args.grains}, {n} |")
    if args.write:
        write_table(os.path.join(HERE, "measured", "shapes.md"), "packings", lines)
    if args.json:
        with open(args.json, "w", encoding="utf-8") as f:
            json.dump({"grains": args.grains, "fractions": found}, f, indent=1)


if __name__ == "__main__":
    main()
