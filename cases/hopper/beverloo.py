#!/usr/bin/env python3
"""Discharge rate against notch size: Beverloo's 5/2 power (round notch) and 3/2 power (slot).

Standard library only; runs `talus`. Each seed is filled once behind the gate (beverloo-circle.toml, beverloo-slot.toml)
and settles; every notch size resumes from that checkpoint with another notch in the scene. The rate is the mass through
the plane below the notch per time, over a window:

  from  0.3 s (slot: 0.2 s) after the gate is gone
  to    the end of the run, or the moment when 45 % (slot: 50 %) of the grains have left

The windows were set after a pilot with one seed (0.15 s, 45 %; its slope for the round notch was 2.68), so they are not
blind: the report also prints the range of the slope over other starts and ends.

The slope is the least-squares slope of ln W against ln(D - 1.4 d), d = 5 mm, over all notches and seeds; its 95 %
confidence interval (Student's t) holds the scatter of the seeds and the misfit of the power law. The fit with k free
(exponent fixed at 5/2 or 3/2) is printed beside it. A fixed k is biased over a range of small notches, since dilation
at the notch fades with its size: round notches are also held against

  W = C (1 - exp(-b (D/d - 1)) / 2) (D/d - 1)^(5/2),  b = 0.051     (Mankoc et al., Granular Matter 9 (2007) 407)

with C as the only free number, from 8 d to 20 d (the widest in a wider bin, beverloo-wide.toml). Every run is checked: bed at rest before opening, no grain lost,
nothing on the trays around the jet, rate without drift.

  python3 cases/hopper/beverloo.py                      # all families, 3 seeds, 33 runs
  python3 cases/hopper/beverloo.py --quick              # one seed, short windows: does the chain work?
  python3 cases/hopper/beverloo.py --plan               # the runs, their size, which ones are done; runs nothing
  python3 cases/hopper/beverloo.py --minutes 10         # no new run after ten minutes; call again until it exits with 0 or 1

Finished runs are kept: a second call only does what is missing. A run that was broken off begins again from its
filling. Writes OUT/beverloo.json and OUT/beverloo.svg. Exit code: 0 slopes in range and Mankoc's law met, 1 not, 2 a run
failed or failed a check, 3 runs are left (--minutes).
"""

import argparse
import concurrent.futures
import csv
import hashlib
import json
import math
import os
import shutil
import subprocess
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
DIAMETER, STEP, GRAVITY = 0.005, 2e-5, 9.81
K_FIXED = 1.4
AT_REST = 1e-3                 # mean kinetic energy of a settled grain, in units of m g d
DRIFT = 0.08                   # largest difference between the halves of a window, relative
TOLERANCE = 0.15               # of the slope
MANKOC_B, MANKOC_TOLERANCE = 0.051, 0.03

FAMILIES = {
    # opens: step at which the scene's gate vanishes; length: seconds of discharge for each notch, enough for
    # more than 2000 grains in every window. transient: start of the window after the opening [s]; share: of the grains
    # that have left at its end (the taller bed of the slot may lose more).
    "circle": {
        "scene": "beverloo-circle.toml", "grains": 20000, "notches": [8, 11, 15], "exponent": 2.5, "opens": 22500, "trays": ["tray"],
        "length": {8: 1.30, 11: 0.90, 15: 0.58}, "transient": 0.3, "share": 0.45,
        "notch": lambda w: ["wall.0.radius_end=%.6g" % (w / 2)],
        "title": "round notch",
    },
    "slot": {
        "scene": "beverloo-slot.toml", "grains": 20000, "notches": [8, 11, 15], "exponent": 1.5, "opens": 35000, "trays": ["tray_left", "tray_right"],
        "length": {8: 0.70, 11: 0.55, 15: 0.40}, "transient": 0.2, "share": 0.50,
        "notch": lambda w: ["wall.0.upper=[-%.6g,0.05,0]" % (w / 2), "wall.1.lower=[%.6g,-0.05,-0.02]" % (w / 2)],
        "title": "slot",
    },
    # Two notches only: no slope of its own. 15 d shows what the width of the bin does.
    "wide": {
        "scene": "beverloo-wide.toml", "grains": 56000, "notches": [15, 20], "exponent": None, "opens": 22500,
        "trays": ["tray"], "length": {15: 1.1, 20: 0.75}, "transient": 0.3, "share": 0.45,
        "notch": lambda w: ["wall.0.radius_end=%.6g" % (w / 2)],
        "title": "round notch, wide bin",
    },
}
# Student's t, two-sided 95 %, by degrees of freedom.
T95 = [math.inf, 12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145,
       2.131, 2.120, 2.110, 2.101, 2.093, 2.086]


