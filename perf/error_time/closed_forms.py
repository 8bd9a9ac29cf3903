"""Exact solutions of the linear law: normal impact, oblique impact on a plane, bouncing under gravity, a clamped stack.

Who calls it: scenes_exact.py. Everything is piecewise closed form in double precision; where pieces join, the instant is
found by bisection to the last bits. verify() checks each against an independent fact and is run before any report.
"""
import math

import numpy as np


def bisect(f, low, high, rounds=80):
    """Root of f between low and high (arrays, f(low) and f(high) differ in sign)."""
    low, high = np.array(low, float), np.array(high, float)
    sign = np.sign(f(low))
    for _ in range(rounds):
        middle = 0.5 * (low + high)
        same = np.sign(f(middle)) == sign
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return 0.5 * (low + high)


class Normal:
    """Overlap of a contact that begins at t = 0 with closing speed v: m u'' + g m u' + k u = 0."""

    def __init__(self, k, g, m, v):
        self.k, self.g, self.m, self.v = k, g, m, v
        self.wd = math.sqrt(k / m - g * g / 4)
        self.duration = math.pi / self.wd
        self.e = math.exp(-0.5 * g * self.duration)
        # the force k u + g m u' vanishes before the overlap does
        self.force_end = (math.pi - math.atan2(2 * self.wd * g / 2, self.wd**2 - g * g / 4)) / self.wd

    def overlap(self, t):
        return self.v / self.wd * np.exp(-0.5 * self.g * t) * np.sin(self.wd * t)

    def rate(self, t):
        return self.v * np.exp(-0.5 * self.g * t) * (np.cos(self.wd * t) - 0.5 * self.g / self.wd * np.sin(self.wd * t))

    def force(self, t):
        return np.maximum(self.k * self.overlap(t) + self.g * self.m * self.rate(t), 0.0)

    def impulse(self, t):
        """Of the force from 0 to t (t before force_end): what the closing speed has lost."""
        return self.m * (self.v - self.rate(t))


def oblique(normal, kt, mu, vt, compliance=3.5):
    """Tangential impulse per mass on a sphere that meets a plane with tangential velocity vt: spring kt, Coulomb limit.

    The contact point's slip s obeys s' = -(7/2) F/m, F = kt xi while it sticks, F = mu N while it slides.
    Returns (change of v_t, change of R omega, both along vt; the surface loses 7/2 of the first).
    """
    w = math.sqrt(compliance * kt / normal.m)
    end = normal.force_end
    t, xi, slip, lost, sticks = 0.0, 0.0, vt, 0.0, True  # lost: tangential impulse so far
    while t < end * (1 - 1e-13):
        grid = t + (end - t) * np.linspace(0, 1, 4001)[1:]
        if sticks:
            def spring(at):
                return xi * np.cos(w * (at - t)) + slip / w * np.sin(w * (at - t))

            over = np.abs(kt * spring(grid)) - mu * normal.force(grid)
            hit = np.flatnonzero(over > 0)
            stop = end if len(hit) == 0 else float(bisect(lambda q: np.abs(kt * spring(q)) - mu * normal.force(q),
                                                          grid[hit[0] - 1] if hit[0] else t, grid[hit[0]]))
            new = slip * math.cos(w * (stop - t)) - xi * w * math.sin(w * (stop - t))
            xi, lost, slip = float(spring(stop)), lost + (slip - new) / compliance * normal.m, new
            t, sticks = stop, False
            continue
        sign = math.copysign(1.0, xi)
        begin, at_begin = normal.impulse(t), slip

        def sliding(q):
            return at_begin - sign * compliance * mu * (normal.impulse(q) - begin) / normal.m

        # it sticks again when the spring, left alone, would fall behind the limit
        def behind(q):
            h = 1e-6 * normal.duration
            growth = (normal.force(np.minimum(q + h, end)) - normal.force(q - h)) / (np.minimum(q + h, end) - q + h)
            return sign * kt * sliding(q) - mu * growth

        back = np.flatnonzero(behind(grid[:-1]) < 0)
        stop = end
        if len(back):
            stop = grid[0] if back[0] == 0 else float(bisect(behind, grid[back[0] - 1], grid[back[0]]))
        slip = float(sliding(stop))
        lost += sign * mu * (normal.impulse(stop) - begin)
        t, sticks, xi = stop, True, sign * mu * float(normal.force(stop)) / kt
    return -lost / normal.m, -2.5 * lost / normal.m


