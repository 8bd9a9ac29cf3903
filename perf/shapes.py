#!/usr/bin/env python3
"""What grains that are no spheres cost: rows of clumps and ellipsoids beside spheres, one core, interleaved.

Beds at rest in a box that is periodic in x and y: spheres; rods of three spheres, with as many rows; ellipsoids 2 : 1.4 : 1 of
the spheres' volume. Each is settled once; each round then continues all of them in turn. Printed: ns per row and step, contacts
per row, and the medians of the ratios within a round. Mark: a clump's row costs at most 1.25 times a sphere.

Settled beds are kept in build/shapes: --prepare makes them and ends, so that the timed part can run on a quiet machine; --write
puts the table on perf/measured/shapes.md.

LIGGGHTS as Debian builds it has no superquadrics (USE_SUPERQUADRICS is off): this is found out by a scene of two lines and
said. LAMMPS of Debian 12 has none either.

Usage: python3 perf/shapes.py [--rows 12000] [--rounds 9] [--steps 1000] [--settle 0.3] [--talus PATH] [--liggghts PATH] [--write]
"""
import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys

from page_table import write_table

HERE = os.path.dirname(os.path.abspath(__file__))
MARK = 1.25
STEP = 8e-6  # [s]
LAYERS = 8
SCENE = """
seed = 5
gravity = [0, 0, -9.81]
[domain]
lower = [0, 0, 0]
upper = [{side:.9g}, {side:.9g}, {height:.9g}]
boundary = ["periodic", "periodic", "wall"]
[time]
step = {step}
duration = 100
[[material]]
name = "m"
density = 2500
[contact]
normal_stiffness = 2000
tangential_stiffness = 600
restitution = 0.5
friction = 0.4
{shape}
[[source]]
kind = "random"
number = {number}
{use}
region = {{ lower = [0, 0, 0], upper = [{side:.9g}, {side:.9g}, {height:.9g}] }}
[output]
checkpoint_wall = 0
"""
ROD = '[[shape]]\nname = "s"\nspheres = [0, 0, -0.001, 0.001, 0, 0, 0, 0.001, 0, 0, 0.001, 0.001]\n'
EGG = '[[shape]]\nname = "s"\nkind = "superquadric"\nsemi_axes = [0.00142, 0.00099, 0.00071]\n'
USE = 'shape = "s"'


def beds(rows):
    """Name: (shape, the source's word for it, grains, rows per grain, reach of a grain [m])."""
    return {"spheres": ("", "size = { diameter = 0.002 }", rows, 1, 1.0e-3),
            "rods": (ROD, USE, rows // 3, 3, 2.0e-3),
            "ellipsoids": (EGG, USE, rows, 1, 1.42e-3)}


def run(args, scene, folder, extra, talus=None):
    command = ["taskset", "-c", str(args.core), talus or args.talus, "run", scene, "--threads", "1", "--quiet", "--json", "--overwrite", "--out",
               folder, *extra]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"shapes.py: {' '.join(command)}\n{done.stderr[-1500:]}")
    return json.loads(done.stdout)


def settle(args, name, bed):
    shape, use, number, _, reach = bed
    side = (args.rows / LAYERS) ** 0.5 * 2e-3
    height = number * (2 * reach) ** 3 / (0.35 * side * side)
    scene = os.path.join(args.out, name + ".toml")
    text = SCENE.format(step=STEP, side=side, height=height, shape=shape, number=number, use=use)
    last = round((args.settle + (2 * height / 9.81) ** 0.5) / STEP)
    folder = os.path.join(args.out, "settled-" + name)
    if not kept(scene, text, folder, last):
        with open(scene, "w", encoding="utf-8") as f:
            f.write(text)
        run(args, scene, folder, ["--steps", str(last)])
    return scene, folder, last


def kept(scene, text, folder, last):
    """The bed of an earlier call."""
    if not os.path.exists(os.path.join(folder, f"checkpoint-{last}.tcp")) or not os.path.exists(scene):
        return False
    with open(scene, encoding="utf-8") as f:
        return f.read() == text