class Failed(Exception):
    pass


class Left(Exception):
    """The time of --minutes is over before this run."""


def t95(degrees):
    return T95[degrees] if degrees < len(T95) else 1.96 + 2.4 / degrees


def run(args, folder, scene, steps, sets, resume=None):
    """`talus run` unless the folder already holds exactly this run, finished."""
    command = [args.talus, "run", os.path.join(HERE, scene), "--out", folder, "--overwrite", "--quiet", "--steps",
               str(steps), "--threads", str(args.threads)]
    for item in sets:
        command += ["--set", item]
    if resume:
        command += ["--resume", resume]
    # The key names everything that determines the result: scene text, overrides, steps, and the state it started from.
    key = hashlib.sha256()
    with open(os.path.join(HERE, scene), "rb") as f:
        key.update(f.read())
    key.update("\n".join(sets + [str(steps)]).encode())
    if resume:
        with open(resume, "rb") as f:
            key.update(f.read())
    stamp = os.path.join(folder, "study.key")
    try:
        with open(stamp) as f:
            if f.read() == key.hexdigest():
                return False
    except OSError:
        pass
    if args.until is not None and time.monotonic() > args.until:
        raise Left()
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode != 0:
        raise Failed("%s: exit code %d\n%s" % (" ".join(command), done.returncode, done.stdout))
    with open(stamp, "w") as f:
        f.write(key.hexdigest())
    return True


def series(folder):
    with open(os.path.join(folder, "series.csv"), newline="") as f:
        rows = list(csv.DictReader(f))
    return {name: [float(row[name]) for row in rows] for name in rows[0]}


def fill(args, family, seed):
    spec = FAMILIES[family]
    folder = os.path.join(args.out, "%s-fill-%d" % (family, seed))
    fresh = run(args, folder, spec["scene"], spec["opens"], ["seed=%d" % seed])
    s = series(folder)
    with open(os.path.join(folder, "summary.json")) as f:
        wall = json.load(f)["wall_s"]
    weight = mean_mass() * GRAVITY * DIAMETER
    grains = spec["grains"]
    rest = s["kinetic_energy"][-1] / (grains * weight)
    print("  fill  %-6s seed %d: kinetic energy per grain %.1e m g d%s" % (family, seed, rest, timing(fresh, wall)),
          flush=True)
    if not rest < AT_REST:
        raise Failed("%s is not at rest: %.2e m g d per grain, %.0e allowed" % (folder, rest, AT_REST))
    if s["particles"][-1] != grains:
        raise Failed("%s holds %d grains, not %d" % (folder, s["particles"][-1], grains))
    return {"family": family, "seed": seed, "at_rest": rest, "wall_s": wall,
            "checkpoint": os.path.join(folder, "checkpoint-%d.tcp" % spec["opens"])}


def mean_mass():
    """Uniform diameters from 4 to 6 mm at 2500 kg/m3: the mean cube is (b^4 - a^4) / 4 (b - a)."""
    return 2500 * math.pi / 6 * (0.006 ** 4 - 0.004 ** 4) / (4 * 0.002)


def timing(fresh, wall):
    return ", %.0f s" % wall if fresh else ", kept from an earlier call"


def discharge(args, filled, notch):
    family, seed = filled["family"], filled["seed"]
    spec = FAMILIES[family]
    folder = os.path.join(args.out, "%s-%g-%d" % (family, notch, seed))
    steps = spec["opens"] + steps_of(args, family, notch)
    fresh = run(args, folder, spec["scene"], steps, ["seed=%d" % seed] + spec["notch"](notch * DIAMETER),
                filled["checkpoint"])
    s = series(folder)
    with open(os.path.join(folder, "summary.json")) as f:
        wall = json.load(f)["wall_s"]
    result = measure(family, notch, s, folder)
    result.update(family=family, seed=seed, notch=notch, wall_s=wall, folder=folder)
    print("  %-6s seed %d, %4g d: %7.0f grains/s, %.4f kg/s, halves %+.1f %%, window %.2f s%s" %
          (family, seed, notch, result["grains_per_s"], result["rate"], 100 * result["drift"], result["window"],
           timing(fresh, wall)), flush=True)
    return result


