#!/usr/bin/env python3
"""Run-out and front speed of an avalanche, from the frames of a finished run.

  python3 cases/avalanche/front.py results/avalanche        # prints a table; writes front.csv and front.svg into that folder

The front is the x [m] that 1 % of the grains have passed (single grains that roll ahead do not count; grains that have left
the valley at its end stay in the count, as passed). Its speed is the central difference between frames. Run-out is the front at
the end minus the lower edge of the slab at the start; the angle of reach is that of the line from the slab's top to the front.
Needs python3-numpy, python3-h5py and, for the picture, python3-matplotlib.
"""
import argparse
import csv
import os
import sys

import numpy as np

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
import case_files  # noqa: E402


def front_of(x, total, passed):
    """The (1 - passed) quantile of all grains, those that left included beyond the end."""
    gone = total - len(x)
    k = int(np.ceil(passed * total)) - gone  # the k-th farthest of those present
    return float(np.sort(x)[-k]) if k > 0 else float("inf")


def measure(frames, passed):
    times, fronts, tails, middles, heights = [], [], [], [], []
    total = top = None
    for time, x, _ in frames:
        if total is None:
            total, top = len(x), float(x[:, 2].max())
        times.append(time)
        fronts.append(front_of(x[:, 0], total, passed))
        tails.append(float(np.quantile(x[:, 0], 0.01)))
        middles.append(float(x[:, 0].mean()))
        heights.append(float(x[np.argsort(x[:, 0])[-max(1, int(passed * total)):], 2].mean()))
    if len(times) < 3:
        raise SystemExit("front.py: at least three frames are needed")
    t, f = np.array(times), np.array(fronts)
    speed = np.gradient(f, t)
    reach = np.degrees(np.arctan2(top - heights[-1], f[-1] - tails[0]))
    return {"time": t, "front": f, "speed": speed, "tail": np.array(tails), "middle": np.array(middles), "run_out": f[-1] - f[0],
            "fastest": float(np.max(speed)), "fastest_at": float(t[np.argmax(speed)]), "reach": float(reach)}


def picture(path, m):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    fig, axes = plt.subplots(1, 2, figsize=(10, 3.6))
    for key in ("front", "middle", "tail"):
        axes[0].plot(m["time"], m[key], label=key)
    axes[0].set(xlabel="time [s]", ylabel="x [m]")
    axes[0].legend(frameon=False)
    axes[1].plot(m["time"], m["speed"])
    axes[1].set(xlabel="time [s]", ylabel="front speed [m/s]")
    fig.savefig(path, bbox_inches="tight")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", help="of a finished run")
    parser.add_argument("--passed", type=float, default=0.01, help="share of the grains beyond the front (0.01)")
    parser.add_argument("--no-picture", action="store_true")
    args = parser.parse_args()
    m = measure(case_files.frames(args.folder), args.passed)
    with open(os.path.join(args.folder, "front.csv"), "w", newline="", encoding="utf-8") as f:
        table = csv.writer(f, lineterminator="\n")
        keys = ("time", "front", "speed", "middle", "tail")
        table.writerow(keys)
        table.writerows(zip(*(m[k] for k in keys)))
    if not args.no_picture:
        picture(os.path.join(args.folder, "front.svg"), m)
    print(f"run-out {m['run_out']:.1f} m, front at x = {m['front'][-1]:.1f} m after {m['time'][-1]:g} s, still moving at {m['speed'][-1]:.2f} m/s\n"
          f"fastest front {m['fastest']:.1f} m/s at {m['fastest_at']:g} s, angle of reach {m['reach']:.1f} degrees")


if __name__ == "__main__":
    main()
