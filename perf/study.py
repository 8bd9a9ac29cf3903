#!/usr/bin/env python3
"""The paper's study with one command: how the cost of a run depends on K and on the list policy, for the five cases.

  python3 perf/study.py --quick                         # small cases, short runs, 2 repeats: about 25 minutes of one core
  python3 perf/study.py --small                         # small cases, 3 repeats: some hours of one core
  python3 perf/study.py --small --cases hopper,grates   # some of them
  python3 perf/study.py                                 # the full cases (>= 1e5 grains), many hours
  python3 perf/study.py --small --budget 50             # stop after 50 s; the next call goes on from there
  python3 perf/study.py --small --series paper,others   # only some policies: paper, local, uniform, others
  python3 perf/study.py --report                        # only write the page again

For each case: one prepared state (a checkpoint), then K in {none, 0, 1, 2, 5, ... 5000} for the policies paper and local, the
uniform skin = R and a tuned one, and every other policy of this build at K = 200, with repeats in random order. Writes to
OUT (build/study): study.html (plots, the paper's table with ours beside it, verdicts on its claims), study.csv, study.json,
runs.jsonl (the journal). TALUS_RUN_PREFIX or --prefix "CMD" is put before every timed run (taskset, for example).
Exit code: 0 done, 3 budget spent before the end, 4 the state hashes of a case differ, 1 a run failed.
Needs python3-numpy and python3-matplotlib.
"""
import argparse
import json
import os
import sys

sys.dont_write_bytecode = True
from study import findings, page, plan, runner  # noqa: E402


def cpu_name():
    with open("/proc/cpuinfo", encoding="utf-8") as f:
        return next((line.split(":", 1)[1].strip() for line in f if line.startswith("model name")), "unknown processor")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--small", action="store_true", help="the small cases instead of the full ones")
    parser.add_argument("--quick", action="store_true", help=f"as --small, with {plan.QUICK_STEPS} timed steps, {plan.QUICK_REPEATS} repeats, --few")
    parser.add_argument("--few", action="store_true", help="fewer uniform skins, the other policies at one setting each")
    parser.add_argument("--cases", help="names, with commas (all)")
    parser.add_argument("--series", default="paper,local,uniform,others", help="what is swept (paper,local,uniform,others)")
    parser.add_argument("--k", help="other values of K, with commas")
    parser.add_argument("--no-audit", action="store_true", help="do not count what inexact lists miss (a sweep over all grains per step)")
    parser.add_argument("--repeats", type=int, help="of every point (3; quick 2)")
    parser.add_argument("--steps", type=int, help="timed steps of a run (5000; quick 1000)")
    parser.add_argument("--warm", type=int, help="untimed steps before them (200)")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--isa")
    parser.add_argument("--prepare-steps", type=int, help="another step for the common state")
    parser.add_argument("--prepare-threads", type=int, default=0, help="threads for preparing it (0: all)")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="scene key for all cases")
    parser.add_argument("--case-set", action="append", default=[], metavar="CASE:KEY=VALUE", help="scene key for one case")
    parser.add_argument("--prefix", help="command before every timed run")
    parser.add_argument("--budget", type=float, help="seconds after which no further run is started")
    parser.add_argument("--seed", type=int, default=1, help="of the random order")
    parser.add_argument("--report", action="store_true", help="run nothing, write the page from what is there")
    parser.add_argument("--talus", default=os.path.join(plan.ROOT, "build", "talus"))
    parser.add_argument("--out", default=os.path.join(plan.ROOT, "build", "study"))
    args = parser.parse_args()
    if not os.access(args.talus, os.X_OK):
        parser.error(f"{args.talus} is not there: build it (bash cases/build.sh) or name another one with --talus")
    args.small, args.few = args.small or args.quick, args.few or args.quick
    args.repeats = args.repeats if args.repeats is not None else plan.QUICK_REPEATS if args.quick else 3
    args.warm = args.warm if args.warm is not None else plan.QUICK_WARM if args.quick else 200
    args.steps = args.steps if args.steps is not None or not args.quick else plan.QUICK_STEPS
    if args.repeats < 1 or (args.steps is not None and args.steps < 1) or args.warm < 0:
        parser.error("--repeats and --steps must be at least 1, --warm at least 0")
    args.talus = os.path.abspath(args.talus)
    return parser, args


