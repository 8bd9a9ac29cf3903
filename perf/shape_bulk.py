#!/usr/bin/env python3
"""What shape does to bulk: discharge of a bin through a slot and the angle of what stays in it, beside published trends.

Grains of one volume (that of a sphere of diameter d) fill a bin that is periodic in y. At the end of its flat floor, beside a
wall, a gate of 5 d opens; grains run out until a slope rests on the floor. One run gives both figures: the rate while 10 to 40 %
of what will leave is leaving, and the angle of the slope: a line through the mean height of the four highest centres of each d of
the floor. Shapes: spheres; rods, clumps of spheres that overlap, of aspect 1, 2, 4 (1: a clump of one sphere, which has to agree with
spheres); cubes, superquadrics with exponents 6. Mean over seeds with its 95 % interval (Student).

Usage: python3 perf/shape_bulk.py [--seeds 4] [--shapes rod-2,cube] [--talus PATH] [--json FILE] [--write]
About 10 minutes on one core; --write puts the table on perf/measured/shapes.md.
"""
import argparse
import csv
import json
import math
import os
import statistics
import subprocess
import sys
import time

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(HERE, "..", "cases"))
from frames import PvdFrames  # noqa: E402
from page_table import write_table  # noqa: E402
from shape_packings import STUDENT  # noqa: E402

D = 5e-3                              # diameter of the sphere of equal volume [m]
G = 9.81
UNIT = math.sqrt(D / G)               # [s]
WIDE, DEEP, SLOT = 14.0, 5.0, 4.5     # of the bin and its slot [d]
MASS = 2500 * math.pi / 6 * D**3
STIFFNESS = 5e3 * MASS * G / D        # a grain under ten others overlaps by 2e-3 d
REST = 8.0                            # from the fall of the highest grain until the gate opens [sqrt(d/g)]
FLOW = 22.0
SCENE = """
title = "A bin of {name}"
seed = {seed}
gravity = [0, 0, -9.81]
[domain]
lower = [0, 0, {bottom:.9g}]
upper = [{wide:.9g}, {deep:.9g}, {height:.9g}]
boundary = ["wall", "periodic", ["open", "wall"]]
[time]
step = {step}
duration = {duration:.9g}
[[material]]
name = "m"
density = 2500
[contact]
normal_stiffness = {stiffness:.9g}
tangential_stiffness = {tangential:.9g}
restitution = 0.5
friction = 0.5
{shape}
[[source]]
kind = "random"
number = {number}
{use}
velocity_jitter = 0.05
size = {{ diameter = {d} }}
region = {{ lower = [0, 0, 0], upper = [{wide:.9g}, {deep:.9g}, {height:.9g}] }}
[[wall]]
name = "floor"
shape = "box"
lower = [{before:.9g}, {before:.9g}, {under:.9g}]
upper = [{edge:.9g}, {behind:.9g}, 0]
[[wall]]
name = "gate"
shape = "box"
lower = [{edge:.9g}, {before:.9g}, {under:.9g}]
upper = [{beyond:.9g}, {behind:.9g}, 0]
vanish = {opens:.9g}
[output]
csv_every = {every:.9g}
particles_every = {duration:.9g}
checkpoint_wall = 0
"""


def rod(aspect, spheres):
    """A clump of spheres of radius 1 along z, ends included `aspect` diameters long."""
    at = np.linspace(-(aspect - 1), aspect - 1, spheres) if spheres > 1 else [0.0]
    return "[[shape]]\nname = \"s\"\nspheres = [" + ", ".join(f"0, 0, {1e-3 * z:.9g}, 0.001" for z in at) + "]\n"


CUBE = '[[shape]]\nname = "s"\nkind = "superquadric"\nsemi_axes = [0.001, 0.001, 0.001]\nexponents = [6, 6]\n'
# name: (shape, fill of the source's region, step [s])
SHAPES = {"sphere": ("", 0.25, 4e-5), "rod-1": (rod(1, 1), 0.25, 4e-5), "rod-2": (rod(2, 4), 0.2, 3e-5),
          "cube": (CUBE, 0.15, 3e-5), "rod-4": (rod(4, 10), 0.12, 2e-5)}


