"""LAMMPS and LIGGGHTS decks of a Problem with the linear law.

Who calls it: engine.py. Invariants: same physics as problem.talus_scene; type 1 free, 2 fixed, 3 driven; fixed and driven
grains have infinite mass in both codes (fix freeze) and do not touch each other. A deck writes dump.txt with 17 digits when
observed, and its last `run` is the timed one.
"""
import os

import numpy as np

from .problem import DRIVEN, FIXED

LAMMPS_HEAD = """units lj
atom_style sphere
boundary {boundary}
newton off
comm_modify vel yes
read_data grains.data
pair_style gran/hooke/history {kn} {kt} {gn} {gt} {mu} {damped}
pair_coeff * *
"""

LIGGGHTS_HEAD = """units si
atom_style granular
atom_modify map array
boundary {boundary}
newton off
communicate single vel yes
read_data grains.data
fix p1 all property/global kn peratomtypepair 3 {kn9}
fix p2 all property/global kt peratomtypepair 3 {kt9}
fix p3 all property/global gamman peratomtypepair 3 {gn9}
fix p4 all property/global gammat peratomtypepair 3 {gt9}
fix p5 all property/global coefficientFriction peratomtypepair 3 {mu9}
pair_style gran model hooke/stiffness tangential history tangential_damping {switch}
pair_coeff * *
"""


def write_data(path, p):
    with open(path, "w") as f:
        f.write(f"grains\n\n{len(p.grains)} atoms\n3 atom types\n\n")
        for k, a in enumerate("xyz"):
            f.write(f"{p.lower[k]:.17g} {p.upper[k]:.17g} {a}lo {a}hi\n")
        f.write("\nAtoms\n\n")
        for i, (g, kind) in enumerate(zip(p.grains, p.kind)):
            f.write(f"{i + 1} {kind + 1} {2 * g[3]:.17g} {p.density:.17g} {g[0]:.17g} {g[1]:.17g} {g[2]:.17g}\n")
        f.write("\nVelocities\n\n")
        for i, g in enumerate(p.grains):
            f.write(f"{i + 1} " + " ".join("%.17g" % v for v in g[4:10]) + "\n")


def deck(code, p, observed, skin, every=None):
    """Deck text. every: None = rebuild when needed; n = at fixed intervals without any check."""
    if p.law.hertz:
        raise ValueError("the peers damp Hertz contacts in another way: only the linear law is the same in all codes")
    numbers = {"kn": p.law.kn, "kt": p.law.kt, "gn": p.law.gn, "gt": p.law.gt, "mu": p.law.mu}
    values = {k: "%.17g" % v for k, v in numbers.items()}
    values.update({k + "9": " ".join([values[k]] * 9) for k in numbers})
    values["damped"], values["switch"] = ("1", "on") if p.law.gt > 0 else ("0", "off")
    values["boundary"] = " ".join("p" if a in p.periodic else "f" for a in "xyz")
    text = (LAMMPS_HEAD if code == "lammps" else LIGGGHTS_HEAD).format(**values)
    check = f"every {every} delay 0 check no" if every else "every 1 delay 0"
    text += f"neighbor {skin:.17g} bin\nneigh_modify {check}\ntimestep {p.dt:.17g}\n"
    fixed, driven = (p.kind == FIXED).any(), (p.kind == DRIVEN).any()
    if fixed or driven:
        text += ("group held type 2 3\ngroup active subtract all held\nneigh_modify exclude group held held\n"
                 "fix hold held freeze\nfix move active nve/sphere\n")
        if driven:
            text += f"group driven type 3\nvelocity driven set {p.drive:.17g} 0 0\nfix carry driven nve/noforce\n"
    else:
        text += "fix move all nve/sphere\n"
    strength = float(np.linalg.norm(p.gravity))
    if strength > 0:
        text += f"fix g all gravity {strength:.17g} vector " + " ".join("%.17g" % c for c in p.gravity) + "\n"
    for i, (z, side) in enumerate(p.planes):
        ends = f"{z:.17g} NULL" if side > 0 else f"NULL {z:.17g}"
        if code == "lammps":
            law = " ".join(values[k] for k in ("kn", "kt", "gn", "gt", "mu"))
            text += f"fix plane{i} all wall/gran hooke/history {law} {values['damped']} zplane {ends}\n"
        else:
            text += (f"fix plane{i} all wall/gran model hooke/stiffness tangential history primitive type 1 "
                     f"zplane {z:.17g} tangential_damping {values['switch']}\n")
    lost = "warn" if code == "lammps" else "ignore"
    text += f"thermo_style custom step atoms ke\nthermo_modify norm no lost {lost}\nthermo 100000000\n"
    if observed:
        fields = "id x y z vx vy vz omegax omegay omegaz"
        form = " ".join(["%d"] + ["%.17g"] * 9)
        text += f'dump out all custom {p.steps // p.frames} dump.txt {fields}\n'
        text += f'dump_modify out sort id format {"line " if code == "lammps" else ""}"{form}"\n'
        if every:  # the touching pairs that the list knows, to be compared with all that touch
            text += (f"compute known all pair/local dist cutoff radius\ndump known all local {p.steps // p.frames} known.txt index "
                     "c_known\n")
    return text + f"run {p.steps}\n"


def missed_contacts(folder, frames, p):
    """Touching pairs that the list of an unchecked run did not hold, summed over the frames after the start."""
    known = {}
    with open(os.path.join(folder, "known.txt")) as f:
        while f.readline():
            step = int(f.readline())
            f.readline()
            known[step] = int(f.readline())
            for _ in range(5 + known[step]):
                f.readline()
    missed, edge = 0, np.subtract(p.upper, p.lower)
    for step, rows in frames.items():
        if step == 0:
            continue
        touching, x, r = 0, rows[:, :3], p.grains[:, 3]
        for i in range(len(x) - 1):
            d = x[i + 1:] - x[i]
            for k, axis in enumerate("xyz"):
                if axis in p.periodic:
                    d[:, k] -= edge[k] * np.rint(d[:, k] / edge[k])
            touching += int(((d**2).sum(1) < (r[i + 1:] + r[i]) ** 2).sum())
        missed += touching - known[step]
    return missed


def read_dump(path, count):
    """Frames as {step: rows by id (x y z vx vy vz wx wy wz)}; a grain that was lost has NaN."""
    frames = {}
    with open(path) as f:
        while f.readline():
            step = int(f.readline())
            f.readline()
            n = int(f.readline())
            for _ in range(5):
                f.readline()
            block = np.array([f.readline().split() for _ in range(n)], float).reshape(n, 10)
            out = np.full((count, 9), np.nan)
            out[block[:, 0].astype(int) - 1] = block[:, 1:]
            frames[step] = out
    return frames
