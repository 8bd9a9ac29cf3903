#!/usr/bin/env python3
"""Error against run time: what a smaller step, another integrator, law, dashpot, list, softer contacts or another code buys.

  python3 perf/error_time.py --quick                   # all scenes, few points, three to eight minutes
  python3 perf/error_time.py                           # all scenes, all points: tens of minutes, resumable
  python3 perf/error_time.py --scenes normal,shear     # some of: normal oblique bounce stack sticking gas shear impacts
                                                       #          sliding frictional rods boxes cooling hopper chute
  python3 perf/error_time.py --wrap "taskset -c 1"     # around the timed batches (each at most about 40 s)

Writes OUT/error_time.html (self-contained, begins with the summary), .csv, .json and summary.md; OUT is build/error_time. Results are kept under OUT/cache by
input, command and program, so that a second call only does what is missing; --fresh starts over. Talus is found in
build/talus (--talus PATH); LAMMPS and LIGGGHTS (apt: lammps, liggghts) are taken from the path if they are there. Needs
python3-numpy and python3-matplotlib. Exit code 1: a claim that has to hold does not (same bits for every list and
instruction set, no missed contact, convergence to the closed forms); 2: something could not be run.
"""
import argparse
import csv
import json
import math
import os
import re
import shutil
import subprocess
import sys
import time

try:
    import numpy  # noqa: F401  (the modules below need it)
except ImportError:
    sys.exit("error_time.py needs numpy (apt-get install python3-numpy python3-matplotlib)")

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from error_time import closed_forms, findings, scenes_bodies, scenes_bulk, scenes_exact, scenes_paths, scenes_sliding  # noqa: E402
from error_time.engine import Engine, Failure, Progress  # noqa: E402

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
SCENES = {s.name: s for s in scenes_exact.SCENES + scenes_paths.SCENES + scenes_sliding.SCENES + scenes_bodies.SCENES + scenes_bulk.SCENES}
FIELDS = ["scene", "label", "family", "code", "steps_per_contact", "softening", "dt", "steps", "grains", "wall_s", "wall_low_s",
          "wall_high_s", "timed_steps", "rounds", "error", "error_half_width", "energy_residual", "missed_contacts",
          "audited_steps", "rebuilds", "state_hash", "note", "stopped", "load_average"]


def features_of(args):
    """What this build and machine offer: list policies, precisions, instruction sets, peers."""
    policies = choices_of(args.talus, "list.policy")
    inexact = [p for p in policies if re.search("fixed|interval|every", p)]
    help_text = subprocess.run([args.talus, "help", "scene"], stdout=subprocess.PIPE, text=True, check=True).stdout
    keys = [k for k in re.findall(r"^\s+(\S*precision)\s", help_text, re.M)]
    precisions = [(k, c) for k in keys for c in choices_of(args.talus, k)]
    with open("/proc/cpuinfo") as f:
        flags = f.read()
    isas = ["sse2"] + [i for i, flag in (("avx2", "avx2"), ("avx512", "avx512dq")) if flag in flags] + ["scalar"]
    return {"exact_policies": [p for p in policies if p not in inexact], "inexact_policies": inexact,
            "precisions": [(k, c) for k, c in precisions if c not in ("exact", "double")], "isas": isas,
            "lammps": bool(args.lammps), "liggghts": bool(args.liggghts)}


def choices_of(talus, key):
    text = subprocess.run([talus, "help", "scene", key], stdout=subprocess.PIPE, text=True, check=True).stdout
    found = re.search(r"one of (.+)", text)
    return [c.strip() for c in found.group(1).split(",")] if found else []


def observe(engine, scene, setting, known):
    """Outcomes for all seeds; only the first one is audited. known: those of earlier settings by label. A setting that has to have
    the bits of an earlier one, and has them for the first seed, takes that one's outcomes for the others."""
    def run(seed):
        return engine.observe(setting.code, scene.build(setting, seed), setting.peer, setting.may_stop,
                              audited=seed == scene.seeds[0])
    first, alike = run(scene.seeds[0]), known.get(setting.same_bits_as)
    if first.stopped:
        return [first]
    if alike and alike[0].hash == first.hash:
        return [first] + alike[1:]
    return [first] + engine.at_once(run, scene.seeds[1:])


