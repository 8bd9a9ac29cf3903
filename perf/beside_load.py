#!/usr/bin/env python3
"""What another process on one of the cores does to a run on two threads.

  python3 perf/beside_load.py                 # 10 rounds: settled bed of 32k grains, a scene of 131 grains
  python3 perf/beside_load.py --former PATH   # also beside another binary on an idle machine: nothing may be lost

Every round runs one thread alone, two threads alone, and two threads beside a busy loop that is bound to the second core
(the worst case: the kernel cannot move it away) and beside one that is free. Mark: beside either loop two threads reach
0.9 of what one thread reaches alone. Exit 1 below it. One thread that is bound to the first core, beside the loop on the
second one, shows what the machine itself takes (cores that are two threads of one, a lower clock). Start-up and 100 steps are left out, rebuilds are included.
"""
import argparse
import json
import os
import subprocess
import sys

import numpy as np

sys.dont_write_bytecode = True
import states  # noqa: E402

ROOT = os.path.dirname(states.HERE)
TINY = """
seed = 7
gravity = [0, 0, -9.81]
domain = { lower = [0, 0, 0], upper = [0.05, 0.05, 0.1] }
time = { step = 1e-5, steps = 1000 }
material = [{ name = "glass", density = 2500 }]
contact = { model = "linear", normal_stiffness = 2e4, tangential_stiffness = 5.7e3, restitution = 0.8, friction = 0.4 }
[[source]]
kind = "random"
number = 131
region = { lower = [0.005, 0.005, 0.02], upper = [0.045, 0.045, 0.095] }
size = { kind = "uniform", min = 0.004, max = 0.006 }
"""


def rate(args, talus, scene, threads, steps, extra, cores="0,1"):
    """particle-steps/s of one run."""
    command = ["taskset", "-c", cores, talus, "run", scene, "--threads", str(threads), "--warm", "100", "--steps", str(100 + steps),
               "--quiet", "--json", "--overwrite", "--out", os.path.join(args.out, "run"), *extra]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"beside_load.py: {' '.join(command)}\n{done.stderr}")
    return json.loads(done.stdout)["particle_steps_per_s"]


def beside(cores, measure):
    """measure() while another process keeps one of these cores busy."""
    load = subprocess.Popen(["taskset", "-c", cores, sys.executable, "-c", "while True: pass"])
    try:
        return measure()
    finally:
        load.kill()
        load.wait()


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--talus", default=os.path.join(ROOT, "build", "talus"))
    p.add_argument("--former", help="another binary, compared on the idle machine")
    p.add_argument("--rounds", type=int, default=10)
    p.add_argument("--out", default=os.path.join(ROOT, "build", "beside_load"))
    args = p.parse_args()
    if (os.cpu_count() or 1) < 2:
        p.error("needs two cores")
    os.makedirs(args.out, exist_ok=True)
    tiny = os.path.join(args.out, "tiny.toml")
    with open(tiny, "w") as f:
        f.write(TINY)
    bed = os.path.join(states.HERE, "scenes", "settle32.toml")
    cases = {"settle32": (bed, 2000, ["--set", f"source.0.file={states.csv_path('settle32')}"]), "131 grains": (tiny, 40000, [])}
    load = os.getloadavg()[0]
    if load > 0.5:
        print(f"warning: load average {load:.1f}: these rates are not to be quoted", file=sys.stderr)
    failed = False
    print(f"{'':<12} {'1 thread':>9} {'2 threads':>9} {'bound loop':>10} {'free loop':>9} {'1 beside':>9}   M particle-steps/s, medians of {args.rounds} rounds")
    for name, case in cases.items():
        rows = []
        for _ in range(args.rounds):
            row = [rate(args, args.talus, case[0], t, *case[1:]) for t in (1, 2)]
            row += [beside(c, lambda: rate(args, args.talus, case[0], 2, *case[1:])) for c in ("1", "0,1")]
            row.append(beside("1", lambda: rate(args, args.talus, case[0], 1, *case[1:], cores="0")))
            if args.former:
                row.append(rate(args, args.former, case[0], 2, *case[1:]))
            rows.append(row)
        r = np.array(rows)
        m = np.median(r, axis=0) / 1e6
        print(f"{name:<12} {m[0]:>9.2f} {m[1]:>9.2f} {m[2]:>10.2f} {m[3]:>9.2f} {m[4]:>9.2f}")
        for k, what in ((2, "bound"), (3, "free")):
            q = r[:, k] / r[:, 0]
            holds = np.median(q) >= 0.9
            failed |= not holds
            print(f"    2 threads beside the {what} loop / 1 thread alone = {np.median(q):.3f} ({q.min():.3f} ... {q.max():.3f})  "
                  f"mark >= 0.9: {'holds' if holds else 'DOES NOT HOLD'}")
        if args.former:
            q = r[:, 1] / r[:, 5]
            print(f"    2 threads, this binary / the other one = {np.median(q):.3f} ({q.min():.3f} ... {q.max():.3f})")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
