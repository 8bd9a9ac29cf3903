"""The report: one HTML page without external resources, from the rows that error_time.py measured.

Who calls it: error_time.py. Everything it says (orders, prices, advice) is computed from the rows.
"""
import html
import io
import math
import os

import numpy as np

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from . import findings  # noqa: E402
from .scene import DEFAULT, LISTS  # noqa: E402

PALETTE = ["#1f6f8b", "#d1792a", "#5a8f3d", "#a8436b", "#6a5aa8", "#8a6d3b", "#3c9d9b", "#c2a83e", "#444c56", "#7b8794"]
MARKERS = "osD^vP*Xh<>"
STYLE = """body{font:15px/1.5 system-ui,sans-serif;color:#1c2430;max-width:1080px;margin:2em auto;padding:0 1em}
h1{font-size:1.6em}h2{margin-top:2em;border-top:1px solid #d9dfe7;padding-top:1em}table{border-collapse:collapse;font-size:12.5px}
td,th{padding:3px 8px;border-bottom:1px solid #e3e8ee;text-align:right;vertical-align:top}td:first-child,th:first-child{text-align:left}
th{color:#5d6b7c;font-weight:600}.bad{color:#b3261e;font-weight:600}.small{color:#5d6b7c;font-size:13px}svg{max-width:100%;height:auto}
.good{color:#2e6b34}summary{cursor:pointer;color:#1f6f8b}.wide{overflow-x:auto}"""
plt.rcParams.update({"font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "grid.color": "#e9edf2",
                     "legend.frameon": False, "legend.fontsize": 7.5, "svg.hashsalt": "talus", "svg.fonttype": "none"})


def write(path, results, facts):
    parts = [f"<!doctype html><html lang=en><meta charset=utf-8><title>Error against run time</title><style>{STYLE}</style>",
             "<h1>Error against run time</h1>", introduction(facts)]
    wrong = [s for r in results for s in r["wrong"]]
    parts += [f'<p class=bad>Does not hold: {html.escape(s)}</p>' for s in wrong]
    parts += [summary(results)] + [section(r) for r in results]
    with open(path + ".part", "w", encoding="utf-8") as f:
        f.write("\n".join(parts))
    os.replace(path + ".part", path)


def introduction(facts):
    f = facts["features"]
    missing = []
    if not f["inexact_policies"]:
        missing.append("Talus has no list policy that can miss contacts (no fixed rebuild interval); where LAMMPS is present, its "
                       "unchecked fixed intervals show in the elastic gas what such lists cost")
    if not f["precisions"]:
        missing.append("this build has no reduced precision to compare with the exact arithmetic")
    missing += [f"{name} was not found" for name in ("lammps", "liggghts") if not f[name]]
    return (f"<p>One point is one setting: run time of the whole scene (median of {facts['rounds']} interleaved repeats on one thread, "
            "bars from the fastest to the slowest; long runs are timed over their first steps and scaled) against the error of the "
            "scene's norm. Black line: Pareto front, no setting is both faster and more accurate. Start-up is not timed; the skins of LAMMPS and LIGGGHTS are fixed per scene, not tuned. "
            "<i>dt q</i> means q steps per contact time of the law in use.</p>"
            f"<p class=small>{html.escape(str(facts['cpu']))}, {facts['cores']} cores; Talus binary {facts['talus']}; "
            f"{'quick mode: few points, small scenes; ' if facts['quick'] else ''}{html.escape('; '.join(missing))}.</p>")


def section(r):
    out = [f"<h2 id={r['name']}>{html.escape(r['title'])}</h2>",
           f"<p class=small>Norm: {html.escape(r['norm'])}. Reference: {html.escape(r['reference'])}.</p>", picture(r)]
    out += [f"<p class=good>Holds: {html.escape(s)}.</p>" for s in r["held"]]
    out += [f"<p class=bad>Does not hold: {html.escape(s)}</p>" for s in r["wrong"]]
    out += [f"<p class=small>{html.escape(s)}</p>" for s in r["notes"]]
    out += [orders(r["rows"]), lists(r["rows"]), softening(r["rows"]), table(r["rows"]), advice_list(r)]
    return "\n".join(out)


