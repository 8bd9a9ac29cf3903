#!/usr/bin/env python3
"""What the first and the last step of a contact are worth: forms of the linear normal law, without friction.

  plain       the dashpot's impulse counts from touch to parting, the spring's force is that at n; a pair parts if its
              speed before the step takes it apart before the next one. At e = 1 that is LAMMPS
  weighed     with u dt the time in contact on this side of n, the spring's impulse is (1/2 + u)^2/(2 u) of that of its
              force at n; a pair parts if its speed after the step takes it apart, and the step after that counts nothing,
              for which the contact has a memory. Talus
  forgetful   the same without the memory

1. Largest error of restitution over the phase of the touch and over contacts of N to N + 1 steps (a whole number of steps
   flatters: touch and parting mirror each other).
2. Energy of one grain on a floor, between floor and lid under gravity, and between two walls that squeeze it, 12 steps per
   contact: the largest over that of the first contact, of 60 draws of gravity, gap and speed.
3. What the normal law alone adds to the error of the impacts of perf/tangential.py at e = 1 and mu = 0.05, which slide from
   touch to parting: nearly all of it with the plain form, so no tangential law could be closer than that.

Usage: python3 perf/contact_ends.py     (a minute or two, no runs of Talus)
"""
import math

import numpy as np

import tangential


def constants(e):
    """Stiffness and rate for unit mass and an undamped contact time of 1."""
    log = math.log(e)
    return math.pi**2, -2 * log / math.sqrt(math.pi**2 + log**2) * math.pi


class Contact:
    """One contact each of many independent runs; `memory` is the velocity that the last step predicted, 0: none."""

    def __init__(self, form, e, dt, runs):
        self.form, self.dt = form, dt
        self.k, self.g = constants(e)
        self.memory = np.zeros(runs)

    def force(self, delta, vn):
        """delta > 0: overlap; vn > 0: parting. Zero where there is no contact."""
        with np.errstate(all="ignore"):
            k, g, dt, weighs = self.k, self.g, self.dt, self.form != "plain"
            damped, touching = g > 0, delta > 0
            remembers = damped if self.form == "plain" else self.form == "weighed"
            fresh = self.memory == 0
            resting = np.where(delta < -vn * dt, vn, vn - 0.5 * dt * k * delta)
            seen = np.where(fresh, resting, vn + 0.5 * (vn - self.memory)) if damped else vn
            f = (k * delta - g * seen) / (1 + 0.5 * dt * g)
            brief = delta < np.abs(vn) * dt
            counted = brief & fresh & (vn > 0) if remembers else np.zeros(np.shape(vn), bool)
            ahead = vn + dt * f if weighs else vn
            early = 17 / 16 if weighs else 1  # rather now than never: the sum is the same
            enters, leaves = brief & (vn < 0), (vn > 0) & (counted | (delta < early * ahead * dt))
            speed = np.where(enters, -vn, ahead)
            u = np.clip(delta / np.maximum(speed * dt, delta / 1.5), 1e-9, None)
            spring = 0.5 * (0.5 + u) ** 2 / u if weighs else 1
            rate = g * (0.5 + u)
            edge = (spring * k * delta - rate * seen) / (1 + 0.5 * dt * rate)
            if remembers:
                edge = np.where(counted, 0 if weighs else k * delta, edge)
            f = np.where(enters | leaves, edge, f)
            self.memory = np.where(leaves | ~touching, 0, vn + dt * f)
            return np.where(touching, f, 0)


def rebound(form, e, dt, phase):
    """Speed after impacts at unit speed, which touch within the second step; dt may be an array."""
    contact = Contact(form, e, dt, np.shape(phase))
    x, v = dt * (1 + phase), -np.ones(np.shape(phase))
    for _ in range(int(4 / np.min(dt))):
        v = v + dt * contact.force(-x, v)
        x = x + dt * v
    return v


