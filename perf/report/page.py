"""The page of one run."""
import html
import os

from .data import Run
from .engine_plots import list_plot, node_plot, rebuild_plot
from .frame_plots import pictures_of, profile_plots, size_plot
from .series_plots import flow_plots, region_plots, series_plots
from .style import STYLE, grouped, seconds, size_text
from .view import view_html

HERE = os.path.dirname(os.path.abspath(__file__))


def script(name):
    with open(os.path.join(HERE, name), encoding="utf-8") as f:
        return f"<script>{f.read()}</script>"


def document(title, body, scripts):
    return (f"<!DOCTYPE html>\n<html lang=en><head><meta charset=utf-8><meta name=viewport content='width=device-width'>"
            f"<title>{html.escape(title)} – Talus report</title><style>{STYLE}</style></head>\n<body><main>\n"
            + "\n".join(b for b in body if b) + "\n</main>" + "".join(script(s) for s in scripts) + "</body></html>\n")


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
    """How the run stands where it has left no summary, or did not finish."""
    if run.summary:
        status = str(run.summary.get("status", "finished"))
        return "" if status in ("finished", "") else f"<p class='note bad'>This run did not finish: {html.escape(status)}</p>"
    if not run.scene:
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
    card("last K that the run chose" if s.get("verlet_k_automatic") else "K", "verlet_k", lambda v: f"{v:.4g}")
    card("threads", "threads")
    card("instruction set", "isa")
    card("contact law", "law", small=True)
    card("pairs of superquadrics solved", "solved_pairs", grouped)
    card("of them by the safe method", "safe_pairs", grouped)
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


def section(heading, plots):
    plots = [p for p in plots if p]
    if not plots:
        return ""
    return f"<h2>{heading}</h2><div class=grid>" + "".join(p.html(heading.lower()) for p in plots) + "</div>"


def picture(image, caption, scale=""):
    bar = f"<div class=bar><img alt='colour scale' src='{scale}'></div>" if scale else ""
    return f"<figure><img alt='{html.escape(caption)}' src='{image}'>{bar}<figcaption>{html.escape(caption)}</figcaption></figure>"


def particle_section(run):
    """3-D view, pictures, size distribution and profiles; what cannot be drawn is named on the page."""
    try:
        view, (by_speed, scale, others) = view_html(run), pictures_of(run)
        plots = section("Last frame: sizes and profiles", [size_plot(run.frames[-1]), *profile_plots(run)])
    except (OSError, KeyError, ValueError) as error:
        run.notes.append(f"the frames cannot be drawn: {error}")
        return []
    body = ["<h2>Last frame in 3-D</h2>" + view, "<h2>Particles</h2>"]
    body.append("<div class=pictures>" + "".join(picture(*p) for p in by_speed) + f"</div><div class=bar><img alt='colour scale' src='{scale}'></div>")
    if others:
        body.append("<div class=pictures>" + "".join(picture(*p) for p in others) + "</div>")
    return [*body, plots]


def page(folder):
    run = Run(folder)
    s, title = run.summary, run.title()
    lead = [f"Talus {s['version']}" if s.get("version") else "", s.get("scene_file") or "", s.get("status") or ""]
    particles = particle_section(run) if run.frames else []
    body = [f"<h1>{html.escape(title)}</h1>", f"<p class=lead>{html.escape(' · '.join(x for x in lead if x))}</p>",
            state_of(run), warnings_of(s)]
    if run.notes:
        body.append(f"<p class=note>{html.escape('; '.join(run.notes))}.</p>")
    body += [cards(s), *particles]
    if run.series:
        body += [section("Mass flow", flow_plots(run.series)), section("Regions", region_plots(run.series)),
                 section("Time series", series_plots(run.series))]
    for heading, plot, folded in [
            ("Where the time went", node_plot(s), False), ("List rebuilds", rebuild_plot(s), True),
            ("The list over the run: skin, K, rebuild interval, pairs per contact", list_plot(s), True)]:
        if plot:
            image = plot.html(heading.lower(), wide=True)
            body.append(f"<details><summary>{heading}</summary>{image}</details>" if folded else f"<h2>{heading}</h2>{image}")
    meshes, files = mesh_table(s), file_table(run.folder)
    body += [meshes and "<h2>Meshes</h2>" + meshes, files and "<h2>Files</h2>" + files]
    if run.scene:
        body.append(f"<h2>Scene</h2><details open><summary>scene.toml</summary><pre>{html.escape(run.scene)}</pre></details>")
    return document(title, body, ["plots.js"] + (["view.js"] if particles else []))
