"""The report of the study: one HTML page without external resources, and the same figures as CSV. Called by perf/study.py."""
import csv
import html
import io
import os

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from . import findings, plan  # noqa: E402

COLOURS = ["#1f6f8b", "#d1792a", "#5a8f3d", "#a8436b", "#6a5aa8", "#8a6d3b", "#3c9d9b"]
STYLE = """body{font:15px/1.5 system-ui,sans-serif;color:#1c2430;max-width:1100px;margin:2em auto;padding:0 1em}h1{font-size:1.6em}
h2{margin-top:2em;border-top:1px solid #d9dfe7;padding-top:1em}table{border-collapse:collapse;font-size:12.5px}td,th{padding:3px 8px;
border-bottom:1px solid #e3e8ee;text-align:right;vertical-align:top}td:first-child,th:first-child,td.text{text-align:left}th{color:#5d6b7c}
.yes{color:#2e6b34;font-weight:600}.no{color:#b3261e;font-weight:600}.small{color:#5d6b7c;font-size:13px}svg{max-width:100%;height:auto}.wide{overflow-x:auto}"""
plt.rcParams.update({"font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "grid.color": "#e9edf2",
                     "legend.frameon": False, "legend.fontsize": 8, "svg.hashsalt": "talus", "svg.fonttype": "none"})


def write(out, summaries, facts):
    some = [s for s in summaries if s.none() and s.runs]
    parts = [f"<!doctype html><html lang=en><meta charset=utf-8><title>The K study</title><style>{STYLE}</style><h1>The paper's study of the "
             "local Verlet buffer, and ours beside it</h1>", introduction(facts, some)]
    parts += [verdict_table(findings.verdicts(summaries, p), p) for p in plan.SWEPT if any(s.series(p) for s in some)]
    parts += [summary_table(some), shares_figure(some), overhead_figure(some), policy_table(some), bounds_table(some)]
    parts += [case_section(s) for s in some]
    with open(os.path.join(out, "study.html.part"), "w", encoding="utf-8") as f:
        f.write("\n".join(parts))
    os.replace(os.path.join(out, "study.html.part"), os.path.join(out, "study.html"))


def write_csv(path, summaries):
    rows = [{"case": s.case.name, **p} for s in summaries for p in s.points.values()]
    if not rows:
        return
    with open(path, "w", newline="", encoding="utf-8") as f:
        table = csv.DictWriter(f, fieldnames=list(rows[0]))
        table.writeheader()
        table.writerows(rows)


def introduction(facts, some):
    few = [f"{s.case.name} {p['point']}" for s in some for p in s.points.values() if p["few_intervals"]]
    done = "" if facts["complete"] else "<p class=no>Not finished: some runs of the plan are missing. Call the study again.</p>"
    return (done + f"<p>Every run of a case resumes from one checkpoint and does the same {facts['steps']} timed steps (after {facts['warm']} untimed ones), on "
            f"{facts['threads']} thread{'s' if facts['threads'] != 1 else ''}; {facts['repeats']} repeats, each in its own random order. Times are medians, intervals are 95 % "
            "bootstrap intervals of the median; overheads are medians of ratios within one repeat. Broad-phase means the nodes displacement_check, rebuild and "
            "sort_epoch, narrow-phase the node narrow_phase, models all the rest (contact and wall forces, integration). "
            "A sort epoch (every 1000 steps by default) forces a rebuild, so no list lives longer, whatever K is.</p>"
            + "".join(f"<p class=no>Stopped by its own physics: {html.escape(f)}</p>" for f in facts["failures"]) +
            f"<p class=small>Talus {html.escape(facts['version'])}, {html.escape(facts['isa'])}, {html.escape(facts['cpu'])}; highest load average seen {facts['load']:.1f}."
            + (f" Fewer than {findings.ENOUGH_INTERVALS} rebuilds were measured in: {html.escape(', '.join(few))}." if few else "") + "</p>")


def mark(holds):
    return {True: "<span class=yes>reproduced</span>", False: "<span class=no>not reproduced</span>", None: "not tested"}[holds]


def verdict_table(claims, series):
    out = [f"<h2>The paper's claims, policy <i>{series}</i></h2><div class=wide><table><tr><th>claim</th><th>case</th><th>verdict</th><th>evidence</th></tr>"]
    for name, text, cases in claims:
        for i, (case, holds, evidence) in enumerate(cases):
            head = f"{name}: {html.escape(text)}" if i == 0 else ""
            out.append(f"<tr><td>{head}</td><td class=text>{case}</td><td class=text>{mark(holds)}</td><td class=text>{html.escape(evidence)}</td></tr>")
    return "\n".join(out) + "</table></div>"


