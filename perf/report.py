#!/usr/bin/env python3
"""One self-contained HTML page about a run: python3 report.py DIR [--out FILE] (default DIR/report.html).

Called by `talus report DIR`. Reads what a run leaves (summary.json, scene.toml, series.csv, frames of particles and
walls); whatever is missing or unreadable is named on the page and left out, so that it also shows a run that goes on or
was killed. No external resources, no dates: the same folder gives the same page.
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
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
except ImportError as error:
    sys.exit(f"error: the report needs {error.name} (apt-get install python3-matplotlib)")

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(os.path.dirname(HERE), "cases")]
from draw import COLOUR_NAMES, COLOURS, MATERIALS, draw, view_of, walls_at, wall_frames  # noqa: E402
from frames import open_frames  # noqa: E402

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
        self.frames = self._frames("particles", read_frames)
        self.walls = self._frames("walls", wall_frames, wanted=False)

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


    def _frames(self, stem, reader, wanted=True):
        try:
            source = open_frames(self.folder, stem)
            if source is None:
                if wanted:
                    self.notes.append(f"there are no {stem} over time")
                return None
            return reader(source)
        except Exception as error:
            self.notes.append(f"{stem} over time cannot be read: {error}")
            return None


def read_series(path):
    with open(path, newline="", encoding="utf-8") as f:
        rows = list(csv.reader(f))
    header, body = rows[0], [r for r in rows[1:] if len(r) == len(rows[0])]
    if not body:
        raise ValueError("it has no rows")
    values = np.array(body, dtype=float)
    return {name: values[:, k] for k, name in enumerate(header)}


def read_frames(source):
    """First, middle and last frame with particles."""
    filled = [k for k in range(len(source)) if source.count(k) > 0]
    if not filled:
        raise ValueError("no frame has particles")
    frames = []
    for k in sorted({filled[0], filled[len(filled) // 2], filled[-1]}):
        points, columns, _ = source.read(k)
        frames.append({
            "index": k, "of": len(source), "time": float(source.times[k]), "step": source.step(k), "x": points,
            "r": columns["radius"], "speed": np.linalg.norm(columns["velocity"], axis=1), "columns": columns,
        })
    return frames


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


def colour_bar(norm, label, extend):
    figure, axes = plt.subplots(figsize=(4.2, 0.16))
    bar = figure.colorbar(matplotlib.cm.ScalarMappable(norm, COLOURS), cax=axes, orientation="horizontal", extend=extend)
    bar.set_label(label)
    bar.outline.set_visible(False)
    return svg(figure)


def material_names(scene):
    """Names in the order of the [[material]] sections, as far as they can be told."""
    names = []
    for block in re.split(r"^\s*\[\[material\]\]", scene or "", flags=re.M)[1:]:
        m = re.search(r"^\s*name\s*=\s*[\"']([^\"'\n]*)", re.split(r"^\s*\[", block, flags=re.M)[0], flags=re.M)
        names.append(m.group(1) if m else "")
    return names


def particle_figures(run):
    """Rows of (pictures, colour scale): three times by speed; the last frame by size and material where they differ."""
    frames = run.frames
    walls = [walls_at(run.walls, f["time"]) for f in frames]
    camera, view = view_of(frames, walls)
    aspect = (view[3] - view[2]) / (view[1] - view[0])
    width = int(np.clip(np.sqrt(900_000 / aspect), 420, 1200))
    names = {1: ["Only frame"], 2: ["First frame", "Last frame"], 3: ["First frame", "Middle frame", "Last frame"]}
    top_speed = max(np.percentile(f["speed"], 99.5) for f in frames)
    norm = plt.Normalize(0, top_speed if top_speed > 0 else 1)
    row = []
    for f, wall, name in zip(frames, walls, names[len(frames)]):
        caption = (f"{name}: t = {f['time']:.4g} s, step {grouped(f['step'])}, "
                   f"{grouped(len(f['r']))} particles")
        row.append((png(draw(f, wall, camera, view, width, COLOURS(norm(f["speed"]))), 100), caption))
    rows = [(row, colour_bar(norm, "speed [m/s]", "max"))]
    last, more = frames[-1], []
    smallest, largest = 2 * last["r"].min(), 2 * last["r"].max()
    if largest > 1.001 * smallest:
        sizes = plt.Normalize(smallest, largest)
        rows.append(([(png(draw(last, walls[-1], camera, view, width, COLOURS(sizes(2 * last["r"]))), 100), "Last frame by size")],
                     colour_bar(sizes, "diameter [m]", "neither")))
    material = last["columns"].get("material")
    if material is not None and len(np.unique(material)) > 1:
        given = material_names(run.scene)
        legend = ", ".join(f"{COLOUR_NAMES[m % len(COLOUR_NAMES)]}: {given[m] if m < len(given) and given[m] else m}"
                           for m in np.unique(material).tolist())
        more.append((png(draw(last, walls[-1], camera, view, width, MATERIALS[material.astype(int) % len(MATERIALS)]), 100),
                     f"Last frame by material ({legend})"))
    if more:
        rows.append((more, ""))
    return rows


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
.warnings ul {{ margin: 4px 0 0; padding-left: 20px; }}
.often {{ color: {MUTED}; }}
details {{ margin: 22px 0 0; }}
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


def warnings_of(s):
    """What the run-time monitor has seen, worst first of all on the page."""
    rows = []
    for w in s.get("warnings") or []:
        often = f"in {grouped(w['count'])} steps from step {grouped(w.get('first_step') or 0)} on" if w.get("count") else ""
        rows.append(f"<li>{html.escape(str(w.get('text') or w.get('kind') or ''))}"
                    + (f" <span class=often>({often})</span>" if often else "") + "</li>")
    return f"<div class='note warnings'><b>Warnings of the run</b><ul>{''.join(rows)}</ul></div>" if rows else ""


def mesh_table(s):
    rows = []
    for m in s.get("meshes") or []:
        facets = (m.get("facets_read") or 0) - (m.get("degenerate") or 0) - (m.get("duplicate") or 0)
        faults = [f"{grouped(m[key])} {text}" for key, text in [("open_edges", "open edges"), ("flipped", "flipped"),
                  ("degenerate", "without area, dropped"), ("duplicate", "twice, dropped"),
                  ("forked_edges", "edges of three or more facets")] if m.get(key)]
        rows.append(f"<tr><td>{html.escape(str(m.get('wall', '')))}</td><td>{html.escape(str(m.get('file', '')))}</td>"
                    f"<td class=number>{grouped(m.get('facets', facets))}</td>"
                    f"<td>{'watertight' if m.get('watertight') else 'open'}</td>"
                    f"<td>{html.escape('; '.join(faults) or 'no faults')}</td></tr>")
    head = "<tr><th>wall</th><th>file</th><th>facets</th><th>surface</th><th>found</th></tr>"
    return "<table>" + head + "".join(rows) + "</table>" if rows else ""


def state_of(run):
    """How the run stands where it has left no summary."""
    if run.summary or not run.scene:
        return ""
    until = f" until t = {run.series['time'][-1]:.5g} s" if run.series else ""
    return f"<p class='note bad'>No summary: this run goes on, or was killed. What it has written{until} is shown.</p>"


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
    "walls.pvd": "walls over time for any ParaView", "contacts.pvd": "contacts over time for any ParaView",
    "grid.pvd": "averages on a grid over time for any ParaView", "series.csv": "scalars over time", "summary.json": "figures of the run",
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
    rows = []
    if run.frames:
        try:
            rows = particle_figures(run)
        except (OSError, KeyError, ValueError) as error:
            run.notes.append(f"the frames cannot be drawn: {error}")
    body.append(state_of(run))
    body.append(warnings_of(s))
    if run.notes:
        body.append(f"<p class=note>{html.escape('; '.join(run.notes))}.</p>")
    body.append(cards(s))
    if rows:
        body.append("<h2>Particles</h2>")
    for pictures, bar in rows:
        body.append(f"<div class=pictures style='grid-template-columns: repeat({max(len(pictures), 1)}, 1fr)'>")
        body += [f"<figure><img alt='{html.escape(c)}' src='{uri}'><figcaption>{html.escape(c)}</figcaption></figure>"
                 for uri, c in pictures]
        body.append("</div>" + (f"<div class=bar><img alt='colour scale' src='{bar}'></div>" if bar else ""))

    def section(heading, images):
        images = [i for i in images if i]
        if images:
            body.append(f"<h2>{heading}</h2><div class=grid>")
            body.extend(f"<figure><img alt='{heading.lower()}' src='{i}'></figure>" for i in images)
            body.append("</div>")

    if run.series:
        section("Mass flow", flow_figures(run.series))
        section("Time series", series_figures(run.series))
    for heading, image, folded in [
            ("Where the time went", node_figure(s), False), ("List rebuilds", rebuild_figure(s), True),
            ("The list over the run: skin, K, rebuild interval, pairs per contact", list_figure(s), True)]:
        if not image:
            continue
        picture_of = f"<figure><img class=wide alt='{heading.lower()}' src='{image}'></figure>"
        body.append(f"<details><summary>{heading}</summary>{picture_of}</details>" if folded
                    else f"<h2>{heading}</h2>{picture_of}")
    meshes = mesh_table(s)
    if meshes:
        body.append("<h2>Meshes</h2>" + meshes)
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
