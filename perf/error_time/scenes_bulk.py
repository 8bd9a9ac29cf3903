"""Scenes judged by a bulk quantity over several seeds: cooling gas, discharge through a slot, flow down a chute.

Who calls it: error_time.py. The trajectories are chaotic, so only averages can be right or wrong. Each seed has its own
initial state, the same for all settings and for the reference (default setting, finest step): the error is the mean over
seeds of the ratio to the reference minus one, with its 95 % interval. The scatter of that ratio is taken from all settings
together (it is chaos, not the setting, that makes it), so that few seeds do not need the wide tails of Student's t. An error
whose interval holds zero is not distinguished from zero; the advice counts |error| + half width.
"""
import math

import numpy as np

from .problem import FIXED, Law, Problem, UNIT_DENSITY, contact_constants, rows
from .scene import Judged, LISTS, Scene, Setting
from .scenes_paths import dropped, rough_base, states_gas

# Student's t, two-sided 95 %, by degrees of freedom.
T95 = [math.inf, 12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228]


def t95(freedom):
    return T95[freedom] if freedom < len(T95) else 1.96 + 2.4 / freedom


def mean_and_half(values):
    values = np.asarray(values, float)
    n = len(values)
    if n < 2:
        return float(values.mean()), math.inf
    return float(values.mean()), t95(n - 1) * float(values.std(ddof=1)) / math.sqrt(n)


class BulkScene(Scene):
    kind = "bulk"
    reference_q = 100
    limits = ("Intervals: 95 %, from the scatter between seeds pooled over all settings.",
              "Lists and instruction sets: run and compared bit by bit for the first seed, then shown with the figures of the setting "
              "whose bits they have.")

    def __init__(self, quick):
        super().__init__(quick)
        self.use_seeds(self.steps_of(3, 20))
        self.ratios = {}

    def use_seeds(self, number):
        self.seeds = tuple(range(1, number + 1))

    def prepare(self, engine):
        self.states = dict(zip(self.seeds, engine.at_once(
            lambda seed: engine.kept_state(self.name, (seed, self.law, self.quick), lambda: self.start(engine, seed)), self.seeds)))
        reference = Setting("", "", self.reference_q)
        outcomes = engine.at_once(lambda seed: engine.observe("talus", self.build(reference, seed), audited=False), self.seeds)
        self.truth = np.array([self.quantity(o) for o in outcomes])
        mean, half = mean_and_half(self.truth[:, 0])
        self.notes.append(f"Reference ({self.reference_q} steps per contact): {self.quantity_name} {mean:.4g} +/- {half:.2g} over "
                          f"{len(self.seeds)} seeds.")

    def judge(self, setting, outcomes):
        found = np.array([self.quantity(o) for o in outcomes])
        # the first number is the quantity judged; the rest is a profile, compared as a whole
        ratios = found[:, 0] / self.truth[:, 0] - 1
        if setting.family != LISTS:  # copies of another setting would only pretend to be more data
            self.ratios[setting.label] = ratios
        mean = float(ratios.mean())
        note = f"{100 * mean:+.2f} %"
        if found.shape[1] > 1:
            both = np.isfinite(found[:, 1:]).all(0) & np.isfinite(self.truth[:, 1:]).all(0)  # bins filled in every run
            ours, theirs = found[:, 1:].mean(0)[both], self.truth[:, 1:].mean(0)[both]
            off = np.sqrt(((ours - theirs) ** 2).sum() / (theirs**2).sum())
            note += f"; profile off by {100 * off:.1f} % (L2)"
        return Judged(abs(mean), math.inf, note)

    def finish(self, rows):
        """The half widths, from the scatter of all settings together."""
        n = len(self.seeds)
        freedom = len(self.ratios) * (n - 1)
        if freedom == 0:
            return
        scatter = math.sqrt(np.mean([r.var(ddof=1) for r in self.ratios.values()]))
        for row in rows:
            if row["error"] is not None:
                row["error_half_width"] = t95(freedom) * scatter / math.sqrt(n)

    def variants(self):
        return [("pairwise dashpot", {"contact.dashpot": "pairwise"}), ("lagged dashpot", {"contact.dashpot": "lagged"})]

    q_middle = 25

    def q_list(self):
        return [12, 25] if self.quick else [6, 8, 12, 18, 25, 50]

    def peer_q_list(self):
        return [25] if self.quick else [12, 25]

    def settled(self, engine, grains, kind, box, T, **more):
        p = Problem(grains=grains, kind=kind, lower=box[0], upper=box[1], dt=self.tc / 20, steps=int(T / (self.tc / 20)),
                    law=self.law, density=UNIT_DENSITY, overlapping=True,
                    **{"periodic": "xy", "gravity": (0.0, 0.0, -1.0), "knobs": {"checks.allow_unstable_step": True}, **more})
        return p, engine.observe("talus", p, audited=False).last


