#!/usr/bin/env python3
"""Where the computed table of Sadhukhan's grains comes from: an own first-order solver, which repeats it to its digits.

    python3 cases/grain/sadhukhan_table.py

60 shells, implicit conduction in steps of 0.25 s with properties of the step before; the wood that is left is found first and char
is made from it, so that some of the char of a step is lost. Smaller steps show what the table would be without that."""
import math

from experiments import SADHUKHAN

R, DENSITY, H, GAS, START, RADIUS = 8.314, 682.0, 48.0, 683.0, 285.0, 0.01


def rates(T):
    return tuple(A * math.exp(-E / (R * T)) for A, E in ((168.4, 51965), (13.2, 45960), (5.7e6, 92400)))


def react(T, wood, char, char2, dt):
    """One step in place; returns the heat released [W/m3]."""
    heat = []
    for i, t in enumerate(T):
        k1, k2, k3 = rates(t)
        before = wood[i] + char[i] + char2[i]
        wood[i] -= dt * (k1 + k2) * wood[i]
        turned = dt * k3 * char[i]
        char[i] += dt * k2 * wood[i] - turned  # of the wood that is left, not of that which there was
        char2[i] += 1.38 * turned
        heat.append(240e3 * (before - wood[i] - char[i] - char2[i]) / dt)
    return heat


def conduct(T, wood, char, char2, heat, r, volume, power, dt):
    n, dx = len(T), RADIUS / len(T)
    capacity, conductivity = [], []
    for i, t in enumerate(T):
        solid = wood[i] + char[i] + char2[i]
        x, c = wood[i] / solid, t - 273.15
        capacity.append(solid * (x * (1112 + 4.85 * c) + (1 - x) * (1003.2 + 2.09 * c)) * volume[i] / dt)
        conductivity.append(max(0.02, x * (0.13 + 3e-4 * c) + (1 - x) * (0.08 - 1e-4 * c)))
    face = [0.0] + [2 * a * b / (a + b) * r[i + 1] ** power / dx for i, (a, b) in enumerate(zip(conductivity, conductivity[1:]))]
    face.append(r[n] ** power / (1 / H + dx / (2 * conductivity[-1])))
    diagonal = [capacity[i] + face[i] + face[i + 1] for i in range(n)]
    right = [capacity[i] * T[i] + heat[i] * volume[i] for i in range(n)]
    right[-1] += face[n] * GAS
    for i in range(1, n):
        w = face[i] / diagonal[i - 1]
        diagonal[i] -= w * face[i]
        right[i] += w * right[i - 1]
    T[-1] = right[-1] / diagonal[-1]
    for i in range(n - 2, -1, -1):
        T[i] = (right[i] + face[i + 1] * T[i + 1]) / diagonal[i]


def table(shape, shells=60, dt=0.25):
    """Innermost temperature [K] and share of the mass at the times of the table."""
    power = {"cylinder": 1, "sphere": 2}[shape]
    r = [RADIUS * i / shells for i in range(shells + 1)]
    volume = [(b ** (power + 1) - a ** (power + 1)) / (power + 1) for a, b in zip(r, r[1:])]
    T, wood, char, char2 = [START] * shells, [DENSITY] * shells, [0.0] * shells, [0.0] * shells
    heat, rows, start = [0.0] * shells, {}, DENSITY * sum(volume)
    for n in range(1, round(600 / dt) + 1):
        conduct(T, wood, char, char2, heat, r, volume, power, dt)
        heat = react(T, wood, char, char2, dt)
        if n * dt % 60 == 0:
            rows[n * dt] = (T[0], sum(v * (a + b + c) for v, a, b, c in zip(volume, wood, char, char2)) / start)
    return rows


def main():
    print("| grain | step [s] | centre, worst [K] | mass, worst | mass at the end |\n|---|---|---|---|---|")
    for shape, points in SADHUKHAN.items():
        for dt in (0.25, 0.0625):
            rows = table(shape, dt=dt)
            T, m = (max(abs(rows[t][k] - v) for t, v in points[name]) for k, name in enumerate(("centre_temperature", "mass")))
            print(f"| {shape} | {dt} | {T:.2f} | {m:.5f} | {rows[600][1]:.4f} (table {points['mass'][-1][1]:.4f}) |")


if __name__ == "__main__":
    main()
