#!/usr/bin/env python3
"""Oblique impacts in three dimensions: how far Talus and LAMMPS are from their own limits at N steps per contact.

Twenty impacts of unequal spheres with slip and spins in all directions, the linear law, both programs from the same
grains; the error is the largest difference of a velocity or surface speed to the same program's run at N = 64000, over
the impact speed. LAMMPS (gran/hooke/history) and Talus differ in their laws where a sliding contact has a tangential
dashpot and where the normal dashpot pulls (kernels/models/linear.hpp), so each is measured against itself.

Usage: python3 perf/tangential.py [--talus build/talus] [--lammps lmp]
"""
import argparse
import math
import os
import subprocess
import tempfile

import numpy as np

import states

STEPS = (20, 50, 200, 1000)
LIMIT = 64000
COUNT = 20


def impacts(e, damping, mu, seed):
    """Grains (x y z r vx vy vz wx wy wz) at the instant of touch, stiffnesses and rates; t_c = 1 for m_eff = 1/2.
    damping: ratio of the tangential dashpot; None: half the normal rate."""
    rng = np.random.default_rng(seed)
    log = math.log(e)
    zeta = -log / math.sqrt(math.pi**2 + log**2)
    kn = 0.5 * math.pi**2
    kt, gn = 2 / 7 * 0.8 * kn, 2 * zeta * math.pi
    gt = 0.5 * gn if damping is None else 2 * damping * math.sqrt(kt / 1.75)
    def direction():
        v = rng.normal(size=3)
        return v / np.linalg.norm(v)
    rows, phases = [], []
    for k in range(COUNT):
        a, b = rng.uniform(0.4, 0.6), rng.uniform(0.4, 0.8)
        n, vn = direction(), 0.02 * (a + b)
        t = direction()
        t -= t @ n * n
        v = -vn * n + 6 * mu * vn * rng.uniform() * t / np.linalg.norm(t)
        share, centre = rng.uniform(), np.array([4.0 * k + 2, 2, 2])
        spins = [3 * mu * vn * rng.uniform() / r * direction() for r in (a, b)]
        rows.append([*(centre + a * n), a, *(share * v), *spins[0]])
        rows.append([*(centre - b * n), b, *((share - 1) * v), *spins[1]])
        phases += 2 * [rng.uniform()]
    return np.array(rows), np.array(phases), (kn, kt, gn, gt, mu)


def started(grains, phases, n):
    """The grains so long before they touch that it happens within the second step."""
    out = grains.copy()
    out[:, :3] -= ((1 + phases) / n)[:, None] * grains[:, 4:7]
    return out


DENSITY = 1 / (math.pi / 6)  # mass 1 at diameter 1


def talus(binary, folder, grains, law, n):
    kn, kt, gn, gt, mu = law
    np.savetxt(os.path.join(folder, "grains.csv"), grains, "%.17g", ",", header="x,y,z,radius,vx,vy,vz,wx,wy,wz",
               comments="")
    steps = 3 * n
    with open(os.path.join(folder, "scene.toml"), "w") as f:
        f.write(f"""[domain]
lower = [0, 0, 0]
upper = [{4 * COUNT}, 4, 4]
boundary = "open"
[time]
step = {1 / n:.17g}
steps = {steps}
[[material]]
name = "grain"
density = {DENSITY:.17g}
[contact]
normal_stiffness = {kn:.17g}
tangential_stiffness = {kt:.17g}
normal_damping = {gn:.17g}
tangential_damping = {gt:.17g}
friction = {mu:.17g}
[[source]]
kind = "file"
file = "grains.csv"
[output]
vtkhdf = false
vtp = true
particles_every = {steps / n:.17g}
""")
    run = os.path.join(folder, "run")
    subprocess.run([binary, "run", os.path.join(folder, "scene.toml"), "--out", run, "--overwrite", "--quiet", "--threads", "1"],
                   check=True, capture_output=True)
    vtp = os.path.join(run, "vtp")
    last = max(x for x in os.listdir(vtp) if x.startswith("particles-"))
    c = states.read_vtp(os.path.join(vtp, last))
    out = np.empty((len(grains), 6))
    out[c["id"]] = np.hstack([c["velocity"], c["omega"]])
    return out


def lammps(binary, folder, grains, law, n):
    kn, kt, gn, gt, mu = law
    with open(os.path.join(folder, "grains.data"), "w") as f:
        f.write(f"grains\n\n{len(grains)} atoms\n1 atom types\n\n0 {4 * COUNT} xlo xhi\n0 4 ylo yhi\n0 4 zlo zhi\n\nAtoms\n\n")
        for i, g in enumerate(grains):
            f.write(f"{i + 1} 1 {2 * g[3]:.17g} {DENSITY:.17g} {g[0]:.17g} {g[1]:.17g} {g[2]:.17g}\n")
        f.write("\nVelocities\n\n")
        for i, g in enumerate(grains):
            f.write(f"{i + 1} " + " ".join("%.17g" % v for v in g[4:10]) + "\n")
    with open(os.path.join(folder, "deck"), "w") as f:
        f.write(f"""units lj
atom_style sphere
boundary f f f
newton off
comm_modify vel yes
read_data grains.data
pair_style gran/hooke/history {kn:.17g} {kt:.17g} {gn:.17g} {gt:.17g} {mu:.17g} 1
pair_coeff * *
neighbor 0.3 bin
fix move all nve/sphere
timestep {1 / n:.17g}
thermo 1000000
run {3 * n}
write_dump all custom dump.txt id vx vy vz omegax omegay omegaz modify format float %.17g
""")
    subprocess.run([binary, "-in", "deck", "-log", "none"], cwd=folder, check=True, capture_output=True)
    rows = np.loadtxt(os.path.join(folder, "dump.txt"), skiprows=9)
    return rows[np.argsort(rows[:, 0])][:, 1:]


def errors(run, grains, phases, law):
    speed = np.repeat(np.linalg.norm(grains[0::2, 4:7] - grains[1::2, 4:7], axis=1), 2)
    at = lambda n: run(started(grains, phases, n), law, n)
    limit = at(LIMIT)
    out = []
    for n in STEPS:
        d = at(n) - limit
        out.append(max((np.linalg.norm(d[:, :3], axis=1) / speed).max(),
                       (grains[:, 3] * np.linalg.norm(d[:, 3:], axis=1) / speed).max()))
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--talus", default="build/talus")
    parser.add_argument("--lammps", default="lmp")
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    binary = os.path.abspath(args.talus)
    print("| e | tangential damping | mu | " + " | ".join(f"N = {n}: Talus, LAMMPS, ratio" for n in STEPS) + " |")
    print("|---" * (3 + len(STEPS)) + "|")
    for e in (1.0, 0.8, 0.5, 0.3):
        for damping in (0.0, 0.02, None, 0.3, 1.0):
            if e == 1 and damping is None:
                continue
            for mu in (0.05, 0.3, 1.0):
                grains, phases, law = impacts(e, damping, mu, args.seed)
                with tempfile.TemporaryDirectory() as folder:
                    own = errors(lambda g, q, n: talus(binary, folder, g, q, n), grains, phases, law)
                    peer = errors(lambda g, q, n: lammps(args.lammps, folder, g, q, n), grains, phases, law)
                name = "half the normal" if damping is None else f"{damping:g}"
                print(f"| {e:g} | {name} | {mu:g} | " +
                      " | ".join(f"{a:.1e}, {b:.1e}, {b / a:.1f}" for a, b in zip(own, peer)) + " |", flush=True)


if __name__ == "__main__":
    main()