def picture(r):
    rows = [x for x in r["rows"] if x["error"] is not None]
    fig, ax = plt.subplots(figsize=(9.2, 4.8))
    floor = min([x["error"] for x in rows if x["error"] > 0], default=1e-16) / 3  # zero has no place on a log axis
    for i, family in enumerate(dict.fromkeys(x["family"] for x in rows)):
        some = [x for x in rows if x["family"] == family]
        t, e = np.array([x["wall_s"] for x in some]), np.maximum([x["error"] for x in some], floor)
        spread = [t - [x["wall_low_s"] for x in some], np.array([x["wall_high_s"] for x in some]) - t]
        half = np.array([min(x["error_half_width"], 1e3) for x in some])
        up = None if not half.any() else [np.minimum(half, 0.999 * e - 0.999 * floor).clip(0), half]
        lines = "none" if family in (LISTS,) or len(some) < 2 else "-"
        # a family is drawn in the order of its steps
        k = np.argsort([x["dt"] for x in some], kind="stable")
        ax.errorbar(t[k], e[k], xerr=[s[k] for s in spread], yerr=None if up is None else [u[k] for u in up], linestyle=lines,
                    linewidth=0.9, elinewidth=0.6, marker=MARKERS[i % len(MARKERS)], markersize=4.5, color=PALETTE[i % len(PALETTE)],
                    label=family, markerfacecolor="none" if family == LISTS else PALETTE[i % len(PALETTE)])
    front = findings.pareto(rows)
    if len(front) > 1:
        ax.step([x["wall_s"] for x in front], [max(x["error"], floor) for x in front], where="post", color="black", linewidth=1.4,
                alpha=0.55, label="Pareto front", zorder=0)
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_xlabel("run time [s]")
    ax.set_ylabel("error")
    for tolerance in findings.TOLERANCES:
        if ax.get_ylim()[0] < tolerance < ax.get_ylim()[1]:
            ax.axhline(tolerance, color="#b3261e", linewidth=0.5, linestyle=":")
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    fig.tight_layout()
    text = io.StringIO()
    fig.savefig(text, format="svg", metadata={"Date": None})
    plt.close(fig)
    svg = text.getvalue()
    # ids repeat from figure to figure and would collide on one page
    return svg[svg.index("<svg"):].replace('id="', f'id="{r["name"]}-').replace("url(#", f"url(#{r['name']}-").replace(
        'href="#', f'href="#{r["name"]}-')


def orders(rows):
    cells = []
    for family in dict.fromkeys(x["family"] for x in rows):
        if family == LISTS or "softened" in family:
            continue
        slope = findings.order([x for x in rows if x["family"] == family and x["error"] is not None])
        if slope is not None:
            cells.append(f"{html.escape(family)} {slope:.2f}")
    return f"<p>Order of the error in dt, from resolved points: {'; '.join(cells)}.</p>" if cells else ""


def lists(rows):
    """Run times of what cannot change the result, against the default at the same step."""
    some = sorted((x for x in rows if x["family"] == LISTS and not x["stopped"]), key=lambda x: x["wall_s"])
    base = next((x for x in rows if some and x["family"] == DEFAULT and x["steps_per_contact"] == some[0]["steps_per_contact"]), None)
    if not base:
        return ""
    shown = "; ".join(f"{html.escape(x['label'])} {x['wall_s'] / base['wall_s']:.2f}" for x in some)
    return f"<p>Same bits, run time against {html.escape(base['label'])} with the default list: {shown}.</p>"


def softening(rows):
    soft = [x for x in rows if x["softening"] != 1]
    if not soft:
        return ""
    base = next((x for x in rows if x["family"] == DEFAULT and x["steps_per_contact"] == soft[0]["steps_per_contact"]), None)
    lines = []
    for x in soft:
        if x["stopped"]:
            lines.append(f"stiffness / {x['softening']:g}: {html.escape(x['stopped'])}")
            continue
        gain = f"{base['wall_s'] / x['wall_s']:.1f} times faster, " if base and not base["stopped"] else ""
        lines.append(f"stiffness / {x['softening']:g}: {gain}error {percent(x)}" + (f" ({html.escape(x['note'])})" if x["note"] else ""))
    against = f" (the hard law at the same steps per contact: error {percent(base)})" if base and base["error"] is not None else ""
    return f"<p>What softening costs{against}:<br>" + "<br>".join(lines) + "</p>"


