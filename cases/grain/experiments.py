#!/usr/bin/env python3
"""Runs the grains of this folder, compares them with what was measured, draws picture.png and prints the table of README.md.

    python3 cases/grain/experiments.py [--talus build/talus]     # exit code 1: an aim is missed that README.md says is met

Measured points are those of the original papers named in the .toml files, as digitised by Caraccio et al., arXiv 2510.17588
(2025), and, for Sadhukhan, a table computed with 60 shells."""
import argparse
import csv
import io
import math
import os
import re
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
# README.md says why; the table of the sphere has itself an error of 0.0011 (sadhukhan_table.py)
MISSED = ("Sadhukhan, sphere, against the computed table", "Lu: points inside the band, mass, core, surface")


def points(times, values):
    return [(float(t), float(v)) for t, v in zip(times.split(), values.split())]


SADHUKHAN = {
    "sphere": {"centre_temperature": points("60 120 180 240 300 360 420 480 600",
                                            "328.1 434.1 518.7 595.2 676.6 726.5 722.4 709.2 692.2"),
               "mass": points("60 120 180 240 300 360 420 480 600",
                              ".9934 .9428 .8142 .6091 .3994 .2988 .2788 .2755 .2747")},
    "cylinder": {"centre_temperature": points("240 360 480 600", "503.1 612.5 714.1 710.8"),
                 "mass": points("240 360 480 600", ".8302 .5268 .3022 .2816")}}
PARK = {"centre_temperature": points("23 56 79 98 130 172 209 260 321 340 391 488 600",
                                     "304 332 387 446 503 542 596 616 647 787 764 751 748"),
        "half_radius_temperature": points("23 37 69 78 97 120 148 185 245 282 305 337 388 489",
                                          "350 399 443 479 527 558 584 623 653 687 715 754 759 751")}
HUANG = {"mass": points("19 51 94 126 149 176 196 218 238 261 306 339",
                        ".985 .960 .910 .848 .785 .667 .568 .450 .351 .260 .212 .208"),
         "centre_temperature": points("20 50 80 100 129 150 180 200 220 240 260 280 299 360",
                                      "301 331 377 380 389 401 488 541 594 654 673 697 806 812"),
         "surface_temperature": points("20 50 80 100 129 150 180 200 220 240 260 280 299 360",
                                       "529 608 633 653 671 706 746 755 759 762 764 765 767 775"),
         "radius": points("19 60 100 150 200 250 300", ".997 .972 .918 .861 .798 .771 .767")}
LU = {"mass": ("4.9 8.0 11.2 14.4 17.6 20.8 24.0 27.3 30.5 35.3 40.0 45.1 50.5 56.2 62.5 72.6",
               ".920 .805 .719 .626 .526 .461 .368 .319 .258 .207 .145 .099 .063 .028 .023 .008",
               ".917 .837 .777 .659 .577 .496 .433 .376 .307 .242 .174 .130 .083 .050 .037 .008", 0.05),
      "centre_temperature": ("8 14 20 24 30 36 40 44 48 52 56 60 66 70 74 78 84",
                             "297 359 408 456 553 609 640 679 764 875 1097 1403 1412 1476 1539 1521 1289",
                             "297 373 410 457 553 644 742 808 943 1116 1410 1437 1455 1587 1629 1627 1430", 60),
      "surface_temperature": ("4 8 10 12 14 18 22 28 32 36 42 48 54 60 66 72 80",
                              "344 388 624 1128 1391 1420 1472 1573 1578 1551 1546 1580 1504 1406 1452 1285 1292",
                              "356 592 769 889 973 1057 1187 1285 1450 1403 1582 1649 1575 1578 1605 1622 1435", 60)}


def run(talus, name, change=()):
    """The table of a grain file as columns; mass and radius as shares of the first row. A change (key, value) replaces the line of
    the key, (key, None) takes it away, (key + "!", text) puts the text below it."""
    with open(os.path.join(HERE, name + ".toml")) as f:
        text = f.read()
    for key, value in change:
        line = rf"(?m)^{key.rstrip('!')} = .*\n"
        new = "" if value is None else f"{key} = {value}\n"
        text, n = re.subn(line, (lambda m: m.group(0) + value + "\n") if key.endswith("!") else (lambda m: new), text, count=1)
        assert n == 1, key
    path = os.path.join("/tmp", f"talus-{os.getpid()}-{name}.toml")
    try:
        with open(path, "w") as f:
            f.write(text)
        out = subprocess.run([talus, "grain", path], check=True, stdout=subprocess.PIPE, text=True).stdout
    finally:
        os.remove(path)
    rows = list(csv.DictReader(io.StringIO(out)))
    c = {k: [float(r[k]) for r in rows] for k in rows[0]}
    for k in ("mass", "radius"):
        c[k] = [x / c[k][0] for x in c[k]]
    return c


def at(c, name, t):
    x, y = c["time"], c[name]
    for k in range(1, len(x)):
        if t <= x[k]:
            return y[k - 1] + (t - x[k - 1]) / (x[k] - x[k - 1]) * (y[k] - y[k - 1])
    return y[-1]


def errors(c, name, measured):
    return [at(c, name, t) - v for t, v in measured]


def rmse(c, name, measured):
    e = errors(c, name, measured)
    return math.sqrt(sum(x * x for x in e) / len(e))


