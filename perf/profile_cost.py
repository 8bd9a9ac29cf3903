#!/usr/bin/env python3
"""What the profile costs that every run keeps: its share of the instructions, and its clock reads times the cost of one.

  python3 perf/profile_cost.py                # dense bed of perf/states, one chunk of 4096 rows and chunks of 256
  python3 perf/profile_cost.py --steps 50

Instructions: callgrind (Debian: valgrind), `--isa avx2` since it knows no AVX-512; the difference of two runs, so that reading the
scene and making the first list are left out. What counts as the profile: NodeTimer, NodeTimes and what they call. Clock reads come
from `talus run --profile` of the same scene, which also measures what one costs. Exit 1 above 1 % of the instructions.
"""
import argparse
import json
import os
import re
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(HERE)
MARK = 0.01
PROFILE = re.compile(r"talus::Node(Timer|Times)::")


def scene(args, steps, chunk, out):
    return [args.talus, "run", os.path.join(HERE, "scenes", "settle32.toml"), "--isa", "avx2", "--threads", "1", "--chunk", str(chunk),
            "--steps", str(steps), "--quiet", "--overwrite", "--out", out]


def done(command):
    r = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    if r.returncode != 0:
        raise SystemExit(f"profile_cost.py: {' '.join(command)}\n{r.stderr[-2000:]}")
    return r.stdout


def instructions(args, steps, chunk, folder):
    """All instructions of a run, and those inside the profile."""
    file = os.path.join(folder, "callgrind.out")
    done(["valgrind", "--tool=callgrind", "--callgrind-out-file=" + file, *scene(args, steps, chunk, os.path.join(folder, "run"))])
    # exclusive costs per function: the profile's own, and those of the inlined or called clock reads are in them
    text = done(["callgrind_annotate", "--threshold=100", "--auto=no", "--show-percs=no", file])
    total = own = 0
    for line in text.splitlines():
        m = re.match(r"\s*([\d,]+)\s+(.*)", line)
        if not m:
            continue
        count = int(m[1].replace(",", ""))
        if "PROGRAM TOTALS" in m[2]:
            total = count
        elif PROFILE.search(m[2]):
            own += count
    if total == 0:
        raise SystemExit("profile_cost.py: callgrind_annotate printed no total")
    return total, own


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--talus", default=os.path.join(ROOT, "build", "talus"))
    p.add_argument("--steps", type=int, default=20, help="steps whose instructions are counted, after 5 that are not")
    p.add_argument("--chunks", default="4096,256", help="rows per chunk; small ones have the most timers per grain")
    p.add_argument("--json", help="write the figures to this file")
    args = p.parse_args()
    args.talus = os.path.abspath(args.talus)
    held, rows = True, []
    with tempfile.TemporaryDirectory() as folder:
        for chunk in map(int, args.chunks.split(",")):
            short, long = (instructions(args, s, chunk, folder) for s in (5, 5 + args.steps))
            total, own = long[0] - short[0], long[1] - short[1]
            if own <= 0:
                raise SystemExit("profile_cost.py: no function of the profile found: is the program built with its symbols?")
            text = done([*scene(args, 300, chunk, os.path.join(folder, "run")), "--warm", "100", "--profile"])
            m = re.search(r"clock: (\S+) reads per step, (\S+) ns each = \S+ s \((\S+) %\)", text)
            if not m:
                raise SystemExit("profile_cost.py: talus run --profile printed no line on the clock")
            share = own / total
            held &= share <= MARK
            rows.append({"chunk": chunk, "instructions": total, "profile": own, "share": share, "clock_reads_per_step": float(m[1]),
                         "ns_per_read": float(m[2]), "clock_share": float(m[3]) / 100})
            print(f"chunks of {chunk:>5} rows: {own / args.steps:.0f} of {total / args.steps:.3e} instructions per step = {100 * share:.3f} % "
                  f"(mark {100 * MARK:.0f} %: {'holds' if share <= MARK else 'DOES NOT HOLD'}); {m[1]} clock reads per step x {m[2]} ns = "
                  f"{m[3]} % of the time", flush=True)
    if args.json:
        with open(args.json, "w", encoding="utf-8") as f:
            json.dump(rows, f, indent=1)
    return 0 if held else 1


if __name__ == "__main__":
    sys.exit(main())
