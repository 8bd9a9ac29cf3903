#!/usr/bin/env python3
"""Roofline of the kernels from one run of perf_kernels, or the medians of several.

    build/perf/perf_kernels --benchmark_format=json > kernels.json      (or --benchmark_filter='avx512|core|stream|peak')
    python3 perf/roofline.py kernels.json [more.json ...] [--isa avx512] [--svg roofline.svg]

Prints, per kernel and element (grain, candidate, contact): time, arithmetic, traffic, arithmetic intensity, GFlop/s,
GB/s, and how much of the time three lower bounds explain:
  memory      bytes over the bandwidth that `stream_triad` reached in the same run: out of cache (512k) at the size that
              512k grains occupy, in cache (4k) in L2, the laws (one block, over and over) in L1
  arithmetic  flops over the peak of independent additions and multiplications without FMA (exact mode never fuses)
  division    divisions and square roots over the throughput of the one unit that does both
`share` is the largest of the three over the measured time: 100 % cannot be beaten without doing less. With
--benchmark_repetitions or several files the median counts (several runs are better than repetitions: which physical
pages a run gets decides how well 4k grains fit into L2). Code of core/ (walls, sorting) is not counted in flops.
"""

import argparse
import json
import statistics
import sys

L1, L2, BED, MEMORY = "24KiB", "768KiB", "196608KiB", "1572864KiB"


def read(paths):
    """Median counters per benchmark name."""
    found = {}
    for path in paths:
        try:
            with open(path) as f:
                rows = json.load(f)["benchmarks"]
        except (OSError, ValueError, KeyError) as e:
            sys.exit(f"{path}: not the JSON of perf_kernels ({e}); run it with --benchmark_format=json")
        for row in rows:
            if row.get("error_occurred"):
                sys.exit(f"{path}: {row['name']} failed: {row.get('error_message', '')}")
            if row.get("run_type") == "aggregate" or "ns" not in row:
                continue
            found.setdefault(row["name"].removesuffix("/real_time"), []).append(row)
    return {
        name: {k: statistics.median(r[k] for r in group) for k in group[0] if isinstance(group[0][k], (int, float))}
        for name, group in found.items()
    }


def need(rows, name, what):
    if name not in rows:
        sys.exit(f"the run lacks {name} ({what}): do not filter it away")
    return rows[name]


class Roofs:
    def __init__(self, rows, isa):
        arithmetic = "sse2" if isa == "scalar" else isa  # scalar code has the units of two lanes and uses one
        self.lanes = 0.5 if isa == "scalar" else 1
        self.flop = need(rows, f"peak_arithmetic/{arithmetic}", "roof of arithmetic")["Gflop_s"] * self.lanes
        self.division = need(rows, f"peak_division/{arithmetic}", "roof of division")["ns"]
        self.root = need(rows, f"peak_root/{arithmetic}", "roof of the square root")["ns"]
        self.band = {s: need(rows, f"stream_triad/1t/{s}", "roof of memory")["GB_s"] for s in (L1, L2, BED, MEMORY)}

    def level(self, name):
        return L1 if name.startswith("law_") else BED if name.endswith("512k") else L2

    def bounds(self, name, row):
        """Lower bounds [ns] per element."""
        return {
            "memory": row["bytes"] / self.band[self.level(name)],
            "arithmetic": row.get("flops", 0) / self.flop,
            "division": row.get("divisions", 0) * self.division + row.get("roots", 0) * self.root,
        }


def kernels(rows, isa):
    for name, row in rows.items():
        part = name.split("/")
        if len(part) == 3 and part[1] in (isa, "core") and part[2] in ("4k", "512k"):
            yield name, row


def table(rows, isa, roofs):
    print(f"{'kernel':<52}{'ns':>9}{'cycles':>9}{'bytes':>8}{'flops':>8}{'div+root':>9}{'flop/B':>8}{'GFlop/s':>9}"
          f"{'GB/s':>8}  {'bound':<11}{'share':>6}")
    out = []
    for name, row in kernels(rows, isa):
        bounds = roofs.bounds(name, row)
        kind = max(bounds, key=bounds.get)
        share = bounds[kind] / row["ns"]
        slow = row.get("divisions", 0) + row.get("roots", 0)
        intensity = row.get("flops", 0) / row["bytes"] if row["bytes"] else 0
        known = share > 0
        print(f"{name:<52}{row['ns']:>9.2f}{row['cycles']:>9.1f}{row['bytes']:>8.0f}{row.get('flops', 0):>8.1f}{slow:>9.2f}"
              f"{intensity:>8.2f}{row.get('Gflop_s', 0):>9.2f}{row['GB_s']:>8.2f}  {kind if known else '-':<11}"
              + (f"{100 * share:>5.0f}%" if known else f"{'-':>6}"))
        out.append((name, intensity, row.get("Gflop_s", 0), kind, share))
    return out


