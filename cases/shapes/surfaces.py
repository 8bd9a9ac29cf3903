#!/usr/bin/env python3
"""Surfaces of superquadrics for ParaView: python3 surfaces.py RUN [--points 24].

Reads bodies.pvd of a run and writes surfaces.pvd beside it: triangles of every superquadric, with point columns id, shape and
speed. Any version of ParaView opens it.
"""
import argparse
import os
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from frames import read_vtp  # noqa: E402


def signed_power(x, p):
    return np.sign(x) * np.abs(x) ** p


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
            if i == 0:
                continue
    return u, v, np.array(triangles)


def surface(axes, exponents, points):
    """Points of the surface at the origin in its own axes, and triangles."""
    u, v, triangles = grid(points)
    e1, e2 = 2 / exponents[0], 2 / exponents[1]
    ring = np.abs(np.cos(u)) ** e1
    x = np.column_stack((ring * signed_power(np.cos(v), e2), ring * signed_power(np.sin(v), e2),
                         signed_power(np.sin(u), e1)))
    return x * axes, triangles


def rotation(q):
    w, x, y, z = q
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def surfaces(centres, columns, points):
    """All superquadrics of a frame: points, triangles, columns."""
    all_points, all_triangles, owner, base = [], [], [], 0
    for k in np.flatnonzero(columns["semi_axes"][:, 0] > 0):
        x, triangles = surface(columns["semi_axes"][k], columns["exponents"][k], points)
        all_points.append(centres[k] + x @ rotation(columns["orientation"][k]).T)
        all_triangles.append(triangles + base)
        owner.append(np.full(len(x), k))
        base += len(x)
    owner = np.concatenate(owner)
    speed = np.linalg.norm(columns["velocity"], axis=1)
    data = {"id": columns["id"][owner], "shape": columns["shape"][owner], "speed": speed[owner]}
    return np.concatenate(all_points), np.concatenate(all_triangles), data


def write_vtp(path, points, triangles, data):
    def array(name, kind, values, width=1):
        text = " ".join(f"{v:.7g}" if kind == "Float32" else str(int(v)) for v in np.ravel(values))
        return (f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{width}" format="ascii">{text}'
                "</DataArray>\n")
    with open(path, "w") as f:
        f.write('<VTKFile type="PolyData" version="0.1" byte_order="LittleEndian">\n<PolyData>\n'
                f'<Piece NumberOfPoints="{len(points)}" NumberOfVerts="0" NumberOfLines="0" NumberOfStrips="0" '
                f'NumberOfPolys="{len(triangles)}">\n<PointData>\n')
        for name, values in data.items():
            f.write(array(name, "Float32" if name == "speed" else "Int64", values))
        f.write("</PointData>\n<Points>\n" + array("Points", "Float32", points, 3) + "</Points>\n<Polys>\n"
                + array("connectivity", "Int64", triangles)
                + array("offsets", "Int64", 3 * np.arange(1, len(triangles) + 1))
                + "</Polys>\n</Piece>\n</PolyData>\n</VTKFile>\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("run")
    parser.add_argument("--points", type=int, default=24, help="around a body")
    options = parser.parse_args()
    with open(os.path.join(options.run, "bodies.pvd"), encoding="utf-8") as f:
        lines = f.read().splitlines()
    written = 0
    with open(os.path.join(options.run, "surfaces.pvd"), "w", encoding="utf-8") as out:
        for line in lines:
            if "<DataSet" not in line:
                out.write(line + "\n")
                continue
            name = line.split('file="')[1].split('"')[0]
            centres, columns, _ = read_vtp(os.path.join(options.run, name))
            if "semi_axes" not in columns:
                continue
            target = name.replace("bodies-", "surfaces-")
            write_vtp(os.path.join(options.run, target), *surfaces(centres, columns, options.points))
            out.write(line.replace(name, target) + "\n")
            written += 1
    if written == 0:
        raise SystemExit(f"{options.run}: no frame has superquadrics")
    print(f"{written} frames in {os.path.join(options.run, 'surfaces.pvd')}")


if __name__ == "__main__":
    main()
