#!/usr/bin/env python3
"""One self-contained HTML page about a run: python3 report.py DIR [--out FILE] (default DIR/report.html).

Called by `talus report DIR`. Reads what a run leaves (summary.json, scene.toml, series.csv, particles.vtkhdf,
walls.vtkhdf); whatever is missing or unreadable is named on the page and left out. No external resources, no dates:
the same folder gives the same page.
"""
import argparse
import base64
import contextlib
import csv
import html
import io
import json
import os
import re
import sys

import numpy as np

try:
    import h5py
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.collections import LineCollection, PolyCollection
except ImportError as error:
    sys.exit(f"error: the report needs {error.name} (apt-get install python3-matplotlib python3-h5py)")

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from particle_picture import Camera, outlines, picture  # noqa: E402

INK, MUTED, LINE, ACCENT = "#1c2430", "#5d6b7c", "#d9dfe7", "#1f6f8b"
PALETTE = ["#1f6f8b", "#d1792a", "#5a8f3d", "#a8436b", "#6a5aa8", "#8a6d3b", "#3c9d9b", "#7b8794"]
plt.rcParams.update({
    "font.family": "DejaVu Sans", "font.size": 9, "axes.edgecolor": "#8793a3", "axes.labelcolor": INK,
    "axes.titlesize": 10, "axes.titleweight": "bold", "axes.titlelocation": "left", "axes.titlepad": 8,
    "text.color": INK, "xtick.color": MUTED, "ytick.color": MUTED, "axes.spines.top": False,
    "axes.spines.right": False, "axes.grid": True, "grid.color": "#e9edf2", "grid.linewidth": 0.8,
    "axes.axisbelow": True, "lines.linewidth": 1.5, "legend.frameon": False, "legend.fontsize": 8,
    "axes.prop_cycle": matplotlib.cycler(color=PALETTE), "svg.hashsalt": "talus", "figure.dpi": 100,
    "axes.formatter.limits": (-3, 6), "axes.formatter.use_mathtext": True,
})
MAX_POINTS = 3000  # per curve: more is invisible and makes the page heavy


# ---- input ----------------------------------------------------------------------------------------------------------
class Run:
    """Everything the folder offers; missing parts are None and named in `notes`."""

    def __init__(self, folder):
        self.folder, self.notes = folder, []
        self.summary = self._part("summary.json", lambda p: json.load(open(p, encoding="utf-8"))) or {}
        self.scene = self._part("scene.toml", lambda p: open(p, encoding="utf-8", errors="replace").read())
        self.series = self._part("series.csv", read_series)
        self.frames = self._part("particles.vtkhdf", read_frames)
        self.walls = self._part("walls.vtkhdf", read_walls, wanted=False)

    def _part(self, name, reader, wanted=True):
        path = os.path.join(self.folder, name)
        if not os.path.exists(path):
            if wanted:
                self.notes.append(f"{name} is missing")
            return None
        try:
            return reader(path)
        except Exception as error:  # a report of the rest is worth more than none
            self.notes.append(f"{name} cannot be read: {error}")
            return None


def read_series(path):
    with open(path, newline="", encoding="utf-8") as f:
        rows = list(csv.reader(f))
    header, body = rows[0], [r for r in rows[1:] if len(r) == len(rows[0])]
    if not body:
        raise ValueError("it has no rows")
    values = np.array(body, dtype=float)
    return {name: values[:, k] for k, name in enumerate(header)}


def part_of(root, step, name, offsets, count):
    start = int(root["Steps"][offsets][step])
    return root[name][start : start + count]