def measure(family, notch, s, folder):
    spec = FAMILIES[family]
    grains = spec["grains"]
    time, mass, number = s["time"], s["plane.notch.mass"], s["plane.notch.particles"]
    opened = spec["opens"] * STEP
    # Mass balance: every grain is in the domain or was counted out, and what left went through the notch.
    for n, present, removed in zip(number, s["particles"], s["removed"]):
        if present + removed != grains or removed > n:
            raise Failed("%s: %d grains present, %d removed, %d through the notch, %d in all" %
                         (folder, present, removed, n, grains))
    for tray in spec["trays"]:
        if any(s["wall.%s.force_%s" % (tray, axis)][i] != 0 for axis in "xyz" for i in range(len(time))):
            raise Failed("%s: a grain fell on the %s: it leaked through a wall, or the jet is too wide" % (folder, tray))
    inside = [i for i in range(len(time)) if time[i] > opened + spec["transient"] - 1e-9 and number[i] <= spec["share"] * grains]
    if len(inside) < 5:
        raise Failed("%s: only %d rows in the window" % (folder, len(inside)))
    a, b = inside[0], inside[-1]
    middle = inside[len(inside) // 2]

    def slope(column, i, j):
        return (column[j] - column[i]) / (time[j] - time[i])

    rate = slope(mass, a, b)
    drift = (slope(mass, middle, b) - slope(mass, a, middle)) / rate
    return {"rate": rate, "grains_per_s": slope(number, a, b), "drift": drift, "window": time[b] - time[a],
            "grains_in_window": number[b] - number[a], "steady": abs(drift) <= DRIFT}


def line(x, y):
    """Least squares y = a + b x: (a, b, half width of the 95 % interval of b, residual standard deviation)."""
    n = len(x)
    mx, my = sum(x) / n, sum(y) / n
    sxx = sum((v - mx) ** 2 for v in x)
    b = sum((v - mx) * (w - my) for v, w in zip(x, y)) / sxx
    a = my - b * mx
    if n < 3:
        return a, b, math.inf, math.inf
    sigma = math.sqrt(sum((w - a - b * v) ** 2 for v, w in zip(x, y)) / (n - 2))
    return a, b, t95(n - 2) * sigma / math.sqrt(sxx), sigma


def interval(values):
    n = len(values)
    mean = sum(values) / n
    if n < 2:
        return mean, math.inf
    sd = math.sqrt(sum((v - mean) ** 2 for v in values) / (n - 1))
    return mean, t95(n - 1) * sd / math.sqrt(n)


def free_k(results, exponent):
    """W^(1/exponent) = c (D/d - k) is a straight line: k from its intercept."""
    a, b, _, _ = line([r["notch"] for r in results], [r["rate"] ** (1 / exponent) for r in results])
    return -a / b


def evaluate(family, results):
    exponent = FAMILIES[family]["exponent"]

    def slope(some, k=K_FIXED):
        return line([math.log((r["notch"] - k) * DIAMETER) for r in some], [math.log(r["rate"]) for r in some])

    intercept, b, half, sigma = slope(results)
    seeds = sorted({r["seed"] for r in results})
    by_seed = [[r for r in results if r["seed"] == seed] for seed in seeds]
    slopes = [slope(group)[1] for group in by_seed]
    k = free_k(results, exponent)
    _, k_half = interval([free_k(group, exponent) for group in by_seed])
    return {"family": family, "expected": exponent, "slope": b, "half_width": half, "intercept": intercept,
            "residual": sigma, "slopes_by_seed": slopes, "half_width_seeds": interval(slopes)[1], "k_free": k,
            "k_half_width": k_half, "in_range": abs(b - exponent) <= TOLERANCE,
            "steady": all(r["steady"] for r in results)}


def mankoc(results):
    """C of Mankoc's law from all round notches (mean of ln C), and the mean rate over the law for each (family, notch)."""
    law = lambda n: (1 - 0.5 * math.exp(-MANKOC_B * (n - 1))) * (n - 1) ** 2.5
    some = [r for r in results if r["family"] != "slot"]
    points = sorted({(r["family"], r["notch"]) for r in some})
    mean = {p: sum(r["rate"] for r in some if (r["family"], r["notch"]) == p) /
            sum((r["family"], r["notch"]) == p for r in some) for p in points}
    c = math.exp(sum(math.log(mean[p] / law(p[1])) for p in points) / len(points))
    ratios = [{"family": f, "notch": n, "rate": mean[f, n], "ratio": mean[f, n] / (c * law(n))} for f, n in points]
    return {"c": c, "ratios": ratios, "in_range": all(abs(q["ratio"] - 1) <= MANKOC_TOLERANCE for q in ratios)}


def other_windows(fit, results):
    """Slopes of the same runs with the window's start from 0.1 s to 0.3 s and its end from 40 % to 50 %: (low, high)."""
    spec, slopes = FAMILIES[fit["family"]], []
    chosen = spec["transient"], spec["share"]
    for start in (0.1, 0.15, 0.2, 0.25, 0.3):
        for share in (0.4, 0.45, 0.5):
            spec["transient"], spec["share"] = start, share
            try:
                again = [dict(r, **measure(r["family"], r["notch"], series(r["folder"]), r["folder"])) for r in results]
            except Failed:
                continue  # too few rows: the widest slot has lost that share before the window begins
            slopes.append(evaluate(fit["family"], again)["slope"])
    spec["transient"], spec["share"] = chosen
    return [min(slopes), max(slopes)] if slopes else [fit["slope"], fit["slope"]]


def number_or_none(x):
    return None if isinstance(x, float) and not math.isfinite(x) else x


def report(fits, results):
    for fit in fits:
        family, some = fit["family"], [r for r in results if r["family"] == fit["family"]]
        print("\n%s: W [kg/s]" % FAMILIES[family]["title"])
        notches, seeds = sorted({r["notch"] for r in some}), sorted({r["seed"] for r in some})
        print("  D/d   " + "".join("  seed %-4d" % s for s in seeds) + "  mean     95 %      C W / law")
        for notch in notches:
            rates = [r["rate"] for s in seeds for r in some if r["seed"] == s and r["notch"] == notch]
            mean, half = interval(rates)
            law = math.exp(fit["intercept"]) * ((notch - K_FIXED) * DIAMETER) ** fit["slope"]
            print("  %-5g " % notch + "".join("  %-9.4f" % r for r in rates) +
                  "  %-7.4f  +/- %-6s %.3f" % (mean, "%.4f" % half if math.isfinite(half) else "-", mean / law))
        print("  slope of ln W against ln(D - %.1f d): %.3f +/- %s (95 %%, %d points); by seed %s" %
              (K_FIXED, fit["slope"], "%.3f" % fit["half_width"] if math.isfinite(fit["half_width"]) else "-", len(some),
               ", ".join("%.3f" % v for v in fit["slopes_by_seed"])))
        print("  slope over other windows (from 0.1 to 0.3 s, to 40 to 50 %%): %.3f to %.3f" % tuple(fit["other_windows"]))
        print("  k with the exponent fixed at %.1f:      %.2f +/- %s" %
              (fit["expected"], fit["k_free"],
               "%.2f" % fit["k_half_width"] if math.isfinite(fit["k_half_width"]) else "-"))
        reach = abs(fit["slope"] - fit["expected"]) + fit["half_width"]
        print("  %s: slope %s %.1f +/- %.2f, its interval %s; rates %s" %
              ("PASS" if fit["in_range"] else "FAIL", "within" if fit["in_range"] else "outside", fit["expected"],
               TOLERANCE, "too" if reach <= TOLERANCE and fit["in_range"] else "not",
               "steady" if fit["steady"] else "NOT steady: halves of a window differ by more than %.0f %%" %
               (100 * DRIFT)))


def report_mankoc(fit):
    print("\nRound notches against Mankoc's law, C = %.4g kg/s" % fit["c"])
    for q in fit["ratios"]:
        print("  %-22s %4g d: W = %.4f kg/s, W / law = %.3f" %
              (FAMILIES[q["family"]]["title"], q["notch"], q["rate"], q["ratio"]))
    print("  %s: every notch within %.0f %% of the law" % ("PASS" if fit["in_range"] else "FAIL", 100 * MANKOC_TOLERANCE))


def plot(path, fits, results):
    """Log-log picture: rates of all seeds and the fitted lines."""
    width, height, left, top, bottom = 640, 440, 70, 30, 390
    x_low, x_high = math.log(0.025), math.log(0.09)
    y_all = [r["rate"] for r in results]
    y_low, y_high = math.log(min(y_all) * 0.7), math.log(max(y_all) * 1.4)

    def px(x):
        return left + (x - x_low) / (x_high - x_low) * (width - left - 20)

    def py(y):
        return bottom - (y - y_low) / (y_high - y_low) * (bottom - top)

    out = ['<svg xmlns="http://www.w3.org/2000/svg" width="%d" height="%d" font-family="sans-serif" font-size="12">' %
           (width, height), '<rect width="100%" height="100%" fill="white"/>']
    for v in [0.03, 0.04, 0.05, 0.06, 0.07, 0.08]:
        x = px(math.log(v))
        out.append('<path d="M%.1f %d V%d" stroke="#ddd"/><text x="%.1f" y="%d" text-anchor="middle">%.0f</text>' %
                   (x, top, bottom, x, bottom + 16, 1000 * v))
    for decade in range(-3, 3):
        for m in (1, 2, 5):
            v = m * 10.0 ** decade
            if y_low < math.log(v) < y_high:
                y = py(math.log(v))
                out.append('<path d="M%d %.1f H%d" stroke="#ddd"/><text x="%d" y="%.1f" text-anchor="end">%g</text>' %
                           (left, y, width - 20, left - 6, y + 4, v))
    out.append('<text x="%d" y="%d" text-anchor="middle">D - %.1f d [mm]</text>' %
               ((left + width - 20) / 2, height - 12, K_FIXED))
    out.append('<text transform="translate(18,%d) rotate(-90)" text-anchor="middle">W [kg/s]</text>' %
               ((top + bottom) / 2))
    for i, fit in enumerate(fits):
        colour = {"circle": "#1f5fa8", "slot": "#b3541e", "wide": "#2a8f5a"}[fit["family"]]
        some = [r for r in results if r["family"] == fit["family"]]
        ends = [math.log((notch - K_FIXED) * DIAMETER) for notch in (min(r["notch"] for r in some) - 0.5,
                                                                     max(r["notch"] for r in some) + 0.8)]
        out.append('<path d="M%.1f %.1f L%.1f %.1f" stroke="%s" fill="none"/>' %
                   (px(ends[0]), py(fit["intercept"] + fit["slope"] * ends[0]), px(ends[1]),
                    py(fit["intercept"] + fit["slope"] * ends[1]), colour))
        for r in some:
            out.append('<circle cx="%.1f" cy="%.1f" r="4" fill="none" stroke="%s"/>' %
                       (px(math.log((r["notch"] - K_FIXED) * DIAMETER)), py(math.log(r["rate"])), colour))
        half = "%.3f" % fit["half_width"] if math.isfinite(fit["half_width"]) else "?"
        out.append('<text x="%d" y="%d" fill="%s">%s: slope %.3f &#177; %s (law %.1f), k free %.2f</text>' %
                   (left + 10, top + 18 * (i + 1), colour, FAMILIES[fit["family"]]["title"], fit["slope"], half,
                    fit["expected"], fit["k_free"]))
    out.append("</svg>")
    with open(path, "w") as f:
        f.write("\n".join(out) + "\n")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--talus", default=os.path.join(HERE, "..", "..", "build", "talus"),
                        help="the program (default: build/talus of this checkout, else the one on PATH)")
    parser.add_argument("--out", default=os.path.join("results", "beverloo"), help="folder of the runs and the result")
    parser.add_argument("--family", choices=["circle", "slot", "wide", "all"], default="all")
    parser.add_argument("--notches", type=float, nargs="+", help="notch sizes in mean diameters (default: the family's own)")
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3])
    parser.add_argument("--threads", type=int, default=1, help="threads of each run")
    parser.add_argument("--jobs", type=int, default=1, help="runs at a time")
    parser.add_argument("--quick", action="store_true", help="one seed and half the window")
    parser.add_argument("--plan", action="store_true", help="list the runs and which of them are done, run nothing")
    parser.add_argument("--minutes", type=float, help="start no run after this time")
    args = parser.parse_args()
    args.until = None if args.minutes is None else time.monotonic() + 60 * args.minutes
    if not os.path.exists(args.talus):
        args.talus = shutil.which("talus") or parser.error("no %s: build Talus first, or name it by --talus" % args.talus)
    if args.quick:
        args.seeds, args.out = args.seeds[:1], args.out + "-quick"
    if args.notches and (len(set(args.notches)) < 2 or min(args.notches) <= 2):
        parser.error("at least two notch sizes above 2 mean diameters")
    return args


