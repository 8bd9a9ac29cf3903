#!/usr/bin/env python3
"""How do beds of shaped grains scale beyond this machine? Predicted as perf/schedule.py does it for spheres.

The beds of perf/shapes.py (spheres, rods, ellipsoids; settled ones in build/shapes are used again) run some steps on one thread
with a trace; schedule_model.py replays the durations on more cores. Efficiency = T(1 core, its best chunk) / (cores x T), rebuilds
included at the rate at which they happen. Stated, not measured: the node (250 GB/s, 105 MB of cache per socket of 56 cores), the
cost of stealing and of waking.

Usage: python3 perf/shape_cores.py [--rows 12000] [--settle 0.3] [--simulated 125000] [--cores 2,4,8,16,28] [--write]
"""
import argparse
import json
import os
import sys

import schedule_model as model
import shapes
from page_table import write_table

HERE = os.path.dirname(os.path.abspath(__file__))
WARM, TRACED, RATE = 100, 40, 2000  # steps before the trace, in it, and of the run that counts rebuilds


def record(args, state, chunk, path):
    """Trace of the bed in chunks of `chunk` rows; the least disturbed of the rounds."""
    scene, folder, last = state
    best = None
    for _ in range(args.rounds):
        shapes.run(args, scene, os.path.join(args.out, "run"),
                   ["--resume", folder, "--chunk", str(chunk), "--set", f"sort_every={TRACED // 5}", "--steps", str(last + WARM + TRACED),
                    "--trace", path, "--trace-from", str(last + WARM), "--trace-steps", str(TRACED)])
        now = model.read_trace(path)
        now.facts["sort_every"] = 1000
        if best is None or now.work() < best.work():
            best = now
    return best


def rebuild_interval(args, state):
    scene, folder, last = state
    s = shapes.run(args, scene, os.path.join(args.out, "run"), ["--resume", folder, "--steps", str(last + RATE)])
    return RATE / max(1, s["rebuilds_skin"])


def predict(args, recordings, interval):
    """cores -> (efficiency, chunk, seconds per step)."""
    facts = next(iter(recordings.values())).facts
    memory = model.Memory(facts["bytes"] / facts["particles"], 250e9, 2e6, 105e6, 56)

    def total(rec, cores):
        costs = model.Costs()
        costs.hop, costs.turn, costs.join = rec.hop, rec.turn, rec.join_gap
        return model.simulate(rec, args.simulated, cores, costs, memory, True, interval)["total"]

    one = min(total(r, 1) for r in recordings.values())
    found = {}
    for cores in args.cores:
        seconds, chunk = min((total(r, cores), c) for c, r in recordings.items())
        found[cores] = (one / (cores * seconds), chunk, seconds)
    return found


def main():
    numbers = lambda text: [int(t) for t in text.split(",")]
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--talus", default=os.path.join(HERE, "..", "build", "talus"))
    p.add_argument("--rows", type=int, default=12000)
    p.add_argument("--settle", type=float, default=0.3, help="after the fall of the highest grain [s]")
    p.add_argument("--simulated", type=int, default=125000, help="rows of the simulated beds")
    p.add_argument("--cores", type=numbers, default=[2, 4, 8, 16, 28])
    p.add_argument("--chunks", type=numbers, default=[256, 512, 1024])
    p.add_argument("--rounds", type=int, default=3)
    p.add_argument("--core", type=int, default=0)
    p.add_argument("--out", default=os.path.join(HERE, "..", "build", "shapes"))
    p.add_argument("--write", action="store_true", help="the table on perf/measured/shapes.md")
    args = p.parse_args()
    args.out = os.path.abspath(args.out)
    os.makedirs(args.out, exist_ok=True)
    print(f"load average {os.getloadavg()[0]:.1f}")
    lines = ["| bed | " + " | ".join(f"{c} cores" for c in args.cores) + " | chunk | µs per step |",
             "|---|" + "---|" * (len(args.cores) + 2)]
    for name, bed in shapes.beds(args.rows).items():
        state = shapes.settle(args, name, bed)
        recordings = {c: record(args, state, c, os.path.join(args.out, f"{name}-{c}.trace.json")) for c in args.chunks}
        found = predict(args, recordings, rebuild_interval(args, state))
        _, chunk, seconds = found[max(args.cores)]
        lines.append(f"| {name} | " + " | ".join(f"{100 * found[c][0]:.0f} %" for c in args.cores) + f" | {chunk} | {1e6 * seconds:.0f} |")
        print(json.dumps({"bed": name, "rows": args.simulated, "efficiency": {c: round(v[0], 3) for c, v in found.items()}, "chunk": chunk}))
    print("\n".join(lines))
    if args.write:
        write_table(os.path.join(HERE, "measured", "shapes.md"), "cores", lines)
    return 0


if __name__ == "__main__":
    sys.exit(main())