def summary_table(some):
    out = ["<h2>Summary (the paper's table 1, ours beside it)</h2><div class=wide><table><tr><th>case</th><th>policy</th><th>grains</th><th>without buffer [s]</th>"
           "<th>K opt</th><th>T opt [s]</th><th>improvement %</th><th>T at 200 [s]</th><th>improvement %</th><th>overhead %</th><th>within 2 %</th></tr>"]
    for s in some:
        for series in plan.SWEPT:
            r = s.row(series)
            if r is None:
                continue
            rest = (f"<td>{r['default_s']:.3f}</td><td>{r['default_improvement']:.1f}</td><td>{r['overhead']:+.2f} ({r['overhead_low']:+.2f} ... {r['overhead_high']:+.2f})</td>"
                    if "overhead" in r else "<td></td><td></td><td></td>")
            out.append(f"<tr><td>{s.case.name}</td><td>{series}</td><td>{s.particles}</td><td>{r['none_s']:.3f} ({r['none_low_s']:.3f} ... {r['none_high_s']:.3f})</td><td>{r['optimum']}</td>"
                       f"<td>{r['optimum_s']:.3f} ({r['optimum_low_s']:.3f} ... {r['optimum_high_s']:.3f})</td><td>{r['improvement']:.1f}</td>{rest}<td>{r['basin'][0]} to {r['basin'][1]}</td></tr>")
        p = findings.paper_row(s.case.paper)
        if p:
            out.append(f"<tr class=small><td>paper: {s.case.paper}</td><td></td><td></td><td>{p['none_s']:.2f}</td><td>{p['optimum']}</td><td>{p['optimum_s']:.2f}</td>"
                       f"<td>{p['improvement']:.1f}</td><td>{p['default_s']:.2f}</td><td>{p['default_improvement']:.1f}</td><td>{p['overhead']:+.2f}</td><td></td></tr>")
    return "\n".join(out) + "</table></div><p class=small>The paper's seconds are of another code, machine and length of run: only the percentages compare.</p>"


def policy_table(some):
    out = ["<h2>All list policies</h2><div class=wide><table><tr><th>case</th><th>setting</th><th>time [s]</th><th>against local, K = 200</th><th>rebuilds in %</th>"
           "<th>broad [s]</th><th>narrow [s]</th><th>models [s]</th><th>pairs per contact</th><th>exact</th></tr>"]
    for s in some:
        default = s.at("local", 200)
        best = [s.optimum(k) for k in (*plan.SWEPT, "uniform")]
        wanted = [s.none(), default, s.at("paper", 200), s.at("uniform", plan.UNIFORM_R), *best]
        wanted += [p for p in s.points.values() if p["series"] not in (plan.NONE, "uniform", *plan.SWEPT)]
        for p in sorted({p["point"]: p for p in wanted if p}.values(), key=lambda p: p["wall_s"]):
            against = ""
            if default:
                m, low, high = s.ratio(p, default)
                against = f"{m:.3f} ({low:.3f} ... {high:.3f})"
            out.append(f"<tr><td>{s.case.name}</td><td class=text>{html.escape(p['point'])}</td><td>{p['wall_s']:.3f}</td><td>{against}</td><td>{p['broad_percent']:.2f}</td>"
                       f"<td>{p['broad_s']:.3f}</td><td>{p['narrow_s']:.3f}</td><td>{p['model_s']:.3f}</td><td>{p['pairs_per_contact']:.1f}</td><td class=text>{exactness(p)}</td></tr>")
    return "\n".join(out) + ("</table></div><p class=small>The number behind a policy is its K; behind uniform, two_largest and accumulated the skin in radii of the smallest "
                             f"grain; behind fixed its interval in steps (skin {plan.FIXED_SKIN} radii). paper + floor is local without the acceleration term. The swept policies stand with "
                             "their optimum and K = 200.</p>")