def steps_of(args, family, notch):
    spec = FAMILIES[family]
    length = spec["length"].get(notch, max(spec["length"].values()))
    if args.quick:
        length = spec["transient"] + 0.5 * (length - spec["transient"])
    return round(length / STEP)


def plan(args, families):
    """Runs in their order with their particle-steps (a discharge with all grains: an upper bound) and state."""
    total = 0
    for family in families:
        spec = FAMILIES[family]
        for seed in args.seeds:
            todo = [("%s-fill-%d" % (family, seed), spec["opens"])]
            todo += [("%s-%g-%d" % (family, n, seed), steps_of(args, family, n)) for n in args.notches or spec["notches"]]
            for name, steps in todo:
                done = os.path.exists(os.path.join(args.out, name, "study.key"))
                total += 0 if done else steps * spec["grains"]
                print("  %-14s %6d steps of %d grains, at most %.1e particle-steps%s" %
                      (name, steps, spec["grains"], steps * spec["grains"], ", done" if done else ""))
    print("left: at most %.1e particle-steps, %.0f core-minutes at 20 million a second" % (total, total / 20e6 / 60))
    return 0


def finished(jobs):
    """Results of all, after the last one has ended."""
    concurrent.futures.wait(jobs)
    return [f.result() for f in jobs]


