#!/usr/bin/env python3
"""Speed of Talus over particles, threads, instruction sets and K: tables, JSON and plots.

  python3 perf/scaling.py                               # all four sweeps on the settled bed
  python3 perf/scaling.py --sweeps threads --threads 1,2,4,8 --sizes 32000,128000 --rounds 9
  python3 perf/scaling.py --out build/scaling           # scaling.json, scaling.png, scaling.svg
  python3 perf/scaling.py --pair                        # two threads against two independent processes run at once, 32k and 128k

Sweeps: sizes (one thread), threads (strong: fixed size; weak: fixed grains per thread), isa, k
(on the flowing chute32: a bed at rest lives on the skin's floor, whatever K is).
Every round runs all points of a sweep once, so that slow minutes hit all alike; medians and spreads are shown. The state is the
committed bed, cut (below 32k) or tiled; start-up and the first 200 steps are left out, rebuilds are included.
Needs python3-numpy; plots need python3-matplotlib.
"""
import argparse
import json
import os
import subprocess
import sys

import numpy as np

import states

ROOT = os.path.dirname(states.HERE)
TILES = {4000: None, 8000: None, 16000: None, 32000: (1, 1), 64000: (1, 2), 128000: (2, 2), 256000: (2, 4), 512000: (4, 4),
         1024000: (4, 8), 2048000: (8, 8), 10240000: (16, 20)}
CUTS = {4000: (0.5, 0.25), 8000: (0.5, 0.5), 16000: (0.5, 1)}  # periodic seams of a cut bed open or overlap a little


def bed(size):
    """CSV file and box of a bed of about `size` grains."""
    path = os.path.join(states.FOLDER, f"bed{size}.csv.gz")
    if TILES[size]:
        nx, ny = TILES[size]
        box = [40.0 * nx, 20.0 * ny, 45.0]
    else:
        fx, fy = CUTS[size]
        box = [40.0 * fx, 20.0 * fy, 45.0]
    if not os.path.exists(path):
        if TILES[size]:
            state, _ = states.tiled("settle32", nx, ny)
        else:
            state = states.committed("settle32")
            state = state[(state[:, 0] < box[0]) & (state[:, 1] < box[1])]
            state = drop_seam_overlaps(state, box)
        states.write_csv(path, state)
    return path, box


def drop_seam_overlaps(state, box):
    """A cut brings strangers together across the new periodic seam: of each overlapping pair the later grain goes."""
    x, r = state[:, :3], state[:, 3]
    near = np.nonzero((x[:, 0] < 1) | (x[:, 0] > box[0] - 1) | (x[:, 1] < 1) | (x[:, 1] > box[1] - 1))[0]
    gone = np.zeros(len(state), bool)
    for q, i in enumerate(near):
        if gone[i]:
            continue
        others = near[q + 1:]
        d = x[others] - x[i]
        d[:, :2] -= np.rint(d[:, :2] / box[:2]) * box[:2]
        gone[others[(d * d).sum(1) < (0.99 * (r[others] + r[i])) ** 2]] = True
    return state[~gone]


