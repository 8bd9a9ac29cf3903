#!/usr/bin/env python3
"""Talus beside LAMMPS and LIGGGHTS on the same states: speed in interleaved rounds, agreement of kinetic energies.

  python3 perf/peers.py                                   # settle32, one core
  python3 perf/peers.py --scenes all --rounds 9 --cores 1,2 --json peers.json
  python3 perf/peers.py --install                         # the peers from Debian (apt packages lammps, liggghts)
  python3 perf/peers.py --lammps ~/lmp-native ...         # or binaries of your own
  python3 perf/peers.py --scenes all --marks              # exit 1 if a scene's speed mark does not hold on one core

Every round runs A B C A B C ... on the same pinned cores, so that a slow minute of the machine hits all codes alike; ratios
are taken within a round. Timed: `steps` steps after `warm` untimed ones, rebuilds included, start-up excluded (Talus:
--warm; peers: "Loop time" of the second run). Talus runs the scene's defaults (centred dashpot, exact lever) in its exact
mode; only the agreement of kinetic energies uses LAMMPS' form of the law. Needs python3-numpy, taskset; mpirun for two cores.
"""
import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import time

import numpy as np

import decks
import states

ROOT = os.path.dirname(states.HERE)
LAMMPS_FORM = ["contact.dashpot=lagged", "contact.lever=radius", "contact.synchronised=false",
               "contact.sliding=balanced", "contact.friction_limit=total"]
CODES = ("talus", "lammps", "liggghts")
# Speed marks on one core: Talus is to be so many times as fast as this peer ("better": the faster of the two).
MARKS = {"settle32": (3.0, "lammps"), "settle128": (3.0, "lammps"), "settle512": (3.0, "lammps"), "chute32": (2.5, "lammps"),
         "flow128": (2.5, "lammps"), "gas128": (2.0, "lammps"), "radii5": (3.0, "better"), "hopper125": (3.0, "better")}
APT_SHARE = 0.85  # of the speed of a native -O3 build of the same peer


class Failure(Exception):
    pass


def load_average():
    return os.getloadavg()[0]


