#!/usr/bin/env python3
"""A picture of a run's grains and walls: python3 draw.py RUN --out FILE.png [--by speed|size|material|COLUMN] [--time T].

Spheres and superquadrics have their true shape and size; walls are outlines. Also the drawing part of the report
(perf/report.py). Needs numpy and matplotlib. Files are small: 256 colours where Pillow is there.
"""
import argparse
import io
import os
import sys

import numpy as np

try:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.collections import LineCollection, PolyCollection
except ImportError as error:
    sys.exit(f"error: pictures need {error.name} (apt-get install python3-matplotlib)")

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from bodies import dressed  # noqa: E402
from frames import open_frames  # noqa: E402
from particle_picture import Camera, outlines, picture  # noqa: E402

COLOUR_NAMES = ["blue", "orange", "green", "red", "violet", "brown", "teal", "grey"]
MATERIALS = np.array([matplotlib.colors.to_rgba(c) for c in (
    "#1f6f8b", "#d1792a", "#5a8f3d", "#a8436b", "#6a5aa8", "#8a6d3b", "#3c9d9b", "#7b8794")])
COLOURS = matplotlib.colors.LinearSegmentedColormap.from_list(
    "talus", ["#4a6fa5", "#58a0b8", "#9cc9a3", "#f0d77b", "#ee9b4a", "#cf4e35"])


def wall_frames(source):
    return source if len(source) else None


def bodies_at(folder, time):
    """The frame of bodies of that time: points, columns, triangles; None in a run without bodies."""
    source = open_frames(folder, "bodies")
    return None if source is None or len(source) == 0 else source.read(int(np.argmin(np.abs(source.times - time))))


def walls_at(walls, time):
    """(points, triangles) of the walls at about this time; empty where there are none."""
    if walls is None:
        return np.zeros((0, 3)), np.zeros((0, 3), int)
    points, _, triangles = walls.read(int(np.argmin(np.abs(walls.times - time))))
    return points, triangles


def view_of(frames, walls, camera=None):
    """Camera and view frame that hold all particles and nearby walls of all pictures."""
    lower = np.min([np.min(f["x"] - f["r"][:, None], axis=0) for f in frames], axis=0)
    upper = np.max([np.max(f["x"] + f["r"][:, None], axis=0) for f in frames], axis=0)
    camera = camera or Camera.for_bounds(lower, upper)
    flat = [camera.project(f["x"])[:, :2] for f in frames]
    low = np.min([np.min(p - f["r"][:, None], axis=0) for p, f in zip(flat, frames)], axis=0)
    high = np.max([np.max(p + f["r"][:, None], axis=0) for p, f in zip(flat, frames)], axis=0)
    near, far = 0.12 * np.max(high - low), 0.45 * np.max(high - low)
    lower, upper = low, high
    for points, _ in walls:
        if len(points):
            p = camera.project(points)[:, :2]
            # Walls that go on (a floor of the whole domain) are cut off, others shown whole.
            lower = np.minimum(lower, np.where(p.min(axis=0) > low - far, p.min(axis=0), low - near))
            upper = np.maximum(upper, np.where(p.max(axis=0) < high + far, p.max(axis=0), high + near))
    (left, bottom), (right, top) = lower, upper
    margin = 0.02 * max(right - left, top - bottom)
    return camera, (left - margin, right + margin, bottom - margin, top + margin)


def draw(frame, walls, camera, view, width, colours_of):
    """A figure of one picture at 100 dots per inch; frame: x, r, columns, bodies (bodies_at()); colours_of: RGBA of every
    particle."""
    points, triangles = walls
    aspect = (view[3] - view[2]) / (view[1] - view[0])
    figure = plt.figure(figsize=(width / 100, width * aspect / 100))
    axes = figure.add_axes([0, 0, 1, 1])
    axes.set_axis_off()
    if len(triangles):
        corners = camera.project(points)[:, :2][triangles]
        axes.add_collection(PolyCollection(corners, facecolors="#7d8fa5", alpha=max(0.012, 0.05 / (1 + len(triangles) / 200)),
                                           edgecolors="none", antialiased=False))
    x, r, normals, row = dressed(frame["x"], frame["columns"], frame.get("bodies"))
    image = picture(x, r, row.astype(float), camera, view, width, lambda v: colours_of[v.astype(int)], normals,
                    np.median(frame["r"]))
    axes.imshow(image, extent=view, interpolation="antialiased", zorder=2)
    if len(triangles):
        lines = outlines(points, triangles, camera)
        # A surface of many creases (rough ground) would hide what lies on it.
        axes.add_collection(LineCollection(lines, colors="#33475e", alpha=0.55, linewidths=0.9,
                                           zorder=3 if len(lines) < 5000 else 1))
    axes.set_xlim(view[0], view[1])
    axes.set_ylim(view[2], view[3])
    axes.set_aspect("equal")
    return figure


