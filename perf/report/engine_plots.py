"""Plots of what the engine did: time per node, neighbour-list rebuilds, skin and K over the run."""
import numpy as np

from .plots import Plot, svg
from .style import ACCENT, INK, MUTED, PALETTE, plt


def rebuild_plot(summary):
    steps = np.array(summary.get("rebuild_steps") or [], dtype=float)
    intervals = np.diff(steps)
    if len(intervals) < 2:
        return None
    figure, (left, right) = plt.subplots(1, 2, figsize=(11.4, 2.7), gridspec_kw={"width_ratios": [2, 1], "wspace": 0.2})
    left.plot(steps[1:], intervals, ".", ms=4, alpha=0.7)
    left.axhline(intervals.mean(), color=PALETTE[1], lw=1.2, label=f"mean {intervals.mean():.3g}")
    left.set(title="Rebuild intervals", xlabel="step", ylabel="steps since last rebuild")
    left.set_ylim(bottom=0)
    left.legend(loc="lower right", bbox_to_anchor=(1, 1), borderaxespad=0.1)
    right.hist(intervals, bins=min(40, max(5, int(np.sqrt(len(intervals)) * 2))), color=ACCENT, alpha=0.85)
    right.set(title="Distribution", xlabel="steps between rebuilds", ylabel="rebuilds")
    return Plot(svg(figure))


def list_plot(summary):
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
            skins.legend(loc="lower right", bbox_to_anchor=(1, 1), ncol=2, borderaxespad=0.1)
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
    return Plot(svg(figure))


def node_plot(summary):
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
    return Plot(svg(figure))