def percent(x):
    half = x["error_half_width"]
    return f"{100 * x['error']:.2g} %" + (f" +/- {100 * half:.2g} %" if half else "")


def table(rows):
    head = ["setting", "code", "dt", "steps", "run time [s]", "spread", "error", "+/-", "energy residual", "missed (audited steps)",
            "rebuilds", "state hash", "remark"]
    body = []
    for x in rows:
        if x["stopped"]:
            body.append(f"<tr><td>{html.escape(x['label'])}<td>{x['code']}<td>{x['dt']:.3g}<td>{x['steps']}"
                        f"<td colspan=9 class=bad style='text-align:left'>{html.escape(x['stopped'])}")
            continue
        spread = (x["wall_high_s"] - x["wall_low_s"]) / x["wall_s"] if x["wall_s"] else 0
        missed = "" if x["missed_contacts"] is None else f"{x['missed_contacts']} ({x['audited_steps']})"
        body.append("<tr><td>" + "<td>".join([
            html.escape(x["label"]), x["code"], f"{x['dt']:.3g}", str(x["steps"]), f"{x['wall_s']:.3g}", f"{100 * spread:.0f} %",
            f"{x['error']:.3g}", f"{x['error_half_width']:.2g}" if x["error_half_width"] else "",
            "" if x["energy_residual"] is None else f"{x['energy_residual']:.1e}", missed,
            "" if x["rebuilds"] is None else str(x["rebuilds"]), x["state_hash"] or "", html.escape(x["note"] or "")]))
    return ("<details><summary>All points</summary><div class=wide><table><tr><th>" + "<th>".join(head) + "".join(body) +
            "</table></div></details>")


def advice_list(r):
    out, rows = [], r["rows"]
    for tolerance, best, ours in findings.advice(rows):
        text = html.escape(findings.describe(best))
        if best is None:
            near = min((x for x in rows if x["error"] is not None and math.isfinite(x["error_half_width"])),
                       key=lambda x: x["error"] + x["error_half_width"], default=None)
            text += (f"; the nearest, counting its interval, is {html.escape(findings.describe(near))}" if near else "")
        elif best is not ours:
            text += f"; with Talus: {html.escape(findings.describe(ours))}"
        out.append(f"<li>{100 * tolerance:g} %: {text}")
    told = findings.statistics(rows, r["seeds"]) if r["kind"] == "bulk" else None
    return ("<p><b>Cheapest setting for an error of</b><ul>" + "".join(out) + "</ul>" +
            (f"<p>{html.escape(told)}</p>" if told else ""))


def summary(results):
    """One row per scene: the cheapest setting of every code for each tolerance."""
    head = "<tr><th>scene" + "".join(f"<th>{100 * t:g} %" for t in findings.TOLERANCES)
    body = []
    for r in results:
        body.append(f"<tr><td><a href='#{r['name']}'>{html.escape(r['title'])}</a>" + "".join(
            f"<td style='text-align:left'>{beside(best)}" for _, best in findings.summary(r["rows"])))
        told = findings.statistics(r["rows"], r["seeds"]) if r["kind"] == "bulk" else None
        if told:
            body.append(f"<tr><td><td colspan={len(findings.TOLERANCES)} class=small style='text-align:left'>{html.escape(told)}")
    return ("<h2>Summary</h2><p>The cheapest measured setting whose error, with its interval, is below the tolerance; q in <i>dt q</i> is "
            "the number of steps per contact. Where the clock does not tell it from the fastest, the default is named. <i>None</i> means "
            "that no point gets there, or that the seeds are too few to say so. Other codes: their cheapest setting, and its run time "
            f"over that of Talus.</p><div class=wide><table>{head}{''.join(body)}</table></div>")


def beside(best):
    ours, lines = best.get("talus"), []
    for code, row in best.items():
        name = {"talus": "Talus", "lammps": "LAMMPS", "liggghts": "LIGGGHTS"}[code]
        if row is None:
            lines.append(f"{name}: none")
        elif row is ours:
            lines.append(f"{name}: {html.escape(row['label'])}, {row['wall_s']:.3g} s")
        else:
            ratio = f", {row['wall_s'] / ours['wall_s']:.2g} x" if ours else ""
            lines.append(f"<span class=small>{name}: dt {row['steps_per_contact']:g}, {row['wall_s']:.3g} s{ratio}</span>")
    return "<br>".join(lines)
