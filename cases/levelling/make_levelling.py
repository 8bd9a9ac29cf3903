#!/usr/bin/env python3
"""Write the recoaters of the levelling case: a blade with a rounded edge and a roller, as closed meshes.

  python3 cases/levelling/make_levelling.py         # generated/blade-small.stl, roller-small.stl and the same for full

Needs python3-numpy. Lengths in metres. The lowest point of each recoater lies at z = 0 and its middle at x = 0: the scene
shifts it to its place and to the height of the gap. Both are longer than the powder bed is wide (y).
"""
import argparse
import os
import sys

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(HERE))
import case_files  # noqa: E402

WIDTH = {"small": 0.6e-3, "full": 3.0e-3}  # of the powder bed [m]


def blade_outline(thickness, height, edge, arc):
    """Corners in the x-z plane, counter-clockwise seen from -y: a rounded edge below, straight flanks, a flat top."""
    t = np.pi * np.arange(arc + 1) / arc
    low = [(-0.5 * thickness + edge - edge * np.cos(a / 2), edge - edge * np.sin(a / 2)) for a in t]
    return low + [(-x, z) for x, z in reversed(low)] + [(0.5 * thickness, height), (-0.5 * thickness, height)]


def roller_outline(radius, corners):
    """Regular polygon on the circle."""
    a = 2 * np.pi * np.arange(corners) / corners - np.pi / 2
    return [(radius * np.cos(t), radius + radius * np.sin(t)) for t in a]


def prism(outline, y0, y1):
    """Closed mesh of an outline in x-z drawn along y, normals outwards (the outlines are convex)."""
    o, out = np.array(outline), []
    mid = o.mean(axis=0)
    for (xa, za), (xb, zb) in zip(o, np.roll(o, -1, axis=0)):
        a0, b0, a1, b1 = (xa, y0, za), (xb, y0, zb), (xa, y1, za), (xb, y1, zb)
        out += [(a0, a1, b1), (a0, b1, b0)]
        out += [((mid[0], y0, mid[1]), a0, b0), ((mid[0], y1, mid[1]), b1, a1)]
    t = np.array(out)
    # outlines run one way or the other: turn every facet so that it looks away from the middle
    normal = np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])
    outward = t.mean(axis=1) - np.array([mid[0], 0.5 * (y0 + y1), mid[1]])
    flip = (normal * outward).sum(axis=1) < 0
    t[flip] = t[flip][:, ::-1]
    return t


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", choices=sorted(WIDTH), action="append", help="just this size (may be repeated)")
    parser.add_argument("--thickness", type=float, default=0.3e-3, help="of the blade [m] (0.3e-3)")
    parser.add_argument("--height", type=float, default=2.0e-3, help="of the blade [m] (2e-3)")
    parser.add_argument("--edge", type=float, default=0.05e-3, help="radius of the blade's edges [m] (0.05e-3)")
    parser.add_argument("--roller", type=float, default=0.5e-3, help="radius of the roller [m] (0.5e-3)")
    parser.add_argument("--out", default=os.path.join(HERE, "generated"))
    args = parser.parse_args()
    if not 0 < 2 * args.edge <= args.thickness:
        parser.error("--edge must be larger than 0 and at most half the thickness")
    for name in args.only or WIDTH:
        half = 0.5 * WIDTH[name] + 0.1e-3
        for kind, outline in (("blade", blade_outline(args.thickness, args.height, args.edge, 6)),
                              ("roller", roller_outline(args.roller, 48))):
            path = os.path.join(args.out, f"{kind}-{name}.stl")
            print(f"{path}: {case_files.write_stl(path, prism(outline, -half, half))} facets")


if __name__ == "__main__":
    main()
