"""One page about many runs, a sweep: a table of chosen figures, each figure over what differs, series beside each other."""
import html
import math
import os
import re
from urllib.parse import quote

import numpy as np

from .data import Run
from .page import document, section
from .plots import line_plot
from .style import grouped

FIGURES = ["particles", "simulated_time", "wall_s", "particle_steps_per_s", "contacts", "removed_mass", "coordination_number",
           "kinetic_energy"]
NOT_VARIED = ("title", "output")  # of no meaning for the physics
MOST_CURVES = 8


class UnknownFigure(ValueError):
    pass


def flat(table, path=""):
    """Keys of a scene as {"section.0.key": value}, lists of numbers as one value."""
    found = {}
    items = table.items() if isinstance(table, dict) else enumerate(table)
    for key, value in items:
        name = f"{path}.{key}" if path else str(key)
        if isinstance(value, dict) or (isinstance(value, list) and any(isinstance(v, dict) for v in value)):
            found.update(flat(value, name))
        else:
            found[name] = value
    return found


def varied(runs):
    """Keys whose values differ between the scenes, with the value of every run (None where it is not given)."""
    scenes = [flat(run.keys) for run in runs]
    names = sorted({name for s in scenes for name in s if not name.startswith(NOT_VARIED)})
    columns = {name: [s.get(name) for s in scenes] for name in names}
    return {name: values for name, values in columns.items() if any(v != values[0] for v in values)}


def figure_of(run, name):
    """A number of the summary, else the last value of a column of the series; None where the run has neither."""
    value = run.summary.get(name)
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return value
    if value is not None and not isinstance(value, (list, dict)):
        return str(value)
    if run.series and name in run.series:
        return float(run.series[name][-1])
    return None


def known_figures(runs):
    names = set()
    for run in runs:
        names.update(k for k, v in run.summary.items() if isinstance(v, (int, float, str)))
        names.update(run.series or ())
    return sorted(names)


def text_of(value):
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return grouped(value)
    if isinstance(value, float) and 1e4 <= abs(value) < 1e15:
        return grouped(round(value))
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def table(runs, links, differ, figures):
    head = ["run", *differ, *figures]
    rows = ["<tr>" + "".join(f"<th{' class=number' if k else ''}>{html.escape(h)}</th>" for k, h in enumerate(head)) + "</tr>"]
    for k, run in enumerate(runs):
        name = html.escape(os.path.basename(os.path.abspath(run.folder)))
        state = "" if run.summary.get("status", "finished") == "finished" and run.summary else " <span class=often>(not finished)</span>"
        cells = [values[k] for values in differ.values()] + [values[k] for values in figures.values()]
        rows.append(f"<tr><td>{f'<a href={chr(34)}{links[k]}{chr(34)}>{name}</a>' if links[k] else name}{state}</td>"
                    + "".join(f"<td class=number>{html.escape(text_of(c))}</td>" for c in cells) + "</tr>")
    return "<div class=scroll><table>" + "".join(rows) + "</table></div>"


def number(value):
    return float(value) if isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value) else None


def abscissa(differ, n):
    """What the sweep sweeps: the first key that is a number of its own in every run; else the order of the runs."""
    for name, values in differ.items():
        numbers = [number(v) for v in values]
        if None not in numbers and len(set(numbers)) == n:
            return name, np.array(numbers)
    return "run, in the order given", np.arange(1, n + 1, dtype=float)


def sweep_plots(runs, differ, figures):
    if len(runs) < 2:
        return []
    name, at = abscissa(differ, len(runs))
    order = np.argsort(at, kind="stable")
    plots = []
    for figure, values in figures.items():
        y = np.array([math.nan if number(v) is None else number(v) for v in values])[order]
        if np.sum(np.isfinite(y)) >= 2 and np.nanmin(y) < np.nanmax(y):
            plots.append(line_plot(at[order], [(figure, y)], figure, name, figure, marks=True))
    return plots


def series_plots(runs, differ):
    """The same column of every run over time."""
    shown = [r for r in runs if r.series and len(r.series["time"]) > 1][:MOST_CURVES]
    if len(shown) < 2:
        return []
    name, at = abscissa(differ, len(runs))
    plots = []
    for column, label in [("kinetic_energy", "energy [J]"), ("coordination_number", "contacts per particle"), ("removed_mass", "mass that left [kg]")]:
        curves, times = [], np.unique(np.concatenate([r.series["time"] for r in shown]))
        for r in shown:
            if column in r.series and np.any(r.series[column] != 0):
                tag = f"{at[runs.index(r)]:g}" if not name.startswith("run,") else os.path.basename(os.path.abspath(r.folder))
                t = r.series["time"]
                y = np.interp(times, t, r.series[column])
                curves.append((tag, np.where((times >= t[0]) & (times <= t[-1]), y, math.nan)))
        plots.append(line_plot(times, curves, f"{column}, {name if not name.startswith('run,') else 'runs'}", "time [s]", label))
    return plots


def index_page(folders, target, chosen=None):
    """Raises UnknownFigure where no run has a chosen figure."""
    runs = [Run(f, with_frames=False) for f in folders]
    for name in chosen or []:
        if all(figure_of(run, name) is None for run in runs):
            known = known_figures(runs)
            raise UnknownFigure(f"no run has the figure '{name}' (there are: {', '.join(known)})" if known else f"no run has the figure '{name}'")
    figures = {name: [figure_of(run, name) for run in runs] for name in chosen or FIGURES}
    figures = {name: values for name, values in figures.items() if chosen or any(v not in (None, 0) for v in values)}
    differ = varied(runs)
    base = os.path.dirname(os.path.abspath(target))
    links = []
    for run in runs:
        report = os.path.join(run.folder, "report.html")
        links.append(quote(os.path.relpath(report, base)) if os.path.exists(report) else "")
    notes = [f"{os.path.basename(os.path.abspath(run.folder))}: {'; '.join(run.notes)}" for run in runs if run.notes]
    titles = sorted({run.title() for run in runs})
    title = titles[0] if len(titles) == 1 else os.path.commonprefix(titles).rstrip(" ,:-") or "Runs"
    title = re.sub(r"\s+", " ", title)
    body = [f"<h1>{html.escape(title)}</h1>", f"<p class=lead>{len(runs)} runs; what differs between their scenes comes first in the table</p>",
            f"<p class=note>{html.escape('. '.join(notes))}.</p>" if notes else "",
            table(runs, links, differ, figures), section("Figures", sweep_plots(runs, differ, figures)),
            section("Series", series_plots(runs, differ))]
    return document(title, body, ["plots.js"])
