"""Files that the cases generate: binary STL, height fields, particle tables. Imported by the make_*.py of the cases.

Everything here is a function of its arguments (no clock, no unseeded random numbers), so that a generated case has the
same bytes on every machine with the same numpy.
"""
import gzip
import os

import numpy as np

from frames import frames  # noqa: F401  for the scripts of the cases


def write_stl(path, triangles):
    """triangles: array [n, 3 corners, 3] in metres. Degenerate ones are dropped."""
    t = np.asarray(triangles, dtype=np.float64)
    normal = np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])
    length = np.linalg.norm(normal, axis=1)
    keep = length > 0
    record = np.zeros(int(keep.sum()), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    record["normal"] = normal[keep] / length[keep][:, None]
    record["corners"] = t[keep]
    replace(path, b"talus case".ljust(80, b" ") + np.uint32(len(record)).tobytes() + record.tobytes())
    return len(record)


def write_particles(path, x, radius):
    """CSV table of grains at rest, gzip by its name; the gzip header carries no time. Lengths are rounded to a nanometre:
    the last digits of sines and exponentials depend on the processor."""
    lines = ["x,y,z,radius,vx,vy,vz"]
    lines += [",".join(repr(round(float(v), 9)) for v in (*row, r)) + ",0,0,0" for row, r in zip(x, radius)]
    data = ("\n".join(lines) + "\n").encode()
    replace(path, gzip.compress(data, 6, mtime=0) if path.endswith(".gz") else data)
    return len(radius)


def grid_triangles(z, xs, ys):
    """Triangles of the height field z[i, j] over the points xs[i], ys[j], seen from above counter-clockwise."""
    p = np.stack([*np.meshgrid(xs, ys, indexing="ij"), z], axis=-1)
    a, b, c, d = p[:-1, :-1], p[1:, :-1], p[1:, 1:], p[:-1, 1:]
    return np.concatenate([np.stack([a, b, c], axis=2).reshape(-1, 3, 3), np.stack([a, c, d], axis=2).reshape(-1, 3, 3)])


def hexagonal(lower, upper, pitch):
    """Points of a hexagonal close packing of spheres of diameter `pitch` in a box."""
    lower, upper = np.asarray(lower, float), np.asarray(upper, float)
    step = pitch * np.array([1.0, np.sqrt(3) / 2, np.sqrt(2 / 3)])
    n = np.maximum(((upper - lower) / step + 1e-9).astype(int) + 1, 1)
    i, j, k = (a.ravel() for a in np.meshgrid(*(np.arange(m) for m in n), indexing="ij"))
    x = lower[0] + step[0] * (i + 0.5 * ((j + k) % 2))
    y = lower[1] + step[1] * (j + (k % 2) / 3)
    z = lower[2] + step[2] * k
    points = np.stack([x, y, z], axis=1)
    return points[(points <= upper + 1e-12 * pitch).all(axis=1)]


def replace(path, data):
    os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
    with open(path + ".part", "wb") as f:
        f.write(data)
    os.replace(path + ".part", path)


def fixed_lattice(path, across, high, pitch, diameter):
    """Writes a particle file: fixed grains on a square lattice of across x across x high, pitch and diameter [m]."""
    n = across * across * high
    rows = ["x,y,z,radius,fixed"]
    for k in range(n):
        place = (k % across, k // across % across, k // across**2)
        rows.append(",".join(repr(round((q + 0.5) * pitch, 9)) for q in place) + f",{diameter / 2!r},1")
    replace(path, ("\n".join(rows) + "\n").encode())
    print(f"{path}: {n} grains")