def chosen(parser, args):
    cases = plan.cases(not args.small)
    if args.cases:
        names = args.cases.split(",")
        unknown = [n for n in names if n not in [c.name for c in cases]]
        if unknown:
            parser.error(f"no case {', '.join(unknown)}; there are {', '.join(c.name for c in cases)}")
        cases = [c for c in cases if c.name in names]
    series = args.series.split(",")
    unknown = [s for s in series if s not in (*plan.SWEPT, "uniform", "others")]
    if unknown:
        parser.error(f"no series {', '.join(unknown)}")
    ks = [int(k) for k in args.k.split(",")] if args.k else plan.K_SWEEP
    return cases, plan.points(*plan.choices(args.talus), series, ks, args.few)


def main():
    parser, args = arguments()
    study = runner.Study(args, *chosen(parser, args))
    complete = False
    try:
        if args.report:
            study.plan_only()
        else:
            complete = study.run_all()
    except KeyboardInterrupt:
        runner.say("stopped; what is finished is kept")
    except runner.Failed as error:
        runner.say(f"study.py: {error}")
        return 1
    runs = study.results()
    complete = complete or len(runs) == len(study.wanted) > 0
    if not runs:
        runner.say("study.py: no finished runs")
        return 1
    summaries = [findings.Summary(c, runs) for c in study.cases]
    facts = {"complete": complete, "steps": args.steps or study.cases[0].steps, "warm": args.warm, "threads": runs[-1]["threads"], "repeats": args.repeats,
             "version": runs[-1]["version"], "isa": runs[-1]["isa"], "cpu": cpu_name(), "load": max(r["load"] for r in runs), "failures": study.failures}
    verdicts = {p: findings.verdicts(summaries, p) for p in plan.SWEPT}
    page.write(args.out, summaries, facts)
    page.write_csv(os.path.join(args.out, "study.csv"), summaries)
    with open(os.path.join(args.out, "study.json"), "w", encoding="utf-8") as f:
        json.dump({"facts": facts, "points": {s.case.name: list(s.points.values()) for s in summaries},
                   "table": [r for s in summaries for p in plan.SWEPT if (r := s.row(p))], "verdicts": verdicts,
                   "bounds": [b for s in summaries if (b := findings.bounds(s))]}, f, indent=1)
    text(summaries, verdicts)
    print(f"\n{os.path.join(args.out, 'study.html')}")
    if any(len(s.hashes) > 1 for s in summaries):
        return 4
    return 0 if complete else 3


def text(summaries, verdicts):
    """The table and the verdicts for a terminal."""
    print(f"{'case':<14}{'policy':<8}{'grains':>8}{'none s':>9}{'K opt':>7}{'opt s':>9}{'impr %':>8}{'K=200 s':>9}{'overhead % (95 %)':>24}  within 2 %")
    for s in summaries:
        for p in plan.SWEPT:
            r = s.row(p)
            if r:
                over = f"{r['overhead']:+.2f} ({r['overhead_low']:+.2f} ... {r['overhead_high']:+.2f})" if "overhead" in r else ""
                print(f"{r['case']:<14}{p:<8}{r['particles']:>8}{r['none_s']:>9.3f}{r['optimum']:>7}{r['optimum_s']:>9.3f}{r['improvement']:>8.1f}"
                      f"{r.get('default_s', float('nan')):>9.3f}{over:>24}  {r['basin'][0]} to {r['basin'][1]}")
    for b in filter(None, map(findings.bounds, summaries)):
        print(f"{b['case']:<14}best: {b['best']}; not built, at most: partial rebuild or reduced cells {b['rebuild_percent']:.1f} %, outer and inner list {b['inner_percent']:.1f} %")
    for policy, claims in verdicts.items():
        for name, claim, cases in claims:
            for case, holds, evidence in cases:
                word = {True: "reproduced", False: "NOT REPRODUCED", None: "not tested"}[holds]
                print(f"{policy:<6} {name:<4}{word:<15}{case:<12}{evidence}")


if __name__ == "__main__":
    sys.exit(main())
