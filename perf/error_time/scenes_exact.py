"""Scenes with an exact reference: normal impact, oblique impact, bouncing, a clamped stack (closed_forms.py).

Who calls it: error_time.py. Many independent copies with different onset phases and directions fill one scene, so that the
error is that of no particular phase and the run is long enough to be timed.
"""
import math

import numpy as np

from . import closed_forms
from .problem import Law, contact_constants, lattice, rows
from .scene import Judged, Scene

E = 0.8
SPEED = 1e-6  # overlaps of 1e-6 d: what the geometry changes during a contact is far below the errors measured


def rms(x):
    return float(np.sqrt(np.mean(np.square(x))))


def directions(rng, n):
    v = rng.normal(size=(n, 3))
    return v / np.linalg.norm(v, axis=1)[:, None]


class NormalImpact(Scene):
    name, title = "normal", "Single normal impact"
    norm = "rms error of the relative velocity after the impact / closing speed"
    reference = "closed form: v' = -e v (linear and Hertz, e = 0.8); independent pairs with random phases and directions"
    T = 2.0
    skin = 0.05

    def __init__(self, quick):
        super().__init__(quick)
        kn = 0.5 * (math.pi**2 + math.log(E) ** 2)
        self.law = Law(kn=kn, gn=-2 * math.log(E))
        # Hertz with the same contact time 1: t_c = 2.87 (m*^2 / (R* E*^2 v))^(1/5), E* = E / (2 (1 - nu^2))
        effective = math.sqrt(0.25 / (0.25 * SPEED)) * 2.87**2.5
        self.hertz_law = Law(young=effective * 2 * (1 - 0.25**2), poisson=0.25, e=E)
        sites, side = lattice(self.steps_of(10, 12), 2.4)
        rng = np.random.default_rng(11)
        self.n = directions(rng, len(sites))
        half = self.n * (0.5 * (1 + SPEED * rng.uniform(0.2, 0.4, (len(sites), 1))))
        self.grains = np.concatenate([rows(sites + half, -0.5 * SPEED * self.n), rows(sites - half, 0.5 * SPEED * self.n)])
        self.side = side

    def body(self, seed):
        return {"grains": self.grains, "lower": (0, 0, 0), "upper": (self.side,) * 3}

    def judge(self, setting, outcomes):
        v = outcomes[0].last[:, 3:6]
        n = len(self.n)
        error = np.linalg.norm(v[:n] - v[n:] - E * SPEED * self.n, axis=1) / SPEED
        return Judged(rms(error), note=f"median {np.median(error):.1e}, worst of {n} phases {error.max():.1e}")

    def variants(self):
        return super().variants() + [("no onset correction", {"contact.onset_correction": False})]