def measure(engine, scene, settings, progress):
    rows, timed, known = [], [], {}
    for setting in settings:
        outcomes = known[setting.label] = observe(engine, scene, setting, known)
        p = scene.build(setting, scene.seeds[0])
        stopped = next((o.stopped for o in outcomes if o.stopped), None)
        row = dict.fromkeys(FIELDS)
        row.update(scene=scene.name, label=setting.label, family=setting.family, code=setting.code,
                   steps_per_contact=setting.q, softening=setting.soft, dt=p.dt, steps=p.steps, grains=len(p.grains),
                   stopped=stopped)
        if stopped:
            shown = "stopped: " + stopped
        else:
            judged, first = scene.judge(setting, outcomes), outcomes[0]
            row.update(error=judged.error, error_half_width=judged.half, note=judged.note, missed_contacts=first.missed,
                       audited_steps=first.audited if first.missed is not None else None, rebuilds=first.rebuilds,
                       state_hash=first.hash, energy_residual=first.energy if scene.energy_counts else None)
            timed.append((row, (setting.code, p, setting.peer, first)))
            shown = f"error {judged.error:.2e}"
        rows.append(row)
        progress.step(f"{scene.name}: {setting.label}: {shown}")
    scene.finish(rows)
    clocks = engine.time([t[1] for t in timed], lambda n: progress.step(f"{scene.name}: {n} settings timed", n))
    differs = []
    for (row, _), (median, low, high, steps, code_hash, load) in zip(timed, clocks):
        scale = row["steps"] / steps
        row.update(wall_s=median * scale, wall_low_s=low * scale, wall_high_s=high * scale, timed_steps=steps,
                   rounds=engine.rounds, load_average=load)
        # fast arithmetic: the kernels that sum energies round otherwise, so a watched run has bits of its own
        if row["family"].startswith("precision"):
            continue
        if code_hash and steps == row["steps"] and code_hash != row["state_hash"]:
            differs.append(f"{scene.name}, {row['label']}: the timed run ended in {code_hash}, the observed one in "
                           f"{row['state_hash']}: watching it changed it")
    return rows, differs






def parse_arguments():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--quick", action="store_true", help="few points, small scenes")
    p.add_argument("--scenes", default="all", help="comma-separated: " + ", ".join(SCENES))
    p.add_argument("--out", default=os.path.join(ROOT, "build", "error_time"))
    p.add_argument("--talus", default=os.path.join(ROOT, "build", "talus"))
    p.add_argument("--lammps", default=shutil.which("lmp"), help="binary (default: lmp of the path; empty: leave out)")
    p.add_argument("--liggghts", default=shutil.which("liggghts"), help="binary (default: liggghts of the path; empty: leave out)")
    p.add_argument("--rounds", type=int, default=3, help="interleaved repeats of each timed run")
    p.add_argument("--wrap", default="", help="command that the timed batches run under, for example 'taskset -c 1'")
    p.add_argument("--audit", type=float, default=0.2, help="seconds of brute-force list audit per point; 0: none")
    p.add_argument("--seeds", type=int, help="of the scenes judged by averages (default: 3 with --quick, else 20)")
    p.add_argument("--jobs", type=int, default=os.cpu_count(), help="runs at a time where nothing is timed")
    p.add_argument("--fresh", action="store_true", help="forget kept results")
    args = p.parse_args()
    args.scenes = list(SCENES) if args.scenes == "all" else args.scenes.split(",")
    for s in args.scenes:
        if s not in SCENES:
            p.error(f"unknown scene '{s}'; there are {', '.join(SCENES)}")
    if args.rounds < 1:
        p.error("--rounds must be at least 1")
    if args.seeds is not None and args.seeds < 2:
        p.error("--seeds must be at least 2: an interval needs a scatter")
    if args.jobs < 1:
        p.error("--jobs must be at least 1")
    if not shutil.which(args.talus):
        p.error(f"{args.talus} not found: build it, or give --talus PATH")
    args.talus = os.path.abspath(args.talus)
    return args