def command_output(command, cwd, env=None):
    done = subprocess.run(command, cwd=cwd, env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if done.returncode != 0:
        tail = "\n".join(done.stdout.splitlines()[-12:])
        raise Failure(f"{' '.join(command)}\nexit code {done.returncode}:\n{tail}")
    return done.stdout


class Runner:
    """Runs one code on one scene; every method returns particle-steps/s and the facts around it."""

    def __init__(self, args):
        self.args = args
        self.work = os.path.abspath(args.work)
        os.makedirs(self.work, exist_ok=True)
        self.binary = {"talus": args.talus, "lammps": args.lammps, "liggghts": args.liggghts}
        self.prepared = {}

    def prepare(self, case):
        """Data file, decks and the box of a scene."""
        if case.name in self.prepared:
            return self.prepared[case.name]
        state, box = states.load(case.name)
        data = os.path.join(self.work, case.name + ".data")
        stl = os.path.join(self.work, case.name + ".stl")
        states.write_lammps_data(data, state, box, case.density)
        if case.silo:
            states.cone_stl(stl)
        for code in ("lammps", "liggghts"):
            with open(os.path.join(self.work, f"{case.name}.{code}"), "w") as f:
                f.write(decks.deck(code, case, data, stl))
        self.prepared[case.name] = (len(state), box)
        return self.prepared[case.name]

    def pin(self, cores):
        first = self.args.first_core
        return ["taskset", "-c", ",".join(str(first + k) for k in range(cores))]

    def talus(self, case, cores, warm, steps, extra=()):
        n, box = self.prepare(case)
        command = self.pin(cores) + [
            self.binary["talus"], "run", os.path.join(states.HERE, "scenes", case.name + ".toml"), "--threads", str(cores),
            "--warm", str(warm), "--steps", str(warm + steps), "--quiet", "--json", "--overwrite", "--out",
            os.path.join(self.work, "talus-run")]
        for key, corner in (("lower", box[0]), ("upper", box[1])):
            command += ["--set", f"domain.{key}=[{', '.join('%.17g' % v for v in corner)}]"]
        for item in list(extra) + self.args.set:
            command += ["--set", item]
        if self.args.isa:
            command += ["--isa", self.args.isa]
        env = dict(os.environ, TALUS_ISA="")
        summary = json.loads(command_output(command, self.work, env))
        if summary["particles"] != n:
            raise Failure(f"talus: {summary['particles']} of {n} particles are left: the rates would not compare")
        return {"rate": n * steps / summary["wall_s"], "rebuilds": sum(s >= warm for s in summary["rebuild_steps"]), "ke": summary["kinetic_energy"],
                "detail": summary}

    def peer(self, code, case, cores, warm, steps, skin):
        n, _ = self.prepare(case)
        deck = os.path.join(self.work, f"{case.name}.{code}")
        command = self.pin(cores)
        if cores > 1:
            command += ["mpirun", "--allow-run-as-root", "--oversubscribe", "--bind-to", "none", "-np", str(cores)]
        command += [self.binary[code], "-in", deck, "-log", "none", "-var", "skin", str(skin), "-var", "warm", str(warm),
                    "-var", "steps", str(steps)]
        out = command_output(command, self.work, dict(os.environ, OMP_NUM_THREADS="1"))
        loops = re.findall(r"Loop time of ([0-9.eE+-]+) on \d+ procs for (\d+) steps with (\d+) atoms", out)
        if not loops or int(loops[-1][1]) != steps:
            raise Failure(f"{code}: no 'Loop time' of {steps} steps in its output")
        seconds, _, atoms = loops[-1]
        if int(atoms) != n:
            raise Failure(f"{code}: {atoms} of {n} atoms are left: the rates would not compare")
        builds = re.findall(r"Neighbor list builds = (\d+)", out)
        last = [line.split() for line in out.splitlines() if re.fullmatch(rf"\s*{warm + steps}\s+{n}\s+\S+\s*", line)]
        return {"rate": n * steps / float(seconds), "rebuilds": int(builds[-1]) if builds else None,
                "ke": float(last[-1][2]) if last else None}

    def run(self, code, case, cores, warm, steps, skin):
        if code == "talus":
            return self.talus(case, cores, warm, steps)
        return self.peer(code, case, cores, warm, steps, skin[code])

    def tune(self, case, cores, codes):
        """The fastest of the case's skins for each peer, from short runs: a fair comparison uses a peer's best."""
        skin = {}
        for code in codes:
            if code == "talus":
                continue
            if self.args.skin is not None or len(case.skins) == 1:
                skin[code] = self.args.skin if self.args.skin is not None else case.skins[0]
                continue
            rates = {s: self.peer(code, case, cores, self.args.warm, max(200, self.args.steps_of(case) // 4), s)["rate"]
                     for s in case.skins}
            skin[code] = max(rates, key=rates.get)
        return skin


def interval(ratios, rng, draws=4000):
    """95 % bootstrap interval of the median of per-round ratios."""
    ratios = np.asarray(ratios)
    if len(ratios) < 3:
        return float(ratios.min()), float(ratios.max())
    medians = np.median(ratios[rng.integers(0, len(ratios), (draws, len(ratios)))], axis=1)
    return tuple(float(v) for v in np.percentile(medians, [2.5, 97.5]))


def measure(runner, case, cores, codes, rounds, warm, steps):
    skin = runner.tune(case, cores, codes)
    rates = {c: [] for c in codes}
    facts = {}
    loads = []
    for r in range(rounds):
        for code in codes:
            loads.append(load_average())
            facts[code] = runner.run(code, case, cores, warm, steps, skin)
            rates[code].append(facts[code]["rate"])
        shown = "  ".join(f"{c} {rates[c][-1] / 1e6:.2f}" for c in codes)
        print(f"  {case.name}, {cores} core(s), round {r + 1}/{rounds}: {shown} M/s", file=sys.stderr)
    result = {"scene": case.name, "particles": runner.prepared[case.name][0], "cores": cores, "warm": warm, "steps": steps,
              "skin": skin, "load_average": max(loads), "codes": {}}
    rng = np.random.default_rng(1)
    for code in codes:
        r = np.array(rates[code])
        entry = {"median": float(np.median(r)), "spread": float((r.max() - r.min()) / np.median(r)), "rates": r.tolist(),
                 "rebuilds": facts[code]["rebuilds"]}
        if code != "talus" and "talus" in codes:
            ratios = np.array(rates["talus"]) / r
            low, high = interval(ratios, rng)
            entry.update(ratio=float(np.median(ratios)), low=low, high=high)
        result["codes"][code] = entry
    return result


def agreement(runner, case, codes, steps=500):
    """Translational kinetic energy after `steps` steps from the state, all codes from empty contact histories."""
    skin = {c: case.skins[0] for c in codes}
    ke = {"talus (defaults)": runner.talus(case, 1, 0, steps)["ke"],
          "talus (LAMMPS form)": runner.talus(case, 1, 0, steps, LAMMPS_FORM)["ke"]}
    for code in codes:
        if code != "talus":
            ke[code] = runner.peer(code, case, 1, 0, steps, skin[code])["ke"]
    return ke


def print_rates(results):
    print(f"{'scene':<10} {'cores':>5} {'code':<9} {'M p-steps/s':>11} {'spread':>7} {'rebuilds':>8}  Talus / code (95 %)")
    for r in results:
        for code, e in r["codes"].items():
            ratio = f"{e['ratio']:.2f}  ({e['low']:.2f} ... {e['high']:.2f})" if "ratio" in e else ""
            rebuilds = "?" if e["rebuilds"] is None else e["rebuilds"]
            print(f"{r['scene']:<10} {r['cores']:>5} {code:<9} {e['median'] / 1e6:>11.2f} {100 * e['spread']:>6.1f}% {rebuilds:>8}  {ratio}")


def origin(path):
    """apt or path: where a peer's binary comes from."""
    return "apt" if os.path.realpath(shutil.which(path) or path).startswith("/usr/bin/") else "path"


def mark_of(result, peers):
    """(mark, peer, ratio, low, high, holds) of a one-core result; None without a mark or without the peer it names. "Better" is the
    peer with the higher median rate, and both have to be there."""
    mark, peer = MARKS.get(result["scene"], (None, None))
    if mark is None or result["cores"] != 1 or "talus" not in result["codes"]:
        return None
    if peer == "better":
        if any(c not in result["codes"] for c in peers):
            return None
        peer = max(peers, key=lambda c: result["codes"][c]["median"])
    entry = result["codes"].get(peer)
    return entry and (mark, peer, entry["ratio"], entry["low"], entry["high"], entry["ratio"] >= mark)


def print_marks(results, binaries):
    """The marks of the scenes against the peers as they were run. Returns whether all hold; a scene that cannot be judged does not."""
    held, noted = True, False
    print(f"\n{'mark, one core':<14} {'at least':>24}  {'measured (95 % of the median)':<30} {'':<14} note")
    for r in results:
        if r["cores"] != 1 or r["scene"] not in MARKS:
            continue
        found = mark_of(r, CODES[1:])
        if found is None:
            held = False
            print(f"{r['scene']:<14} cannot be judged: a peer is missing")
            continue
        mark, peer, ratio, low, high, ok = found
        held = held and ok
        note = ""
        if origin(binaries[peer]) == "apt":
            noted = True
            note = f"~ {APT_SHARE * ratio:.2f} x a native build"
        print(f"{r['scene']:<14} {f'{mark:.1f} x {peer} ({origin(binaries[peer])})':>24}  {f'{ratio:.2f}  ({low:.2f} ... {high:.2f})':<30} "
              f"{'holds' if ok else 'DOES NOT HOLD':<14} {note}")
    if noted:
        print(f"The marks are meant against native -O3 builds; an apt binary has about {APT_SHARE} of the speed of one: the notes convert, the "
              "verdicts do not.")
    return held


def print_agreement(name, ke):
    reference = ke.get("lammps") or ke["talus (LAMMPS form)"]
    print(f"\nkinetic energy of {name} after 500 steps (translation):")
    for code, value in ke.items():
        shown = "not printed by the code" if value is None else f"{value:.6g}  {100 * (value / reference - 1):+.4f} %"
        print(f"  {code:<20} {shown}")


def parse_arguments():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--talus", default=os.path.join(ROOT, "build", "talus"))
    p.add_argument("--lammps", default=shutil.which("lmp"), help="binary (default: lmp of the path)")
    p.add_argument("--liggghts", default=shutil.which("liggghts"), help="binary (default: liggghts of the path)")
    p.add_argument("--install", action="store_true", help="install the peers with apt first")
    p.add_argument("--scenes", default="settle32", help="comma-separated, or all: " + ", ".join(decks.CASES))
    p.add_argument("--codes", default=",".join(CODES))
    p.add_argument("--rounds", type=int, default=7)
    p.add_argument("--warm", type=int, default=200, help="untimed steps before the timed ones")
    p.add_argument("--steps", type=int, help="timed steps (default by scene)")
    p.add_argument("--cores", default="1", help="core counts, for example 1,2")
    p.add_argument("--first-core", type=int, default=0, help="pin from this core on")
    p.add_argument("--skin", type=float, help="skin of the peers (default: the best of a few per scene)")
    p.add_argument("--isa", help="instruction set of Talus")
    p.add_argument("--set", action="append", default=[], help="section.key=value for Talus (repeatable)")
    p.add_argument("--no-agreement", action="store_true", help="leave out the kinetic energies")
    p.add_argument("--mark", type=float, help="exit 1 if Talus / LAMMPS is below this on any scene with one core")
    p.add_argument("--marks", action="store_true", help="exit 1 if the mark of a scene does not hold on one core")
    p.add_argument("--json", help="write all figures to this file")
    p.add_argument("--work", default=os.path.join(ROOT, "build", "peers"))
    args = p.parse_args()
    args.steps_of = lambda case: args.steps or case.steps
    args.scenes = list(decks.CASES) if args.scenes == "all" else args.scenes.split(",")
    for s in args.scenes:
        if s not in decks.CASES:
            p.error(f"unknown scene '{s}'; there are {', '.join(decks.CASES)}")
    args.codes = args.codes.split(",")
    if any(c not in CODES for c in args.codes):
        p.error("codes are " + ", ".join(CODES))
    args.cores = [int(c) for c in args.cores.split(",")]
    return args


def install():
    sudo = [] if os.geteuid() == 0 else ["sudo"]
    subprocess.run(sudo + ["apt-get", "-qq", "update"], check=True)
    subprocess.run(sudo + ["env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "-qq", "install", "-y",
                           "--no-install-recommends", "lammps", "liggghts"], check=True)


def main():
    args = parse_arguments()
    if args.install:
        install()
        args.lammps = args.lammps or shutil.which("lmp")
        args.liggghts = args.liggghts or shutil.which("liggghts")
    for code in args.codes:
        if not getattr(args, code) or not shutil.which(getattr(args, code)):
            raise SystemExit(f"peers.py: {code} not found; give --{code} PATH, "
                             + ("build it" if code == "talus" else "or --install, or leave it out with --codes"))
    cpus = os.cpu_count() or 1
    if load_average() > 0.3 * cpus:
        print(f"warning: load average {load_average():.1f} on {cpus} cores: other programs run, these rates are not to be "
              "quoted", file=sys.stderr)
    states.TALUS = args.talus
    runner = Runner(args)
    results, energies = [], {}
    started = time.time()
    for name in args.scenes:
        case = decks.CASES[name]
        if not args.no_agreement:
            energies[name] = agreement(runner, case, args.codes)
        for cores in args.cores:
            results.append(measure(runner, case, cores, args.codes, args.rounds, args.warm, args.steps_of(case)))
    binaries = {c: getattr(args, c) for c in CODES}
    print("binaries: " + ", ".join(f"{c} {binaries[c]}" + (f" ({origin(binaries[c])})" if c != "talus" else "") for c in args.codes))
    print(f"{args.rounds} interleaved rounds, {args.warm} warm-up steps; spread = (max - min) / median; "
          f"largest load average {max(r['load_average'] for r in results):.1f} on {cpus} cores; "
          f"{time.time() - started:.0f} s in all\n")
    print_rates(results)
    held = print_marks(results, binaries)
    for name, ke in energies.items():
        print_agreement(name, ke)
    if args.json:
        with open(args.json, "w") as f:
            json.dump({"binaries": {c: [binaries[c], origin(binaries[c])] for c in args.codes}, "results": results,
                       "marks": {r["scene"]: mark_of(r, CODES[1:]) for r in results if r["cores"] == 1},
                       "kinetic_energy": energies}, f, indent=1)
    if args.marks and not held:
        return 1
    if args.mark is not None:
        low = [r for r in results if r["cores"] == 1 and r["codes"].get("lammps", {}).get("ratio", 1e9) < args.mark]
        for r in low:
            print(f"below the mark: {r['scene']}: {r['codes']['lammps']['ratio']:.2f} < {args.mark} x LAMMPS")
        return 1 if low else 0
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Failure as e:
        raise SystemExit(f"peers.py: {e}")
