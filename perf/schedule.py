#!/usr/bin/env python3
"""Predicts how the step's task graph scales beyond this machine, and checks the prediction where it can be checked.

  python3 perf/schedule.py                                  # record, simulate, check against 1 and 2 threads, plot
  python3 perf/schedule.py --reuse --no-check               # simulate again from the traces in build/schedule
  python3 perf/schedule.py --scene flow --particles 125000,500000 --cores 28,64,112
  python3 perf/schedule.py --mark                           # exit 1 if a mark does not hold

Records traces of `talus run --threads 1` for a few chunk sizes, replays their measured durations on 1 to 112 simulated cores
(schedule_model.py says how) and prints efficiency = T(1 core, its best chunk) / (cores x T), rebuilds and sort epochs included at
the rate at which they happen. Stated, not measured here: the node (bandwidth, caches), the cost of stealing and of waking.
Writes schedule.json, schedule.svg and schedule.png. Needs python3-numpy; plots need python3-matplotlib.
"""
import argparse
import json
import os
import subprocess
import sys

import numpy as np

import scaling
import schedule_model as model
import states

ROOT = os.path.dirname(states.HERE)
MARKS = ((125000, 28, 0.80), (500000, 64, 0.70))  # judged for the chunks that the engine chooses on so many threads
BEDS = {125000: 128000, 500000: 512000}  # the state that it is asked about


def scene_arguments(scene, size):
    """Scene file and --set arguments of a state of about `size` grains."""
    if scene == "settle":
        path, box = scaling.bed(size)
        name = "settle32"
    else:
        tiles = {32000: (1, 1, "chute32"), 128000: (2, 2, "flow128")}
        if size not in tiles:
            raise SystemExit(f"schedule.py: states of the flow have {', '.join(map(str, tiles))} grains")
        nx, ny, name = tiles[size]
        path, box = states.csv_path(name), [40.0 * nx, 20.0 * ny, 45.0]
    return [os.path.join(states.HERE, "scenes", name + ".toml"), "--set", f"source.0.file={path}", "--set",
            f"domain.upper=[{box[0]}, {box[1]}, {box[2]}]"]


def start(args, size, threads, number, extra):
    command = [args.talus, "run"] + scene_arguments(args.scene, size) + [
        "--threads", str(threads), "--quiet", "--json", "--overwrite", "--out", os.path.join(args.out, f"run{number}")] + extra
    if args.isa:
        command += ["--isa", args.isa]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def finish(process):
    out, errors = process.communicate()
    if process.returncode != 0:
        raise SystemExit(f"schedule.py: {' '.join(process.args)}\n{errors}")
    return json.loads(out)


def talus(args, size, extra):
    return finish(start(args, size, 1, 0, extra))


