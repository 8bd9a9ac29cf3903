"""Checks a VTKHDF temporal PolyData file against the format and against the frames of output_frames.hpp.

usage: check_vtkhdf.py FILE particles|walls|contacts STEP:COUNT ...   (columns omega, material, ... follow from the file)
       check_vtkhdf.py FILE particles --whole                          any number of whole frames (after a kill)
Reads every frame twice: as VTK up to 9.3 addresses it and as later versions do (see core/io/vtkhdf.cpp).
"""
import sys

import h5py
import numpy as np

KINDS = ["Vertices", "Lines", "Polygons", "Strips"]


def cell_start_old(root, step, kind):
    return root["Steps/CellOffsets"][step, KINDS.index(kind)] + root["Steps/PartOffsets"][step]


def cell_start_new(root, step, kind):
    start = root["Steps/CellOffsets"][step, KINDS.index(kind)]
    parts = cells = 0
    for n in root[kind + "/NumberOfCells"][: root["Steps/PartOffsets"][step]]:
        if cells >= start:
            break
        parts += 1
        cells += n
    return start + parts


def check_header(f):
    root = f["VTKHDF"]
    kind = root.attrs.get_id("Type").get_type()
    assert kind.get_class() == h5py.h5t.STRING and not kind.is_variable_str(), "Type must be a fixed string"
    assert kind.get_size() == 8 and kind.get_cset() == h5py.h5t.CSET_ASCII, "Type must be 8 ASCII bytes"
    assert root.attrs["Type"] == b"PolyData"
    assert list(root.attrs["Version"]) == [2, 0]
    for name, width in [("Points", 3), ("Steps/CellOffsets", 4), ("Steps/ConnectivityIdOffsets", 4)]:
        assert root[name].ndim == 2 and root[name].shape[1] == width, name
    for kind in KINDS:
        for name in ["NumberOfCells", "NumberOfConnectivityIds", "Offsets", "Connectivity"]:
            assert root[kind][name].dtype == np.int64 and root[kind][name].ndim == 1, (kind, name)
    return root


def read_cells(root, step, kind, start):
    """Offsets (n + 1) and connectivity of one kind in one frame."""
    part = root["Steps/PartOffsets"][step]
    n = root[kind + "/NumberOfCells"][part]
    ids = root[kind + "/NumberOfConnectivityIds"][part]
    at = root["Steps/ConnectivityIdOffsets"][step, KINDS.index(kind)]
    offsets = root[kind + "/Offsets"][start : start + n + 1]
    connectivity = root[kind + "/Connectivity"][at : at + ids]
    assert len(offsets) == n + 1 and len(connectivity) == ids, (kind, step)
    assert offsets[0] == 0 and offsets[-1] == ids, (kind, step, offsets)
    return offsets, connectivity


def column(root, step, place, name, n):
    at = root[f"Steps/{place}Offsets/{name}"][step]
    values = root[f"{place}/{name}"][at : at + n]
    assert len(values) == n, (name, step)
    return values


def check_particles(root, step, number, points, n):
    d = 3.0 * np.arange(n) + 1
    s = float(number)
    one = np.ones(n)
    expected = {
        "id": d,
        "velocity": np.stack([d, -s * one, 0.5 * d], 1),
        "radius": 0.25 + d / 64,
        "diameter": 0.5 + d / 32,
        "omega": np.stack([2 * d, s * one, one], 1),
        "material": d % 3,
        "fixed": d % 2,
        "coordination": d % 7,
        "stress": np.stack([d, d + 10, d + 20, d + 30, d + 50, d + 40 + s], 1),  # XX YY ZZ XY YZ XZ
    }
    assert np.array_equal(points, np.stack([0.5 * d, 0.25 * s * one, 0.125 * d + s], 1))
    for name in root["PointData"]:
        assert np.array_equal(column(root, step, "PointData", name, n), expected[name]), (name, step)
    assert {"id", "velocity", "radius", "diameter"} <= set(root["PointData"])
    return n, 0


def check_walls(root, step, number, points, n):
    t = np.arange(n, dtype=float)
    s, zero = float(number) * np.ones(n), np.zeros(n)
    corners = np.stack([np.stack(c, 1) for c in [(t, s, zero), (t + 1, s, zero), (t, s, zero + 1)]], 1)
    assert np.array_equal(points, corners.reshape(-1, 3))
    assert np.array_equal(column(root, step, "CellData", "wall", n), zero)
    return 0, n


def check_contacts(root, step, number, points, n):
    d = 3.0 * np.arange(n) + 1
    assert np.array_equal(column(root, step, "PointData", "particle_a", n), d)
    assert np.array_equal(column(root, step, "PointData", "particle_b", n), -1 - d % 2)
    assert np.array_equal(column(root, step, "PointData", "normal_force", n)[:, 2], d)
    assert np.array_equal(column(root, step, "PointData", "overlap", n), d / 1024)
    return n, 0


def main():
    path, content = sys.argv[1:3]
    with h5py.File(path, "r") as f:
        root = check_header(f)
        steps = root["Steps"].attrs["NSteps"]
        numbers = f["talus/step"][:steps]
        if sys.argv[3] == "--whole":
            frames = [(s, root["NumberOfPoints"][k]) for k, s in enumerate(numbers)]
            print(steps, "whole frames")
        else:
            frames = [tuple(int(v) for v in a.split(":")) for a in sys.argv[3:]]
            # Nothing beyond the frames that count (also after a resume that dropped some).
            for name in ["Values", "PartOffsets", "NumberOfParts", "PointOffsets", "CellOffsets", "ConnectivityIdOffsets"]:
                assert len(root["Steps"][name]) == steps, name
            assert len(root["Points"]) == root["NumberOfPoints"][:].sum()
            for kind in KINDS:
                assert len(root[kind]["Connectivity"]) == root[kind]["NumberOfConnectivityIds"][:].sum(), kind
        assert steps == len(frames), (steps, frames)
        for k, (number, n) in enumerate(frames):
            assert numbers[k] == number and root["Steps/Values"][k] == 0.125 * number
            assert root["Steps/NumberOfParts"][k] == 1 and root["Steps/PartOffsets"][k] == k
            n_points = root["NumberOfPoints"][k]
            at = root["Steps/PointOffsets"][k]
            points = root["Points"][at : at + n_points]
            verts, polys = globals()["check_" + content](root, k, number, points, n)
            for cell_start in (cell_start_old, cell_start_new):
                for kind, cells, per in [("Vertices", verts, 1), ("Polygons", polys, 3), ("Lines", 0, 1), ("Strips", 0, 1)]:
                    offsets, connectivity = read_cells(root, k, kind, cell_start(root, k, kind))
                    assert np.array_equal(offsets, per * np.arange(cells + 1)), (cell_start.__name__, kind, k, offsets)
                    assert np.array_equal(connectivity, np.arange(per * cells)), (kind, k)


main()
