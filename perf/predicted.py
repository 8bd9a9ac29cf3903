#!/usr/bin/env python3
"""Does `talus check` predict how long a run takes? Runs scenes and prints predicted / actual for each.

  python3 perf/predicted.py --talus build/talus                  # scenes of the tutorial and small cases
  python3 perf/predicted.py --talus build/talus SCENE.toml ...   # these
  options: --threads N (default 1), --rounds N (default 3), --set KEY=VALUE (any number)

Each round asks for a prediction and then runs the whole scene; the median ratio counts, with its range. Mark: within a
factor of 1.5, on a machine that does nothing else: says so and exits 1 where it does not hold, 2 where a run fails.
"""
import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
MARK = 1.5
SCENES = [f"cases/tutorial/{s}/scene.toml" for s in ("1-box", "2-material", "3-drum", "4-mesh", "7-repose")]


def json_of(command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}: {done.stderr.strip() or done.stdout.strip()}")
    return json.loads(done.stdout)


def round_of(args, scene, folder):
    """(predicted, actual) seconds of one run."""
    common = ["--threads", str(args.threads)] + [w for s in args.set for w in ("--set", s)]
    predicted = json_of([args.talus, "check", scene, "--json"] + common)["predicted"]["seconds"]
    out = os.path.join(folder, "out")
    done = subprocess.run([args.talus, "run", scene, "--out", out, "--overwrite", "--quiet"] + common,
                          capture_output=True, text=True)
    if done.returncode != 0:
        print(f"{scene}: {done.stderr.strip()}", file=sys.stderr)
        sys.exit(2)
    with open(os.path.join(out, "summary.json"), encoding="utf-8") as f:
        return predicted, json.load(f)["wall_s"]


def main():
    p = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    p.add_argument("scenes", nargs="*")
    p.add_argument("--talus", required=True)
    p.add_argument("--threads", type=int, default=1)
    p.add_argument("--rounds", type=int, default=3)
    p.add_argument("--set", action="append", default=[])
    args = p.parse_args()
    args.talus = os.path.abspath(args.talus)
    load = os.getloadavg()[0]
    if load > 0.5:
        print(f"warning: load average {load:.1f}: these ratios are not to be quoted")
    print(f"{'scene':40}{'predicted s':>12}{'actual s':>10}{'ratio':>8}   range of {args.rounds}")
    missed = []
    for scene in args.scenes or [os.path.join(ROOT, s) for s in SCENES]:
        with tempfile.TemporaryDirectory() as folder:
            rounds = [round_of(args, os.path.abspath(scene), folder) for _ in range(args.rounds)]
        ratios = sorted(predicted / actual for predicted, actual in rounds)
        ratio = statistics.median(ratios)
        name = os.path.relpath(scene, ROOT)
        print(f"{name[-39:]:40}{statistics.median(r[0] for r in rounds):12.2f}"
              f"{statistics.median(r[1] for r in rounds):10.2f}{ratio:8.2f}   {ratios[0]:.2f} ... {ratios[-1]:.2f}",
              flush=True)
        if not 1 / MARK <= ratio <= MARK:
            missed.append(name)
    print(f"mark: within a factor of {MARK}: {'DOES NOT HOLD for ' + ', '.join(missed) if missed else 'holds'}")
    sys.exit(1 if missed else 0)


if __name__ == "__main__":
    main()
