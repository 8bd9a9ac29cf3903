"""Impacts of grains that are no spheres on planes, with the exact reference: rods of three spheres, rounded boxes.

Who calls it: error_time.py. Bodies of a lattice lie as chance has turned them and fall, without gravity or friction, each on a
box whose top has been put a little below the lowest point that a first frame shows. While the contact lasts they turn by some
1e-6, so that its normal motion is a linear oscillator of the mass that answers there, m_n = 1 / (1/m + (r x n) I^-1 (r x n)):
closed_forms.Normal. The dashpot of a clump sees the body's mass, that of a superquadric sees m_n.
"""
import math

import numpy as np

from . import closed_forms
from .problem import UNIT_DENSITY, Law, Problem, rows
from .scene import Judged, Scene

E = 0.8
SPEED = 1e-6


def beta(a, b):
    return math.gamma(a) * math.gamma(b) / math.gamma(a + b)


def turns_of(q):
    """Rotation matrices of quaternions w, x, y, z."""
    w, x, y, z = q.T
    return np.stack([np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], 1),
                     np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], 1),
                     np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], 1)], 1)


class BodyImpact(Scene):
    """words: of the [[shape]]; reach: its bounding radius; mass, moments in its own axes; lowest(m): the point that lies farthest
    along the unit vectors m of the body's frame; lever_mass(m_n): that the dashpot sees."""
    norm = "rms of the error of motion after the impact, in the norm of the kinetic energy / that before"
    T = 2.0
    words, reach, mass = "", 1.0, 1.0
    moments = np.ones(3)

    def __init__(self, quick):
        super().__init__(quick)
        self.law = Law(kn=self.mass * (math.pi**2 + math.log(E) ** 2), gn=-2 * math.log(E))
        self.side = self.steps_of(8, 12)
        self.gap = SPEED * np.random.default_rng(15).uniform(0.2, 0.4, self.side**2)
        self.boxes = ""

    def lowest(self, m):
        raise NotImplementedError

    def lever_mass(self, answering):
        raise NotImplementedError

    def prepare(self, engine):
        first = engine.observe("talus", Problem(dt=1e-3, steps=1, law=self.law, **self.body(1)), audited=False).frames[0]
        turn = turns_of(first[:, 9:13])
        arm = np.einsum("kij,kj->ki", turn, self.lowest(-turn[:, 2, :]))  # from the centre to the lowest point
        low = first[:, :3] + arm
        for (x, y, z), gap in zip(low, self.gap):
            top = z - gap
            self.boxes += (f'[[wall]]\nname = "box{self.boxes.count("[[wall]]")}"\nshape = "box"\nlower = [{x - 0.2:.17g}, {y - 0.2:.17g}, '
                           f'{top - 0.2:.17g}]\nupper = [{x + 0.2:.17g}, {y + 0.2:.17g}, {top:.17g}]\nappear = 1e-3\n')
        lever = np.cross(arm, [0, 0, 1.0])
        own = np.einsum("kji,kj->ki", turn, lever)
        answering = 1 / (1 / self.mass + (own**2 / self.moments).sum(1))
        e = [closed_forms.Normal(self.law.kn, self.law.gn * self.lever_mass(m) / m, m, 1.0).e for m in answering]
        impulse = (1 + np.array(e)) * SPEED * answering
        self.v = (impulse / self.mass - SPEED)[:, None] * [0, 0, 1.0]
        self.spin = impulse[:, None] * lever  # angular momentum about the centre
        self.notes.append(f"{len(e)} bodies; the mass that answers is {answering.min() / self.mass:.2f} to "
                          f"{answering.max() / self.mass:.2f} of the body's, the restitution {min(e):.3f} to {max(e):.3f}; a contact lasts "
                          "as much less than that of a blow through the centre, of which dt counts the steps, as the root of that mass.")

    def body(self, seed):
        pitch = 3.0 * self.reach
        edge = self.side * pitch
        words = (f'[[shape]]\nname = "body"\n{self.words}\n[[source]]\nkind = "lattice"\nlattice = "cubic"\nspacing = '
                 f'{pitch / (2 * self.reach):.17g}\nnumber = {self.side**2}\nshape = "body"\norientation = "random"\nvelocity = [0, 0, '
                 f'{-SPEED:.17g}]\nregion = {{ lower = [0, 0, 0], upper = [{edge:.17g}, {edge:.17g}, {pitch:.17g}] }}\n{self.boxes}')
        return {"grains": rows(np.zeros((self.side**2, 3))), "lower": (-1, -1, -2), "upper": (edge + 1, edge + 1, pitch + 2), "words": words}

    def judge(self, setting, outcomes):
        x = outcomes[0].last
        dv = x[:, 3:6] - self.v
        turn = turns_of(x[:, 9:13])
        # the change of the angular momentum in the body's frame, where its moments are
        found = np.einsum("kji,kj->ki", turn, x[:, 6:9]) * self.moments
        dl = found - np.einsum("kji,kj->ki", turn, self.spin)
        lost = self.mass * (dv**2).sum(1) + (dl**2 / self.moments).sum(1)
        return Judged(float(np.sqrt(np.mean(lost) / self.mass)) / SPEED)

    def settings(self, features):
        return super().settings({**features, "precisions": []})  # the motion of bodies knows one precision

    def peer_q_list(self):
        return []


