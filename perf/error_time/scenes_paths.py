"""Scenes judged by the path of every grain against a much finer run: three-grain sticking, elastic gas, dense shear.

Who calls it: error_time.py. The reference is the default setting at a step several times finer than the finest point. In
chaotic scenes errors grow like exp(lambda t); lambda is measured with a twin run whose start is shifted by 1e-10 d, and
the horizon is the last frame at which the reference and a run at twice its step still agree to TRUST: beyond it no error
norm of paths means anything. The error is taken at that frame (or at the end, if that is earlier).
"""
import dataclasses
import math

import numpy as np

from .problem import DRIVEN, FIXED, Law, Problem, UNIT_DENSITY, contact_constants, rows
from .scene import Judged, Scene, Setting

TRUST = 1e-3


class PathScene(Scene):
    """frames: x of every free grain, compared in the periodic box; unit: length by which the error is divided."""
    kind = "path"
    unit = 1.0
    reference_q = 640
    chaotic = True
    at = None  # frame number at which errors are taken

    def prepare(self, engine):
        self.engine = engine
        coarse = self.run(Setting("", "", self.reference_q / 2))
        self.truth = self.run(Setting("", "", self.reference_q))
        doubt = [self.distance(a, b) for a, b in zip(coarse, self.truth)]
        self.at = self.horizon(doubt)
        self.doubt = doubt[self.at]
        when = self.T / self.frames * self.at
        self.notes.append(f"Reference: {self.reference_q} steps per contact; the run at half as many differs from it by "
                          f"{self.doubt:.1e} (same norm) at the frame judged, t = {when:g} of {self.T:g}. "
                          "Errors below that are not resolved.")
        if self.chaotic:
            self.lyapunov()

    def run(self, setting, shift=0.0):
        p = self.build(setting, 1)
        if shift:
            grains = p.grains.copy()
            grains[p.free, :3] += shift * np.random.default_rng(5).normal(size=(p.free.sum(), 3))
            p = dataclasses.replace(p, grains=grains)
        frames = self.engine.observe("talus", p, audited=False).frames  # the reference is not a point of the plot
        return [frames[s] for s in sorted(frames)]

    def horizon(self, doubt):
        trusted = [i for i in range(1, len(doubt)) if max(doubt[1:i + 1]) <= TRUST]
        if not trusted:
            self.notes.append("The reference does not reach the first frame with the accuracy asked for.")
            return 1
        return trusted[-1]

    def lyapunov(self):
        shift = 1e-10
        s = Setting("", "", self.q_middle)
        growth = [self.distance(a, b) * self.unit / shift for a, b in zip(self.run(s), self.run(s, shift))]
        t = self.T / self.frames * np.arange(len(growth))
        use = [i for i in range(1, len(growth)) if 3 < growth[i] < 1e-2 / shift]
        if len(use) < 3:
            self.notes.append("Lyapunov exponent: the shift of the start grows too little within the run to measure it.")
            return
        rate = np.polyfit(t[use], np.log([growth[i] for i in use]), 1)[0]
        limit = t[self.at] + (math.log(0.1 * self.unit / max(self.doubt * self.unit, 1e-14)) / rate if rate > 0 else math.inf)
        self.notes.append(f"Lyapunov exponent {rate:.2f} per unit of time (start shifted by {shift:g} d, {len(use)} frames): "
                          f"the reference itself is off by 0.1 d at about t = {limit:.2f}, the horizon of any path norm here.")

    def distance(self, a, b):
        """rms over the free grains of |x_a - x_b| / unit."""
        p = self.shape
        d = (a[:, :3] - b[:, :3])[p["free"]]
        for k, axis in enumerate("xyz"):
            if axis in p["periodic"]:
                edge = p["upper"][k] - p["lower"][k]
                d[:, k] -= edge * np.rint(d[:, k] / edge)
        return float(np.sqrt((d**2).sum(1).mean())) / self.unit

    @property
    def shape(self):
        body = self.body(1)
        kind = body.get("kind")
        free = np.ones(len(body["grains"]), bool) if kind is None else np.sort(kind, kind="stable") == 0
        return {"free": free, "periodic": body.get("periodic", ""), "lower": body["lower"], "upper": body["upper"]}

    def judge(self, setting, outcomes):
        frames = outcomes[0].frames
        return Judged(self.distance(frames[sorted(frames)[self.at]], self.truth[self.at]), self.doubt)

    def q_list(self):
        return [10, 40] if self.quick else [6, 10, 20, 40, 80, 160]

    def peer_q_list(self):
        return [10, 40] if self.quick else [10, 20, 40, 80, 160]


