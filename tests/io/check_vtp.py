"""Reads .vtp/.vti/.pvd files back with VTK and compares them with the frames of output_frames.hpp.

usage: check_vtp.py particles|walls|contacts FILE STEP COUNT | grid FILE NX NY NZ | pvd FILE STEP:COUNT ...
"""
import os
import sys
import xml.etree.ElementTree as ET

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLImageDataReader, vtkXMLPolyDataReader


def read(path, reader=vtkXMLPolyDataReader):
    r = reader()
    failed = []
    r.AddObserver("ErrorEvent", lambda *a: failed.append(a))
    r.SetFileName(path)
    assert r.CanReadFile(path), path
    r.Update()
    assert not failed, path
    return r.GetOutput()


def columns(data):
    return {data.GetArrayName(k): vtk_to_numpy(data.GetArray(k)) for k in range(data.GetNumberOfArrays())}


def check_time(out, step):
    time = out.GetFieldData().GetArray("TimeValue")
    assert time is not None and time.GetValue(0) == 0.125 * step, time


def particles(path, step, n):
    out = read(path)
    check_time(out, step)
    d = 3.0 * np.arange(n) + 1
    s, one = float(step), np.ones(n)
    assert out.GetNumberOfPoints() == n and out.GetNumberOfVerts() == n and out.GetNumberOfPolys() == 0
    if n == 0:
        return
    assert np.array_equal(vtk_to_numpy(out.GetPoints().GetData()), np.stack([0.5 * d, 0.25 * s * one, 0.125 * d + s], 1))
    expected = {
        "id": d, "velocity": np.stack([d, -s * one, 0.5 * d], 1), "radius": 0.25 + d / 64, "diameter": 0.5 + d / 32,
        "omega": np.stack([2 * d, s * one, one], 1), "material": d % 3, "fixed": d % 2, "coordination": d % 7,
        "stress": np.stack([d, d + 10, d + 20, d + 30, d + 50, d + 40 + s], 1),
    }
    got = columns(out.GetPointData())
    assert set(got) == set(expected), set(got)
    for name in expected:
        assert np.array_equal(got[name], expected[name]), name
    assert out.GetCell(n - 1).GetPointId(0) == n - 1


def walls(path, step, n):
    out = read(path)
    check_time(out, step)
    assert out.GetNumberOfPolys() == n and out.GetNumberOfPoints() == 3 * n
    assert [out.GetCell(n - 1).GetPointId(k) for k in range(3)] == [3 * n - 3, 3 * n - 2, 3 * n - 1]
    assert np.array_equal(columns(out.GetCellData())["wall"], np.zeros(n))


def contacts(path, step, n):
    out = read(path)
    d = 3.0 * np.arange(n) + 1
    got = columns(out.GetPointData())
    assert np.array_equal(got["particle_b"], -1 - d % 2) and np.array_equal(got["overlap"], d / 1024)
    assert np.array_equal(got["normal_force"][:, 2], d)


def grid(path, nx, ny, nz):
    out = read(path, vtkXMLImageDataReader)
    assert out.GetDimensions() == (nx + 1, ny + 1, nz + 1)
    assert out.GetOrigin() == (-1.0, 0.0, 0.5) and out.GetSpacing() == (0.5, 0.25, 2.0)
    value = columns(out.GetCellData())["value"]
    assert np.array_equal(value, np.arange(nx * ny * nz))


def pvd(path, frames):
    listed = [(float(e.get("timestep")), e.get("file")) for e in ET.parse(path).getroot().iter("DataSet")]
    assert len(listed) == len(frames), listed
    for (time, name), (step, n) in zip(listed, frames):
        assert time == 0.125 * step
        particles(os.path.join(os.path.dirname(path), name), step, n)


what, name, *rest = sys.argv[1:]
if what == "pvd":
    pvd(name, [tuple(map(int, a.split(":"))) for a in rest])
else:
    globals()[what](name, *map(int, rest))
