#!/usr/bin/env python3
"""Four plots of a run from its series.csv and its particle frames: python3 plot.py RUN [--out plot.png]."""
import argparse
import csv
import os
import sys

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
from draw import save  # noqa: E402
from frames import open_frames  # noqa: E402

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("run")
parser.add_argument("--out", default="plot.png")
options = parser.parse_args()

with open(os.path.join(options.run, "series.csv"), newline="", encoding="utf-8") as f:
    rows = list(csv.DictReader(f))
column = {name: np.array([float(r[name]) for r in rows]) for name in rows[0]}
time = column["time"]

figure, ((flow, force), (energy, speed)) = plt.subplots(2, 2, figsize=(9, 5.6), constrained_layout=True)
flow.plot(time, column["plane.inlet.mass_flow"], drawstyle="steps-pre")
flow.set(title="Mass flow through the plane", xlabel="time [s]", ylabel="kg/s")
force.plot(time, -column["wall.plate.force_z"])
force.set(title="Weight and impacts on the plate", xlabel="time [s]", ylabel="N")
for name in ("kinetic_translation", "dissipated_damping", "dissipated_friction"):
    energy.plot(time, column[name], label=name.replace("_", ", "))
energy.set(title="Energies", xlabel="time [s]", ylabel="J")
energy.legend(frameon=False)

frames = open_frames(options.run)
points, columns, _ = frames.read(len(frames) - 1)
speed.scatter(points[:, 2], np.linalg.norm(columns["velocity"], axis=1), s=6, c=columns["coordination"])
speed.set(title=f"Grains at t = {frames.times[-1]:.3g} s", xlabel="height [m]", ylabel="speed [m/s]")
save(figure, options.out)
print(options.out)