class Sticking(PathScene):
    name, title = "sticking", "Three grains: a small one rolls round two fixed ones"
    norm = "distance from the reference at t = 0.2 s, after it has left the groove / 10 mm, about what it has fallen"
    reference = "finer run; physically the grain leaves the groove (plain Verlet with history leaves it hanging)"
    T, frames, chaotic, skin = 0.2, 10, False, 1e-4
    unit, radius = 0.01, 2.5e-4
    q_middle = 12
    softenings = (10, 100)

    def __init__(self, quick):
        super().__init__(quick)
        r = self.radius
        mass = 2500 * 4 / 3 * math.pi * r**3
        rate, self.tc = contact_constants(1e4, 0.5, mass)
        self.law = Law(kn=1e4, gn=rate, kt=8235, mu=0.5)
        self.copies = self.steps_of(4, 16)
        grains, kind = [], []
        for k in range(self.copies):
            at = np.array([0.03 * k, 0, 0])
            grains += [at + [0.010, 0, 0], at, at + [0.005, 2.7937481665e-5, 1.60053725e-3]]
            kind += [FIXED, FIXED, 0]
        self.grains = rows(np.array(grains))
        self.sorts = np.array(kind)
        self.grains[:, 3] = np.where(self.sorts == FIXED, 0.005, r)
        self.reference_q = self.steps_of(48, 192)

    def body(self, seed):
        return {"grains": self.grains, "kind": self.sorts, "lower": (-0.05, -0.05, -0.25), "upper": (0.03 * self.copies, 0.05, 0.05),
                "gravity": (0.0, 0.0, -9.81), "density": 2500.0, "overlapping": True}

    def horizon(self, doubt):
        return len(doubt) - 1  # not chaotic: the whole path

    def judge(self, setting, outcomes):
        judged = super().judge(setting, outcomes)
        last = outcomes[0].last[:self.copies]
        if (last[:, 2] > -0.006).any():
            judged.note = "hangs on the underside at 0.2 s"
        return judged

    def variants(self):
        return super().variants() + [("not synchronised", {"contact.synchronised": False})]

    def q_list(self):
        return [6, 12] if self.quick else [6, 12, 24, 48]

    def peer_q_list(self):
        return [12] if self.quick else [12, 24, 48]


class ElasticGas(PathScene):
    name, title = "gas", "Elastic gas, solid fraction 0.1"
    norm = "rms distance of all grains from the reference / d"
    reference = "finer run, up to the Lyapunov horizon"
    T, frames, tc = 1.5, 15, 0.02
    softenings = (10, 100)

    def variants(self):
        return [("leapfrog", {"integrator": "leapfrog"})]  # no dashpot

    def __init__(self, quick):
        super().__init__(quick)
        self.law = Law(kn=0.5 * math.pi**2 / self.tc**2)
        n = self.steps_of(8, 11)
        self.state, (self.lower, self.upper) = states_gas((n, n, n), 0.1, 1.0, 3)

    def body(self, seed):
        return {"grains": self.state, "lower": tuple(self.lower), "upper": tuple(self.upper), "periodic": "xyz"}

    def settings(self, features):
        out = super().settings(features)
        if features["lammps"]:  # a list without a check, as codes with fixed rebuild intervals have it
            q = self.q_middle
            # no divisors of the steps between frames, at which a list would be fresh whenever it is looked at
            for every in (93,) if self.quick else (19, 47, 93, 171):
                out.append(Setting(f"lammps, rebuilt every {every}", "LAMMPS, fixed rebuild interval, no check", q, code="lammps",
                                   peer={"skin": 0.02, "every": every}, may_stop=True))
        return out