def bounce(times, height, g, k, rate, m=1.0):
    """Heights of a sphere's lowest point at `times`, dropped at rest from `height` (array) on a plane (array of rows)."""
    out = np.empty((len(times), len(height)))
    for i, h in enumerate(height):
        t, u, v = 0.0, h, 0.0  # start of the present piece
        done = 0
        while done < len(times):
            flight = u > 0 or (u == 0 and v > 0)
            if flight:
                length = (v + math.sqrt(v * v + 2 * g * u)) / g
                path = lambda q, u=u, v=v: (u + v * q - 0.5 * g * q * q, v - g * q)
            else:
                path = contact_path(u, v, g, k, rate, m)
                period = math.pi / math.sqrt(k / m - rate * rate / 4)
                grid = np.linspace(0, 1.5 * period, 3001)[1:]
                up = np.flatnonzero(path(grid)[0] > 0)
                if len(up) == 0:
                    raise ValueError("the sphere no longer leaves the plane: shorten the run")
                length = float(bisect(lambda q: path(q)[0], grid[up[0] - 1], grid[up[0]]))
            while done < len(times) and times[done] <= t + length:
                out[done, i] = path(times[done] - t)[0]
                done += 1
            v = float(path(length)[1])
            t, u = t + length, 0.0
            if flight:
                v = -abs(v)
    return out


def contact_path(u, v, g, k, rate, m):
    """(u, u') of m u'' + rate m u' + k u = -m g."""
    rest, a = -m * g / k, 0.5 * rate
    wd = math.sqrt(k / m - a * a)

    def path(q):
        c, s, f = np.cos(wd * q), np.sin(wd * q), np.exp(-a * np.asarray(q))
        b = (v + a * (u - rest)) / wd
        y = f * ((u - rest) * c + b * s)
        return rest + y, -a * y + f * wd * (b * c - (u - rest) * s)

    return path


def stack(times, z, height, g, k, rate, m=1.0):
    """Centres of two spheres of diameter 1 clamped between planes at 0 and `height` (z: two columns, all in touch, at
    rest). A dashpot's mass is m at a plane and m/2 between the spheres."""
    stiff = np.array([[-2 * k, k], [k, -2 * k]]) / m
    damp = np.array([[-1.5 * rate, 0.5 * rate], [0.5 * rate, -1.5 * rate]])
    load = np.array([k * 0.5 - k * 1.0 - m * g, k * 1.0 + k * (height - 0.5) - m * g]) / m
    rest = -np.linalg.solve(stiff, load)
    system = np.block([[np.zeros((2, 2)), np.eye(2)], [stiff, damp]])
    values, vectors = np.linalg.eig(system)
    start = np.concatenate([(z - rest).T, np.zeros((2, len(z)))])
    weights = np.linalg.solve(vectors, start.astype(complex))
    return np.array([((vectors * np.exp(values * t)) @ weights).real[:2].T + rest for t in times])


def verify():
    """Each closed form against an independent one; AssertionError names what is wrong."""
    n = Normal(math.pi**2 + math.log(0.8) ** 2, -2 * math.log(0.8), 1.0, 1.0)
    assert abs(n.duration - 1) < 1e-14 and abs(n.e - 0.8) < 1e-14, "normal impact"
    assert abs(n.k * n.overlap(n.force_end) + n.g * n.rate(n.force_end)) < 1e-13, "end of the force"
    dv, dw = oblique(n, 2 / 7 * n.k, 0.3, 50.0)
    assert abs(-dv - 0.3 * n.impulse(n.force_end)) < 1e-3 * -dv, "gross sliding: impulse mu N"
    free = oblique(n, 2 / 7 * n.k, 1e6, 0.1)
    # never slides: a harmonic spring up to the end of the normal force
    w = math.sqrt(n.k)
    assert abs(-free[0] - 0.1 * (1 - math.cos(w * n.force_end)) / 3.5) < 1e-8, "sticking impact"
    t = np.array([0.5, 2.0])
    drop = bounce(t, [1.0], 1.0, 1e10, 0.0)[:, 0]
    # elastic and nearly rigid: a parabola again after the impact at sqrt 2
    assert abs(drop[0] - 0.875) < 1e-12 and abs(drop[1] - (1 - 0.5 * (2.0 - 2 * math.sqrt(2)) ** 2)) < 2e-4, "bounce"
    z = np.array([[0.47, 1.35]])
    s = stack(np.array([0.0, 1e-3, 2e-3]), z, 1.8, 1.0, 1e3, 5.0)
    assert np.abs(s[0] - z).max() < 1e-12, "stack, start"
    a = (s[2] - 2 * s[1] + s[0])[0] / 1e-6
    f1 = 1e3 * (0.5 - 0.47) - 1e3 * (1 - 0.88) - 1
    assert abs(a[0] - f1) < 2e-2 * abs(f1), "stack, first acceleration"
