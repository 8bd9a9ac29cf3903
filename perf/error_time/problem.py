"""A scene as data: grains, box, law, fixed and driven grains, planes; written as a Talus scene here, as decks in peers.py.

Who calls it: the scene modules build a Problem per setting, engine.py writes and runs it. Invariants: every code reads the
same numbers (17 digits); the physics of the linear law is F_n = k_n delta - g_n m_eff v_n, F_t = -k_t xi - g_t m_eff v_t, |F_t| <= mu F_n.
Units are reduced: d = m = 1 for the grains, and g = 1 or the contact time of the hard law = 1.
"""
import dataclasses
import math

import numpy as np

FREE, FIXED, DRIVEN = 0, 1, 2
UNIT_DENSITY = 6 / math.pi  # mass 1 at diameter 1
COLUMNS = "x,y,z,r,vx,vy,vz,wx,wy,wz,fixed"


def contact_constants(kn, e, meff=0.5):
    """(rate of the dashpot, contact time) of the linear law for one effective mass."""
    log = -math.log(e)
    zeta = log / math.sqrt(math.pi**2 + log**2)
    omega = math.sqrt(kn / meff)
    return 2 * zeta * omega, math.pi / (omega * math.sqrt(1 - zeta**2))


@dataclasses.dataclass
class Law:
    """Linear by stiffness and rate; Hertz by Young's modulus and restitution. mu = 0: no tangential force at all."""
    kn: float = 0.0
    gn: float = 0.0
    kt: float = 0.0
    gt: float = 0.0
    mu: float = 0.0
    young: float = 0.0
    poisson: float = 0.25
    e: float = 1.0

    @property
    def hertz(self):
        return self.young > 0

    def softened(self, factor):
        """Stiffness / factor at the same restitution: rates fall with the root, and the step may follow."""
        return dataclasses.replace(self, kn=self.kn / factor, kt=self.kt / factor, gn=self.gn / math.sqrt(factor),
                                   gt=self.gt / math.sqrt(factor),
                                   young=self.young / factor)


@dataclasses.dataclass
class Problem:
    grains: np.ndarray              # rows: x y z r vx vy vz wx wy wz
    lower: tuple
    upper: tuple
    dt: float
    steps: int
    law: Law
    kind: np.ndarray = None         # FREE, FIXED or DRIVEN per grain
    periodic: str = ""              # axes, for example "xy"; the others are open
    gravity: tuple = (0.0, 0.0, 0.0)
    density: float = UNIT_DENSITY
    frames: int = 1                 # at equal distances, the last one at the end; steps is a multiple of it
    planes: tuple = ()              # (z, +1 or -1): side of the grains
    drive: float = 0.0              # velocity of the driven grains along x
    overlapping: bool = False       # the initial state has overlaps
    words: str = ""                 # of the scene: its source, shapes and walls in place of the file of grains
    knobs: dict = dataclasses.field(default_factory=dict)  # Talus scene keys

    def __post_init__(self):
        if self.kind is None:
            self.kind = np.zeros(len(self.grains), int)
        order = np.argsort(self.kind, kind="stable")  # driven grains last: their ids are one range
        self.grains, self.kind = self.grains[order], self.kind[order]
        if self.steps % self.frames:
            raise ValueError(f"{self.steps} steps are not a multiple of {self.frames} frames")

    @property
    def free(self):
        return self.kind == FREE

    def with_steps(self, steps):
        return dataclasses.replace(self, steps=steps, frames=1)


def write_csv(path, problem):
    with open(path, "w") as f:
        f.write(COLUMNS + "\n")
        for row, kind in zip(problem.grains, problem.kind):
            f.write(",".join("%.17g" % v for v in row) + (",1\n" if kind == FIXED else ",0\n"))


def talus_scene(p, observed):
    """Scene text. observed: with frames, energies and the time series; otherwise nothing is written but the end."""
    def vector(v):
        return "[" + ", ".join("%.17g" % c for c in v) + "]"

    sides = ", ".join('"periodic"' if a in p.periodic else '"open"' for a in "xyz")
    knobs = dict(p.knobs)
    lines = [f"gravity = {vector(p.gravity)}"]
    lines += [f'{k} = {toml(v)}' for k, v in knobs.items() if "." not in k]
    lines += ["[domain]", f"lower = {vector(p.lower)}", f"upper = {vector(p.upper)}", f"boundary = [{sides}]", "[time]",
              f"step = {p.dt:.17g}", f"steps = {p.steps}", "[[material]]", 'name = "grain"',
              f"density = {p.density:.17g}"]
    if p.law.hertz:
        lines += [f"young = {p.law.young:.17g}", f"poisson = {p.law.poisson:.17g}"]
    lines += ["[contact]", f"friction = {p.law.mu:.17g}"]
    if p.law.hertz:
        lines += ['model = "hertz_mindlin"', f"restitution = {p.law.e:.17g}"]
    else:
        lines += ['model = "linear"', f"normal_stiffness = {p.law.kn:.17g}", f"normal_damping = {p.law.gn:.17g}"]
        if p.law.mu > 0:
            lines += [f"tangential_stiffness = {p.law.kt:.17g}", f"tangential_damping = {p.law.gt:.17g}"]
    lines += section(knobs, "contact")
    lines += ["[list]"] + section(knobs, "list")
    lines += ["[checks]", f"allow_initial_overlap = {toml(p.overlapping)}"] + section(knobs, "checks")
    for name in sorted({k.split(".")[0] for k in knobs if "." in k} - {"contact", "list", "checks"}):
        lines += [f"[{name}]"] + section(knobs, name)
    lines += [p.words] if p.words else ["[[source]]", 'kind = "file"', 'file = "grains.csv"']
    if (p.kind == FIXED).any():
        lines += ["[[group]]", 'name = "fixed"', "fixed_in_file = true"]
    driven = np.flatnonzero(p.kind == DRIVEN)
    if len(driven):
        lines += ["[[group]]", 'name = "driven"', f"ids = [{driven[0]}, {driven[-1]}]", "[[event]]", "time = 0",
                  'action = "drive"', 'group = "driven"', f"velocity = [{p.drive:.17g}, 0, 0]"]
    for i, (z, side) in enumerate(p.planes):
        lines += ["[[wall]]", f'name = "plane{i}"', 'shape = "plane"', f"point = [0, 0, {z:.17g}]", f"normal = [0, 0, {side}]"]
    lines += ["[output]", "vtkhdf = false"]
    if observed:
        every = p.steps // p.frames * p.dt
        lines += ["vtp = true", "energies = true", f"particles_every = {every:.17g}", f"csv_every = {every:.17g}"]
    return "\n".join(lines) + "\n"


def section(knobs, name):
    return [f"{k.split('.', 1)[1]} = {toml(v)}" for k, v in knobs.items() if k.startswith(name + ".")]


def toml(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return f'"{value}"'
    return "%.17g" % value if isinstance(value, float) else str(value)


def lattice(count, pitch):
    """count^3 sites of a cubic lattice, centred in their cells, and the edge of the box."""
    axis = (np.arange(count) + 0.5) * pitch
    return np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1).reshape(-1, 3), count * pitch


def rows(x, v=None, w=None, r=0.5):
    out = np.zeros((len(x), 10))
    out[:, :3], out[:, 3] = x, r
    if v is not None:
        out[:, 4:7] = v
    if w is not None:
        out[:, 7:10] = w
    return out