def start(args, size, threads=1, isa=None, k=None, scene="settle32", steps=None, cores=None, number=0):
    """Starts one timed run; finish() waits for it."""
    path, box = bed(size) if scene == "settle32" else (states.csv_path(scene), states.BED_BOX[1])
    steps = steps or max(args.min_steps, int(args.work / size) * threads)
    cores = cores or [args.first_core + c for c in range(threads)]
    command = ["taskset", "-c", ",".join(map(str, cores)), args.talus, "run",
               os.path.join(states.HERE, "scenes", scene + ".toml"), "--threads", str(threads), "--warm", "200", "--steps",
               str(200 + steps), "--quiet", "--json", "--overwrite", "--out", os.path.join(args.out, f"run{number}"), "--set",
               f"source.0.file={path}", "--set", f"domain.upper=[{box[0]}, {box[1]}, {box[2]}]"]
    if isa:
        command += ["--isa", isa]
    if k is not None:
        command += ["--verlet-k", str(k)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def finish(process):
    """particle-steps/s and facts of a run."""
    out, errors = process.communicate()
    if process.returncode != 0:
        raise SystemExit(f"scaling.py: {' '.join(process.args)}\n{errors}")
    summary = json.loads(out)
    return {"rate": summary["particle_steps_per_s"], "rebuilds": 1000 * summary["rebuilds"] / summary["steps"],
            "bytes": summary["bytes_per_particle"], "particles": summary["particles"], "isa": summary["isa"]}


def run(args, size, **keywords):
    return finish(start(args, size, **keywords))


def pair(args, sizes):
    """Two threads against the summed rate of two independent one-thread processes that run at the same time, one per core: the
    same cores, caches and memory, so that only what the threads do to each other counts. Rounds are interleaved."""
    cores = [args.first_core, args.first_core + 1]
    rng = np.random.default_rng(1)
    rows = []
    rounds = {size: [] for size in sizes}
    if args.append:
        with open(os.path.join(args.out, "pair.json")) as f:
            rounds = {row["size"]: [tuple(v) for v in row["rounds"]] for row in json.load(f)["pair"] if row["size"] in sizes}
        for size in sizes:
            rounds.setdefault(size, [])
    for r in range(args.rounds):
        for size in sizes:
            steps = max(args.min_steps, int(args.work / size))
            threads = run(args, size, threads=2, steps=2 * steps, cores=cores)["rate"]
            both = [start(args, size, steps=steps, cores=[c], number=k) for k, c in enumerate(cores)]
            copies = sum(finish(p)["rate"] for p in both)
            rounds[size].append((threads, copies))
        print(f"  pair: round {r + 1}/{args.rounds}", file=sys.stderr)
    print(f"\ntwo threads against two independent processes at the same time (interleaved rounds, cores {cores})\n"
          f"{'':<12} {'2 threads':>10} {'2 processes':>12}   ratio (95 % of the median)   rounds   >= 0.95")
    for size, values in rounds.items():
        values = np.array(values)
        ratios = values[:, 0] / values[:, 1]
        medians = np.median(ratios[rng.integers(0, len(ratios), (4000, len(ratios)))], axis=1)
        low, high = np.percentile(medians, [2.5, 97.5])
        row = {"size": size, "ratio": float(np.median(ratios)), "low": float(low), "high": float(high), "rounds": values.tolist()}
        rows.append(row)
        print(f"N = {size:<8} {np.median(values[:, 0]) / 1e6:>8.2f} M {np.median(values[:, 1]) / 1e6:>10.2f} M   {row['ratio']:.3f}  "
              f"({low:.3f} ... {high:.3f})            {len(values):>4}   {'holds' if row['ratio'] >= 0.95 else 'DOES NOT HOLD'}")
    return rows


def sweep(args, name, points):
    """points: label -> keyword arguments of run(). Interleaved rounds."""
    collected = {label: [] for label in points}
    for r in range(args.rounds):
        for label, keywords in points.items():
            collected[label].append(run(args, **keywords))
        print(f"  {name}: round {r + 1}/{args.rounds}", file=sys.stderr)
    rows = []
    for label, runs in collected.items():
        rates = np.array([q["rate"] for q in runs])
        rows.append({"label": label, **points[label], "median": float(np.median(rates)),
                     "spread": float((rates.max() - rates.min()) / np.median(rates)), "rates": rates.tolist(),
                     "rebuilds_per_1000": runs[-1]["rebuilds"], "bytes_per_particle": runs[-1]["bytes"],
                     "particles": runs[-1]["particles"]})
    return rows


def print_table(name, rows, extra=None):
    print(f"\n{name}\n{'':<16} {'M p-steps/s':>11} {'spread':>7} {'ns/p-step':>10} {'rebuilds/1000':>13} {'B/particle':>10}"
          + (f"  {extra[0]}" if extra else ""))
    for r in rows:
        print(f"{r['label']:<16} {r['median'] / 1e6:>11.2f} {100 * r['spread']:>6.1f}% {1e9 / r['median']:>10.1f} "
              f"{r['rebuilds_per_1000']:>13.1f} {r['bytes_per_particle']:>10.0f}" + (f"  {extra[1](r)}" if extra else ""))


def isas(talus):
    """Instruction sets that run here, widest first: those that `talus run` accepts."""
    found = []
    for isa in ("avx512", "avx2", "sse2", "scalar"):
        check = subprocess.run([talus, "check", os.path.join(states.HERE, "scenes", "settle32.toml"), "--isa", isa, "--json"],
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
        if check.returncode == 0:
            found.append(isa)
    return found


def plot(out, results):
    try:
        import matplotlib
    except ImportError:
        print("no plots: python3-matplotlib is missing", file=sys.stderr)
        return
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    figure, axes = plt.subplots(2, 2, figsize=(10, 7.5), constrained_layout=True)
    axes = dict(zip(("sizes", "threads", "isa", "k"), axes.flat))
    for axis in axes.values():
        axis.set_ylabel("million particle-steps/s")
        axis.grid(alpha=0.3)

    def line(axis, rows, x, label=None):
        rates = [np.array(r["rates"]) / 1e6 for r in rows]
        median = [np.median(r) for r in rates]
        bars = [[m - r.min() for m, r in zip(median, rates)], [r.max() - m for m, r in zip(median, rates)]]
        axis.errorbar([x(r) for r in rows], median, yerr=bars, marker="o", capsize=3, label=label)

    if "sizes" in results:
        line(axes["sizes"], results["sizes"], lambda r: r["particles"])
        axes["sizes"].set_xscale("log")
        axes["sizes"].set_xlabel("particles (one thread)")
    for kind in ("strong", "weak"):
        groups = {}
        for r in results.get(kind, []):
            groups.setdefault(r["group"], []).append(r)
        for group, rows in groups.items():
            line(axes["threads"], rows, lambda r: r["threads"], f"{kind} {group}")
        if groups:
            axes["threads"].legend()
    axes["threads"].set_xlabel("threads")
    if "isa" in results:
        rows = results["isa"]
        axes["isa"].bar([r["label"] for r in rows], [r["median"] / 1e6 for r in rows])
    axes["isa"].set_xlabel("instruction set (one thread)")
    if "k" in results:
        line(axes["k"], results["k"], lambda r: max(r["k"], 0.5))
        axes["k"].set_xscale("log")
    axes["k"].set_xlabel("K of the skin, chute32 (0 drawn at 0.5)")
    axes["sizes"].set_ylim(bottom=0)
    axes["threads"].set_ylim(bottom=0)
    for kind in ("png", "svg"):
        figure.savefig(os.path.join(out, "scaling." + kind), dpi=120)
    print(f"\nplots: {out}/scaling.png, scaling.svg")


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    numbers = lambda text: [int(v) for v in text.split(",")]
    p.add_argument("--talus", default=os.path.join(ROOT, "build", "talus"))
    p.add_argument("--sweeps", default="sizes,threads,isa,k")
    p.add_argument("--sizes", type=numbers, help="of the sweep (default 4000 ... 512000) or of --pair; from "
                   + ", ".join(str(s) for s in TILES))
    p.add_argument("--threads", type=numbers, help="default: powers of two up to the cores of this machine")
    p.add_argument("--strong-size", type=int, default=128000)
    p.add_argument("--weak-size", type=int, default=32000, help="grains per thread")
    p.add_argument("--ks", type=numbers, default=[0, 10, 50, 100, 200, 500, 1000, 2000])
    p.add_argument("--rounds", type=int, help="default: 5, 15 with --pair")
    p.add_argument("--pair", action="store_true", help="only: two threads against two processes (default sizes 32000,128000)")
    p.add_argument("--append", action="store_true", help="with --pair: add the rounds to those of the last call (pair.json in --out)")
    p.add_argument("--work", type=float, default=64e6, help="particle-steps per timed run and thread")
    p.add_argument("--min-steps", type=int, default=200)
    p.add_argument("--first-core", type=int, default=0)
    p.add_argument("--out", default=os.path.join(ROOT, "build", "scaling"))
    args = p.parse_args()
    args.talus, args.out = os.path.abspath(args.talus), os.path.abspath(args.out)
    args.rounds = args.rounds or (15 if args.pair else 5)
    args.sizes = args.sizes or ([32000, 128000] if args.pair else [s for s in TILES if s <= 512000])
    if any(s not in TILES for s in args.sizes + [args.strong_size, args.weak_size]):
        p.error("sizes are " + ", ".join(str(s) for s in TILES))
    os.makedirs(args.out, exist_ok=True)
    cpus = os.cpu_count() or 1
    threads = args.threads or [t for t in (1 << b for b in range(10)) if t <= cpus]
    states.csv_path("settle32")
    load = os.getloadavg()[0]
    if load > 0.3 * cpus:
        print(f"warning: load average {load:.1f} on {cpus} cores: these rates are not to be quoted", file=sys.stderr)
    results = {"load_average": load}
    if args.pair:
        if cpus < args.first_core + 2:
            p.error("--pair needs two cores")
        results["pair"] = pair(args, args.sizes)
        with open(os.path.join(args.out, "pair.json"), "w") as f:
            json.dump(results, f, indent=1)
        return
    for name in args.sweeps.split(","):
        if name == "sizes":
            results["sizes"] = sweep(args, name, {f"N = {s}": {"size": s} for s in args.sizes})
            print_table("one thread, over the number of grains", results["sizes"])
        elif name == "threads":
            results["strong"] = sweep(args, "strong", {f"{t} threads": {"size": args.strong_size, "threads": t} for t in threads})
            sizes = {t: args.weak_size * t for t in threads}
            results["weak"] = sweep(args, "weak", {f"{t} threads": {"size": s, "threads": t} for t, s in sizes.items() if s in TILES})
            for kind, text in (("strong", f"N = {args.strong_size}"), ("weak", f"{args.weak_size} per thread")):
                first = results[kind][0]
                for r in results[kind]:
                    r["group"] = text
                    r["efficiency"] = r["median"] * first["threads"] / (first["median"] * r["threads"])
                print_table(f"{kind} scaling, {text}", results[kind], ("efficiency", lambda r: f"{100 * r['efficiency']:.1f} %"))
        elif name == "isa":
            results["isa"] = sweep(args, name, {i: {"size": 32000, "isa": i} for i in isas(args.talus)})
            print_table("instruction sets, one thread, N = 32000", results["isa"])
        elif name == "k":
            results["k"] = sweep(args, name, {f"K = {k}": {"size": 32000, "k": k, "scene": "chute32"} for k in args.ks})
            print_table("K of the skin, one thread, chute32", results["k"])
        else:
            p.error(f"unknown sweep '{name}'")
    with open(os.path.join(args.out, "scaling.json"), "w") as f:
        json.dump(results, f, indent=1)
    plot(args.out, results)


if __name__ == "__main__":
    main()
