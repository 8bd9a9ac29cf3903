#!/usr/bin/env python3
"""Density and surface profile of the powder layer that the recoater left, from the last frame of a finished run.

  python3 cases/levelling/layer.py results/levelling --from 0.001 --to 0.003 --gap 1e-4

Solid fraction: volume of the grains whose centre lies in the window, over window area times gap. Surface: the plate is divided into
squares; the height of a square is the highest point of the spheres whose centre lies in it, 0 where there is none. Printed: mean
height, its standard deviation (roughness), covered share, and the same per strip along the stroke in layer.csv (and layer.svg).
Needs python3-numpy, python3-h5py and, for the picture, python3-matplotlib. Lengths in metres.
"""
import argparse
import csv
import os
import sys

import numpy as np

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
import case_files  # noqa: E402


def height_map(x, r, x0, x1, width, square):
    """[strip along x, square along y]: highest sphere top. The bed is periodic in y with the given width."""
    nx, ny = max(1, round((x1 - x0) / square)), max(1, round(width / square))
    h = np.zeros((nx, ny))
    i = ((x[:, 0] - x0) / (x1 - x0) * nx).astype(int)
    j = np.minimum((np.mod(x[:, 1] / width, 1.0) * ny).astype(int), ny - 1)
    keep = (x[:, 0] >= x0) & (i < nx)
    np.maximum.at(h, (i[keep], j[keep]), x[keep, 2] + r[keep])
    return h


def measure(x, r, x0, x1, gap, width, square):
    inside = (x[:, 0] >= x0) & (x[:, 0] < x1)
    if not inside.any():
        raise SystemExit(f"layer.py: no grain between x = {x0} and {x1}")
    h = height_map(x, r, x0, x1, width, square)
    volume = 4 / 3 * np.pi * (r[inside] ** 3).sum()
    edges = np.linspace(x0, x1, len(h) + 1)
    strip = [(4 / 3 * np.pi * (r[(x[:, 0] >= a) & (x[:, 0] < b)] ** 3).sum()) / ((b - a) * width * gap) for a, b in zip(edges, edges[1:])]
    return {"grains": int(inside.sum()), "fraction": volume / ((x1 - x0) * width * gap), "height": float(h.mean()),
            "roughness": float(h.std()), "covered": float((h > 0).mean()), "x": 0.5 * (edges[:-1] + edges[1:]),
            "strip_height": h.mean(axis=1), "strip_roughness": h.std(axis=1), "strip_fraction": np.array(strip)}


def picture(path, m):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    fig, axes = plt.subplots(2, 1, figsize=(8, 4.6), sharex=True)
    mm, um = 1e3 * m["x"], 1e6
    axes[0].fill_between(mm, um * (m["strip_height"] - m["strip_roughness"]), um * (m["strip_height"] + m["strip_roughness"]), alpha=0.25)
    axes[0].plot(mm, um * m["strip_height"])
    axes[0].set_ylabel("surface height [µm]")
    axes[1].plot(mm, m["strip_fraction"])
    axes[1].set(xlabel="x [mm]", ylabel="solid fraction [-]")
    fig.savefig(path, bbox_inches="tight")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", help="of a finished run")
    parser.add_argument("--from", dest="x0", type=float, default=0.001, help="window along the stroke [m] (0.001)")
    parser.add_argument("--to", dest="x1", type=float, default=0.003, help="its end [m] (0.003)")
    parser.add_argument("--gap", type=float, default=1e-4, help="height of the blade over the plate [m] (1e-4)")
    parser.add_argument("--width", type=float, default=6e-4, help="of the bed [m] (6e-4; full: 3e-3)")
    parser.add_argument("--square", type=float, default=5e-5, help="edge of the squares of the surface [m] (5e-5)")
    parser.add_argument("--no-picture", action="store_true")
    args = parser.parse_args()
    if not args.x0 < args.x1 or min(args.gap, args.width, args.square) <= 0:
        parser.error("--from must lie below --to; gap, width and square must be larger than 0")
    *_, (time, x, r) = case_files.frames(args.folder)
    m = measure(x, r, args.x0, args.x1, args.gap, args.width, args.square)
    with open(os.path.join(args.folder, "layer.csv"), "w", newline="", encoding="utf-8") as f:
        table = csv.writer(f, lineterminator="\n")
        table.writerow(("x", "height", "roughness", "solid_fraction"))
        table.writerows(zip(m["x"], m["strip_height"], m["strip_roughness"], m["strip_fraction"]))
    if not args.no_picture:
        picture(os.path.join(args.folder, "layer.svg"), m)
    print(f"t = {time:g} s, {m['grains']} grains between x = {args.x0:g} and {args.x1:g} m\n"
          f"solid fraction {m['fraction']:.3f} of the gap; surface {1e6 * m['height']:.1f} um high, roughness {1e6 * m['roughness']:.1f} um, "
          f"{100 * m['covered']:.0f} % covered")


if __name__ == "__main__":
    main()