def colours_by(what, columns):
    """RGBA of every particle."""
    if what == "material":
        return MATERIALS[columns["material"].astype(int) % len(MATERIALS)]
    values = (2 * columns["radius"] if what == "size" else np.linalg.norm(columns["velocity"], axis=1) if what == "speed"
              else columns[what].astype(float))
    top = np.percentile(values, 99.5) if what == "speed" else values.max()
    low = 0 if what == "speed" else values.min()
    return COLOURS(plt.Normalize(low, top if top > low else low + 1)(values))


def small_png(figure):
    """The figure as a PNG of 256 colours, or as it is where Pillow is missing or that is smaller."""
    out = io.BytesIO()
    figure.savefig(out, format="png", dpi=100, metadata={"Software": None})
    plt.close(figure)
    data = out.getvalue()
    try:
        from PIL import Image
        image = Image.open(io.BytesIO(data)).convert("RGB").quantize(256, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
        out = io.BytesIO()
        image.save(out, format="png", optimize=True)
        data = min(data, out.getvalue(), key=len)
    except ImportError:
        pass
    return data


def save(figure, path):
    """A small PNG."""
    data = small_png(figure)
    with open(path + ".part", "wb") as f:
        f.write(data)
    os.replace(path + ".part", path)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder", metavar="RUN", help="folder of a run with particle frames")
    parser.add_argument("--out", required=True, metavar="FILE", help="PNG to write")
    parser.add_argument("--by", default="speed", help="what colours tell: speed, size, material or a column of the frames")
    parser.add_argument("--time", type=float, help="simulated time [s] (default: the last frame)")
    parser.add_argument("--width", type=int, default=900, help="pixels")
    parser.add_argument("--azimuth", type=float, help="of the view [degrees]")
    parser.add_argument("--elevation", type=float, default=14, help="of the view [degrees]")
    parser.add_argument("--no-walls", action="store_true", help="grains alone")
    options = parser.parse_args()
    try:
        source = open_frames(options.folder)
        walls = None if options.no_walls else open_frames(options.folder, "walls")
    except (OSError, ValueError) as error:
        sys.exit(f"error: {options.folder}: {error}")
    if source is None or len(source) == 0:
        sys.exit(f"error: {options.folder}: no particle frames (run with output.particles_every > 0)")
    k = len(source) - 1 if options.time is None else int(np.argmin(np.abs(source.times - options.time)))
    points, columns, _ = source.read(k)
    if len(points) == 0:
        sys.exit(f"error: {options.folder}: the frame at {source.times[k]:g} s has no particles")
    if options.by == "material" and "material" not in columns:
        sys.exit(f"error: {options.folder}: the scene has one material")
    if options.by not in ("speed", "size") and (options.by not in columns or columns[options.by].ndim != 1):
        names = ", ".join(name for name, values in columns.items() if values.ndim == 1)
        sys.exit(f"error: {options.folder}: the frames have no column '{options.by}'; there is speed, size, {names}")
    frame = {"x": points, "r": columns["radius"], "columns": columns, "bodies": bodies_at(options.folder, source.times[k])}
    shown = walls_at(walls if walls is not None and len(walls) else None, source.times[k])
    camera, view = view_of([frame], [shown])
    if options.azimuth is not None:
        camera, view = view_of([frame], [shown], Camera(options.azimuth, options.elevation))
    save(draw(frame, shown, camera, view, options.width, colours_by(options.by, columns)), options.out)
    print(options.out)


if __name__ == "__main__":
    main()