def main():
    args = arguments()
    families = list(FAMILIES) if args.family == "all" else [args.family]
    if args.plan:
        return plan(args, families)
    os.makedirs(args.out, exist_ok=True)
    try:
        with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
            fills = [pool.submit(fill, args, family, seed) for family in families for seed in args.seeds]
            filled = finished(fills)
            runs = [pool.submit(discharge, args, one, notch) for one in filled
                    for notch in args.notches or FAMILIES[one["family"]]["notches"]]
            results = finished(runs)
    except Left:
        print("Time is over: call again for the runs that are left (--plan lists them)")
        return 3
    except Failed as failure:
        print("beverloo.py: " + str(failure), file=sys.stderr)
        return 2
    fits = [evaluate(family, [r for r in results if r["family"] == family]) for family in families
            if FAMILIES[family]["exponent"]]
    for fit in fits:
        fit["other_windows"] = other_windows(fit, [r for r in results if r["family"] == fit["family"]])
    report(fits, results)
    law = mankoc(results) if families != ["slot"] else None
    if law:
        report_mankoc(law)
    for fit in fits:
        for key in list(fit):
            fit[key] = number_or_none(fit[key])
    text = json.dumps({"diameter": DIAMETER, "k": K_FIXED, "quick": args.quick, "fits": fits, "mankoc": law, "fills": filled, "runs": results},
                      indent=1)
    with open(os.path.join(args.out, "beverloo.json"), "w") as f:
        f.write(text + "\n")
    for fit in fits:
        fit["half_width"] = math.inf if fit["half_width"] is None else fit["half_width"]
    plot(os.path.join(args.out, "beverloo.svg"), fits, results)
    print("\nComputed in %.0f s of runs (sum); results in %s, picture %s" %
          (sum(r["wall_s"] for r in results + filled), os.path.join(args.out, "beverloo.json"),
           os.path.join(args.out, "beverloo.svg")))
    return 0 if all(fit["in_range"] for fit in fits) and (law is None or law["in_range"]) else 1


if __name__ == "__main__":
    sys.exit(main())