def states_gas(cells, solid_fraction, speed, seed):
    import states

    state, box = states.gas(cells, solid_fraction, speed, seed)
    return state[:, :10], box


class DenseShear(PathScene):
    name, title = "shear", "Dense shear between rough plates"
    norm = "rms distance of all free grains from the reference / d"
    reference = "finer run, up to the Lyapunov horizon"
    T, frames, tc = 1.0, 20, 0.00702481473
    softenings = (10, 100, 1000)
    reference_q = 320
    width, depth = 8.0, 6.0

    def __init__(self, quick):
        super().__init__(quick)
        kn = 2e4
        rate, self.tc = contact_constants(kn, 0.8)
        self.law = Law(kn=kn, gn=rate, kt=2 / 7 * kn, mu=0.5)
        self.frames = self.steps_of(10, 20)
        self.T = self.steps_of(0.5, 1.0)
        self.layers = self.steps_of(6, 10)

    def prepare(self, engine):
        self.state = engine.kept_state("shear", (self.layers, self.law), lambda: self.settled(engine))
        super().prepare(engine)

    def settled(self, engine):
        """Jittered lattice dropped on a fixed rough base; the top of the settled bed becomes the driven plate."""
        rng = np.random.default_rng(21)
        base = rough_base(rng, self.width, self.depth)
        x = dropped(rng, self.width, self.depth, self.layers)
        n = len(x)
        grains = np.concatenate([rows(base), rows(x, rng.normal(0, 0.2, (n, 3)))])
        kind = np.concatenate([np.full(len(base), FIXED), np.zeros(n, int)])
        p = Problem(grains=grains, kind=kind, lower=(0, 0, -2), upper=(self.width, self.depth, 2.0 * self.layers + 4),
                    periodic="xy", gravity=(0.0, 0.0, -1.0), dt=self.tc / 20, steps=int(12 / (self.tc / 20)), law=self.law,
                    density=UNIT_DENSITY, overlapping=True, knobs={"damping.viscous": 0.5, "checks.allow_unstable_step": True})
        last = engine.observe("talus", p).last
        z = last[:, 2]
        kind = np.where(p.kind == FIXED, FIXED, np.where(z > np.quantile(z[p.free], 0.85), DRIVEN, 0))
        out = np.column_stack([last[:, :3], np.full(len(last), 0.5), np.zeros((len(last), 6)), kind])
        return out[np.argsort(kind, kind="stable")]

    def body(self, seed):
        return {"grains": self.state[:, :10], "kind": self.state[:, 10].astype(int), "lower": (0, 0, -2),
                "upper": (self.width, self.depth, 2.0 * self.layers + 4), "periodic": "xy", "gravity": (0.0, 0.0, -1.0),
                "drive": 2.0, "overlapping": True}


def rough_base(rng, width, depth, pitch=1.0):
    """Fixed grains on a jittered grid at z = 0."""
    nx, ny = int(width / pitch), int(depth / pitch)
    gx, gy = np.meshgrid((np.arange(nx) + 0.5) * width / nx, (np.arange(ny) + 0.5) * depth / ny, indexing="ij")
    x = np.stack([gx.ravel(), gy.ravel(), np.zeros(nx * ny)], 1)
    return x + rng.uniform(-0.1, 0.1, x.shape)


def dropped(rng, width, depth, layers, bottom=1.2, pitch=1.1):
    """Jittered cubic lattice above the base; no two grains touch."""
    nx, ny = int(width / pitch), int(depth / pitch)
    g = np.meshgrid((np.arange(nx) + 0.5) * width / nx, (np.arange(ny) + 0.5) * depth / ny,
                    bottom + pitch * np.arange(layers), indexing="ij")
    x = np.stack([a.ravel() for a in g], 1)
    return x + rng.uniform(-0.04, 0.04, x.shape)


SCENES = (Sticking, ElasticGas, DenseShear)
