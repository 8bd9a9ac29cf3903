"""The 3-D view of a frame: data for view.js, packed small.

Own code instead of a library: the spheres need shaders of their own in any case, a library (three.js: 600 kB a page, not
installed everywhere) would add a camera and a mouse, and this is complete in every page.
"""
import base64
import html
import json

import numpy as np

from bodies import dressed
from draw import COLOURS, MATERIALS, walls_at
from particle_picture import Camera, outlines

from .data import scalars_of
from .style import grouped

MOST_GRAINS, MOST_LINES = 100_000, 30_000


def text_of(array, kind):
    return base64.b64encode(np.ascontiguousarray(array, kind).tobytes()).decode()


def visible_first(x, r, most):
    """Indices of at most `most` grains in their order: those with free space around them, then others evenly."""
    if len(x) <= most:
        return np.arange(len(x))
    cell = np.floor((x - x.min(axis=0)) / (2.5 * r.max())).astype(np.int64) + 1
    shape = cell.max(axis=0) + 2
    if np.prod(shape.astype(float)) > 3e8:  # a few large grains among many small ones: cells tell nothing
        return np.linspace(0, len(x) - 1, most).astype(int)
    full = np.zeros(shape, bool)
    full[tuple(cell.T)] = True
    inside = np.ones(len(x), bool)
    for a in (-1, 0, 1):
        for b in (-1, 0, 1):
            for c in (-1, 0, 1):
                inside &= full[tuple((cell + (a, b, c)).T)]
    order = np.concatenate([np.flatnonzero(~inside), np.flatnonzero(inside)])
    outer = int(np.sum(~inside))
    if outer >= most:
        return np.sort(order[np.linspace(0, outer - 1, most).astype(int)])
    rest = order[outer:][np.linspace(0, len(order) - outer - 1, most - outer).astype(int)]
    return np.sort(np.concatenate([order[:outer], rest]))


def packed(values, low, high):
    return text_of(np.round(65535 * np.clip((values - low) / (high - low if high > low else 1), 0, 1)), "<u2")


def grains_of(frame):
    """Positions, radii, normals and rows of the spheres that show the frame (bodies.dressed()). Superquadrics are shown by
    their spheres where there are too many of them for surfaces."""
    bodies = frame.get("bodies")
    most = 0 if bodies is None else MOST_GRAINS // max(1, len(bodies[0]))
    around = next((n for n in (32, 24, 20, 16) if n * (n // 2 + 1) <= most), 0)
    return dressed(np.asarray(frame["x"], float), frame["columns"], bodies if around else None, around)


def columns_of(run, frame, chosen):
    columns = []
    ramp = np.round(255 * COLOURS(np.linspace(0, 1, 256))[:, :3])
    for name, unit, values in scalars_of(frame):
        values = np.nan_to_num(np.asarray(values, float)[chosen])
        low, high = (0.0 if name == "speed" else float(values.min())), float(values.max())
        # One grain that flies must not take the colours from all others.
        top = float(np.percentile(values, 99.5)) if name == "speed" else high
        top = top if top > low else high
        columns.append({"name": name, "unit": unit, "low": low, "high": high, "top": top, "gain": (high - low) / (top - low) if top > low else 1,
                        "values": packed(values, low, high), "colours": text_of(ramp, "u1")})
    material = frame["columns"].get("material")
    if material is not None and len(np.unique(material)) > 1:
        given = run.materials()
        table = np.round(255 * MATERIALS[np.arange(256) % len(MATERIALS)][:, :3])
        names = [given[m] if m < len(given) and given[m] else f"material {m}" for m in range(int(material.max()) + 1)]
        columns.append({"name": "material", "names": names, "low": 0, "high": 255, "top": 255, "gain": 1, "unit": "",
                        "values": packed(material[chosen].astype(float), 0, 255), "colours": text_of(table, "u1")})
    return columns


def view_html(run):
    """The last frame as a block of the page."""
    frame = run.frames[-1]
    x, r, normals, row = grains_of(frame)
    chosen = visible_first(x, r, MOST_GRAINS)
    rows = row[chosen]
    lower, upper = np.min(x - r[:, None], axis=0), np.max(x + r[:, None], axis=0)
    camera = Camera.for_bounds(lower, upper)
    segments = outlines(*walls_at(run.walls, frame["time"]))
    if len(segments):
        # Walls that go on (a floor of the whole domain) do not make the grains small.
        reach = 0.3 * np.max(upper - lower)
        corners = segments.reshape(-1, 3)
        lower, upper = (np.minimum(lower, np.maximum(corners.min(axis=0), lower - reach)),
                        np.maximum(upper, np.minimum(corners.max(axis=0), upper + reach)))
        longest = np.argsort(-np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1), kind="stable")
        segments = segments[np.sort(longest[:MOST_LINES])]
    centre, radius = (lower + upper) / 2, np.linalg.norm(upper - lower) / 2
    corners = np.array([[(lower, upper)[i][0], (lower, upper)[j][1], (lower, upper)[k][2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    fit = np.abs(camera.project(corners - centre)[:, :2]).max(axis=0) / radius
    x, r, segments = (x[chosen] - centre) / radius, r[chosen] / radius, (segments - centre) / radius
    cut = np.array([camera.towards[0], camera.towards[1], 0])
    cut /= np.linalg.norm(cut)
    along = x @ cut
    span = float(np.abs(x).max())
    farthest = max(1.0, float(np.linalg.norm(segments, axis=2).max()) if len(segments) else 0)
    columns = columns_of(run, frame, rows)
    data = {
        "count": len(chosen), "grains": text_of(np.concatenate([np.round((x / span + 1) / 2 * 65535), np.round(r / r.max() * 65535)[:, None]], axis=1), "<u2"),
        "span": span, "largest": float(r.max()), "ids": text_of(np.asarray(frame["columns"].get("id", np.arange(len(frame["r"]))))[rows], "<u4"),
        "lines": text_of(segments, "<f4"), "reach": 1.05 * farthest, "columns": columns, "cut": cut.tolist(),
        "fit": (1.03 * fit).tolist(), "near": [float(along.min()), float(along.max())],
        "azimuth": float(np.degrees(np.arctan2(camera.right[1], camera.right[0]))), "elevation": float(np.degrees(np.arcsin(camera.towards[2]))),
    }
    if not np.isnan(normals).all():
        data["normals"] = text_of(np.round(127 * np.nan_to_num(normals[chosen])), "i1")
    options = "".join(f"<option>{html.escape(c['name'])}</option>" for c in columns)
    some = "" if len(chosen) == len(x) else f" · {grouped(len(chosen))} of {grouped(len(x))} grains, the outer ones first"
    if "normals" not in data and frame.get("bodies") is not None and (frame["bodies"][1].get("semi_axes", np.zeros((1, 3))) > 0).any():
        some += " · superquadrics as the spheres around them"
    return f"""<div class=view><canvas></canvas><div class=values></div>
<p class=none hidden>This browser shows no WebGL 2; the pictures below need none.</p>
<div class=controls><label>colour <select aria-label="colour by">{options}</select></label>
<span><span class=low></span> <span class=scale></span> <span class=high></span></span>
<label>cut away from the front <input class=cut type=range min=0 max=1000 value=1000 style="direction: rtl"></label>
<span>drag: turn · shift: move · wheel: zoom · double click: back{some}</span></div>
<script type="application/json">{json.dumps(data, separators=(",", ":")).replace("<", chr(92) + "u003c")}</script></div>"""
