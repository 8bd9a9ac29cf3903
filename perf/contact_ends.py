#!/usr/bin/env python3
"""What the first and the last step of a contact are worth: two forms of the linear normal law, without friction.

  plain    the dashpot's impulse counts from touch to parting, the spring's force is that at n; a pair parts if its speed
           before the step takes it apart before the next one
  weighed  with u dt the time in contact on this side of n, the spring's impulse is (1/2 + u)^2/(2 u) of that of its force
           at n; a pair parts if its speed after the step takes it apart

First table: largest error of restitution over 1000 phases of the touch, N steps per contact. Second: energy of one grain on
a floor, between floor and lid under gravity, and between two walls that squeeze it, over 1000 contact times: the largest
over that of the first one. Impacts of e = 1 are far better weighed; but a pair that another force holds together is then
given the impulse of a parting that does not happen, and without a dashpot nothing takes that energy: that bounds what an
elastic contact can have without a memory of the other forces.

Usage: python3 perf/contact_ends.py     (seconds, no runs of Talus)
"""
import math

import numpy as np


def constants(e):
    """Stiffness and rate for unit mass and an undamped contact time of 1."""
    log = math.log(e)
    return math.pi**2, -2 * log / math.sqrt(math.pi**2 + log**2) * math.pi


class Contact:
    """One contact each of many independent runs; `memory` is the velocity that the last step predicted, 0: none."""

    def __init__(self, form, e, dt, runs):
        self.weighed, self.dt = form == "weighed", dt
        self.k, self.g = constants(e)
        self.memory = np.zeros(runs)

    def force(self, delta, vn):
        """delta > 0: overlap; vn > 0: parting. Zero where there is no contact."""
        with np.errstate(all="ignore"):
            k, g, dt = self.k, self.g, self.dt
            touching, damped = delta > 0, g > 0
            fresh = self.memory == 0
            resting = np.where(delta < -vn * dt, vn, vn - 0.5 * dt * k * delta)
            seen = np.where(fresh, resting, vn + 0.5 * (vn - self.memory)) if damped else vn
            f = (k * delta - g * seen) / (1 + 0.5 * dt * g)
            speed = vn + dt * f if self.weighed else vn
            brief = delta < np.abs(vn) * dt
            counted = brief & fresh & (vn > 0) if damped else np.zeros(len(vn), bool)
            enters, leaves = brief & (vn < 0), (vn > 0) & (counted | (delta < speed * dt))
            speed = np.where(enters, -vn, speed)
            for _ in range(2 if self.weighed else 1):
                u = np.clip(delta / (speed * dt), 1e-9, 1)
                spring = 0.5 * (0.5 + u) ** 2 / u if self.weighed else 1
                rate = g * (0.5 + u)
                edge = (spring * k * delta - rate * seen) / (1 + 0.5 * dt * rate)
                if self.weighed:
                    edge = np.where(counted, 0, edge)
                elif damped:
                    edge = np.where(counted, k * delta, edge)
                speed = np.where(leaves, vn + dt * edge, speed)
            f = np.where(enters | leaves, edge, f)
            self.memory = np.where(leaves | ~touching, 0, vn + dt * f)
            return np.where(touching, f, 0)


def restitution(form, e, n, phases=1000):
    dt, contact = 1 / n, Contact(form, e, 1 / n, phases)
    x, v = dt * (1 + (np.arange(phases) + 0.5) / phases), -np.ones(phases)
    for _ in range(4 * n):
        v = v + dt * contact.force(-x, v)
        x = x + dt * v
    return np.abs(v - e).max()


def energy(form, e, n, gravity, gap, speed, starts=8):
    """Largest energy of any start after the first contact time, over that before."""
    dt = 1 / n
    floor, lid = Contact(form, e, dt, starts), Contact(form, e, dt, starts)
    k = floor.k
    x, v = np.zeros(starts), speed * (1 + 0.1 * np.arange(starts) / starts)
    first = largest = None
    for step in range(1000 * n):
        f = -gravity + floor.force(-x, v) - lid.force(x - gap, -v)
        middle = v + 0.5 * dt * f
        now = 0.5 * middle**2 + gravity * x + 0.5 * k * (np.maximum(-x, 0) ** 2 + np.maximum(x - gap, 0) ** 2)
        now = now + 0.5 * gravity**2 / k  # above that at rest
        if step <= n:
            first = now if first is None else np.maximum(first, now)
        largest = now if largest is None else np.maximum(largest, now)
        v = v + dt * f
        x = x + dt * v
    return (largest / first).max()


def main():
    forms = ("plain", "weighed")
    print("Largest error of restitution over the phases")
    print("| e | " + " | ".join(f"N = {n}: {', '.join(forms)}" for n in (12, 20, 50, 200)) + " |")
    print("|---" * 5 + "|")
    for e in (1.0, 0.98, 0.95, 0.9, 0.8, 0.7, 0.5, 0.3, 0.1):
        print(f"| {e:g} | " + " | ".join(", ".join(f"{restitution(form, e, n):.1e}" for form in forms) for n in (12, 20, 50, 200)) + " |",
              flush=True)
    print("\nLargest energy over that of the first contact time, 12 steps per contact: " + ", ".join(forms))
    print("| e | on a floor | floor and lid, under gravity | squeezed between walls |")
    print("|---" * 4 + "|")
    for e in (1.0, 0.999, 0.9):
        print(f"| {e:g} | " + " | ".join(", ".join(f"{energy(form, e, 12, *where):.3f}" for form in forms) for where in
              ((0.3, 1e9, 0.05), (0.3, 0.02, 0.02), (0.0, -1e-4, 0.01))) + " |", flush=True)


if __name__ == "__main__":
    main()
