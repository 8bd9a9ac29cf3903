#!/usr/bin/env python3
"""Write the valley (a triangle mesh from a height field) and the slab of snow that is released at its top.

  python3 cases/avalanche/make_avalanche.py                 # generated/valley-*.stl and snow-*.csv.gz, small and full
  python3 cases/avalanche/make_avalanche.py --only small

Needs python3-numpy. Lengths in metres; the formula of the terrain is in height() and in README.md.
"""
import argparse
import os
import sys

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(HERE))
import case_files  # noqa: E402

# scale: of all lengths of the valley and the slab; cells: of the height field along and across the valley
SIZES = {"small": dict(scale=1.0, cells=(160, 70)), "full": dict(scale=2.3, cells=(400, 150))}
LENGTH, HALF_WIDTH, DROP, DECAY = 240.0, 50.0, 47.0, 60.0     # of scale 1 [m]
SLAB = dict(x=(8.0, 30.0), y=(-15.0, 15.0), thickness=3.0)    # of scale 1 [m]
DIAMETER = (0.4, 0.6)                                         # of the snow grains, not scaled [m]
# bumps: amplitude [m], wavelengths along and across [m], phases [rad]; not scaled
BUMPS = [(0.30, 17.0, 23.0, 0.3, 1.1), (0.20, 9.0, 13.0, 2.1, 0.4), (0.12, 5.5, 7.0, 4.0, 2.7), (0.08, 3.7, 4.3, 1.3, 5.2)]


def height(x, y, scale):
    """Terrain [m]: a slope of 38 degrees that runs out, a valley floor that opens downstream, and bumps."""
    u, w = x / scale, y / scale
    z = scale * (DROP * np.exp(-u / DECAY) + 0.012 * w ** 2 * np.exp(-u / 150.0))
    for amplitude, along, across, a, b in BUMPS:
        z = z + amplitude * np.sin(2 * np.pi * x / along + a) * np.sin(2 * np.pi * y / across + b)
    return z


def terrain(scale, cells):
    """The mesh reaches a little beyond the domain, so that no grain finds an edge."""
    margin = 2.0
    xs = np.linspace(-margin, scale * LENGTH + margin, cells[0] + 1)
    ys = np.linspace(-scale * HALF_WIDTH - margin, scale * HALF_WIDTH + margin, cells[1] + 1)
    return case_files.grid_triangles(height(*np.meshgrid(xs, ys, indexing="ij"), scale), xs, ys)


def slab(scale, seed):
    """Grains of uniformly distributed diameter on a hexagonal lattice that is sheared to follow the terrain."""
    pitch = 1.04 * DIAMETER[1]
    x0, x1 = (scale * v for v in SLAB["x"])
    y0, y1 = (scale * v for v in SLAB["y"])
    p = case_files.hexagonal([x0, y0, 0], [x1, y1, scale * SLAB["thickness"]], pitch)
    # Neighbours of one layer only move apart when the lattice is sheared along z. Those of the next layer, half a pitch
    # down the slope, come closer: hence the stretch. The slab settles by it in the first second.
    p[:, 2] *= 1.8
    p[:, 2] += height(p[:, 0], p[:, 1], scale) + 1.3 * DIAMETER[1]
    radius = 0.5 * np.random.default_rng(seed).uniform(*DIAMETER, len(p))
    return p, radius


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", choices=sorted(SIZES), action="append", help="just this size (may be repeated)")
    parser.add_argument("--seed", type=int, default=1, help="of the grain sizes")
    parser.add_argument("--out", default=os.path.join(HERE, "generated"))
    args = parser.parse_args()
    for name in args.only or SIZES:
        size = SIZES[name]
        mesh = os.path.join(args.out, f"valley-{name}.stl")
        print(f"{mesh}: {case_files.write_stl(mesh, terrain(size['scale'], size['cells']))} facets")
        snow = os.path.join(args.out, f"snow-{name}.csv.gz")
        print(f"{snow}: {case_files.write_particles(snow, *slab(size['scale'], args.seed))} grains")


if __name__ == "__main__":
    main()
