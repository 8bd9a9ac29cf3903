#!/usr/bin/env python3
"""Automatic K against the best fixed K of a sweep: table and marks, exit 1 when one is missed.

  python3 perf/auto_k.py                                  # the five small cases, chute32 and flow128
  python3 perf/auto_k.py --scenes hopper,grates           # some of them
  python3 perf/auto_k.py --scenes hopper@2000,hopper@20000,hopper@30000,hopper@60000   # fill, rest, gate opens, discharge
  python3 perf/auto_k.py --scenes my/scene.toml@5000      # any scene
  python3 perf/auto_k.py --prepare                        # only make the states

Every run of a scene goes on from one checkpoint and ends with the same state hash. A run with automatic K knows nothing
at its start, so what it spends on learning is in its time. Rounds are interleaved, each in its own random order; after
two rounds only the fixed K within 6 % of the best one, K = 200 and "auto" go on. Ratios are taken within a round; their
medians are printed with 95 % bootstrap intervals. The best fixed K is the one of the least median, which favours it.

Marks: at most 2 % slower than the best fixed K; at most 3 % slower than K = 200; rebuilds at most 5 % of the run time in
dense flow (chute32, flow128; --dense for others). A mark is missed where the median misses it.
"""
import argparse
import json
import os
import random
import shlex
import subprocess
import sys

import numpy as np

sys.dont_write_bytecode = True
from study import findings, plan, runner  # noqa: E402

FLOWS = ("chute32", "flow128")
SWEEP = [10, 20, 50, 100, 200, 500, 1000, 2000, 5000]
AUTO = "auto"
OVER_BEST, OVER_200, SHARE = 1.02, 1.03, 5.0
KEEP = 1.06  # after two rounds: fixed K slower than this against the best one are out


def case_of(text, small):
    """Case and step of its state (None: its own) of NAME, NAME@STEP, FILE or FILE@STEP."""
    name, _, step = text.partition("@")
    step = int(step) if step else None
    known = {c.name: c for c in plan.cases(not small)}
    if name in known:
        return known[name], step
    scene = os.path.join(plan.ROOT, "perf", "scenes", name + ".toml")
    if os.path.exists(scene):
        return plan.Case(name, "", scene, 0.1, 5000), step
    if not os.path.exists(name):
        raise SystemExit(f"auto_k.py: '{name}' is no scene file; cases: {', '.join(known)}; others: perf/scenes/NAME.toml by NAME")
    return plan.Case(os.path.splitext(os.path.basename(name))[0], "", os.path.abspath(name), 0, 5000), step or 0


class Table(runner.Study):
    def __init__(self, args, case, step):
        args.prepare_steps = step
        super().__init__(args, [case], [])
        self.binary = ""  # a state serves every build: all points of a table start from the same one
        self.case = case
        self.state(case)

    def state(self, case):
        if case.name in FLOWS and not os.path.exists(os.path.join(plan.ROOT, "build", "states", case.name + ".csv.gz")):
            self.check([sys.executable, os.path.join(plan.ROOT, "perf", "states.py"), case.name])
        if self.args.prepare_steps == 0:
            self.first, self.checkpoint = 0, None
        else:
            _, self.first, self.checkpoint = self.prepare(case)

    def once(self, k):
        steps = self.args.steps or self.case.steps
        command = shlex.split(self.args.prefix or os.environ.get("TALUS_RUN_PREFIX", ""))
        command += [self.args.talus, "run", self.scene(self.case), "--out", os.path.join(self.args.out, "run"), "--overwrite",
                    "--quiet", "--json", "--threads", str(self.args.threads), "--steps", str(self.first + steps)]
        command += ["--resume", self.checkpoint] if self.checkpoint else []
        command += runner.sets(self.overrides(self.case) + [f'list.verlet_k="{k}"' if k == AUTO else f"list.verlet_k={k}"])
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
        if done.returncode:
            raise runner.Failed(f"{shlex.join(command)}: exit code {done.returncode}\n{done.stderr[-2000:]}")
        s = json.loads(done.stdout[done.stdout.index("{"):])
        nodes = {n["name"]: n["seconds"] for n in s["nodes"]}
        share = 100 * (nodes.get("rebuild", 0) + nodes.get("sort_epoch", 0)) / sum(nodes.values())
        return {"k": k, "wall_s": s["wall_s"], "share": share, "rebuilds": s["rebuilds"], "particles": s["particles"],
                "pairs": s["candidate_pairs"], "hash": s["state_hash"], "last_k": s["verlet_k"], "steps": steps}

    def measure(self, ks):
        """Runs by K, one per round."""
        runs = {k: [] for k in [*ks, AUTO]}
        going = list(runs)
        for turn in range(self.args.rounds):
            if turn == 2:
                median = {k: np.median([r["wall_s"] for r in runs[k]]) for k in ks}
                best = min(median.values())
                going = [k for k in going if k in (AUTO, 200) or median[k] <= KEEP * best]
            order = list(going)
            random.Random(f"{self.case.name} {turn} {self.args.seed}").shuffle(order)
            for k in order:
                runs[k].append(self.once(k))
        hashes = {r["hash"] for rows in runs.values() for r in rows}
        if len(hashes) > 1:
            raise runner.Failed(f"{self.case.name}: the runs end in different states: {', '.join(sorted(hashes))}")
        return runs