def scene_of(args, name, seed):
    shape, fill, step = SHAPES[name]
    height = args.grains * math.pi / 6 / (fill * WIDE * DEEP)
    opens = (REST + math.sqrt(2 * height)) * UNIT
    return SCENE.format(name=name, seed=seed, bottom=-2.5 * D, wide=WIDE * D, deep=DEEP * D, height=height * D, step=step,
                        duration=round((opens + FLOW * UNIT) / step) * step, stiffness=STIFFNESS, tangential=2 / 7 * STIFFNESS,
                        shape=shape, number=args.grains, use='shape = "s"' if shape else "", d=D, before=-D, under=-D,
                        edge=(WIDE - SLOT) * D, behind=(DEEP + 1) * D, beyond=(WIDE + 1) * D, opens=opens, every=0.05 * UNIT), opens


def rate_of(folder, opens, grains):
    """Grains per sqrt(d/g), from when 10 % of those that leave have left until 40 % have."""
    with open(os.path.join(folder, "series.csv"), newline="", encoding="utf-8") as f:
        table = np.array([(float(r["time"]), grains - int(r["particles"])) for r in csv.DictReader(f)])
    t, left = table[table[:, 0] > opens].T
    use = (left > 0.1 * left[-1]) & (left < 0.4 * left[-1])
    return float(np.polyfit(t[use] / UNIT, left[use], 1)[0]), int(left[-1])


def angle_of(folder):
    """Of the slope that stays [degrees]."""
    path = os.path.join(folder, "bodies.pvd")
    frames = PvdFrames(path if os.path.exists(path) else os.path.join(folder, "particles.pvd"))
    x = frames.read(len(frames) - 1)[0] / D
    edge, at, top = WIDE - SLOT, [], []
    for low in np.arange(0.5, edge - 1, 1.0):
        z = np.sort(x[(x[:, 0] >= low) & (x[:, 0] < low + 1), 2])
        if len(z) >= 4:
            at.append(low + 0.5)
            top.append(np.mean(z[-4:]))
    return math.degrees(math.atan(-np.polyfit(at, top, 1)[0])) if len(at) > 3 else float("nan")


def measure(args, name, seed):
    text, opens = scene_of(args, name, seed)
    os.makedirs(args.out, exist_ok=True)
    scene, folder = os.path.join(args.out, "bin.toml"), os.path.join(args.out, f"{name}-{seed}")
    with open(scene, "w", encoding="utf-8") as f:
        f.write(text)
    started = time.time()
    done = subprocess.run([args.talus, "run", scene, "--quiet", "--overwrite", "--out", folder, "--threads", "1"],
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"shape_bulk.py: {done.stdout[-1500:]}")
    rate, left = rate_of(folder, opens, args.grains)
    return rate, angle_of(folder), left, time.time() - started


def interval(values):
    n = len(values)
    wide = STUDENT.get(n, 2.2) * statistics.stdev(values) / n**0.5 if n > 1 else float("nan")
    return statistics.mean(values), wide


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--talus", default=os.path.join(HERE, "..", "build", "talus"))
    p.add_argument("--grains", type=int, default=700)
    p.add_argument("--seeds", type=int, default=4)
    p.add_argument("--shapes", default=",".join(SHAPES))
    p.add_argument("--out", default=os.path.join(HERE, "..", "build", "shape_bulk"))
    p.add_argument("--json", help="all figures to a file")
    p.add_argument("--write", action="store_true", help="the table on perf/measured/shapes.md")
    args = p.parse_args()
    found, lines = {}, ["| shape | rate [grains per √(d/g)] | rate / that of spheres | angle [°] | seeds |", "|---|---|---|---|---|"]
    for name in args.shapes.split(","):
        runs = [measure(args, name, seed) for seed in range(1, args.seeds + 1)]
        found[name] = [r[:3] for r in runs]
        (rate, rate_half), (angle, angle_half) = interval([r[0] for r in runs]), interval([r[1] for r in runs])
        if "sphere" in found:
            of, of_half = interval([r[0] for r in found["sphere"]])
            share = "1" if name == "sphere" else f"{rate / of:.2f} ± {rate / of * math.hypot(rate_half / rate, of_half / of):.2f}"
        else:
            share = ""
        lines.append(f"| {name} | {rate:.1f} ± {rate_half:.1f} | {share} | {angle:.1f} ± {angle_half:.1f} | {args.seeds} |")
        print(f"{lines[-1]}  {sum(r[3] for r in runs):.0f} s, {statistics.mean(r[2] for r in runs):.0f} of {args.grains} left", flush=True)
    if args.json:
        with open(args.json, "w", encoding="utf-8") as f:
            json.dump({"grains": args.grains, "rate, angle, left": found}, f, indent=1)
    if args.write:
        write_table(os.path.join(HERE, "measured", "shapes.md"), "bulk", lines)


if __name__ == "__main__":
    main()
