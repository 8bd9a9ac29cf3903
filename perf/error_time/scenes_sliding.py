"""Scenes of friction in three dimensions: impacts that are not planar, the impulse of gross sliding, a gas with friction.

Who calls it: error_time.py. The first one is judged against the limit of each code's own law, Hertz with and without partial
slip included: the laws differ by more than the errors of a good step, and a scheme has to converge to its own law before it
can be compared with another one.
"""
import math

import numpy as np

from .problem import Law, contact_constants, lattice, rows
from .scene import Judged, Scene, Setting
from .scenes_bulk import BulkScene, states_gas
from .scenes_exact import directions, rms
from .scenes_paths import PathScene

E = 0.8


class NonPlanarImpacts(PathScene):
    name, title = "impacts", "Non-planar impacts of unequal spheres with a tangential dashpot"
    norm = "rms of |error of (v, R w)| after the impact / closing speed"
    reference = "each code's and law's own run at 20 times as many steps as the finest point (friction 0.5, e 0.8, radii 0.25 to 0.5)"
    T, chaotic, skin = 2.0, False, 0.05
    closing = 0.1  # the line of centres turns by some degrees during the contact
    reference_q = 6400
    q_middle = 50

    def __init__(self, quick):
        super().__init__(quick)
        sites, self.side = lattice(self.steps_of(6, 10), 2.4)
        rng = np.random.default_rng(31)
        n, count = directions(rng, len(sites)), len(sites)
        r = rng.uniform(0.25, 0.5, (2, count))
        across = np.cross(n, directions(rng, count))
        across /= np.linalg.norm(across, axis=1)[:, None]
        slip = self.closing * np.tan(np.radians(rng.uniform(5, 75, count)))
        v = -self.closing * n + slip[:, None] * across
        gap = self.closing * rng.uniform(0.2, 0.4, count)
        half = n * (0.5 * (r.sum(0) + gap))[:, None]
        spin = [directions(rng, count) * (self.closing / r[k] * rng.uniform(0, 1, count))[:, None] for k in (0, 1)]
        self.grains = np.concatenate([rows(sites + half, 0.5 * v, spin[0]), rows(sites - half, -0.5 * v, spin[1])])
        self.grains[:, 3] = np.concatenate(r)
        # contact time 1 for two spheres of mean size; rates are per effective mass
        kn = 0.5 * (math.pi**2 + math.log(E) ** 2) * 0.75**3
        rate, self.tc = contact_constants(kn, E, 0.5 * 0.75**3)
        self.law = Law(kn=kn, gn=rate, kt=2 / 7 * kn, gt=0.5 * rate, mu=0.5)
        # the same contact time at the closing speed: 2.87 (m*^2 / (R* E*^2 v))^(1/5)
        effective = 0.5 * 0.75**3 / math.sqrt(0.1875 * self.closing) * 2.87**2.5
        self.hertz_law = Law(young=effective * 2 * (1 - 0.25**2), poisson=0.25, e=E, mu=0.5)
        self.limits_of = {}

    def body(self, seed):
        return {"grains": self.grains, "lower": (-1, -1, -1), "upper": (self.side + 1,) * 3}

    def horizon(self, doubt):
        return len(doubt) - 1

    def distance(self, a, b):
        r = self.grains[:, 3:4]
        d = np.concatenate([(a - b)[:, 3:6], r * (a - b)[:, 6:9]], 1)
        return rms(np.sqrt((d**2).sum(1))) / self.closing

    def judge(self, setting, outcomes):
        frames = outcomes[0].frames
        last = frames[sorted(frames)[self.at]]
        if setting.code == "talus" and not setting.hertz:
            return Judged(self.distance(last, self.truth[self.at]), self.doubt)
        law = setting.code if setting.code != "talus" else setting.family
        if law not in self.limits_of:
            finest = Setting("", "", self.reference_q, hertz=setting.hertz, knobs=setting.knobs)
            own = self.engine.observe(setting.code, self.build(finest, 1), setting.peer, audited=False)
            self.limits_of[law] = own.last
            self.notes.append(f"The limit of {law} differs from that of the default law by {self.distance(own.last, self.truth[self.at]):.1e} "
                              "(same norm): another law.")
        return Judged(self.distance(last, self.limits_of[law]), 0.0)

    def variants(self):
        return [("pairwise dashpot", {"contact.dashpot": "pairwise"})]

    def q_list(self):
        return [20, 50, 320] if self.quick else [10, 20, 50, 100, 200, 320]

    def peer_q_list(self):
        return [20, 50] if self.quick else [20, 50, 100, 200]


