#!/usr/bin/env python3
"""What an exact tangential dashpot would cost: step limits of one mode of a packing.

The normal dashpot is exact at rest because it sees what the other forces of the last step have done (dashpot_velocity()
in kernels/models/linear.hpp); the tangential one solves for the pair alone, which leaves a resting spring too soft by
7/4 gamma_t dt. With the same feedback it would be exact too, but a feedback is one step late: this script gives the
largest stable step of both forms from the eigenvalues of the recurrence.

A mode of a packing has `compliance` times that of a pair (fcc: 4); x is the spring, v its rate at n-1/2:
  pairwise  u = v + dt/2 f;  with feedback  u = v + (v - q)/2 + dt/2 f,  q = v + dt f of the last step
  f = -(omega^2 x + 2 zeta omega u),   v' = v + compliance dt f,   x' = x + dt v'

Usage: python3 perf/dashpot_limits.py
"""
import math

import numpy as np

COMPLIANCE = 4
POISSON = 0.3


def growth(omega_dt, zeta, feedback):
    """Largest amplification per step."""
    def step(state):
        x, v, q = state
        u = v + (0.5 * (v - q) if feedback else 0)
        f = -(omega_dt**2 * x + 2 * zeta * omega_dt * u) / (1 + zeta * omega_dt)
        fast = v + COMPLIANCE * f
        return [x + fast, fast, v + f]
    size = 3 if feedback else 2
    matrix = np.array([step(e) for e in np.eye(3)]).T[:size, :size]
    return max(abs(np.linalg.eigvals(matrix)))


def limit(zeta, feedback):
    """Largest stable omega dt, of the pair's omega."""
    low, high = 0.0, 2.0
    for _ in range(40):
        middle = 0.5 * (low + high)
        stable = all(growth(s * middle, zeta, feedback) <= 1 + 1e-9 for s in (1, 0.8, 0.6, 0.4))
        low, high = (middle, high) if stable else (low, middle)
    return low


def main():
    print("Hertz, step limits times the normal omega of a pair: normal dashpot with feedback, tangential without and with")
    print("| e | damping ratio, normal, tangential | normal | tangential, pairwise | with feedback | a step is shorter by |")
    print("|---|---|---|---|---|---|")
    for e in (0.9, 0.7, 0.5, 0.3, 0.1):
        alpha = -math.sqrt(5) * math.log(e) / math.hypot(math.pi, math.log(e))
        # tangent stiffness 3/2 S_n; tangential spring S_t = 2 (1 - nu)/(2 - nu) S_n with 7/2 of the compliance
        ratio = math.sqrt(3.5 * 2 * (1 - POISSON) / (2 - POISSON) / 1.5)
        normal, tangential = alpha / (2 * math.sqrt(1.5)), 0.5 * alpha * math.sqrt(2 / 3 * 3.5)
        n, pairwise, exact = limit(normal, True), limit(tangential, False) / ratio, limit(tangential, True) / ratio
        loss = 1 - min(n, exact) / min(n, pairwise)
        print(f"| {e} | {normal:.2f}, {tangential:.2f} | {n:.2f} | {pairwise:.2f} | {exact:.2f} | {100 * loss:.0f} % |")


if __name__ == "__main__":
    main()
