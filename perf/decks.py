"""Input decks of LAMMPS and LIGGGHTS for the benchmark scenes, from one description of the physics.

Who calls it: peers.py. Invariant: the decks state the same physics as perf/scenes/NAME.toml:
  F_n = k_n delta n - m_eff gamma_n v_n,  F_t = -k_t xi - m_eff gamma_t v_t capped at mu |F_n|,  time step 1e-4,
fixed grains (type 2) carry no force among themselves. Deck variables: skin, warm, steps. The last `run` is the timed one.
LIGGGHTS damps tangentially only while a contact sticks (or not at all), LAMMPS always: kinetic energies differ a little.
"""
import states

KN, KT, GAMMA_N, MU, DT = 200000.0, 57142.857142857145, 50.0, 0.5, 1e-4
DENSITY = 1.909859317102744  # mass 1 at diameter 1


class Case:
    """One benchmark scene: its physics as far as it differs, and how the peers run it best."""

    def __init__(self, name, gravity, gamma_t=25.0, density=DENSITY, base=True, periodic="xy", skins=(0.02,),
                 silo=False, steps=2000):
        self.name, self.gravity, self.gamma_t, self.density = name, gravity, gamma_t, density
        self.base, self.periodic, self.skins, self.silo, self.steps = base, periodic, skins, silo, steps


CASES = {
    c.name: c
    for c in (
        Case("settle32", "down", skins=(0.02, 0.05)),
        Case("settle128", "down", skins=(0.02, 0.05)),
        Case("settle512", "down", skins=(0.02, 0.05), steps=1000),
        Case("chute32", "slope", gamma_t=0.0, density=1.0, skins=(0.2, 0.3)),
        Case("flow128", "slope", skins=(0.2, 0.3)),
        Case("gas128", None, base=False, periodic="xyz", skins=(0.1, 0.3)),
        Case("radii5", "down", skins=(0.02, 0.05, 0.2)),
        Case("hopper125", "down", base=False, periodic="", skins=(0.02, 0.05, 0.1), silo=True),
    )
}

LAMMPS = """units lj
atom_style sphere
boundary {boundary}
newton off
{processors}
comm_modify vel yes
read_data {data}
pair_style gran/hooke/history {kn:.12g} {kt:.12g} {gn:.12g} {gt:.12g} {mu:.12g} {tangential}
pair_coeff * *
neighbor ${{skin}} bin
neigh_modify every 1 delay 0
timestep {dt:.12g}
{base}{gravity}{walls}{integrate}
thermo_style custom step atoms ke
thermo_modify norm no lost warn
thermo 1000000
run ${{warm}}
run ${{steps}}
"""

LIGGGHTS = """units si
atom_style granular
atom_modify map array
boundary {boundary}
newton off
{processors}
communicate single vel yes
read_data {data}
fix p1 all property/global kn peratomtypepair 2 {kn} {kn} {kn} {kn}
fix p2 all property/global kt peratomtypepair 2 {kt} {kt} {kt} {kt}
fix p3 all property/global gamman peratomtypepair 2 {gn} {gn} {gn} {gn}
fix p4 all property/global gammat peratomtypepair 2 {gt} {gt} {gt} {gt}
fix p5 all property/global coefficientFriction peratomtypepair 2 {mu} {mu} {mu} {mu}
pair_style gran model hooke/stiffness tangential history tangential_damping {tangential}
pair_coeff * *
neighbor ${{skin}} bin
neigh_modify every 1 delay 0
timestep {dt:.12g}
{base}{gravity}{walls}{integrate}
thermo_style custom step atoms ke
thermo_modify norm no lost ignore
thermo 1000000
run ${{warm}}
run ${{steps}}
"""

BASE = "group bottom type 2\ngroup active subtract all bottom\nneigh_modify exclude group bottom bottom\n"


def boundary(case, code):
    if case.periodic == "xyz":
        return "p p p"
    if case.periodic == "xy":
        return "p p fs" if code == "lammps" else "p p f"
    return "f f f"


def gravity(case):
    if case.gravity is None:
        return ""
    return "fix g all gravity 1.0 " + ("vector 0 0 -1\n" if case.gravity == "down" else "chute 26.0\n")


def integrate(case):
    return "fix b bottom freeze\nfix i active nve/sphere" if case.base else "fix i all nve/sphere"


def lammps_walls(case):
    if not case.silo:
        return ""
    h = states.HOPPER
    law = f"hooke/history {KN:.12g} {KT:.12g} {GAMMA_N:.12g} {case.gamma_t:.12g} {MU} 1"
    return (f"region cyl cylinder z 0 0 {h['radius']} 0 {h['top']} open 1 open 2\n"
            f"region cone cone z 0 0 {h['outlet']} {h['radius']} {-h['cone_length']} 0 open 1 open 2\n"
            f"fix w1 all wall/gran/region {law} region cyl\nfix w2 all wall/gran/region {law} region cone\n")


def liggghts_walls(case, stl):
    if not case.silo:
        return ""
    law = "model hooke/stiffness tangential history"
    return (f"fix w1 all wall/gran {law} primitive type 1 zcylinder {states.HOPPER['radius']} 0.0 0.0 tangential_damping on\n"
            f"fix cone all mesh/surface file {stl} type 1\n"
            f"fix w2 all wall/gran {law} mesh n_meshes 1 meshes cone tangential_damping on\n")


def deck(code, case, data, stl):
    values = dict(kn=KN, kt=KT, gn=GAMMA_N, gt=case.gamma_t, mu=MU, dt=DT, data=data, boundary=boundary(case, code),
                  base=BASE if case.base else "", gravity=gravity(case), integrate=integrate(case),
                  processors="processors * * 1")
    if case.periodic == "xyz":
        values["processors"] = "processors * 1 1"
    if code == "lammps":
        return LAMMPS.format(tangential=1 if case.gamma_t > 0 else 0, walls=lammps_walls(case), **values)
    return LIGGGHTS.format(tangential="on" if case.gamma_t > 0 else "off", walls=liggghts_walls(case, stl), **values)