def as_state(last, kind):
    return np.column_stack([last[:, :3], np.full(len(last), 0.5), last[:, 3:9], kind])


class CoolingGas(BulkScene):
    name, title = "cooling", "Cooling gas, solid fraction 0.1, e = 0.8"
    norm = "error of the temperature at the end, mean over seeds"
    reference = "finer runs, seed by seed; Haff's law is printed beside it"
    quantity_name = "T(end)/T(0)"
    tc = 0.02
    softenings = (10, 100)

    def __init__(self, quick):
        super().__init__(quick)
        self.T = 10.0
        kn = 0.5 * (math.pi**2 + math.log(0.8) ** 2) / self.tc**2
        rate, _ = contact_constants(kn, 0.8)
        self.law = Law(kn=kn, gn=rate)
        # softer by overlap than the linear law at these speeds; e is the same, and that is what cooling depends on
        self.hertz_law = Law(young=3.0 * kn, poisson=0.25, e=0.8)

    def start(self, engine, seed):
        n = self.steps_of(12, 20)
        state, (lower, upper) = states_gas((n, n, n), 0.1, 1.0, 100 + seed)
        return np.concatenate([state, np.array([np.concatenate([lower, upper, np.zeros(4)])])])

    def body(self, seed):
        s = self.states[seed]
        return {"grains": s[:-1], "lower": tuple(s[-1, :3]), "upper": tuple(s[-1, 3:6]), "periodic": "xyz"}

    def prepare(self, engine):
        super().prepare(engine)
        phi, e = 0.1, 0.8
        chi = (2 - phi) / (2 * (1 - phi) ** 3)
        tau = 6 / ((1 - e * e) * 4 * math.sqrt(math.pi) * chi * phi * 6 / math.pi)
        haff = 1 / (1 + self.T / tau) ** 2
        self.notes.append(f"Haff's law: T(end)/T(0) = {haff:.4g} with 1/tau = {1 / tau:.3f}; the reference is "
                          f"{100 * (self.truth[:, 0].mean() / haff - 1):+.1f} % from it (the law holds for hard spheres without "
                          "correlations).")

    def quantity(self, outcome):
        first = outcome.frames[min(outcome.frames)]
        return [np.sum(outcome.last[:, 3:6] ** 2) / np.sum(first[:, 3:6] ** 2)]


