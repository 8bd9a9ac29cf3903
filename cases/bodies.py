"""Surfaces of superquadrics for pictures. Used by draw.py, the report and shapes/surfaces.py."""
import functools

import numpy as np


def signed_power(x, p):
    return np.sign(x) * np.abs(x) ** p


@functools.lru_cache(maxsize=4)  # the same for every body of a picture
def grid(points):
    """Directions (polar, azimuth) of a sphere and its triangles."""
    polar = np.linspace(-np.pi / 2, np.pi / 2, points // 2 + 1)
    turn = np.arange(points) * 2 * np.pi / points
    u, v = (g.ravel() for g in np.meshgrid(polar, turn, indexing="ij"))
    triangles = []
    for i in range(points // 2):
        for j in range(points):
            a, b = i * points + j, i * points + (j + 1) % points
            c, d = a + points, b + points
            triangles += ([[a, b, d]] if i > 0 else []) + ([[a, d, c]] if i < points // 2 - 1 else [])
    return u, v, np.array(triangles)


def surface(axes, exponents, points):
    """Points of the surface at the origin in its own axes, outward normals, and triangles."""
    u, v, triangles = grid(points)
    e1, e2 = 2 / exponents[0], 2 / exponents[1]
    ring = np.abs(np.cos(u)) ** e1
    x = np.column_stack((ring * signed_power(np.cos(v), e2), ring * signed_power(np.sin(v), e2),
                         signed_power(np.sin(u), e1)))
    ring = np.abs(np.cos(u)) ** (2 - e1)
    normal = np.column_stack((ring * signed_power(np.cos(v), 2 - e2), ring * signed_power(np.sin(v), 2 - e2),
                              signed_power(np.sin(u), 2 - e1))) / axes
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    return x * axes, normal, triangles


def rotation(q):
    w, x, y, z = q
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def dressed(points, columns, bodies, around=48):
    """What a picture draws of a frame: spheres, and instead of every superquadric small spheres on its surface.

    `bodies` is the frame of bodies of the same time (points, columns, triangles) or None. Returns positions [m], radii [m],
    normals (nan for a sphere, which has its own), and the row of the frame that each belongs to.
    """
    rows = np.arange(len(points))
    plain = np.full((len(points), 3), np.nan)
    if bodies is None or "semi_axes" not in bodies[1]:
        return points, columns["radius"], plain, rows
    centres, of = bodies[0], bodies[1]
    row_of = {int(name): k for k, name in enumerate(columns["id"])}
    sphere = np.ones(len(points), bool)
    parts = []
    for k in np.flatnonzero(of["semi_axes"][:, 0] > 0):
        row = row_of.get(int(of["id"][k]))
        if row is None:
            continue
        sphere[row] = False
        x, normal, _ = surface(of["semi_axes"][k], of["exponents"][k], around)
        turn = rotation(of["orientation"][k]).T
        gap = 4.5 * of["semi_axes"][k].max() / around  # neighbours overlap
        parts.append((centres[k] + (x - normal * gap) @ turn, np.full(len(x), gap), normal @ turn, np.full(len(x), row)))
    kept = (points[sphere], columns["radius"][sphere], plain[sphere], rows[sphere])
    return tuple(np.concatenate(column) for column in zip(kept, *parts))
