#!/usr/bin/env python3
"""Schumann's bed beside its closed form.

  python3 cases/packed_bed/schumann.py --make            # generated/schumann.csv, the grains
  talus run cases/packed_bed/schumann.toml --out out/schumann
  python3 cases/packed_bed/schumann.py out/schumann      # errors, schumann.svg in the folder

Schumann (1929): dT_f/dY = -(T_f - T_s), dT_s/dZ = T_f - T_s, solved by T_f = J(Y, Z), T_s = 1 - J(Z, Y); Y = a h x / (G c_f) and
Z = a h t / ((1 - e) rho_s c_s). Properties of air as in core/gas. Needs python3-numpy; for the picture python3-matplotlib.
"""
import argparse
import os
import sys

import numpy as np

sys.dont_write_bytecode = True
HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.dirname(HERE))
import case_files  # noqa: E402
from frames import PvdFrames, read_vti, whole_frames  # noqa: E402

PITCH, DIAMETER, ACROSS, HIGH = 0.01, 0.0098, 3, 40  # [m], [m], grains
VELOCITY, HOT, COLD, PRESSURE = 3.0, 305.0, 300.0, 101325.0
SOLID = 1000.0 * 1000.0  # density times heat capacity [J/m3/K]
R = 8.314462618
AIR = {  # mass fraction, molar mass [kg/mol], cp/R as a polynomial of T
    "O2": (0.233, 31.9988e-3, (3.78245636, -2.99673416e-3, 9.84730201e-6, -9.68129509e-9, 3.24372837e-12)),
    "N2": (0.767, 28.0134e-3, (3.298677, 1.4082404e-3, -3.963222e-6, 5.641515e-9, -2.444854e-12))}


def make():
    case_files.fixed_lattice(os.path.join(HERE, "generated", "schumann.csv"), ACROSS, HIGH, PITCH, DIAMETER)


def numbers():
    """Y per length [1/m] and Z per time [1/s]."""
    T = 0.5 * (HOT + COLD)
    c = sum(y * R / m * sum(a * T**n for n, a in enumerate(p)) for y, m, p in AIR.values())
    mu = 1.458e-6 * T**1.5 / (T + 110.4)
    flow = VELOCITY * PRESSURE / (R * sum(y / m for y, m, _ in AIR.values()) * HOT)
    re, pr = flow * DIAMETER / mu, 0.7
    h = (2 + (0.4 * re**0.5 + 0.06 * re ** (2 / 3)) * pr**0.4) * mu * c / pr / DIAMETER  # Whitaker (1972)
    area = h * np.pi * DIAMETER**2 / PITCH**3
    return area / (flow * c), area / (np.pi / 6 * (DIAMETER / PITCH) ** 3 * SOLID)


def solid(Y, Z, n=4000):
    """1 - J(Z, Y), of the grains; that of the gas is J(Y, Z) = 1 - solid(Z, Y)."""
    y = Z * (np.arange(n) + 0.5) / n
    return float(np.sum(np.exp(-Y - y) * np.i0(2 * np.sqrt(Y * y))) * Z / n)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", help="of a finished run")
    parser.add_argument("--make", action="store_true", help="write the grains")
    parser.add_argument("--no-picture", action="store_true")
    args = parser.parse_args()
    if args.make:
        make()
    if not args.folder:
        return 0 if args.make else parser.error("a folder, or --make")
    per_length, per_time = numbers()
    curves, gases = [], gas_temperatures(args.folder)
    for t, x, columns in whole_frames(args.folder):
        if not t > 0:
            continue
        z = np.unique(np.round(x[:, 2], 6))
        ours = np.array([columns["temperature"][np.abs(x[:, 2] - h) < 1e-5].mean() for h in z])
        ours = (ours - COLD) / (HOT - COLD)
        theirs = np.array([solid(per_length * h, per_time * t) for h in z])
        height, gas = gases[t]
        gas = (gas - COLD) / (HOT - COLD)
        expected = np.array([1 - solid(per_time * t, per_length * h) for h in height])
        curves.append((t, z, ours, theirs, height, gas, expected))
        print(f"t = {t:4.0f} s: largest error of the grains {np.abs(ours - theirs).max():.4f}, of the gas "
              f"{np.abs(gas - expected).max():.4f} of the step")
    if not args.no_picture:
        picture(os.path.join(args.folder, "schumann.svg"), curves)
    return 0


def gas_temperatures(folder):
    """{time: (heights of the cells, temperatures of the gas)}."""
    frames, found = PvdFrames(os.path.join(folder, "gas.pvd")), {}
    for t, (_, path) in zip(frames.times, frames.list):
        origin, spacing, cells, columns = read_vti(path)
        found[t] = origin[2] + spacing[2] * (np.arange(cells[2]) + 0.5), columns["temperature"].reshape(cells[2], -1).mean(1)
    return found


def picture(path, curves):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    fig, axes = plt.subplots(1, 2, figsize=(11, 4), sharey=True)
    for t, z, ours, theirs, height, gas, expected in curves:
        for axis, at, dots, curve in zip(axes, (z, height), (ours, gas), (theirs, expected)):
            line, = axis.plot(at, curve, label=f"{t:.0f} s")
            axis.plot(at, dots, "o", ms=3, color=line.get_color())
    for axis, what in zip(axes, ("grains", "gas")):
        axis.set(xlabel="height [m]", ylabel=f"(T - 300 K) / 5 K of the {what}", title="lines: Schumann (1929), dots: Talus")
    axes[0].legend()
    fig.savefig(path, bbox_inches="tight")


if __name__ == "__main__":
    sys.exit(main())