class SlidingImpulse(Scene):
    name, title = "sliding", "Impulse of gross sliding on a plane, e = 0.5"
    norm = "rms of |J_t / (mu J_n) - 1|, the ratio of the impulses of an impact that slides all through"
    reference = "Coulomb's law for impulses: J_t = mu J_n (friction 0.3; angles of 70 to 85 degrees, random phases)"
    T, mu, e, skin, speed = 2.0, 0.3, 0.5, 0.05, 1e-6

    def __init__(self, quick):
        super().__init__(quick)
        kn = math.pi**2 + math.log(self.e) ** 2
        self.law = Law(kn=kn, gn=-2 * math.log(self.e), kt=2 / 7 * kn, mu=self.mu)
        effective = math.sqrt(1 / (0.5 * self.speed)) * 2.87**2.5
        self.hertz_law = Law(young=effective * 2 * (1 - 0.25**2), poisson=0.25, e=self.e, mu=self.mu)
        rng = np.random.default_rng(32)
        n = self.steps_of(400, 1600)
        slip = self.speed * np.tan(np.radians(rng.uniform(70, 85, n)))
        turn = rng.uniform(0, 2 * math.pi, n)
        self.side = math.ceil(math.sqrt(n))
        k = np.arange(n)
        x = np.stack([1.5 * (k % self.side) + 1, 1.5 * (k // self.side) + 1, 0.5 + self.speed * rng.uniform(0.2, 0.4, n)], 1)
        self.v = np.stack([slip * np.cos(turn), slip * np.sin(turn), -self.speed + 0 * slip], 1)
        self.grains = rows(x, self.v)

    def body(self, seed):
        top = 1.5 * self.side + 1
        return {"grains": self.grains, "lower": (-1, -1, -1), "upper": (top, top, 3), "planes": ((0.0, 1),)}

    def judge(self, setting, outcomes):
        change = outcomes[0].last[:, 3:6] - self.v
        ratio = np.linalg.norm(change[:, :2], axis=1) / (self.mu * change[:, 2])
        return Judged(rms(ratio - 1), note=f"mean {ratio.mean():.5f}")


class FrictionalGas(BulkScene):
    name, title = "frictional", "Cooling gas with friction, solid fraction 0.1"
    norm = "error of the rotational share of the kinetic energy at the end, mean over seeds"
    reference = "finer runs, seed by seed (e 0.8, friction 0.5, tangential dashpot half the normal one)"
    quantity_name = "E_rot / E_kin"
    tc, T = 0.02, 4.0

    def __init__(self, quick):
        super().__init__(quick)
        kn = 0.5 * (math.pi**2 + math.log(E) ** 2) / self.tc**2
        rate, _ = contact_constants(kn, E)
        self.law = Law(kn=kn, gn=rate, kt=2 / 7 * kn, gt=0.5 * rate, mu=0.5)

    def start(self, engine, seed):
        n = self.steps_of(10, 16)
        state, (lower, upper) = states_gas((n, n, n), 0.1, 1.0, 400 + seed)
        return np.concatenate([state, np.array([np.concatenate([lower, upper, np.zeros(4)])])])

    def body(self, seed):
        s = self.states[seed]
        return {"grains": s[:-1], "lower": tuple(s[-1, :3]), "upper": tuple(s[-1, 3:6]), "periodic": "xyz"}

    def quantity(self, outcome):
        turning, moving = 0.1 * np.sum(outcome.last[:, 6:9] ** 2), np.sum(outcome.last[:, 3:6] ** 2)
        return [turning / (turning + moving)]


SCENES = (NonPlanarImpacts, SlidingImpulse, FrictionalGas)