def superquadrics_of(liggghts, folder):
    """Empty if the binary has them, else what it says."""
    deck = os.path.join(folder, "in.superquadric")
    with open(deck, "w", encoding="utf-8") as f:
        f.write("units si\natom_style superquadric\n")
    done = subprocess.run([liggghts, "-in", deck, "-log", "none"], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, errors="replace", check=False)
    errors = [line for line in done.stdout.splitlines() if "ERROR" in line]
    return errors[0] if errors else ""


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--talus", default=os.path.join(HERE, "..", "build", "talus"))
    p.add_argument("--liggghts", default="liggghts")
    p.add_argument("--rows", type=int, default=12000)
    p.add_argument("--rounds", type=int, default=9)
    p.add_argument("--warm", type=int, default=200)
    p.add_argument("--steps", type=int, default=1000)
    p.add_argument("--settle", type=float, default=0.3, help="after the fall of the highest grain [s]")
    p.add_argument("--prepare", action="store_true", help="settle the beds, time nothing")
    p.add_argument("--write", action="store_true", help="the table on perf/measured/shapes.md")
    p.add_argument("--before", help="another talus, timed on the same states: a column of the table")
    p.add_argument("--core", type=int, default=0)
    p.add_argument("--out", default=os.path.join(HERE, "..", "build", "shapes"))
    args = p.parse_args()
    args.out = os.path.abspath(args.out)
    os.makedirs(args.out, exist_ok=True)
    load = os.getloadavg()[0]
    print(f"load average {load:.1f}" + (": these rates are not to be quoted" if load > 0.5 else ""))
    if shutil.which(args.liggghts) is None:
        print(f"{args.liggghts}: not found")
    else:
        says = superquadrics_of(args.liggghts, args.out)
        print(f"{args.liggghts}: " + (f"no superquadrics ({says})" if says else "has superquadrics; no deck for it here"))
    all_beds = beds(args.rows)
    states = {name: settle(args, name, bed) for name, bed in all_beds.items()}
    if args.prepare:
        return 0
    cost, facts, before = {name: [] for name in all_beds}, {}, {name: [] for name in all_beds}
    for _ in range(args.rounds):
        for name, bed in all_beds.items():
            scene, folder, last = states[name]
            extra = ["--resume", folder, "--warm", str(args.warm), "--steps", str(last + args.warm + args.steps)]
            s = run(args, scene, os.path.join(args.out, "run"), extra)
            rows = bed[2] * bed[3]
            cost[name].append(1e9 * s["wall_s"] / (args.steps * rows))
            if args.before:
                other = run(args, scene, os.path.join(args.out, "run"), extra, args.before)
                before[name].append(1e9 * other["wall_s"] / (args.steps * rows))
            facts[name] = (rows, s["contacts"] / rows, s.get("solved_pairs", 0) / (rows * (args.steps + args.warm)), s.get("safe_pairs"))
    print(f"{'bed':<11} {'rows':>7} {'ns/row':>8} {'least':>8} {'most':>8} {'contacts/row':>13} {'solved/row':>11} {'safe':>6}")
    for name, values in cost.items():
        rows, contacts, solved, safe = facts[name]
        print(f"{name:<11} {rows:>7} {statistics.median(values):>8.1f} {min(values):>8.1f} {max(values):>8.1f} {contacts:>13.2f} "
              f"{solved:>11.2f} {'' if safe is None else safe:>6}")
    ratio = {name: statistics.median(a / b for a, b in zip(cost[name], cost["spheres"])) for name in ("rods", "ellipsoids")}
    if args.write:
        lines = ["| bed | rows | ns per row and step | / spheres | before | contacts per row | pairs solved per row |",
                 "|---|---|---|---|---|---|---|"]
        for name, values in cost.items():
            rows, contacts, solved, _ = facts[name]
            lines.append(f"| {name} | {rows} | {statistics.median(values):.1f} ({min(values):.1f} … {max(values):.1f}) | "
                         f"{ratio.get(name, 1):.2f} | {f'{statistics.median(before[name]):.1f}' if before[name] else ''} | {contacts:.2f} | {f'{solved:.2f}' if solved else ''} |")
        write_table(os.path.join(HERE, "measured", "shapes.md"), "speed", lines)
    holds = ratio["rods"] <= MARK
    print(f"a clump's row / a sphere = {ratio['rods']:.3f}  mark <= {MARK}: {'holds' if holds else 'DOES NOT HOLD'}")
    print(f"an ellipsoid / a sphere = {ratio['ellipsoids']:.2f}")
    return 0 if holds else 1


if __name__ == "__main__":
    sys.exit(main())