def ratio(runs, a, b, rng):
    pairs = list(zip(runs[a], runs[b]))
    return findings.median_interval([x["wall_s"] / y["wall_s"] for x, y in pairs], rng)


def judge(name, runs, dense):
    rng = np.random.default_rng(1)
    fixed = [k for k in runs if k != AUTO and len(runs[k]) == len(runs[AUTO])]
    median = lambda k, what: float(np.median([r[what] for r in runs[k]]))  # noqa: E731
    best = min(fixed, key=lambda k: median(k, "wall_s"))
    row = {"scene": name, "best_k": best, "best_s": median(best, "wall_s"), "best_share": median(best, "share"),
           "auto_s": median(AUTO, "wall_s"), "share": median(AUTO, "share"), "rebuilds": median(AUTO, "rebuilds"),
           "last_k": median(AUTO, "last_k"), "steps": runs[AUTO][0]["steps"], "rounds": len(runs[AUTO]),
           "over_best": ratio(runs, AUTO, best, rng), "over_200": ratio(runs, AUTO, 200, rng) if 200 in fixed else None,
           "sweep": {k: median(k, "wall_s") for k in runs}, "runs": {str(k): v for k, v in runs.items()}}
    row["missed"] = [text for text, bad in (
        ("best", row["over_best"][0] > OVER_BEST), ("K = 200", bool(row["over_200"]) and row["over_200"][0] > OVER_200),
        ("share", dense and row["share"] > SHARE)) if bad]
    return row


def head():
    return (f"{'scene':<16}{'best K':>7}{'us/step':>9}{'share':>7}{'auto':>9}{'share':>7}{'last K':>8}{'rebuilds':>9}"
            f"{'auto / best (95 %)':>25}{'auto / K=200 (95 %)':>25}  missed")


def line(row):
    of = lambda t: f"{t[0]:.3f} ({t[1]:.3f} ... {t[2]:.3f})" if t else ""  # noqa: E731
    scale = 1e6 / row["steps"]
    return (f"{row['scene']:<16}{row['best_k']:>7}{scale * row['best_s']:>9.1f}{row['best_share']:>6.1f}%{scale * row['auto_s']:>9.1f}"
            f"{row['share']:>6.1f}%{row['last_k']:>8.0f}{row['rebuilds']:>9.0f}{of(row['over_best']):>25}{of(row['over_200']):>25}  "
            f"{', '.join(row['missed']) or 'none'}")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", default="hopper,incline,avalanche,levelling,grates,chute32,flow128")
    parser.add_argument("--full", action="store_true", help="the full cases instead of the small ones")
    parser.add_argument("--k", default=",".join(map(str, SWEEP)), help="fixed K, with commas")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--steps", type=int, help="steps of a run (5000)")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--dense", default=",".join(FLOWS), help="scenes whose rebuild share is judged")
    parser.add_argument("--prepare", action="store_true", help="only make the states")
    parser.add_argument("--prepare-threads", type=int, default=0)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="scene key for all scenes")
    parser.add_argument("--prefix", help="command before every timed run")
    parser.add_argument("--seed", type=int, default=1, help="of the random order")
    parser.add_argument("--json", help="file for all figures")
    parser.add_argument("--talus", default=os.path.join(plan.ROOT, "build", "talus"))
    parser.add_argument("--out", default=os.path.join(plan.ROOT, "build", "auto_k"))
    args = parser.parse_args()
    if not os.access(args.talus, os.X_OK):
        parser.error(f"{args.talus} is not there: build it (bash cases/build.sh) or name another one with --talus")
    args.ks = [int(k) for k in args.k.split(",")]
    if args.rounds < 1 or (args.steps is not None and args.steps < 1) or not args.ks:
        parser.error("--rounds and --steps must be at least 1")
    args.talus, args.case_set = os.path.abspath(args.talus), []
    return args


def main():
    args = arguments()
    rows = []
    try:
        tables = [(text, Table(args, *case_of(text, not args.full))) for text in args.scenes.split(",")]
        if args.prepare:
            return 0
        print(f"{args.threads} thread(s), {cpu_name()}, load {os.getloadavg()[0]:.1f}\n{head()}", flush=True)
        for text, table in tables:
            rows.append(judge(os.path.splitext(os.path.basename(text))[0] if text.endswith(".toml") else text, table.measure(args.ks),
                              text.partition("@")[0] in args.dense.split(",")))
            print(line(rows[-1]), flush=True)
    except runner.Failed as error:
        runner.say(f"auto_k.py: {error}")
        return 2
    if args.json:
        with open(args.json, "w", encoding="utf-8") as f:
            json.dump(rows, f, indent=1)
    for r in rows:
        sweep = "  ".join(f"{k}: {1e6 / r['steps'] * s:.1f}" for k, s in r["sweep"].items())
        print(f"{r['scene']:<16}us/step  {sweep}")
    missed = [f"{r['scene']} ({', '.join(r['missed'])})" for r in rows if r["missed"]]
    print(f"marks: at most {OVER_BEST} x best, {OVER_200} x K = 200, rebuilds {SHARE:g} % in dense flow: "
          + (f"missed by {'; '.join(missed)}" if missed else "all met"))
    return 1 if missed else 0


def cpu_name():
    with open("/proc/cpuinfo", encoding="utf-8") as f:
        return next((text.split(":", 1)[1].strip() for text in f if text.startswith("model name")), "unknown processor")


if __name__ == "__main__":
    sys.exit(main())
