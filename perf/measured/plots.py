#!/usr/bin/env python3
"""Draws the plots of the pages in this folder from perf/results/MACHINE/*.csv: python3 perf/measured/plots.py [--machine zen5]."""
import argparse
import csv
import os

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

HERE = os.path.dirname(os.path.abspath(__file__))
COLOURS = ["#1f6f8b", "#d1792a", "#7b8794"]
plt.rcParams.update({"font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "grid.color": "#e9edf2",
                     "axes.axisbelow": True, "svg.hashsalt": "talus", "legend.frameon": False})


def table(machine, name):
    with open(os.path.join(os.path.dirname(HERE), "results", machine, name + ".csv"), newline="", encoding="utf-8") as f:
        return list(csv.DictReader(f))


def number(text):
    return float(text) if text else float("nan")


def bars(axes, rows, label, columns, one):
    """Horizontal bars of ratios, with their intervals; columns: [(column, low, high, legend)]."""
    height = 0.8 / len(columns)
    for k, (column, low, high, legend) in enumerate(columns):
        y = [i + (k - (len(columns) - 1) / 2) * height for i in range(len(rows))]
        x = [number(r[column]) for r in rows]
        error = [[v - number(r.get(low)) if r.get(low) else 0 for v, r in zip(x, rows)],
                 [number(r.get(high)) - v if r.get(high) else 0 for v, r in zip(x, rows)]]
        axes.barh(y, x, 0.92 * height, color=COLOURS[k], label=legend, xerr=error, error_kw={"lw": 1, "ecolor": "#33475e"})
    axes.axvline(1, color="#33475e", lw=0.9)
    axes.set_yticks(range(len(rows)), [r[label] for r in rows])
    axes.invert_yaxis()
    axes.grid(axis="y", visible=False)
    axes.set_xlabel(one)
    axes.legend(loc="lower right", bbox_to_anchor=(1, 1), ncol=len(columns), borderaxespad=0.1)


def save(figure, name):
    figure.savefig(os.path.join(HERE, name), bbox_inches="tight", metadata={"Date": None, "Creator": None})
    plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--machine", default="zen5", help="folder below perf/results")
    machine = parser.parse_args().machine

    figure, axes = plt.subplots(figsize=(7, 3.4))
    bars(axes, table(machine, "peers"), "text", [("lammps", "lammps_low", "lammps_high", "LAMMPS"), ("liggghts", "", "", "LIGGGHTS")],
         "times as fast as, one core, rebuilds included")
    save(figure, "speed.svg")

    figure, axes = plt.subplots(figsize=(7, 3.1))
    bars(axes, table(machine, "auto_k"), "scene", [("best", "best_low", "best_high", "best fixed K"), ("k200", "k200_low", "k200_high", "K = 200")],
         "run time with the automatic K / with")
    axes.set_xlim(0.8, 1.05)
    save(figure, "lists.svg")

    figure, axes = plt.subplots(figsize=(5, 3))
    rows = table(machine, "impacts")
    names = list(rows[0])
    for k, name in enumerate(names[1:]):
        at = [(number(r[names[0]]), number(r[name])) for r in rows if r[name]]
        axes.loglog(*zip(*at), "o-", color=COLOURS[k], label=name)
    axes.set(xlabel=names[0], ylabel="error of non-planar impacts [%]")
    axes.legend()
    save(figure, "errors.svg")


if __name__ == "__main__":
    main()
