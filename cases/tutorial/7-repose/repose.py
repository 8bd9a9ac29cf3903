#!/usr/bin/env python3
"""The angle of repose of a heap from the last frame of a run: python3 repose.py RUN.

The surface is the top of the highest grain within rings about the axis; the slope is the straight line through the rings
between a fifth and four fifths of the height of the heap.
"""
import os
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
from frames import open_frames  # noqa: E402


def angle(points, radii, sectors=4):
    """(mean, standard deviation) over sectors [degrees]."""
    x = points - np.append(points[:, :2].mean(axis=0), 0)
    distance, direction = np.hypot(x[:, 0], x[:, 1]), np.arctan2(x[:, 1], x[:, 0])
    width, found = 2 * radii.mean(), []
    for s in range(sectors):
        inside = np.floor((direction + np.pi) / (2 * np.pi) * sectors).astype(int) % sectors == s
        ring = (distance[inside] / width).astype(int)
        top = [(x[inside, 2] + radii[inside])[ring == k].max() for k in range(ring.max() + 1) if np.any(ring == k)]
        at = [(k + 0.5) * width for k in range(ring.max() + 1) if np.any(ring == k)]
        top, at = np.array(top), np.array(at)
        on_slope = (top > 0.2 * top.max()) & (top < 0.8 * top.max())
        if on_slope.sum() >= 3:
            found.append(np.degrees(np.arctan(-np.polyfit(at[on_slope], top[on_slope], 1)[0])))
    if not found:
        raise SystemExit("no slope: the heap is too low")
    return np.mean(found), np.std(found)


if __name__ == "__main__":
    frames = open_frames(sys.argv[1])
    points, columns, _ = frames.read(len(frames) - 1)
    mean, spread = angle(points, columns["radius"])
    print(f"angle of repose {mean:.1f} +- {spread:.1f} degrees")
