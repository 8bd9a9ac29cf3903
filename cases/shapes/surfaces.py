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
from bodies import rotation, surface  # noqa: E402
from frames import read_vtp  # noqa: E402


def surfaces(centres, columns, points):
    """All superquadrics of a frame: points, triangles, columns."""
    all_points, all_triangles, owner, base = [], [], [], 0
    for k in np.flatnonzero(columns["semi_axes"][:, 0] > 0):
        x, _, triangles = surface(columns["semi_axes"][k], columns["exponents"][k], points)
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