def bounds_table(some):
    out = ["<h2>What list policies that are not built could save at most</h2><div class=wide><table><tr><th>case</th><th>best exact setting</th><th>time [s]</th>"
           "<th>partial rebuild %</th><th>reduced cells %</th><th>outer and inner list %</th></tr>"]
    for b in filter(None, map(findings.bounds, some)):
        out.append(f"<tr><td>{b['case']}</td><td class=text>{html.escape(b['best'])}</td><td>{b['wall_s']:.3f}</td><td>{b['rebuild_percent']:.1f}</td>"
                   f"<td>{b['rebuild_percent']:.1f}</td><td>{b['inner_percent']:.1f}</td></tr>")
    return "\n".join(out) + ("</table></div><p class=small>A partial rebuild or smaller cells save at most all rebuilds of the best setting. An inner list saves at most these and what its narrow "
                             "phase takes more than that of the tightest list in the table above; both are bounds, since none of the three comes for nothing.</p>")


def exactness(p):
    missed = p["missed_contacts"]
    if missed is None and p["series"] in findings.INEXACT:
        return "no: misses not counted"
    return "yes" if missed is None else f"no: {missed} contacts missed in {p['audited_steps']} steps"


def figure_svg(fig):
    out = io.StringIO()
    fig.savefig(out, format="svg", bbox_inches="tight", metadata={"Date": None})
    plt.close(fig)
    text = out.getvalue()
    return text[text.index("<svg"):]


def place(value):
    """K on a logarithmic axis that also has room for 0."""
    return 0.5 if value == 0 else value


def k_axis(ax, rows):
    ax.set_xscale("log")
    ticks = [p["value"] for p in rows]
    ax.set_xticks([place(v) for v in ticks], [str(v) for v in ticks], fontsize=7)
    ax.minorticks_off()
    ax.set_xlabel("K")


def case_section(s):
    out = [f"<h2>{s.case.name}: {s.particles} grains</h2>"]
    for series in plan.SWEPT:
        rows = s.series(series)
        if len(rows) < 2:
            continue
        best = s.optimum(series)
        x = [place(p["value"]) for p in rows]
        fig, axes = plt.subplots(1, 2, figsize=(10.5, 3.6))
        for ax, keys in zip(axes, ([("wall_s", "total"), ("broad_s", "broad-phase")], [("narrow_s", "narrow-phase"), ("model_s", "models")])):
            for i, (key, label) in enumerate(keys):
                ax.plot(x, [p[key] for p in rows], "o-", ms=3, lw=1.2, color=COLOURS[i if ax is axes[0] else i + 2], label=label)
            ax.axvline(place(best["value"]), color="#3a6ad1", ls="--", lw=1, label=f"optimum, K = {best['value']}")
            k_axis(ax, rows)
            ax.set_ylabel("seconds")
            ax.set_ylim(bottom=0)
        axes[0].fill_between(x, [p["wall_low_s"] for p in rows], [p["wall_high_s"] for p in rows], color=COLOURS[0], alpha=0.2, lw=0)
        none, rival, tuned = s.none(), s.at("uniform", plan.UNIFORM_R), s.optimum("uniform")
        axes[0].axhline(none["wall_s"], color="#777", ls=":", lw=1, label="without buffer")
        if rival:
            axes[0].axhline(rival["wall_s"], color="#e58a1f", lw=1, label="uniform skin = R")
            axes[0].axhline(tuned["wall_s"], color="#e58a1f", ls="-.", lw=1, label=f"uniform, tuned ({tuned['value']} R)")
        for ax in axes:
            ax.legend()
        fig.suptitle(f"{s.case.name}, policy {series}", fontsize=10)
        out.append(figure_svg(fig))
    return "\n".join(out)


def lines_figure(some, title, ylabel, key, log):
    fig, axes = plt.subplots(1, len(plan.SWEPT), figsize=(10.5, 3.6), squeeze=False)
    for ax, series in zip(axes[0], plan.SWEPT):
        longest = []
        for i, s in enumerate(some):
            rows = s.series(series)
            longest = max(longest, rows, key=len)
            if rows:
                ax.plot([place(p["value"]) for p in rows], [key(s, series, p) for p in rows], "o-", ms=3, lw=1.2, color=COLOURS[i % len(COLOURS)], label=s.case.name)
        if longest:
            k_axis(ax, longest)
            ax.legend()
        if log:
            ax.set_yscale("log")
        ax.set_ylabel(ylabel)
        ax.set_title(f"policy {series}", fontsize=9)
    return f"<h2>{title}</h2>" + figure_svg(fig)


def shares_figure(some):
    return lines_figure(some, "Executed broad-phases", "rebuilds / steps [%]", lambda s, k, p: p["broad_percent"], True)


def overhead_figure(some):
    return lines_figure(some, "Overhead against the optimum", "time over the optimum [%]", lambda s, k, p: 100 * (p["wall_s"] / s.optimum(k)["wall_s"] - 1), False)
