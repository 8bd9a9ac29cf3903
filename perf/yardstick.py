#!/usr/bin/env python3
"""Talus beside the throw-away prototype of its design: the step and the rebuild of one dense periodic bed, on one core.

  python3 perf/yardstick.py --prototype DIR              # DIR holds the program canonical_order and the state mono60.bin
  python3 perf/yardstick.py --prototype DIR --rounds 9 --json yardstick.json

The prototype is no part of this repository: one file with AVX-512 intrinsics and contracted operations that showed what the design
can reach. Same state, law and skin (0.02) in both. Chunks: 4096 rows in the prototype (1024 to 8192 are alike), its own choice in Talus
(`--chunk 4096` for the same). Step: the prototype's `bench` line "cs 4096 ieee 1 thr" against a run of Talus without the rebuilds, all
else included. Rebuild: the prototype's `cost` line without sorting of rows against a run of Talus that rebuilds every 25 steps, as `cost`
does. Two rows of Talus: its default law, and the prototype's (damping with lagged velocities, levers of one radius, leapfrog). One round
runs all programs in turn; ratios are taken within a round. Exit 1 below a mark.
"""
import argparse
import json
import os
import re
import subprocess
import sys

import numpy as np

import states

ROOT = os.path.dirname(states.HERE)
SKIN, EVERY = 0.02, 25
OWN_LAW = ["contact.dashpot=lagged", "contact.lever=radius", "contact.onset_correction=false", "contact.synchronised=false",
           "integrator=leapfrog"]
SCENE = """sort_every = 1000000000
[domain]
lower = [0, 0, 0]
upper = [{0:.17g}, {1:.17g}, {2:.17g}]
boundary = "periodic"
[time]
step = 1e-4
steps = 0
[[material]]
name = "grain"
density = {density:.17g}
[contact]
normal_stiffness = 2e5
tangential_stiffness = 57142.857142857145
normal_damping = 50
tangential_damping = 25
friction = 0.5
[[source]]
kind = "file"
file = "yardstick.csv"
[list]
verlet_k = 0
acceleration = false
floor = {skin}
[checks]
allow_initial_overlap = true
warn_overlap = 0.5
"""


def convert(path, folder):
    """The prototype's state as a Talus scene. File: int32 n, 3 doubles box, n rows {x,y,z,r}, n rows {v,0,r omega,1/m}."""
    with open(path, "rb") as f:
        n = int(np.fromfile(f, "<i4", 1)[0])
        box = np.fromfile(f, "<f8", 3)
        p = np.fromfile(f, "<f8", 4 * n).reshape(-1, 4)
        v = np.fromfile(f, "<f8", 8 * n).reshape(-1, 8)
    if len(p) != n or len(v) != n:
        raise SystemExit(f"yardstick.py: {path} is shorter than its header says ({n} particles)")
    density = 1 / v[:, 7] / (4 / 3 * np.pi * p[:, 3] ** 3)
    if np.ptp(density) > 1e-9 * density[0]:
        raise SystemExit(f"yardstick.py: {path} holds several densities; one material has one")
    p[:, :3] %= box
    state = np.concatenate([p, v[:, :3], v[:, 4:7] / p[:, 3:4]], 1)
    np.savetxt(os.path.join(folder, "yardstick.csv"), state, fmt="%.17g", delimiter=",", header="x,y,z,r,vx,vy,vz,wx,wy,wz", comments="")
    scene = os.path.join(folder, "yardstick.toml")
    with open(scene, "w") as f:
        f.write(SCENE.format(*box, density=density[0], skin=SKIN / (2 * p[:, 3].max())))
    return scene, p[:, 3]


def pinned(core, command):
    return ["taskset", "-c", str(core)] + [str(c) for c in command]


def prototype(args, mode, wanted, values):
    """Numbers of the first line that matches `wanted`; the rest of the program's sweep is not waited for."""
    command = pinned(args.core, [args.program, args.state, 1, 1, 1, mode, SKIN if mode != "check" else args.check_steps])
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        for line in process.stdout:
            if re.search(wanted, line):
                found = [re.search(v, line) for v in values]
                if all(found):
                    return [float(m.group(1)) for m in found]
        raise SystemExit(f"yardstick.py: {' '.join(command)} printed no line '{wanted}'")
    finally:
        process.kill()
        process.wait()


def talus(args, scene, steps, warm, settings):
    command = pinned(args.core, [args.talus, "run", scene, "--threads", 1, "--isa", args.isa, "--chunk", args.chunk, "--warm", warm, "--steps",
                                 warm + steps, "--quiet", "--json", "--overwrite", "--out", os.path.join(args.out, "run")])
    for s in settings:
        command += ["--set", s]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"yardstick.py: {' '.join(command)}\n{done.stderr}")
    s = json.loads(done.stdout)
    rebuild = next((q for q in s["nodes"] if q["name"] == "rebuild"), {"calls": 0, "seconds": 0.0})
    return s, rebuild


