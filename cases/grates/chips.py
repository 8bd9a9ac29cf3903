#!/usr/bin/env python3
"""Rods of wood on the grates beside spheres that resist rolling: the table of CHIPS.md.

  python3 cases/grates/chips.py results/chips results/chips-spheres
"""
import argparse
import csv
import os
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from frames import whole_frames  # noqa: E402

GRATES = [(0.0, 0.08, 0.0), (0.08, 0.16, -0.02), (0.16, 0.24, -0.04), (0.24, 0.32, -0.06)]  # x from, to, top [m]
LENGTH = 0.32


def grains_of(x, columns):
    """(number, centre, {what: kg}) of each grain: of a body the mean of its spheres, which lie alike on both sides."""
    ids = columns["body"] if "body" in columns else columns["id"]
    number, at = np.unique(ids, return_inverse=True)
    count = np.bincount(at)
    centre = np.stack([np.bincount(at, x[:, k]) / count for k in range(3)], axis=1)
    return number, centre, {k: np.bincount(at, columns[k]) for k in ("grain_mass", "moisture", "fuel", "char")}


def read(folder, end):
    out = [(time, *grains_of(x, columns)) for time, x, columns in whole_frames(folder) if time <= end + 1e-9]
    with open(os.path.join(folder, "series.csv")) as f:
        series = [{k: float(v) for k, v in r.items() if v} for r in csv.DictReader(r for r in f if not r.startswith("#"))]
    return out, [r for r in series if r["time"] <= out[-1][0] + 1e-9]


def half_time(all_frames, what):
    """When half of what the grains of the start held is gone [s]."""
    first = all_frames[0][1]
    left = [m[what][np.isin(n, first)].sum() for _, n, _, m in all_frames]
    for k in range(1, len(left)):
        if left[k] <= 0.5 * left[0]:
            share = (left[k - 1] - 0.5 * left[0]) / (left[k - 1] - left[k])
            return all_frames[k - 1][0] + share * (all_frames[k][0] - all_frames[k - 1][0])
    return float("nan")


def top(x, grate):
    """Highest centre in each 10 mm of a grate: (middles, heights over the grate) [m]."""
    a, b, level = GRATES[grate]
    edges = np.arange(a, b + 1e-9, 0.01)
    where = np.digitize(x[:, 0], edges) - 1
    return zip(*[(edges[k] + 0.005, x[where == k, 2].max() - level) for k in range(len(edges) - 1) if (where == k).any()])


def bed(late):
    """Height of the bed and slope of its surface on the grates but the first, which the feed falls on."""
    heights, slopes = [], []
    for _, _, x, _ in late:
        for g in (1, 2, 3):
            at, high = (np.array(v) for v in top(x, g))
            heights.append(high.mean())
            if len(at) >= 5:
                slopes.append(np.degrees(np.arctan(-np.polyfit(at, high, 1)[0])))
    return np.mean(heights), np.mean(slopes), np.std(slopes) / np.sqrt(len(slopes))


def speed(late):
    """Of the grains that are there at both ends [m/s]."""
    (t0, n0, x0, _), (t1, n1, x1, _) = late[0], late[-1]
    _, i, j = np.intersect1d(n0, n1, return_indices=True)
    return (x1[j, 0] - x0[i, 0]).mean() / (t1 - t0)


def front(late, what):
    """Along the grates: where the mean of `what` per grain has fallen to half of that on the first 40 mm [m]."""
    x = np.concatenate([c[:, 0] for _, _, c, _ in late])
    m = np.concatenate([v[what] for *_, v in late])
    edges = np.arange(0, LENGTH + 1e-9, 0.04)
    where = np.digitize(x, edges) - 1
    mean = [m[where == k].mean() if (where == k).any() else 0.0 for k in range(len(edges) - 1)]
    for k in range(1, len(mean)):
        if mean[k] <= 0.5 * mean[0]:
            return edges[k] - 0.02 + 0.04 * (mean[k - 1] - 0.5 * mean[0]) / (mean[k - 1] - mean[k])
    return float("nan")


def lines_of(folder, start, end):
    all_frames, series = read(folder, end)
    late = [f for f in all_frames if f[0] >= start - 1e-9]
    last = series[-1]
    height, slope, error = bed(late)
    v = speed(late)
    first, final = all_frames[0], all_frames[-1]
    return [
        ("grains at the start, fed, left", f"{len(first[1])}, {last['inserted']:.0f}, {last['removed']:.0f}"),
        ("wood, water, char at the end [g]", ", ".join(f"{1e3 * last['conversion.' + k]:.2f}" for k in ("fuel", "moisture", "char"))),
        ("half of the first water, of the first wood gone [s]", f"{half_time(all_frames, 'moisture'):.2f}, {half_time(all_frames, 'fuel'):.2f}"),
        (f"height of the bed, {start:g} s to {final[0]:g} s [mm]", f"{1e3 * height:.1f}"),
        ("slope of its surface along a grate [degrees]", f"{slope:.1f} ± {error:.1f}"),
        ("mean speed along the grates [mm/s]", f"{1e3 * v:.2f}"),
        ("residence time, 320 mm at that speed [s]", f"{LENGTH / v:.0f}"),
        ("drying front along the grates [mm]", f"{1e3 * front(late, 'moisture'):.0f}"),
        ("wood front along the grates [mm]", f"{1e3 * front(late, 'fuel'):.0f}"),
    ]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rods", help="folder of a run of chips.toml")
    parser.add_argument("spheres", help="folder of a run of chips-spheres.toml")
    parser.add_argument("--from", type=float, default=10, dest="start", help="means begin here [s]")
    parser.add_argument("--until", type=float, default=1e9, dest="end", help="and end here [s]")
    args = parser.parse_args()
    print("| | rods, no rolling resistance | spheres, rolling resistance 0.1 |\n|---|---|---|")
    for (what, a), (_, b) in zip(*(lines_of(f, args.start, args.end) for f in (args.rods, args.spheres))):
        print(f"| {what} | {a} | {b} |")
    return 0


if __name__ == "__main__":
    sys.exit(main())
