#!/usr/bin/env python3
"""Write the rough surface of the incline: big grains side by side on a tilted plate, as one mesh that can vibrate.

  python3 cases/incline/make_incline.py            # generated/rough-small.stl, -full.stl and -extreme.stl
  python3 cases/incline/make_incline.py --only small --angle 28 --grain 0.008

Each big grain is a faceted half ball on a plate; together they are one rigid body, as grains glued to a shaken plate are.
Needs python3-numpy. Lengths in metres; the numbers are those of README.md.
"""
import argparse
import os
import sys

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(HERE))
import case_files  # noqa: E402

# length along the slope and width of the rough surface [m]
SIZES = {"small": (0.56, 0.16), "full": (1.24, 0.36), "extreme": (0.56, 0.64)}


def half_ball(radius, around=8, up=3):
    """Triangles of a half ball on z = 0, its corners on the sphere."""
    rings = [[(radius * np.cos(p) * np.cos(t), radius * np.cos(p) * np.sin(t), radius * np.sin(p))
              for t in 2 * np.pi * np.arange(around) / around] for p in 0.5 * np.pi * np.arange(up) / up]
    out = []
    for low, high in zip(rings, rings[1:]):
        for i in range(around):
            j = (i + 1) % around
            out += [(low[i], low[j], high[j]), (low[i], high[j], high[i])]
    top = (0.0, 0.0, radius)
    out += [(rings[-1][i], rings[-1][(i + 1) % around], top) for i in range(around)]
    return np.array(out)


def rough_surface(length, width, grain, angle, seed):
    """Half balls in rows across the slope, each turned and moved a little so that no straight furrow remains."""
    rng = np.random.default_rng(seed)
    pitch, row = 1.02 * grain, 1.02 * grain * np.sqrt(3) / 2
    centres = [(s, y + (0.5 * pitch if k % 2 else 0.0)) for k, s in enumerate(np.arange(-0.1 * length, length, row))
               for y in np.arange(-width / 2, width / 2, pitch)]
    ball = half_ball(grain / 2)
    parts = []
    for s, y in centres:
        turn, (ds, dy), sink = rng.uniform(0, 2 * np.pi), rng.uniform(-0.1, 0.1, 2) * grain, rng.uniform(0, 0.15) * grain
        c, n = np.cos(turn), np.sin(turn)
        part = ball @ np.array([[c, n, 0], [-n, c, 0], [0, 0, 1]])
        parts.append(part + np.array([s + ds, y + dy, -sink]))
    lo, hi = -0.1 * length - grain, length + grain
    w = width / 2 + grain
    plate = [[(lo, -w, 0), (hi, -w, 0), (hi, w, 0)], [(lo, -w, 0), (hi, w, 0), (lo, w, 0)]]
    t = np.concatenate([np.concatenate(parts), np.array(plate)])
    c, s = np.cos(angle), np.sin(angle)
    return t @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])  # slope coordinate to x, normal to (sin, 0, cos)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", choices=sorted(SIZES), action="append", help="just this size (may be repeated)")
    parser.add_argument("--grain", type=float, default=0.008, help="diameter of the big grains [m] (0.008)")
    parser.add_argument("--angle", type=float, default=32, help="slope [degrees] (32)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", default=os.path.join(HERE, "generated"))
    args = parser.parse_args()
    if not 0 < args.angle < 90 or args.grain <= 0:
        parser.error("the slope must lie between 0 and 90 degrees and the grain be larger than 0")
    for name in args.only or SIZES:
        path = os.path.join(args.out, f"rough-{name}.stl")
        facets = case_files.write_stl(path, rough_surface(*SIZES[name], args.grain, np.radians(args.angle), args.seed))
        print(f"{path}: {facets} facets")


if __name__ == "__main__":
    main()