class RodImpact(BodyImpact):
    name, title = "rods", "Rods of three spheres hit a plane"
    reference = "closed form: a linear oscillator of the mass that answers at the sphere that touches"
    words = "spheres = [0, 0, -1, 0.5, 0, 0, 0, 0.5, 0, 0, 1, 0.5]"
    reach, mass = 1.5, 3.0
    moments = np.array([0.3, 0.3 + 2.0, 0.3 + 2.0])  # principal axes, as the frames have them: the rod's own first

    def lowest(self, m):
        return np.sign(m[:, :1]) * [1.0, 0, 0] + 0.5 * m

    def lever_mass(self, answering):
        return self.mass


class BoxImpact(BodyImpact):
    name, title = "boxes", "Rounded boxes (superquadrics) hit a plane"
    reference = "closed form: a linear oscillator of the mass that answers at the point that touches"
    axes, n1, n2 = np.array([0.9, 0.6, 0.45]), 3.0, 2.5
    words = "kind = \"superquadric\"\nsemi_axes = [0.9, 0.6, 0.45]\nexponents = [3, 2.5]"
    reach = 1.1  # at least its bounding radius

    def __init__(self, quick):
        a, b, c = self.axes
        e1, e2 = 2 / self.n1, 2 / self.n2
        density = UNIT_DENSITY * a * b * c * e1 * e2
        self.mass = density * 2 * beta(e1 / 2 + 1, e1) * beta(e2 / 2, e2 / 2)
        flat = beta(1.5 * e2, 0.5 * e2) * beta(0.5 * e1, 2 * e1 + 1)
        along = 4 * c * c * beta(0.5 * e2, 0.5 * e2 + 1) * beta(1.5 * e1, e1 + 1)
        self.moments = 0.5 * density * np.array([b * b * flat + along, a * a * flat + along, (a * a + b * b) * flat])
        super().__init__(quick)

    def lowest(self, m):
        p1, p2 = self.n1 / (self.n1 - 1), self.n2 / (self.n2 - 1)
        u = np.abs(self.axes * m)
        pair = u[:, 0] ** p2 + u[:, 1] ** p2
        h = (pair ** (p1 / p2) + u[:, 2] ** p1) ** (1 / p1)
        slope = np.stack([pair ** (p1 / p2 - 1) * u[:, 0] ** (p2 - 1), pair ** (p1 / p2 - 1) * u[:, 1] ** (p2 - 1), u[:, 2] ** (p1 - 1)], 1)
        return h[:, None] ** (1 - p1) * slope * self.axes * np.sign(m)

    def lever_mass(self, answering):
        return answering


SCENES = (RodImpact, BoxImpact)