def inside(c, name, late=0):
    """Points within the band, and all; `late` [s]: were the clock of the measurement late."""
    times, a, b, margin = LU[name]
    n = total = 0
    for (t, x), (_, y) in zip(points(times, a), points(times, b)):
        total += 1
        n += min(x, y) - margin <= at(c, name, max(0, t - late)) <= max(x, y) + margin
    return n, total


def report(c):
    """Prints figure, aim and whether it is met; returns the names of the missed."""
    rows = []
    for shape in ("sphere", "cylinder"):
        d = c["sadhukhan-" + shape]
        T, m = (max(map(abs, errors(d, k, SADHUKHAN[shape][k]))) for k in ("centre_temperature", "mass"))
        rows.append((f"Sadhukhan, {shape}, against the computed table", f"centre {T:.2f} K, mass {m:.4f}", "1 K, 0.001",
                     T <= 1 and m <= 0.001))
    d = c["corbetta"]
    over, when = max((a - b, t) for a, b, t in zip(d["centre_temperature"], d["surface_temperature"], d["time"]))
    rows.append(("Park / Corbetta: core above the surface", f"{over:.0f} K at {when:.0f} s (measured 37 K at 340 s)",
                 "20 to 60 K, 300 to 380 s", 20 <= over <= 60 and 300 <= when <= 380))
    rows.append(("Park / Corbetta: RMSE core, half radius",
                 f"{rmse(d, 'centre_temperature', PARK['centre_temperature']):.0f} K, "
                 f"{rmse(d, 'half_radius_temperature', PARK['half_radius_temperature']):.0f} K", "-", None))
    mass, core, surface, radius = huang(c["huang"])
    rows.append(("Huang: RMSE mass, core, surface, radius", f"{mass:.3f}, {core:.0f} K, {surface:.0f} K, {radius:.3f}",
                 "0.05, 40 K, -, 0.05", mass <= 0.05 and core <= 40 and radius <= 0.05))
    n = [inside(c["lu"], k) for k in LU]
    rows.append(("Lu: points inside the band, mass, core, surface", ", ".join(f"{a} of {b}" for a, b in n), "80 %",
                 sum(a for a, _ in n) >= 0.8 * sum(b for _, b in n)))
    print("| experiment | this grain | aim | met |\n|---|---|---|---|")
    for name, figure, aim, met in rows:
        print(f"| {name} | {figure} | {aim} | {'-' if met is None else 'yes' if met else 'no'} |")
    return [name for name, _, _, met in rows if met is False]


def huang(c):
    return [rmse(c, k, HUANG[k]) for k in ("mass", "centre_temperature", "surface_temperature", "radius")]


def draw(c, path):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    fig, axes = plt.subplots(2, 3, figsize=(13, 7.2))

    def panel(ax, d, curves, title, unit):
        for (name, label, measured), colour in zip(curves, ("C3", "C0", "C2")):
            ax.plot(d["time"], d[name], color=colour, label=label)
            for series in measured:
                ax.plot(*zip(*series), "o", color=colour, ms=3.5, mfc="none")
        ax.set_title(title, fontsize=10)
        ax.set_xlabel("time [s]")
        ax.set_ylabel(unit)
        ax.legend(fontsize=8)

    both = {"time": c["sadhukhan-sphere"]["time"], "s": c["sadhukhan-sphere"]["centre_temperature"],
            "c": c["sadhukhan-cylinder"]["centre_temperature"]}
    panel(axes[0][0], both, [("s", "sphere, centre", [SADHUKHAN["sphere"]["centre_temperature"]]),
                             ("c", "cylinder, centre", [SADHUKHAN["cylinder"]["centre_temperature"]])],
          "Sadhukhan 2009 (points: computed table)", "K")
    panel(axes[0][1], c["corbetta"], [("centre_temperature", "core", [PARK["centre_temperature"]]),
                                      ("half_radius_temperature", "half radius", [PARK["half_radius_temperature"]]),
                                      ("surface_temperature", "surface (given)", [])], "Park 2010, maple 25.4 mm", "K")
    panel(axes[0][2], c["huang"], [("centre_temperature", "core", [HUANG["centre_temperature"]]),
                                   ("surface_temperature", "surface", [HUANG["surface_temperature"]])],
          "Huang, 20 mm, 773 K", "K")
    panel(axes[1][0], c["huang"], [("mass", "mass", [HUANG["mass"]]), ("radius", "radius", [HUANG["radius"]])],
          "Huang, 20 mm, 773 K", "share of the start")
    two = {k: [points(v[0], v[1]), points(v[0], v[2])] for k, v in LU.items()}
    panel(axes[1][1], c["lu"], [("centre_temperature", "core", two["centre_temperature"]),
                                ("surface_temperature", "surface", two["surface_temperature"])],
          "Lu 2008, wet poplar 9.5 mm in air (two runs)", "K")
    panel(axes[1][2], c["lu"], [("mass", "mass", two["mass"])], "Lu 2008", "share of the start")
    fig.tight_layout()
    fig.savefig(path, dpi=75)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--talus", default=os.path.join(HERE, "..", "..", "build", "talus"))
    parser.add_argument("--picture", default=os.path.join(HERE, "picture.png"))
    a = parser.parse_args()
    c = {n: run(a.talus, n) for n in ("sadhukhan-sphere", "sadhukhan-cylinder", "corbetta", "huang", "lu")}
    missed = report(c)
    draw(c, a.picture)
    return int(bool([m for m in missed if m not in MISSED]))


if __name__ == "__main__":
    sys.exit(main())
