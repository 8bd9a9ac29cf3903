#!/usr/bin/env python3
"""Surfaces of superquadrics for ParaView: python3 surfaces.py RUN [--points 24].

Reads bodies.pvd of a run and writes surfaces.pvd beside it: triangles of every superquadric, with point columns id, shape,
velocity and speed. Any version of ParaView opens it; view.py calls it by itself.
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
    data = {"id": columns["id"][owner], "shape": columns["shape"][owner], "velocity": columns["velocity"][owner],
            "speed": speed[owner]}
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
            f.write(array(name, "Int64" if values.dtype.kind == "i" else "Float32", values, values[0].size))
        f.write("</PointData>\n<Points>\n" + array("Points", "Float32", points, 3) + "</Points>\n<Polys>\n"
                + array("connectivity", "Int64", triangles)
                + array("offsets", "Int64", 3 * np.arange(1, len(triangles) + 1))
                + "</Polys>\n</Piece>\n</PolyData>\n</VTKFile>\n")


def make(run, points=24):
    """Writes surfaces.pvd of a run; returns the number of its frames. Frames without superquadrics have none."""
    with open(os.path.join(run, "bodies.pvd"), encoding="utf-8") as f:
        lines = f.read().splitlines()
    kept, written = [], 0
    for line in lines:
        if "<DataSet" in line:
            name = line.split('file="')[1].split('"')[0]
            centres, columns, _ = read_vtp(os.path.join(run, name))
            if "semi_axes" not in columns or not (columns["semi_axes"][:, 0] > 0).any():
                continue
            target = name.replace("bodies-", "surfaces-")
            write_vtp(os.path.join(run, target), *surfaces(centres, columns, points))
            line = line.replace(name, target)
            written += 1
        kept.append(line)
    if written:
        with open(os.path.join(run, "surfaces.pvd"), "w", encoding="utf-8") as out:
            out.write("\n".join(kept) + "\n")
    return written


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("run")
    parser.add_argument("--points", type=int, default=24, help="around a body")
    options = parser.parse_args()
    written = make(options.run, options.points)
    if written == 0:
        raise SystemExit(f"{options.run}: no frame has superquadrics")
    print(f"{written} frames in {os.path.join(options.run, 'surfaces.pvd')}")


if __name__ == "__main__":
    main()
