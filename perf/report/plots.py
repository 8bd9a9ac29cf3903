"""A plot as an image that stands alone, with its numbers beside it for the script that zooms and reads values off."""
import base64
import html
import io
import json
from dataclasses import dataclass

import matplotlib
import numpy as np

from draw import small_png

from .style import PALETTE, plt

MAX_POINTS = 1600  # per plot: more is invisible and makes the page heavy


@dataclass
class Plot:
    image: str           # data URI
    numbers: dict | None = None  # for plots.js; None: no values to read off

    def html(self, name, wide=False):
        image = f"<img{' class=wide' if wide else ''} alt='{html.escape(name)}' src='{self.image}'>"
        if self.numbers is None:
            return f"<figure>{image}</figure>"
        return f"<figure class=plot data-numbers='{html.escape(json.dumps(self.numbers, separators=(',', ':')), quote=True)}'>{image}</figure>"


def data_uri(data, mime):
    return f"data:{mime};base64,{base64.b64encode(data).decode()}"


def svg(figure, tight=True):
    out = io.BytesIO()
    box = {"bbox_inches": "tight", "pad_inches": 0.06} if tight else {}
    figure.savefig(out, format="svg", metadata={"Date": None, "Creator": None}, **box)
    plt.close(figure)
    return data_uri(out.getvalue(), "image/svg+xml")


def png(figure):
    return data_uri(small_png(figure), "image/png")


def thinned(x, curves):
    """Rows to show: per interval of x the least and the greatest value of every curve, first and last row always. A
    peak of one row is not lost."""
    if len(x) <= MAX_POINTS:
        return np.arange(len(x))
    blocks = max(2, MAX_POINTS // (2 * max(1, len(curves))))
    edges = np.linspace(0, len(x), blocks + 1).astype(int)
    chosen = {0, len(x) - 1}
    for y in curves:
        y = np.where(np.isfinite(y), y, np.nanmin(np.where(np.isfinite(y), y, np.inf)))
        for a, b in zip(edges, edges[1:]):
            chosen.update((a + int(np.argmin(y[a:b])), a + int(np.argmax(y[a:b]))))
    return np.array(sorted(chosen))


def rounded(values):
    return [float(f"{v:.6g}") if np.isfinite(v) else None for v in values]


def line_plot(x, curves, title, xlabel, ylabel, zero=False, step=False, size=(5.6, 2.7), marks=False):
    """Curves over one axis; curves: [(label, values)]. None where there is nothing to draw."""
    x = np.asarray(x, float)
    curves = [(label, np.asarray(y, float)) for label, y in curves if np.any(np.isfinite(y))]
    if not curves or len(x) < 2:
        return None
    rows = thinned(x, [y for _, y in curves])
    figure, axes = plt.subplots(figsize=size, layout="constrained")
    for label, y in curves:
        axes.plot(x[rows], y[rows], label=label, drawstyle="steps-pre" if step else "default", marker="o" if marks else None, ms=3.5)
    axes.set(title=title, xlabel=xlabel, ylabel=ylabel)
    axes.margins(x=0.01)
    if zero:
        axes.set_ylim(bottom=min(0, axes.get_ylim()[0]))
    if len(curves) > 1:  # above the plot, where it covers no curve
        columns = min(len(curves), 4 if size[0] < 8 else 8)
        axes.legend(loc="lower left", bbox_to_anchor=(-0.02, 1.0), ncol=columns, borderaxespad=0.2, columnspacing=1.2, handlelength=1.4)
        axes.set_title(title, pad=8 + 13 * -(-len(curves) // columns))
    figure.draw_without_rendering()
    power = axes.yaxis.get_major_formatter().get_offset()
    if power:  # above the axis it would lie under the legend
        axes.yaxis.offsetText.set_visible(False)
        axes.set_ylabel(ylabel[:-1].replace("[", f"[{power} ") + "]" if ylabel.endswith("]") else f"{ylabel} / {power}")
        figure.draw_without_rendering()
    box = axes.get_position()
    numbers = {
        "box": rounded([box.x0, 1 - box.y1, box.x1, 1 - box.y0]), "x": rounded(axes.get_xlim()), "y": rounded(axes.get_ylim()),
        "title": title, "xlabel": xlabel, "ylabel": ylabel, "step": step, "at": rounded(x[rows]),
        "curves": [{"label": label, "colour": PALETTE[k % len(PALETTE)], "values": rounded(y[rows])}
                   for k, (label, y) in enumerate(curves)],
    }
    return Plot(svg(figure, tight=False), numbers)


def colour_bar(norm, colours, label, extend):
    figure, axes = plt.subplots(figsize=(4.2, 0.16))
    bar = figure.colorbar(matplotlib.cm.ScalarMappable(norm, colours), cax=axes, orientation="horizontal", extend=extend)
    bar.set_label(label)
    bar.outline.set_visible(False)
    return svg(figure)