def read_frames(path):
    """First, middle and last frame with particles."""
    with h5py.File(path, "r") as f:
        root = f["VTKHDF"]
        steps = int(root["Steps"].attrs["NSteps"])
        counts = root["NumberOfPoints"][:steps]
        filled = np.flatnonzero(counts)
        if len(filled) == 0:
            raise ValueError("no frame has particles")
        chosen = sorted({int(filled[0]), int(filled[len(filled) // 2]), int(filled[-1])})
        frames = []
        for k in chosen:
            n = int(counts[k])
            column = lambda name: part_of(root, k, "PointData/" + name, "PointDataOffsets/" + name, n)  # noqa: E731
            frames.append({
                "index": k, "of": steps, "time": float(root["Steps/Values"][k]), "step": int(f["talus/step"][k]),
                "x": part_of(root, k, "Points", "PointOffsets", n), "r": column("radius"),
                "speed": np.linalg.norm(column("velocity"), axis=1),
            })
        return frames


def read_walls(path):
    """All frames' times and a function that reads points and triangles of one."""
    with h5py.File(path, "r") as f:
        root = f["VTKHDF"]
        steps = int(root["Steps"].attrs["NSteps"])
        frames = []
        for k in range(steps):
            frames.append({"time": float(root["Steps/Values"][k])})
        if not frames:
            raise ValueError("it has no frames")
        # Only those that may be drawn are read, later, by the nearest time.
        return {"path": path, "times": np.array([w["time"] for w in frames])}


def walls_at(walls, time):
    k = int(np.argmin(np.abs(walls["times"] - time)))
    with h5py.File(walls["path"], "r") as f:
        root = f["VTKHDF"]
        points = part_of(root, k, "Points", "PointOffsets", int(root["NumberOfPoints"][k]))
        n = int(root["Polygons/NumberOfConnectivityIds"][k])
        start = int(root["Steps/ConnectivityIdOffsets"][k, 2])
        return points, root["Polygons/Connectivity"][start : start + n].reshape(-1, 3)


# ---- figures --------------------------------------------------------------------------------------------------------
def svg(figure):
    out = io.BytesIO()
    figure.savefig(out, format="svg", bbox_inches="tight", pad_inches=0.06, metadata={"Date": None, "Creator": None})
    plt.close(figure)
    return "data:image/svg+xml;base64," + base64.b64encode(out.getvalue()).decode()


def png(figure, dpi):
    out = io.BytesIO()
    figure.savefig(out, format="png", dpi=dpi, bbox_inches="tight", pad_inches=0.04, metadata={"Software": None})
    plt.close(figure)
    return "data:image/png;base64," + base64.b64encode(out.getvalue()).decode()


def thin(x, *ys):
    """At most MAX_POINTS rows, first and last included."""
    if len(x) <= MAX_POINTS:
        return (x, *ys)
    at = np.unique(np.linspace(0, len(x) - 1, MAX_POINTS).astype(int))
    return tuple(a[at] for a in (x, *ys))


def curves(series, title, ylabel, columns, zero=False, step=False):
    """One panel of columns over time; columns: list of (name, label). None if nothing of it exists or moves."""
    columns = [(c, label) for c, label in columns if c in series and np.any(np.isfinite(series[c]))]
    if not columns or len(series["time"]) < 2:
        return None
    figure, axes = plt.subplots(figsize=(5.6, 2.7))
    for name, label in columns:
        x, y = thin(series["time"], series[name])
        axes.plot(x, y, label=label, drawstyle="steps-pre" if step else "default")
    axes.set(title=title, xlabel="time [s]", ylabel=ylabel)
    axes.margins(x=0.01)
    if zero:
        axes.set_ylim(bottom=min(0, axes.get_ylim()[0]))
    if len(columns) > 1:
        axes.legend(ncol=2 if len(columns) > 3 else 1)
    return svg(figure)


def wall_names(series, kind):
    names = []
    for column in series:
        m = re.fullmatch(kind + r"\.(.*)\.[^.]*", column)
        if m and m.group(1) not in names:
            names.append(m.group(1))
    return names


def series_figures(s):
    figures = [
        curves(s, "Particles", "particles", [("particles", "in the domain"), ("inserted", "inserted, total"),
                                             ("removed", "left, total")], zero=True),
        curves(s, "Kinetic energy (translation)", "energy [J]", [("kinetic_energy", "kinetic")], zero=True),
        curves(s, "Coordination number", "contacts per particle", [("coordination_number", "Z")], zero=True),
        curves(s, "Contacts", "contacts", [("contacts", "particle–particle"), ("wall_contacts", "particle–wall")],
               zero=True),
        curves(s, "Energies", "energy [J]", [
            ("kinetic_translation", "kinetic, translation"), ("kinetic_rotation", "kinetic, rotation"),
            ("potential", "potential"), ("elastic", "elastic"), ("dissipated_damping", "dissipated, damping"),
            ("dissipated_friction", "dissipated, friction"), ("dissipated_background", "dissipated, background"),
            ("wall_work", "work of walls")]),
        curves(s, "Energy balance", "residual [J]", [("balance_residual", "residual")]),
    ]
    forces = []
    for name in wall_names(s, "wall"):
        axes = ["wall." + name + ".force_" + a for a in "xyz"]
        if all(a in s for a in axes):
            total = np.sqrt(sum(s[a] ** 2 for a in axes))
            if np.any(total > 0):
                forces.append((np.nanmax(total), name, total))
    if forces:  # the most loaded ones: eight curves are still told apart
        forces.sort(key=lambda f: -f[0])
        chosen = {f"|F| {name}": total for _, name, total in forces[:8]}
        figures.append(curves({"time": s["time"], **chosen}, "Force on walls", "force [N]",
                              [(k, k[4:]) for k in chosen], zero=True))
    regions = wall_names(s, "region")
    for suffix, title, label in [("solid_fraction", "Solid fraction in regions", "solid fraction"),
                                 ("granular_temperature", "Granular temperature in regions", "temperature [m²/s²]")]:
        figures.append(curves(s, title, label, [(f"region.{r}.{suffix}", r) for r in regions], zero=True))
    return [f for f in figures if f]


def flow_figures(s):
    planes = wall_names(s, "plane")
    rates = [(f"plane.{p}.mass_flow", f"through {p}") for p in planes]
    totals = [(f"plane.{p}.mass", f"through {p}") for p in planes]
    if "mass_flow" in s and np.any(s["removed_mass"] != 0):
        rates.insert(0, ("mass_flow", "leaving the domain"))
        totals.insert(0, ("removed_mass", "left the domain"))
    return [f for f in (curves(s, "Mass flow", "mass flow [kg/s]", rates, step=True, zero=True),
                        curves(s, "Mass passed", "mass [kg]", totals, zero=True)) if f]


def rebuild_figure(summary):
    steps = np.array(summary.get("rebuild_steps") or [], dtype=float)
    intervals = np.diff(steps)
    if len(intervals) < 2:
        return None
    figure, (left, right) = plt.subplots(1, 2, figsize=(11.4, 2.7), gridspec_kw={"width_ratios": [2, 1], "wspace": 0.2})
    left.plot(steps[1:], intervals, ".", ms=4, alpha=0.7)
    left.axhline(intervals.mean(), color=PALETTE[1], lw=1.2, label=f"mean {intervals.mean():.3g}")
    left.set(title="Rebuild intervals", xlabel="step", ylabel="steps since last rebuild")
    left.set_ylim(bottom=0)
    left.legend()
    right.hist(intervals, bins=min(40, max(5, int(np.sqrt(len(intervals)) * 2))), color=ACCENT, alpha=0.85)
    right.set(title="Distribution", xlabel="steps between rebuilds", ylabel="rebuilds")
    return svg(figure)


def list_figure(summary):
    """Skin, K, interval and candidates per contact of the list over the run."""
    names = summary.get("list_series_columns") or []
    rows = np.array(summary.get("list_series") or [], dtype=float)
    if len(rows) < 3 or "interval" not in names:
        return None
    column = {name: rows[:, k] for k, name in enumerate(names)}
    step = column["step"]
    figure, ((skins, k), (intervals, pairs)) = plt.subplots(2, 2, figsize=(11.4, 5), gridspec_kw={"wspace": 0.2, "hspace": 0.5})

    def over_run(panel, name, label, title, style):
        panel.plot(step, column[name], drawstyle="steps-post", lw=1.2, **style)
        panel.set(title=title, xlabel="step", ylabel=label)
        panel.set_ylim(bottom=0)

    if "skin" in column:
        over_run(skins, "skin", "skin / diameter", "Skin", {"color": ACCENT, "label": "mean"})
        if column["floor"].any():
            skins.plot(step, column["floor"], drawstyle="steps-post", lw=1, color=PALETTE[1], label="floor")
            skins.legend()
    over_run(k, "k", "K [steps]", "K" + (", chosen by the run" if summary.get("verlet_k_automatic") else ""), {"color": ACCENT})
    if not column["k"].any():
        k.text(0.5, 0.5, "this policy has no K", ha="center", va="center", transform=k.transAxes)
    intervals.plot(step[1:], column["interval"][1:], ".", ms=3, alpha=0.7)
    intervals.set(title="Rebuild interval", xlabel="step", ylabel="steps since last rebuild")
    intervals.set_ylim(bottom=0)
    some = column["contacts"] > 0
    pairs.plot(step[some], column["pairs"][some] / column["contacts"][some], lw=1.2)
    pairs.set(title="Candidate pairs per contact", xlabel="step", ylabel="pairs / contact")
    pairs.set_ylim(bottom=0)
    return svg(figure)


def node_figure(summary):
    nodes = [n for n in summary.get("nodes") or [] if n.get("seconds")]
    if not nodes:
        return None
    nodes.sort(key=lambda n: n["seconds"])
    total = sum(n["seconds"] for n in nodes)
    figure, axes = plt.subplots(figsize=(11.4, 0.55 + 0.32 * len(nodes)))
    axes.barh([n["name"] for n in nodes], [n["seconds"] for n in nodes], color=ACCENT, height=0.62)
    work = (summary.get("particles") or 0) * (summary.get("steps") or 0)
    for k, n in enumerate(nodes):
        text = f" {100 * n['seconds'] / total:.1f} %"
        if work > 0:
            text += f"   {1e9 * n['seconds'] / work:.3g} ns per particle-step"
        axes.text(n["seconds"], k, text, va="center", fontsize=8, color=MUTED)
    axes.set(title="Time per node of the flow graph", xlabel="time, summed over threads [s]")
    axes.set_xlim(0, 1.28 * nodes[-1]["seconds"])
    axes.grid(axis="y", visible=False)
    axes.tick_params(axis="y", length=0, labelcolor=INK)
    return svg(figure)


def view_of(frames, walls):
    """Camera and view frame that hold all particles and nearby walls of all pictures."""
    lower = np.min([np.min(f["x"] - f["r"][:, None], axis=0) for f in frames], axis=0)
    upper = np.max([np.max(f["x"] + f["r"][:, None], axis=0) for f in frames], axis=0)
    camera = Camera.for_bounds(lower, upper)
    flat = [camera.project(f["x"])[:, :2] for f in frames]
    low = np.min([np.min(p - f["r"][:, None], axis=0) for p, f in zip(flat, frames)], axis=0)
    high = np.max([np.max(p + f["r"][:, None], axis=0) for p, f in zip(flat, frames)], axis=0)
    reach = 0.12 * np.max(high - low)  # walls that go on (a floor of the whole domain) are cut off
    (left, bottom), (right, top) = low, high
    for points, _ in walls:
        if len(points):
            p = camera.project(points)[:, :2]
            left, bottom = np.minimum((left, bottom), np.maximum(p.min(axis=0), low - reach))
            right, top = np.maximum((right, top), np.minimum(p.max(axis=0), high + reach))
    margin = 0.02 * max(right - left, top - bottom)
    return camera, (left - margin, right + margin, bottom - margin, top + margin)


def particle_figures(run):
    frames = run.frames
    walls = [walls_at(run.walls, f["time"]) if run.walls else (np.zeros((0, 3)), np.zeros((0, 3), int)) for f in frames]
    camera, view = view_of(frames, walls)
    top_speed = max(np.percentile(f["speed"], 99.5) for f in frames)
    largest = max(f["r"].max() for f in frames)
    smallest = min(f["r"].min() for f in frames)
    by_size = top_speed <= 0 and largest > smallest
    colour_map = matplotlib.colors.LinearSegmentedColormap.from_list(
        "talus", ["#4a6fa5", "#58a0b8", "#9cc9a3", "#f0d77b", "#ee9b4a", "#cf4e35"])
    norm = plt.Normalize(2 * smallest, 2 * largest) if by_size else plt.Normalize(0, top_speed if top_speed > 0 else 1)
    label = "diameter [m]" if by_size else "speed [m/s]"
    aspect = (view[3] - view[2]) / (view[1] - view[0])
    width = int(np.clip(np.sqrt(900_000 / aspect), 420, 1200))
    names = {1: ["Only frame"], 2: ["First frame", "Last frame"], 3: ["First frame", "Middle frame", "Last frame"]}
    out = []
    for f, (points, triangles), name in zip(frames, walls, names[len(frames)]):
        figure = plt.figure(figsize=(width / 100, width * aspect / 100))
        axes = figure.add_axes([0, 0, 1, 1])
        axes.set_axis_off()
        if len(triangles):
            corners = camera.project(points)[:, :2][triangles]
            axes.add_collection(PolyCollection(corners, facecolors="#7d8fa5", alpha=max(0.012, 0.05 / (1 + len(triangles) / 200)),
                                               edgecolors="none", antialiased=False))
        values = 2 * f["r"] if by_size else f["speed"]
        image = picture(f["x"], f["r"], values, camera, view, width, lambda v: colour_map(norm(v)))
        axes.imshow(image, extent=view, interpolation="antialiased", zorder=2)
        if len(triangles):
            axes.add_collection(LineCollection(outlines(points, triangles, camera), colors="#33475e", alpha=0.55,
                                               linewidths=0.9, zorder=3))
        axes.set_xlim(view[0], view[1])
        axes.set_ylim(view[2], view[3])
        axes.set_aspect("equal")
        caption = (f"{name}: t = {f['time']:.4g} s, step {grouped(f['step'])}, "
                   f"{grouped(len(f['r']))} particles")
        out.append((png(figure, 100), caption))
    figure, axes = plt.subplots(figsize=(4.2, 0.16))
    bar = figure.colorbar(matplotlib.cm.ScalarMappable(norm, colour_map), cax=axes, orientation="horizontal",
                          extend="neither" if by_size else "max")
    bar.set_label(label)
    bar.outline.set_visible(False)
    return out, svg(figure)


# ---- page -----------------------------------------------------------------------------------------------------------
STYLE = f"""
:root {{ color-scheme: light; }}
* {{ box-sizing: border-box; }}
body {{ margin: 0; background: #fff; color: {INK}; font: 15px/1.55 system-ui, "Segoe UI", "Helvetica Neue", "DejaVu Sans", sans-serif; }}
main {{ max-width: 1180px; margin: 0 auto; padding: 40px 28px 64px; }}
h1 {{ font-size: 30px; line-height: 1.2; margin: 0 0 6px; letter-spacing: -0.01em; }}
h2 {{ font-size: 19px; margin: 44px 0 14px; padding-top: 14px; border-top: 1px solid {LINE}; }}
p.lead {{ color: {MUTED}; margin: 0 0 24px; }}
.cards {{ display: grid; grid-template-columns: repeat(auto-fill, minmax(165px, 1fr)); gap: 1px; border: 1px solid {LINE}; border-radius: 6px; overflow: hidden; }}
.cards div {{ box-shadow: 0 0 0 1px {LINE}; padding: 12px 14px; }}
.cards dt {{ color: {MUTED}; font-size: 12px; }}
.cards dd {{ margin: 1px 0 0; font-size: 18px; font-variant-numeric: tabular-nums; overflow-wrap: anywhere; }}
.cards dd.small {{ font-size: 14px; line-height: 1.45; padding-top: 3px; }}
.grid {{ display: grid; grid-template-columns: repeat(auto-fit, minmax(430px, 1fr)); gap: 22px 26px; align-items: start; }}
.pictures {{ display: grid; gap: 18px; align-items: end; }}
figure {{ margin: 0; }}
img {{ max-width: 100%; height: auto; display: block; }}
.grid img, img.wide {{ width: 100%; }}
figcaption {{ color: {MUTED}; font-size: 13px; margin-top: 6px; text-align: center; }}
.pictures img {{ margin: 0 auto; }}
.bar {{ margin: 18px auto 0; max-width: 420px; }}
.note {{ background: #fdf6e7; border-left: 3px solid #d9a441; padding: 8px 14px; margin: 0 0 18px; font-size: 14px; }}
.bad {{ background: #fcebea; border-color: #c0392b; }}
table {{ border-collapse: collapse; font-size: 14px; }}
td, th {{ text-align: left; padding: 5px 22px 5px 0; border-bottom: 1px solid {LINE}; vertical-align: top; }}
td.number {{ text-align: right; font-variant-numeric: tabular-nums; }}
pre {{ background: #f6f8fa; border: 1px solid {LINE}; border-radius: 6px; padding: 14px 16px; overflow-x: auto; font: 12.5px/1.5 ui-monospace, "DejaVu Sans Mono", monospace; }}
summary {{ cursor: pointer; color: {ACCENT}; }}
@media print {{ main {{ padding: 0; }} figure {{ break-inside: avoid; }} }}
"""


def grouped(n):
    return f"{n:,}".replace(",", "\u202f")


def seconds(s):
    if s < 120:
        return f"{s:.3g} s"
    minutes, rest = divmod(int(round(s)), 60)
    return f"{minutes // 60} h {minutes % 60:02d} min" if minutes >= 60 else f"{minutes} min {rest:02d} s"


def size_text(n):
    for unit in ("B", "KiB", "MiB", "GiB"):
        if n < 1024 or unit == "GiB":
            return f"{n:.0f} {unit}" if unit == "B" else f"{n:.1f} {unit}"
        n /= 1024
    return ""


def cards(s):
    known = []

    def card(title, key, show=str, small=False):
        if s.get(key) not in (None, ""):
            known.append((title, show(s[key]), small))

    card("particles at the end", "particles", grouped)
    card("steps", "steps", grouped)
    card("simulated time", "simulated_time", lambda v: f"{v:.5g} s")
    card("time step", "dt", lambda v: f"{v:.4g} s")
    card("wall time", "wall_s", seconds)
    card("particle-steps per second", "particle_steps_per_s", lambda v: f"{v / 1e6:.3g} million")
    card("contacts", "contacts", grouped)
    card("candidate pairs", "candidate_pairs", grouped)
    card("list rebuilds", "rebuilds", grouped)
    card("steps per rebuild", "mean_interval", lambda v: f"{v:.4g}")
    card("shortest interval", "shortest_interval", lambda v: f"{grouped(v)} steps")
    card("list policy", "policy")
    card("K, chosen by the run: the last" if s.get("verlet_k_automatic") else "K", "verlet_k", lambda v: f"{v:.4g}")
    card("threads", "threads")
    card("instruction set", "isa")
    card("contact law", "law", small=True)
    card("left the domain", "removed", grouped)
    card("mass that left", "removed_mass", lambda v: f"{v:.4g} kg")
    card("bytes per particle", "bytes_per_particle", lambda v: f"{v:.0f}")
    card("peak memory", "peak_rss_bytes", size_text)
    card("missed contacts (audit)", "missed_contacts", grouped)
    card("seed", "seed")
    card("state hash", "state_hash", small=True)
    items = "".join(
        f"<div><dt>{html.escape(t)}</dt><dd{' class=small' if small else ''}>{html.escape(v)}</dd></div>"
        for t, v, small in known)
    return f'<dl class="cards" style="margin:0">{items}</dl>' if known else ""


PURPOSE = {
    "particles.vtkhdf": "particles over time; open in ParaView 5.12 or newer", "walls.vtkhdf": "walls over time, the same",
    "contacts.vtkhdf": "contacts over time, the same", "particles.pvd": "particles over time for any ParaView",
    "walls.pvd": "walls over time for any ParaView", "series.csv": "scalars over time", "summary.json": "figures of the run",
    "scene.toml": "copy of the scene",
}


def file_table(folder):
    rows = []
    for name in sorted(os.listdir(folder)):
        path = os.path.join(folder, name)
        purpose = PURPOSE.get(name, "checkpoint, for --resume" if name.endswith(".tcp") else "")
        if purpose and os.path.isfile(path):
            rows.append(f"<tr><td>{html.escape(name)}</td><td class=number>{size_text(os.path.getsize(path))}</td>"
                        f"<td>{html.escape(purpose)}</td></tr>")
    return "<table>" + "".join(rows) + "</table>" if rows else ""


def page(run):
    s = run.summary
    title = s.get("title") or os.path.basename(os.path.abspath(run.folder))
    body = [f"<h1>{html.escape(title)}</h1>"]
    lead = [f"Talus {s['version']}" if s.get("version") else "", s.get("scene_file") or "", s.get("status") or ""]
    body.append(f"<p class=lead>{html.escape(' · '.join(x for x in lead if x))}</p>")
    if str(s.get("status", "finished")) not in ("finished", ""):
        body.append(f"<p class='note bad'>This run did not finish: {html.escape(s['status'])}</p>")
    pictures, bar = [], ""
    if run.frames:
        try:
            pictures, bar = particle_figures(run)
        except (OSError, KeyError, ValueError) as error:
            run.notes.append(f"the frames cannot be drawn: {error}")
    if run.notes:
        body.append(f"<p class=note>{html.escape('; '.join(run.notes))}.</p>")
    body.append(cards(s))
    if pictures:
        body.append(f"<h2>Particles</h2><div class=pictures style='grid-template-columns: repeat({len(pictures)}, 1fr)'>")
        body += [f"<figure><img alt='{html.escape(c)}' src='{uri}'><figcaption>{html.escape(c)}</figcaption></figure>"
                 for uri, c in pictures]
        body.append(f"</div><div class=bar><img alt='colour scale' src='{bar}'></div>")

    def section(heading, images):
        images = [i for i in images if i]
        if images:
            body.append(f"<h2>{heading}</h2><div class=grid>")
            body.extend(f"<figure><img alt='{heading.lower()}' src='{i}'></figure>" for i in images)
            body.append("</div>")

    if run.series:
        section("Mass flow", flow_figures(run.series))
        section("Time series", series_figures(run.series))
    for heading, image in [("List rebuilds", rebuild_figure(s)), ("The list over the run: skin, K, rebuild interval, pairs per contact", list_figure(s)),
                           ("Where the time went", node_figure(s))]:
        if image:
            body.append(f"<h2>{heading}</h2><figure><img class=wide alt='{heading.lower()}' src='{image}'></figure>")
    files = file_table(run.folder)
    if files:
        body.append("<h2>Files</h2>" + files)
    if run.scene:
        body.append(f"<h2>Scene</h2><details open><summary>scene.toml</summary><pre>{html.escape(run.scene)}</pre></details>")
    return (f"<!DOCTYPE html>\n<html lang=en><head><meta charset=utf-8><meta name=viewport content='width=device-width'>"
            f"<title>{html.escape(title)} – Talus report</title><style>{STYLE}</style></head>\n<body><main>\n"
            + "\n".join(body) + "\n</main></body></html>\n")


def main():
    parser = argparse.ArgumentParser(description="Write one self-contained HTML page about a run.")
    parser.add_argument("folder", metavar="DIR", help="output folder of talus run")
    parser.add_argument("--out", metavar="FILE", help="page to write (default DIR/report.html)")
    arguments = parser.parse_args()
    if not os.path.isdir(arguments.folder):
        print(f"error: {arguments.folder}: is not a folder (give the folder that talus run wrote)", file=sys.stderr)
        return 5
    target = arguments.out or os.path.join(arguments.folder, "report.html")
    text = page(Run(arguments.folder))
    # The mark of all scratch files of Talus (core/io/scratch.hpp); "x": nobody else's file is opened.
    scratch = os.path.join(os.path.dirname(target), ".talus-" + os.urandom(8).hex())
    try:
        try:
            with open(scratch, "x", encoding="utf-8") as f:
                f.write(text)
            os.replace(scratch, target)
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(scratch)
            raise
    except OSError as error:
        print(f"error: {target}: cannot write: {error.strerror}", file=sys.stderr)
        return 5
    try:
        print(target, flush=True)
    except OSError as error:
        print(f"error: standard output: cannot write: {error.strerror}", file=sys.stderr)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # the interpreter flushes once more at its end
        return 5
    return 0


if __name__ == "__main__":
    sys.exit(main())