def one_round(args, scene, radius):
    n = len(radius)
    out = {}
    step, pairs = prototype(args, "bench", r"cs +4096 +ieee +1 thr", [r"mean ([\d.]+) ns", r"pairs/N ([\d.]+)"])
    out["prototype"] = {"step": step, "pairs": pairs}
    out["prototype"]["rebuild"] = prototype(args, "cost", r"^ *epoch 1000000 ", [r"rebuild ([\d.]+) ns"])[0]
    for name, law in (("talus", []), ("talus, prototype's law", OWN_LAW)):
        s, rebuild = talus(args, scene, 200, 60, law)
        row = {"step": (s["wall_s"] - rebuild["seconds"]) / 200 / n * 1e9, "pairs": s["candidate_pairs"] / n}
        # a fixed interval with one skin for all is the same list here: K = 0 leaves the floor alone
        s, rebuild = talus(args, scene, 6 * EVERY, 60, law + ["list.policy=fixed", f"list.interval={EVERY}",
                                                            f"list.uniform_skin={SKIN / radius.min():.17g}"])
        if rebuild["calls"] < 5:
            raise SystemExit("yardstick.py: Talus did not rebuild as often as asked")
        row["rebuild"] = rebuild["seconds"] / rebuild["calls"] / n * 1e9
        out[name] = row
    return out


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--prototype", required=True, metavar="DIR")
    p.add_argument("--talus", default=os.path.join(ROOT, "build", "talus"))
    p.add_argument("--isa", default="avx512")
    p.add_argument("--rounds", type=int, default=7)
    p.add_argument("--chunk", type=int, default=0, help="rows of a chunk of Talus; 0: its own choice")
    p.add_argument("--core", type=int, default=0)
    p.add_argument("--check-steps", type=int, default=100, help="kinetic energies are compared after so many steps")
    p.add_argument("--json", metavar="FILE")
    p.add_argument("--out", default=os.path.join(ROOT, "build", "yardstick"))
    args = p.parse_args()
    args.program, args.state = (os.path.join(os.path.abspath(args.prototype), f) for f in ("canonical_order", "mono60.bin"))
    for path in (args.program, args.state):
        if not os.path.exists(path):
            raise SystemExit(f"yardstick.py: --prototype {args.prototype}: there is no {os.path.basename(path)}")
    args.talus, args.out = os.path.abspath(args.talus), os.path.abspath(args.out)
    os.makedirs(args.out, exist_ok=True)
    print(f"load average {os.getloadavg()[0]:.2f}", file=sys.stderr)
    scene, radius = convert(args.state, args.out)
    rounds = []
    for r in range(args.rounds):
        rounds.append(one_round(args, scene, radius))
        print(f"  round {r + 1}/{args.rounds}", file=sys.stderr)
    names = list(rounds[0])
    get = lambda name, what: np.array([q[name][what] for q in rounds])
    result = {"rounds": rounds}
    print(f"\n{len(radius)} equal spheres, dense, one core, {args.rounds} rounds: medians; ratio to the prototype: median (smallest ... largest)")
    print(f"{'':<24} {'pairs/particle':>14} {'ns/particle-step':>17}  {'ratio':<24} {'ns/particle/rebuild':>19}  ratio")
    for name in names:
        line = f"{name:<24} {np.median(get(name, 'pairs')):>14.2f}"
        for what, width in (("step", 17), ("rebuild", 19)):
            ratio = get(name, what) / get("prototype", what)
            text = "" if name == "prototype" else f"{np.median(ratio):.3f} ({ratio.min():.3f} ... {ratio.max():.3f})"
            line += f" {np.median(get(name, what)):>{width}.1f}  {text:<24}"
            result.setdefault(name, {})[what + "_ratio"] = float(np.median(ratio))
        print(line.rstrip())
    best = {name: {what: get(name, what).min() for what in ("step", "rebuild")} for name in names}
    print("smallest of all rounds, ratio: " + "; ".join(f"{name}: step {best[name]['step'] / best['prototype']['step']:.3f}, rebuild "
                                                        f"{best[name]['rebuild'] / best['prototype']['rebuild']:.3f}" for name in names[1:]))
    ke = prototype(args, "check", r"KE/N", [r"KE/N ([-+.e\d]+)"])[0]
    own = [talus(args, scene, args.check_steps, 0, law)[0]["kinetic_energy"] / len(radius) for law in ([], OWN_LAW)]
    print(f"translational kinetic energy per particle after {args.check_steps} steps: prototype {ke:.5g}, Talus {own[0]:.5g} "
          f"({100 * (own[0] / ke - 1):+.3f} %), with the prototype's law {own[1]:.5g} ({100 * (own[1] / ke - 1):+.3f} %)")
    failed = False
    for what, mark in (("step", 1.0), ("rebuild", 0.6)):
        value = result["talus"][what + "_ratio"]
        failed |= value > mark
        print(f"{what:<8} {value:.3f} x the prototype's, mark {mark:g}: {'holds' if value <= mark else 'DOES NOT HOLD'}")
    if args.json:
        with open(args.json, "w") as f:
            json.dump(result, f, indent=1)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