def write_tables(folder, results, facts):
    path = os.path.join(folder, "error_time")
    with open(path + ".csv", "w", newline="") as f:
        out = csv.DictWriter(f, FIELDS)
        out.writeheader()
        for r in results:
            out.writerows(r["rows"])
    with open(path + ".json", "w") as f:
        json.dump({"facts": facts, "scenes": results}, f, indent=1, allow_nan=False,
                  default=lambda v: v.item())  # numpy scalars


def finite(rows):
    """Infinities (an interval from one seed) as null, for JSON."""
    return [{k: None if isinstance(v, float) and not math.isfinite(v) else v for k, v in r.items()} for r in rows]


def main():
    args = parse_arguments()
    closed_forms.verify()
    if args.fresh:
        shutil.rmtree(os.path.join(args.out, "cache"), ignore_errors=True)
    features = features_of(args)
    engine = Engine(os.path.abspath(args.out), {"talus": args.talus, "lammps": args.lammps, "liggghts": args.liggghts}, args.wrap,
                    args.rounds, args.audit, args.jobs)
    started = time.time()
    chosen = [SCENES[name](args.quick) for name in args.scenes]
    for scene in chosen:
        if args.seeds and scene.kind == "bulk":
            scene.use_seeds(args.seeds)
    progress = Progress(sum(2 * len(s.settings(features)) + 4 for s in chosen))
    results, wrong = [], []
    for scene in chosen:
        progress.step(f"{scene.name}: references and initial states", 0)
        scene.prepare(engine)
        progress.step(f"{scene.name}: references ready", 4)
        settings = scene.settings(features)
        rows, differs = measure(engine, scene, settings, progress)
        failed, held = findings.claims(scene, settings, rows)
        wrong += failed + differs
        results.append({"name": scene.name, "title": scene.title, "seeds": len(scene.seeds), "norm": scene.norm, "reference": scene.reference,
                        "kind": scene.kind, "notes": scene.notes + scene.limits, "held": held, "wrong": failed + differs, "rows": rows})
    with open("/proc/cpuinfo") as f:
        model = re.search(r"model name\s*: (.*)", f.read())
    facts = {"quick": args.quick, "rounds": args.rounds, "wall_of_study_s": time.time() - started, "cpu": model and model.group(1),
             "cores": os.cpu_count(), "talus": engine.identity["talus"][:16], "features": features, "command": " ".join(sys.argv)}
    from error_time import page  # needs matplotlib: a missing one must not cost the measurements
    print_advice(results)
    page.write(os.path.join(args.out, "error_time.html"), results, facts)
    with open(os.path.join(args.out, "summary.md"), "w") as f:
        f.write(findings.summary_table(results))
    for r in results:
        r["rows"] = finite(r["rows"])
    write_tables(args.out, results, facts)
    shutil.rmtree(engine.work, ignore_errors=True)
    print(f"{engine.ran} new runs, {time.time() - started:.0f} s; report: {os.path.join(args.out, 'error_time.html')}")
    for sentence in wrong:
        print("DOES NOT HOLD: " + sentence)
    return 1 if wrong else 0


def print_advice(results):
    """The summary of the page, as text."""
    for r in results:
        print(f"\n{r['title']}: cheapest setting")
        for tolerance, best in findings.summary(r["rows"]):
            print(f"  {100 * tolerance:g} %: " + "; ".join(f"{code}: {findings.describe(row)}" for code, row in best.items()))
        if r["kind"] == "bulk":
            print(f"  {findings.statistics(r['rows'], r['seeds'])}")


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Failure as e:
        print(f"error_time.py: {e}", file=sys.stderr)
        sys.exit(2)