class Hopper(BulkScene):
    name, title = "hopper", "Discharge through a slot of 5 d"
    norm = "error of the discharge rate, mean over seeds"
    reference = "finer runs, seed by seed"
    quantity_name = "grains per sqrt(d/g)"
    softenings = (10, 100, 1000)
    width, depth, slot, opened = 16.0, 6.0, 5.0, 1.5

    def __init__(self, quick):
        super().__init__(quick)
        self.T, self.frames = self.steps_of(4.0, 6.0), self.steps_of(16, 24)
        kn = 2e5
        rate, self.tc = contact_constants(kn, 0.8)
        self.law = Law(kn=kn, gn=rate, kt=2 / 7 * kn, mu=0.5)
        # E such that a grain under 10 m g overlaps about as much as with the linear spring
        self.hertz_law = Law(young=3e7, poisson=0.25, mu=0.5, e=0.8)
        self.layers = self.steps_of(10, 14)
        self.upper = (self.width, self.depth, 1.25 * self.layers + 6)

    def start(self, engine, seed):
        rng = np.random.default_rng(200 + seed)
        base, x = rough_base(rng, self.width, self.depth), dropped(rng, self.width, self.depth, self.layers)
        grains = np.concatenate([rows(base), rows(x, rng.normal(0, 0.2, (len(x), 3)))])
        kind = np.concatenate([np.full(len(base), FIXED), np.zeros(len(x), int)])
        p, last = self.settled(engine, grains, kind, ((0, 0, -60), self.upper), 10.0)
        state = as_state(last, p.kind)
        gate = (p.kind == FIXED) & (np.abs(state[:, 0] - self.width / 2) < self.slot / 2)
        return state[~gate]

    def body(self, seed):
        s = self.states[seed]
        return {"grains": s[:, :10], "kind": s[:, 10].astype(int), "lower": (0, 0, -60), "upper": self.upper, "periodic": "xy",
                "gravity": (0.0, 0.0, -1.0), "overlapping": True}

    def quantity(self, outcome):
        steps = sorted(outcome.frames)
        t = self.T * np.array(steps) / steps[-1]
        below = [np.sum(outcome.frames[s][:, 2] < -0.5) for s in steps]
        use = t > self.opened
        return [np.polyfit(t[use], np.array(below)[use], 1)[0]]


class Chute(BulkScene):
    name, title = "chute", "Flow down a rough chute of 24 degrees"
    norm = "error of the mean velocity, mean over seeds"
    reference = "finer runs, seed by seed; the velocity profile is compared too"
    quantity_name = "mean velocity / sqrt(g d)"
    softenings = (10, 100, 1000)
    width, depth, bins = 8.0, 6.0, 10
    skin = 0.2

    def __init__(self, quick):
        super().__init__(quick)
        self.T, self.frames = self.steps_of(4.0, 12.0), self.steps_of(8, 24)
        kn = 2e5
        rate, self.tc = contact_constants(kn, 0.88)
        self.law = Law(kn=kn, gn=rate, kt=2 / 7 * kn, mu=0.5)
        self.hertz_law = Law(young=3e7, poisson=0.25, mu=0.5, e=0.88)
        self.layers = self.steps_of(7, 9)
        self.box = ((0, 0, -2), (self.width, self.depth, 3.0 * self.layers))
        self.gravity = (math.sin(math.radians(24)), 0.0, -math.cos(math.radians(24)))

    def start(self, engine, seed):
        rng = np.random.default_rng(300 + seed)
        base, x = rough_base(rng, self.width, self.depth), dropped(rng, self.width, self.depth, self.layers)
        grains = np.concatenate([rows(base), rows(x, rng.normal(0, 0.2, (len(x), 3)) + [1.0, 0, 0])])
        kind = np.concatenate([np.full(len(base), FIXED), np.zeros(len(x), int)])
        p, last = self.settled(engine, grains, kind, self.box, self.steps_of(15.0, 40.0), gravity=self.gravity)
        return as_state(last, p.kind)

    def body(self, seed):
        s = self.states[seed]
        return {"grains": s[:, :10], "kind": s[:, 10].astype(int), "lower": self.box[0], "upper": self.box[1], "periodic": "xy",
                "gravity": self.gravity, "overlapping": True}

    def quantity(self, outcome):
        steps = sorted(outcome.frames)
        moving = (self.states[1][:, 10] == 0).sum()  # rows by id: the free grains come first
        x = np.concatenate([outcome.frames[s][:moving] for s in steps if s >= 0.25 * steps[-1]])
        cell = np.floor(x[:, 2] / (1.1 * self.layers) * self.bins).astype(int)
        profile = [x[cell == b, 3].mean() if (cell == b).sum() > 20 else np.nan for b in range(self.bins)]
        return [x[:, 3].mean()] + profile


SCENES = (CoolingGas, Hopper, Chute)