def streams(rows):
    print(f"\n{'STREAM, GB/s':<18}" + "".join(f"{s:>14}" for s in (L1, L2, BED, MEMORY)))
    for loop in ("copy", "scale", "add", "triad", "copy_around"):
        for threads in ("1t", "2t"):
            values = [rows.get(f"stream_{loop}/{threads}/{s}") for s in (L1, L2, BED, MEMORY)]
            if any(values):
                print(f"{loop + ', ' + threads:<18}" + "".join(f"{v['GB_s']:>14.1f}" if v else f"{'-':>14}" for v in values))


def plot(points, roofs, isa, path):
    try:
        import matplotlib
    except ImportError:
        sys.exit("--svg needs python3-matplotlib")
    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "talus"
    import matplotlib.pyplot as plt

    fig, ax = plt.subplots(figsize=(10, 6.5))
    low, high = 0.02, 40.0
    for size, label, style in ((L1, "L1", ":"), (L2, "L2", "--"), (BED, "512k bed", "-.")):
        band = roofs.band[size]
        knee = roofs.flop / band
        ax.plot([low, knee], [low * band, roofs.flop], style, color="0.4", lw=1)
        ax.text(low * 1.1, low * band * 1.15, f"{label} {band:.0f} GB/s", fontsize=8, color="0.3", rotation=36)
    ax.axhline(roofs.flop, color="0.4", lw=1)
    ax.text(high * 0.95, roofs.flop * 1.05, f"add and mul, no FMA: {roofs.flop:.0f} GFlop/s", fontsize=8, ha="right")
    division = 1 / roofs.division
    ax.axhline(division, color="0.7", lw=1)
    ax.text(high * 0.95, division * 1.05, f"divisions alone: {division:.1f} G/s", fontsize=8, ha="right", color="0.5")
    colours = {"4k": "tab:blue", "512k": "tab:red"}
    seen = set()
    for name, x, y, _, share in points:
        if x <= 0 or y <= 0 or "_multi" in name or "_energy" in name:
            continue
        kernel, _, size = name.split("/")
        law = kernel.startswith("law_")
        label = "one block in L1" if law else ("4k grains, in cache" if size == "4k" else "512k grains, out of cache")
        colour = "tab:green" if law else colours[size]
        ax.plot(x, y, "o", color=colour, ms=5, label=None if label in seen else label)
        seen.add(label)
        ax.annotate(f"{kernel} {100 * share:.0f}%", (x, y), fontsize=7, xytext=(4, 3), textcoords="offset points")
    ax.set(xscale="log", yscale="log", xlim=(low, high), ylim=(0.2, roofs.flop * 2), xlabel="flops per byte",
           ylabel="GFlop/s", title=f"Talus kernels, {isa}, one core (percent: share of the tightest bound)")
    ax.legend(loc="lower right", fontsize=8)
    ax.grid(True, which="both", lw=0.3)
    fig.tight_layout()
    fig.savefig(path, metadata={"Date": None})
    print(f"\n{path}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("json", nargs="+", help="output of perf_kernels --benchmark_format=json")
    parser.add_argument("--isa", choices=("avx512", "avx2", "sse2", "scalar"), help="default: the best in the file")
    parser.add_argument("--svg", help="file to draw to")
    args = parser.parse_args()
    rows = read(args.json)
    isa = args.isa or next((i for i in ("avx512", "avx2", "sse2", "scalar") if f"step/{i}/4k" in rows), None)
    if isa is None or not any(kernels(rows, isa)):
        sys.exit(f"{' '.join(args.json)}: no kernels of {isa or 'any instruction set'}")
    roofs = Roofs(rows, isa)
    points = table(rows, isa, roofs)
    streams(rows)
    print(f"\nroofs, {isa}: {roofs.flop:.1f} GFlop/s without FMA; a division {roofs.division:.3f} ns, a root "
          f"{roofs.root:.3f} ns per lane; triad L1 {roofs.band[L1]:.0f}, L2 {roofs.band[L2]:.0f}, 512k bed "
          f"{roofs.band[BED]:.1f}, memory {roofs.band[MEMORY]:.1f} GB/s")
    if args.svg:
        plot(points, roofs, isa, args.svg)


if __name__ == "__main__":
    main()