def restitution(form, e, n):
    phase, steps = np.meshgrid((np.arange(500) + 0.5) / 500, n + np.arange(8) / 8)
    return np.abs(rebound(form, e, 1 / steps, phase) - e).max()


def energy(form, e, n, where, draws=60, contacts=400):
    """Largest energy after the first contact over that until then."""
    rng = np.random.default_rng(1)
    gravity = 10 ** rng.uniform(-2, 0, draws) if where != "walls" else np.zeros(draws)
    gap = 10 ** rng.uniform(-4, -1, draws) * (np.where(np.arange(draws) % 2, -1, 1) if where == "walls" else 1)
    if where == "floor":
        gap += 1e9
    dt = 1 / n
    floor, lid = Contact(form, e, dt, draws), Contact(form, e, dt, draws)
    k = floor.k
    x, v = np.zeros(draws), 10 ** rng.uniform(-3, -1, draws)
    first = largest = np.zeros(draws)
    for step in range(contacts * n):
        f = -gravity + floor.force(-x, v) - lid.force(x - gap, -v)
        middle = v + 0.5 * dt * f
        now = 0.5 * middle**2 + gravity * x + 0.5 * k * (np.maximum(-x, 0) ** 2 + np.maximum(x - gap, 0) ** 2)
        now = now + 0.5 * gravity**2 / k  # above that at rest
        if step <= 2 * n:
            first = np.maximum(first, now)
        else:
            largest = np.maximum(largest, now)
        v = v + dt * f
        x = x + dt * v
    return (largest / first).max()


def normal_part(form, seed, n):
    """Error of tangential.py at e = 1, mu = 0.05 that the normal law alone makes: largest velocity error of a grain over
    the impact speed."""
    grains, phases, law = tangential.impacts(1.0, 0.0, 0.05, seed)
    a, b = grains[0::2], grains[1::2]
    mass = [tangential.DENSITY * 4 / 3 * math.pi * g[:, 3] ** 3 for g in (a, b)]
    reduced = mass[0] * mass[1] / (mass[0] + mass[1])
    contact = math.pi * np.sqrt(reduced / law[0])
    normal = a[:, :3] - b[:, :3]
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    v = a[:, 4:7] - b[:, 4:7]
    share = np.abs((v * normal).sum(axis=1)) / np.linalg.norm(v, axis=1)
    error = np.abs(rebound(form, 1.0, 1 / (n * contact), phases[0::2]) - 1)
    return (error * share * reduced / np.minimum(*mass)).max()


def main():
    print("1. Largest error of restitution")
    print("| e | " + " | ".join(f"N = {n}: plain, weighed" for n in (12, 20, 50, 200)) + " |")
    print("|---" * 5 + "|")
    for e in (1.0, 0.98, 0.95, 0.9, 0.8, 0.7, 0.5, 0.3, 0.1):
        print(f"| {e:g} | " + " | ".join(", ".join(f"{restitution(form, e, n):.1e}" for form in ("plain", "weighed"))
                                         for n in (12, 20, 50, 200)) + " |", flush=True)
    forms = ("plain", "weighed", "forgetful")
    print("\n2. Largest energy over that of the first contact: " + ", ".join(forms))
    print("| e | on a floor | floor and lid, under gravity | squeezed between walls |")
    print("|---" * 4 + "|")
    for e in (1.0, 0.999, 0.9):
        print(f"| {e:g} | " + " | ".join(", ".join(f"{energy(form, e, 12, where):.3f}" for form in forms)
                                         for where in ("floor", "lid", "walls")) + " |", flush=True)
    print("\n3. Error of the impacts at e = 1, mu = 0.05 by the normal law alone: plain (LAMMPS), weighed (Talus)")
    print("| seed | N = 20 | N = 50 |\n|---|---|---|")
    for seed in (1, 2, 3):
        print(f"| {seed} | " + " | ".join(", ".join(f"{normal_part(form, seed, n):.2e}" for form in ("plain", "weighed"))
                                          for n in (20, 50)) + " |", flush=True)


if __name__ == "__main__":
    main()
