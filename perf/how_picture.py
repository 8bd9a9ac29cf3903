#!/usr/bin/env python3
"""The picture of how_it_works.md: skins of slow and fast grains, and the pairs that are in the list."""
import os
import sys

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(os.path.dirname(HERE), "cases"))
from draw import save  # noqa: E402

rng = np.random.default_rng(4)
points, radii = [], []
while len(points) < 34:
    p, r = rng.uniform([0.5, 0.5], [13.5, 6.5]), rng.uniform(0.32, 0.5)
    if all(np.hypot(*(p - q)) > r + s + 0.04 for q, s in zip(points, radii)):
        points.append(p)
        radii.append(r)
x, r = np.array(points), np.array(radii)
speed = np.clip((x[:, 0] - 6) / 7, 0.02, 1) ** 1.5  # slow on the left, fast on the right
skins = {"one skin for all": np.full(len(x), 0.75), "a skin for each: K |v| Δt, at least a floor": np.maximum(0.75 * speed, 0.05)}

figure, panels = plt.subplots(2, 1, figsize=(7, 7.2), constrained_layout=True)
for axes, (title, skin) in zip(panels, skins.items()):
    reach = r + skin
    pairs = 0
    for i in range(len(x)):
        for j in range(i):
            if np.hypot(*(x[i] - x[j])) < reach[i] + reach[j]:
                axes.plot(*zip(x[i], x[j]), color="#d1792a", lw=0.9, zorder=2)
                pairs += 1
    for p, own, all_of, v in zip(x, r, reach, speed):
        axes.add_patch(plt.Circle(p, all_of, color="#1f6f8b", alpha=0.10, lw=0, zorder=1))
        axes.add_patch(plt.Circle(p, own, facecolor="#9cc3d5", edgecolor="#33475e", lw=0.7, zorder=3))
        axes.annotate("", p + [1.1 * v, 0], p, arrowprops={"arrowstyle": "->", "color": "#1c2430", "lw": 0.9}, zorder=4)
    axes.set(xlim=(0, 14.6), ylim=(0, 7), aspect="equal", title=f"{title}: {pairs} pairs in the list")
    axes.set_axis_off()
save(figure, os.path.join(HERE, "how_skins.png"))