def record(args, size, chunk):
    """Trace of some steps on one thread, with five sort epochs (and the rebuilds in them) among them; kept if it beats the last."""
    path = os.path.join(args.out, f"{args.scene}-{size}-{chunk}.trace.json")
    epoch = max(1, args.steps // 5)
    talus(args, size, ["--chunk", str(chunk), "--steps", str(args.warm + args.steps), "--set", f"sort_every={epoch}", "--trace",
                       path + ".part", "--trace-from", str(args.warm), "--trace-steps", str(args.steps)])
    if not os.path.exists(path) or read(args, path + ".part").work() < read(args, path).work():
        os.replace(path + ".part", path)


def read(args, path):
    try:
        rec = model.read_trace(path)
    except (OSError, model.TraceError, KeyError, ValueError) as e:
        raise SystemExit(f"schedule.py: {e}")
    rec.facts["sort_every"] = args.sort_every
    for name in args.leave_out:
        setattr(rec, name, None)
    return rec


def own_chunk(args, particles, threads):
    """Rows of the chunks that the engine chooses."""
    command = [args.talus, "explain"] + scene_arguments("settle", BEDS[particles]) + ["--threads", str(threads), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"schedule.py: {' '.join(command)}\n{done.stderr}")
    return json.loads(done.stdout)["chunk"]


def recordings_of(args):
    """size -> chunk -> recording. Rounds are interleaved; of each chunk size the least disturbed round stays."""
    missing = []
    for size in args.sizes:
        for chunk in args.chunks:
            path = os.path.join(args.out, f"{args.scene}-{size}-{chunk}.trace.json")
            if not (args.reuse and os.path.exists(path)):
                missing.append((size, chunk))
                if os.path.exists(path):
                    os.remove(path)
    for _ in range(args.record_rounds):
        for size, chunk in missing:
            record(args, size, chunk)
    return {s: {c: read(args, os.path.join(args.out, f"{args.scene}-{s}-{c}.trace.json")) for c in args.chunks} for s in args.sizes}


def rebuild_interval(args, size):
    path = os.path.join(args.out, f"{args.scene}-{size}.rate.json")
    if args.reuse and os.path.exists(path):
        with open(path) as f:
            summary = json.load(f)
    else:
        summary = talus(args, size, ["--steps", str(args.rate_steps)])
        with open(path, "w") as f:
            json.dump(summary, f)
    return summary["steps"] / max(1, summary["rebuilds_skin"])


def measured_check(args, recordings, memory):
    """Real steps on the threads of this machine against the prediction for the same chunk, both without rebuilds: the median
    over the steps of a traced run, so that an interruption of a few steps does not count; rounds are interleaved.
    The speed of a core depends on what its neighbours do (clock, shared caches): t threads are compared with t independent
    one-thread processes at the same time, whose ratio to the recording scales the prediction."""
    rows = []
    size = min(recordings)
    chunk = args.check_chunk or max(recordings[size])
    threads = [t for t in args.check_threads if t <= (os.cpu_count() or 1)]
    together, copies = {t: [] for t in threads}, {t: [] for t in threads}
    run = lambda t, k: start(args, size, t, k, ["--chunk", str(chunk), "--steps", str(args.warm + args.check_steps), "--trace",
                                                os.path.join(args.out, f"check{k}.trace.json"), "--trace-from", str(args.warm),
                                                "--trace-steps", str(args.check_steps)])
    for _ in range(args.rounds):
        for t in threads:
            finish(run(t, 0))
            together[t].append(step_median(args, 0))
            for process in [run(1, k) for k in range(t)]:
                finish(process)
            copies[t].append(float(np.mean([step_median(args, k) for k in range(t)])))
    rec = recordings[size][chunk]
    simulated = lambda t: model.simulate(rec, rec.facts["particles"], t, costs_of(args, rec), memory, args.fan_out == "tree", 1e9)["step"]
    one = simulated(1)
    for t in threads:
        ratio = np.array(copies[t]) / np.array(together[t])
        rows.append({"threads": t, "particles": rec.facts["particles"], "chunk": chunk, "copies": float(np.median(copies[t])),
                     "recorded": one, "predicted": simulated(t) * float(np.median(copies[t])) / one, "predicted_speedup": one / simulated(t),
                     "measured": float(np.median(together[t])), "measured_speedup": float(np.median(ratio)),
                     "low": float(ratio.min()), "high": float(ratio.max()), "rounds": [together[t], copies[t]]})
    return rows


def step_median(args, k):
    return model.median(model.step_times(os.path.join(args.out, f"check{k}.trace.json")))


def costs_of(args, rec):
    c = model.Costs(steal=args.steal * 1e-6, attempt=args.attempt * 1e-6, wake=args.wake * 1e-6)
    c.hop, c.turn, c.join = rec.hop, rec.turn, rec.join_gap
    return c


def nearest(recordings, particles):
    """The recorded size whose cache behaviour is closest: the largest one not above, or the smallest."""
    below = [s for s in recordings if s <= particles * 1.1]
    return recordings[max(below) if below else min(recordings)]


def predict(args, recordings, interval, memory):
    rows = []
    for particles in args.particles:
        by_chunk = nearest(recordings, particles)
        samples = 6 if particles <= 1000000 else 2
        one = {c: model.simulate(r, particles, 1, costs_of(args, r), memory, False, interval, samples) for c, r in by_chunk.items()}
        base = min(one.values(), key=lambda r: r["total"])
        for cores in args.cores:
            for fan_out in args.fan_outs:
                for chunk, rec in by_chunk.items():
                    p = model.simulate(rec, particles, cores, costs_of(args, rec), memory, fan_out == "tree", interval, samples)
                    row = {"particles": particles, "cores": cores, "chunk": chunk, "fan_out": fan_out,
                           "efficiency": base["total"] / (cores * p["total"]), "step_efficiency": base["step"] / (cores * p["step"]),
                           "one_core_step": base["step"], "one_core_total": base["total"], **p}
                    row["limit"] = base["total"] / p["critical_path"]
                    best_rec = by_chunk[min(one, key=lambda c: one[c]["total"])]
                    phase = p["busy_step"] / (cores * p["step"])
                    factor = particles / best_rec.facts["particles"], particles / rec.facts["particles"]
                    row["kinds"] = {k: best_rec.kind_seconds(k) * factor[0] / (rec.kind_seconds(k) * factor[1]) * phase
                                    for k in rec.kinds}
                    for k in ("rebuild", "sort_epoch"):
                        if k in p:
                            row["kinds"][k] = p[k + "_work"] / (cores * p[k])
                    rows.append(row)
    return rows


def best_of(rows, particles, cores, fan_out):
    return max((r for r in rows if r["particles"] == particles and r["cores"] == cores and r["fan_out"] == fan_out),
               key=lambda r: r["efficiency"])


def print_predictions(args, rows):
    for fan_out in args.fan_outs:
        print(f"\npredicted efficiency in %, fan-out: {fan_out} (rebuilds and sort epochs included; b: some chunks wait for memory)")
        chunks = sorted({r["chunk"] for r in rows})
        print(f"{'particles':>10} {'cores':>5} " + " ".join(f"{'chunk ' + str(c):>11}" for c in chunks)
              + f" {'best':>6} {'us/step':>9} {'critical':>9} {'speed-up limit':>14}")
        for particles in args.particles:
            for cores in args.cores:
                line = {r["chunk"]: r for r in rows if (r["particles"], r["cores"], r["fan_out"]) == (particles, cores, fan_out)}
                cells = " ".join(f"{100 * line[c]['efficiency']:>10.1f}{'b' if line[c]['bandwidth_limited'] > 0.1 else ' '}"
                                 if c in line else " " * 11 for c in chunks)
                best = best_of(rows, particles, cores, fan_out)
                print(f"{particles:>10} {cores:>5} {cells} {best['chunk']:>6} {1e6 * best['total']:>9.1f} "
                      f"{1e6 * best['critical_path']:>9.1f} {best['limit']:>14.0f}")


def print_kinds(args, rows):
    print("\nefficiency per node kind at the best chunk in %, and the share of a step's time that each phase takes:")
    for particles, cores, _ in MARKS:
        for fan_out in args.fan_outs:
            try:
                best = best_of(rows, particles, cores, fan_out)
            except ValueError:
                continue
            kinds = ", ".join(f"{k} {100 * v:.0f}" for k, v in best["kinds"].items())
            shares = ", ".join(f"{k} {100 * best[k + '_per_step'] / best['total']:.1f} %" for k in ("rebuild", "sort_epoch")
                               if k + "_per_step" in best)
            print(f"  {particles} on {cores}, {fan_out}, chunk {best['chunk']}: displacement_check {100 / cores:.0f} (serial), {kinds}; "
                  f"of the step: rest {100 * best['step'] / best['total']:.1f} %, {shares}")


def print_marks(args, rows):
    held = True
    for particles, cores, mark in MARKS:
        if particles not in args.particles or cores not in args.cores:
            continue
        best = best_of(rows, particles, cores, args.fan_out)
        own = best_of([r for r in rows if r["chunk"] == args.own[particles, cores]], particles, cores, args.fan_out)
        ok = own["efficiency"] >= mark
        held = held and ok
        print(f"mark: {particles} particles on {cores} cores >= {100 * mark:.0f} %: predicted {100 * own['efficiency']:.1f} % "
              f"with the engine's own chunk of {own['chunk']}, {100 * best['efficiency']:.1f} % with the best one, {best['chunk']} "
              f"({args.fan_out} fan-out): {'holds' if ok else 'DOES NOT HOLD'}")
    return held


def plot(args, rows):
    try:
        import matplotlib
    except ImportError:
        print("no plot: python3-matplotlib is missing", file=sys.stderr)
        return
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    columns = min(2, len(args.particles))
    lines = -(-len(args.particles) // columns)
    figure, axes = plt.subplots(lines, columns, figsize=(5.5 * columns, 4 * lines), constrained_layout=True, squeeze=False)
    for axis, particles in zip(axes.flat, args.particles):
        for chunk in sorted({r["chunk"] for r in rows}):
            line = [r for r in rows if (r["particles"], r["chunk"], r["fan_out"]) == (particles, chunk, args.fan_out)]
            if line:
                axis.plot([r["cores"] for r in line], [100 * r["efficiency"] for r in line], marker="o", ms=3, label=f"chunk {chunk}")
        for n, cores, mark in MARKS:
            if n == particles:
                axis.plot([cores], [100 * mark], "k*", ms=10, label="mark")
        axis.set_title(f"{particles:,} particles, {args.fan_out} fan-out")
        axis.set_xlabel("cores")
        axis.set_ylabel("predicted efficiency [%]")
        axis.set_ylim(0, 105)
        axis.grid(alpha=0.3)
        axis.legend(fontsize=8)
    for axis in list(axes.flat)[len(args.particles):]:
        axis.set_axis_off()
    for kind in ("svg", "png"):
        figure.savefig(os.path.join(args.out, "schedule." + kind), dpi=120)
    print(f"\nplots: {args.out}/schedule.svg, schedule.png")


def parse_arguments():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    numbers = lambda text: [int(float(v)) for v in text.split(",")]
    p.add_argument("--talus", default=os.path.join(ROOT, "build", "talus"))
    p.add_argument("--scene", default="settle", choices=("settle", "flow"))
    p.add_argument("--sizes", type=numbers, default=[128000], help="recorded states, for example 128000,512000")
    p.add_argument("--chunks", type=numbers, default=[512, 1024, 1496, 2240, 2608, 4096, 4480, 8192],
                   help="1496 and 2608: what the engine chooses for the two marks; 2240 and 4480: two and one per thread of the first; 8192: one thread alone")
    p.add_argument("--particles", type=numbers, default=[32000, 125000, 500000, 10000000], help="simulated systems")
    p.add_argument("--cores", type=numbers, default=[1, 2, 4, 8, 16, 28, 56, 64, 112])
    p.add_argument("--fan-out", default="tree", choices=("tree", "flat"), help="as the step graph does it: judged by the marks")
    p.add_argument("--compare", action="store_true", help="simulate the other fan-out too")
    p.add_argument("--warm", type=int, default=100, help="steps before the trace")
    p.add_argument("--steps", type=int, default=40, help="traced steps")
    p.add_argument("--sort-every", type=int, default=1000, help="steps between sort epochs in production")
    p.add_argument("--record-rounds", type=int, default=3)
    p.add_argument("--leave-out", type=lambda t: t.split(","), default=[], help="what if: sort_epoch, rebuild or both cost nothing")
    p.add_argument("--rate-steps", type=int, default=1000, help="steps of the run that counts rebuilds")
    p.add_argument("--rebuild-every", type=float, help="steps between rebuilds instead of the measured interval")
    p.add_argument("--steal", type=float, default=0.3, help="taking a task out of another queue [us]")
    p.add_argument("--attempt", type=float, default=0.4, help="a failed attempt to steal [us]")
    p.add_argument("--wake", type=float, default=20, help="waking a sleeping worker [us]")
    p.add_argument("--bandwidth", type=float, default=250, help="memory of a socket [GB/s]; 0: no limit")
    p.add_argument("--socket", type=int, default=56, help="cores of a socket")
    p.add_argument("--l2", type=float, default=2, help="cache of a core [MB]")
    p.add_argument("--l3", type=float, default=105, help="cache of a socket [MB]")
    p.add_argument("--bytes", type=float, help="traffic per particle-step [B] (default: all arrays once, from the trace)")
    p.add_argument("--reuse", action="store_true", help="use the traces that are there")
    p.add_argument("--record-only", action="store_true")
    p.add_argument("--no-check", action="store_true", help="no real runs beside the prediction")
    p.add_argument("--check-threads", type=numbers, default=[1, 2])
    p.add_argument("--check-chunk", type=int, help="chunk of the real runs (default: the largest recorded)")
    p.add_argument("--check-steps", type=int, default=100)
    p.add_argument("--rounds", type=int, default=5, help="of the real runs")
    p.add_argument("--isa")
    p.add_argument("--mark", action="store_true", help="exit 1 if a mark does not hold")
    p.add_argument("--out", default=os.path.join(ROOT, "build", "schedule"))
    args = p.parse_args()
    args.talus, args.out = os.path.abspath(args.talus), os.path.abspath(args.out)
    args.fan_outs = ["tree", "flat"] if args.compare else [args.fan_out]
    args.own = {(n, cores): own_chunk(args, n, cores) for n, cores, _ in MARKS}
    args.chunks = sorted({*args.chunks, *args.own.values()})
    return args


def main():
    args = parse_arguments()
    os.makedirs(args.out, exist_ok=True)
    recordings = recordings_of(args)
    interval = args.rebuild_every or rebuild_interval(args, min(args.sizes))
    if args.record_only:
        return 0
    for size, by_chunk in recordings.items():
        print(f"recorded: {args.scene}, {size} grains, one thread, {args.steps} steps; ns per particle-step:")
        for chunk, rec in by_chunk.items():
            n = rec.facts["particles"]
            kinds = ", ".join(f"{k} {1e9 * rec.kind_seconds(k) / n:.1f}" for k in rec.kinds)
            parts = ", ".join(f"{k} {1e9 * model.length(v) / n:.0f} (serial {1e9 * sum(x for kind, x in v if kind == 'serial') / n:.0f})"
                              for k, v in (("rebuild", rec.rebuild), ("sort_epoch", rec.sort_epoch)) if v)
            print(f"  chunk {chunk:>5}: {kinds}; per event: {parts}; check {1e6 * rec.check:.1f} us, start "
                  f"{1e6 * rec.first_gap:.2f} us, hop {1e6 * rec.hop:.2f} us, turn {1e6 * rec.turn:.2f} us, join {1e6 * rec.join_gap:.1f} us")
    some = next(iter(next(iter(recordings.values())).values()))
    bytes_per_particle = args.bytes or some.facts["bytes"] / some.facts["particles"]
    memory = model.Memory(bytes_per_particle, args.bandwidth * 1e9, args.l2 * 1e6, args.l3 * 1e6, args.socket)
    print(f"stated: {bytes_per_particle:.0f} B per particle-step; sockets of {args.socket} cores with {args.bandwidth:.0f} GB/s, L3 "
          f"{args.l3:.0f} MB, L2 {args.l2:.0f} MB per core; queueing a task {1e6 * model.Costs.spawn:.1f} us, steal {args.steal} us, failed attempt {args.attempt} us, wake-up "
          f"{args.wake} us; a rebuild every {interval:.0f} steps, a sort epoch every {args.sort_every}")
    checks = []
    if not args.no_check:
        checks = measured_check(args, recordings, memory)
        print(f"\nprediction against real runs, steps without rebuilds ({args.rounds} interleaved rounds, medians):")
        for r in checks:
            print(f"  {r['threads']} thread(s), {r['particles']} grains, chunk {r['chunk']}: predicted {1e6 * r['predicted']:.0f} us per "
                  f"step, measured {1e6 * r['measured']:.0f} us, predicted / measured {r['predicted'] / r['measured']:.3f}\n"
                  f"    speed-up over {r['threads']} independent one-thread processes run at once (mean {1e6 * r['copies']:.0f} us; recorded "
                  f"{1e6 * r['recorded']:.0f}): predicted {r['predicted_speedup']:.2f}, measured {r['measured_speedup']:.2f} "
                  f"({r['low']:.2f} ... {r['high']:.2f})")
    rows = predict(args, recordings, interval, memory)
    print_predictions(args, rows)
    print_kinds(args, rows)
    held = print_marks(args, rows)
    with open(os.path.join(args.out, "schedule.json"), "w") as f:
        json.dump({"arguments": {k: v for k, v in vars(args).items() if k != "own"}, "rebuild_every": interval, "check": checks,
                   "predictions": rows}, f, indent=1)
    plot(args, rows)
    return 1 if args.mark and not held else 0


if __name__ == "__main__":
    sys.exit(main())