class ObliqueImpact(Scene):
    name, title = "oblique", "Single oblique impact on a plane"
    norm = "rms of |error of (v, sqrt(2/5) R w)| after the impact / impact speed"
    reference = ("piecewise closed form of stick and slip (spring k_t = 2/7 k_n, Coulomb mu 0.3, e 0.8); angles of 5 to 85 "
                 "degrees, random phases")
    T = 2.0
    mu = 0.3
    skin = 0.05

    def __init__(self, quick):
        super().__init__(quick)
        kn = math.pi**2 + math.log(E) ** 2
        self.law = Law(kn=kn, gn=-2 * math.log(E), kt=2 / 7 * kn, mu=self.mu)
        rng = np.random.default_rng(12)
        angles = np.radians(np.arange(5, 90, 5))
        copies = self.steps_of(100, 180)
        tilt = np.repeat(angles, copies)
        n = len(tilt)
        self.turn = rng.uniform(0, 2 * math.pi, n)
        self.side = math.ceil(math.sqrt(n))
        k = np.arange(n)
        x = np.stack([1.5 * (k % self.side) + 1, 1.5 * (k // self.side) + 1, 0.5 + SPEED * rng.uniform(0.2, 0.4, n)], 1)
        self.along = np.stack([np.cos(self.turn), np.sin(self.turn), np.zeros(n)], 1)
        self.vt = SPEED * np.tan(tilt)
        self.grains = rows(x, self.vt[:, None] * self.along + [0, 0, -SPEED])
        self.speed = SPEED / np.cos(tilt)
        normal = closed_forms.Normal(kn, self.law.gn, 1.0, 1.0)
        change = {a: closed_forms.oblique(normal, self.law.kt, self.mu, math.tan(a)) for a in angles}
        dv = SPEED * np.array([change[a][0] for a in tilt])
        self.v = (self.vt + dv)[:, None] * self.along + [0, 0, normal.e * SPEED]
        # the force -F along the slip turns the sphere: R dw = -5/2 dv (z x along)
        self.rw = -2.5 * dv[:, None] * np.cross([0, 0, 1], self.along)

    def build(self, setting, seed):
        # The closed form, as the peers, limits friction by the whole normal force; the default's limit is its elastic part.
        problem = super().build(setting, seed)
        problem.knobs.setdefault("contact.friction_limit", "total")
        return problem

    def body(self, seed):
        top = 1.5 * self.side + 1
        return {"grains": self.grains, "lower": (-1, -1, -1), "upper": (top, top, 3), "planes": ((0.0, 1),)}

    def judge(self, setting, outcomes):
        x = outcomes[0].last
        dv, dw = x[:, 3:6] - self.v, 0.5 * x[:, 6:9] - self.rw
        return Judged(rms(np.sqrt((dv**2).sum(1) + 0.4 * (dw**2).sum(1)) / self.speed))


class Bounce(Scene):
    name, title = "bounce", "Spheres bouncing under gravity"
    norm = "rms error of the height, 12 instants / height of the drop"
    reference = "closed form, flight by flight and contact by contact (e 0.8, contact 0.02 sqrt(d/g))"
    T, frames, tc = 6.0, 12, 0.02
    softenings = (10, 100)

    def __init__(self, quick):
        super().__init__(quick)
        kn = (math.pi**2 + math.log(E) ** 2) / self.tc**2
        self.law = Law(kn=kn, gn=-2 * math.log(E) / self.tc)
        rng = np.random.default_rng(13)
        n = self.steps_of(64, 144)
        self.h = rng.uniform(1.0, 2.0, n)
        self.side = math.ceil(math.sqrt(n))
        k = np.arange(n)
        self.grains = rows(np.stack([1.5 * (k % self.side) + 1, 1.5 * (k // self.side) + 1, 0.5 + self.h], 1))
        times = self.T / self.frames * np.arange(1, self.frames + 1)
        self.exact = closed_forms.bounce(times, self.h, 1.0, kn, self.law.gn)

    def body(self, seed):
        top = 1.5 * self.side + 1
        return {"grains": self.grains, "lower": (-1, -1, -1), "upper": (top, top, 4), "planes": ((0.0, 1),),
                "gravity": (0.0, 0.0, -1.0)}

    def judge(self, setting, outcomes):
        frames = outcomes[0].frames
        z = np.array([frames[s][:, 2] for s in sorted(frames)[1:]]) - 0.5
        return Judged(rms((z - self.exact) / self.h))


class Stack(Scene):
    name, title = "stack", "Two spheres clamped between planes"
    norm = "rms error of both heights, 12 instants / initial displacement"
    reference = "matrix exponential of the linear system (three contacts that stay closed)"
    T, frames = 6.0, 12
    height = 1.8

    def __init__(self, quick):
        super().__init__(quick)
        kn = 0.5 * math.pi**2
        rate, _ = contact_constants(kn, E)
        self.law = Law(kn=kn, gn=rate)
        rng = np.random.default_rng(14)
        n = self.steps_of(200, 500)
        self.z = np.stack([0.45 + rng.uniform(-0.03, 0.03, n), 1.35 + rng.uniform(-0.03, 0.03, n)], 1)
        self.side = math.ceil(math.sqrt(n))
        k = np.arange(n)
        x = np.stack([1.5 * (k % self.side) + 1, 1.5 * (k // self.side) + 1, 0 * k], 1)
        self.grains = np.concatenate([rows(x + self.z[:, :1] * [0, 0, 1]), rows(x + self.z[:, 1:] * [0, 0, 1])])
        times = self.T / self.frames * np.arange(1, self.frames + 1)
        self.exact = closed_forms.stack(times, self.z, self.height, 0.01, kn, rate)

    def body(self, seed):
        top = 1.5 * self.side + 1
        return {"grains": self.grains, "lower": (-1, -1, -1), "upper": (top, top, 3), "overlapping": True,
                "planes": ((0.0, 1), (self.height, -1)), "gravity": (0.0, 0.0, -0.01)}

    def judge(self, setting, outcomes):
        frames, n = outcomes[0].frames, len(self.z)
        z = np.array([np.stack([frames[s][:n, 2], frames[s][n:, 2]], 1) for s in sorted(frames)[1:]])
        return Judged(rms(z - self.exact) / rms(self.z - [0.45, 1.35]))


SCENES = (NormalImpact, ObliqueImpact, Bounce, Stack)
