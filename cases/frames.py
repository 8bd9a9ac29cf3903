"""Frames of a run over time, whichever format it wrote: particles.pvd (.vtp files) or particles.vtkhdf.

Imported by the scripts of the cases, by the report and by the pictures. Needs numpy; h5py for VTKHDF alone. Columns have
the names of the files: id, radius, velocity, and omega, material, fixed, coordination, stress where the run wrote them.
"""
import os
import re
import xml.etree.ElementTree as ET

import numpy as np

TYPES = {"Float64": "<f8", "Int64": "<i8", "Int32": "<i4", "UInt8": "u1"}
MARK, END = b'<AppendedData encoding="raw">\n_', b"\n</AppendedData>\n</VTKFile>\n"


def appended(path):
    """(root element, function that gives an array of it as numbers) of one VTK file of Talus."""
    with open(path, "rb") as f:
        data = f.read()
    at = data.find(MARK)
    if at < 0 or not data.endswith(END):
        raise ValueError(f"{path}: cut off, or written by another program")
    root = ET.fromstring(data[:at] + b"</VTKFile>")
    blocks = at + len(MARK)

    def values(element):
        start = blocks + int(element.get("offset"))
        size = int(np.frombuffer(data, "<u8", 1, start)[0])
        kind = np.dtype(TYPES[element.get("type")])
        array = np.frombuffer(data, kind, size // kind.itemsize, start + 8)
        width = int(element.get("NumberOfComponents"))
        return array.reshape(-1, width) if width > 1 else array

    return root, values


def read_vti(path):
    """(origin, spacing, cells per axis, {name: column}) of one .vti file of Talus; cells run along x first."""
    root, values = appended(path)
    image = root.find("ImageData")
    numbers = [np.array(image.get(k).split(), float) for k in ("Origin", "Spacing", "WholeExtent")]
    columns = {e.get("Name"): values(e) for e in image.find("Piece/CellData")}
    return numbers[0], numbers[1], numbers[2][1::2].astype(int), columns


def read_vtp(path):
    """(points, {name: column}, triangles) of one .vtp file of Talus."""
    root, values = appended(path)
    piece = root.find("PolyData/Piece")
    points = values(piece.find("Points/DataArray"))
    columns = {e.get("Name"): values(e) for e in piece.find("PointData")}
    columns.update({e.get("Name"): values(e) for e in piece.find("CellData")})
    polygons = {e.get("Name"): values(e) for e in piece.find("Polys")}
    return points, columns, polygons["connectivity"].reshape(-1, 3)


class PvdFrames:
    def __init__(self, path):
        entries = ET.parse(path).getroot().iter("DataSet")
        folder = os.path.dirname(path)
        self.list = [(float(e.get("timestep")), os.path.join(folder, e.get("file"))) for e in entries]
        self.times = np.array([t for t, _ in self.list])

    def __len__(self):
        return len(self.list)

    def step(self, k):
        return int(re.search(r"-(\d+)\.\w+$", self.list[k][1]).group(1))

    def count(self, k):
        with open(self.list[k][1], "rb") as f:
            return int(re.search(rb'NumberOfPoints="(\d+)"', f.read(2000)).group(1))

    def read(self, k):
        return read_vtp(self.list[k][1])


class HdfFrames:
    def __init__(self, path):
        import h5py  # on its own: most runs write no HDF5
        self.h5py, self.path = h5py, path
        with h5py.File(path, "r") as f:
            self.size = int(f["VTKHDF/Steps"].attrs["NSteps"])
            self.times = f["VTKHDF/Steps/Values"][:self.size].astype(float)
            self.steps = f["talus/step"][:self.size] if "talus/step" in f else np.arange(self.size)
            self.counts = f["VTKHDF/NumberOfPoints"][:self.size]

    def __len__(self):
        return self.size

    def step(self, k):
        return int(self.steps[k])

    def count(self, k):
        return int(self.counts[k])

    def read(self, k):
        with self.h5py.File(self.path, "r") as f:
            root, n = f["VTKHDF"], self.count(k)
            at = int(root["Steps/PointOffsets"][k])
            points = root["Points"][at:at + n]
            columns = {}
            for name in root["PointData"]:
                start = int(root["Steps/PointDataOffsets"][name][k])
                columns[name] = root["PointData"][name][start:start + n]
            ids = int(root["Polygons/NumberOfConnectivityIds"][k]) if "Polygons" in root else 0
            start = int(root["Steps/ConnectivityIdOffsets"][k, 2]) if ids else 0
            triangles = root["Polygons/Connectivity"][start:start + ids].reshape(-1, 3) if ids else np.zeros((0, 3), int)
            return points, columns, triangles


def open_frames(folder, stem="particles"):
    """The frames of a run folder (of two formats the one that goes on longer), or None. Raises what the reader raises."""
    found = []
    for name, kind in ((stem + ".pvd", PvdFrames), (stem + ".vtkhdf", HdfFrames)):
        path = os.path.join(folder, name)
        if os.path.exists(path):
            found.append(kind(path))
    return max(found, key=lambda f: f.times[-1] if len(f) else -1.0) if found else None


def whole_frames(folder):
    """(time [s], positions [n, 3], columns by name) of every particle frame of a run."""
    source = open_frames(folder)
    if source is None:
        raise SystemExit(f"{folder} holds no particle frames: run the scene first, with output.particles_every > 0")
    for k in range(len(source)):
        points, columns, _ = source.read(k)
        yield float(source.times[k]), points.astype(float), columns


def frames(folder):
    """(time [s], positions [n, 3], radii [n]) of every particle frame of a run."""
    for time, points, columns in whole_frames(folder):
        yield time, points, columns["radius"].astype(float)
