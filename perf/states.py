#!/usr/bin/env python3
"""States of the benchmark scenes: reads the two committed beds, tiles them, generates the others.

Who calls it: peers.py and scaling.py; by hand `python3 perf/states.py [NAME ...]` writes build/states/NAME.csv.gz, where
the scenes of perf/scenes look for them. Invariant: every code reads numbers from the same text, so all start from
the same state. States are arrays with the columns x y z r vx vy vz wx wy wz fixed (reduced units: g = 1, and the
smallest diameter is 1).
"""
import gzip
import json
import os
import re
import shutil
import subprocess
import sys

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
FOLDER = os.path.join(os.path.dirname(HERE), "build", "states")
TALUS = os.environ.get("TALUS", os.path.join(os.path.dirname(HERE), "build", "talus"))
HEADER = "x,y,z,r,vx,vy,vz,wx,wy,wz,fixed"
BED_BOX = ([0.0, 0.0, 0.0], [40.0, 20.0, 45.0])

# Silo of the hopper scene: cylinder on a cone with the outlet open, and the box around it.
HOPPER = {"radius": 20.0, "top": 110.0, "cone_length": 16.0, "outlet": 6.0}


def committed(name):
    with gzip.open(os.path.join(HERE, "states", name + ".csv.gz"), "rt") as f:
        if f.readline().strip() != HEADER:
            raise SystemExit(f"states/{name}.csv.gz: the header is not '{HEADER}'")
        return np.loadtxt(f, delimiter=",")


def tiled(name, nx, ny):
    """nx x ny copies of a bed that is periodic in x and y."""
    bed = committed(name)
    copies = []
    for i in range(nx):
        for j in range(ny):
            copy = bed.copy()
            copy[:, 0] += i * BED_BOX[1][0]
            copy[:, 1] += j * BED_BOX[1][1]
            copies.append(copy)
    box = (BED_BOX[0], [nx * BED_BOX[1][0], ny * BED_BOX[1][1], BED_BOX[1][2]])
    return np.concatenate(copies), box


def gas(cells=(64, 50, 40), solid_fraction=0.1, rms=5.0, seed=1):
    """Jittered cubic lattice of equal spheres with Gaussian velocities, rms speed per axis as given."""
    rng = np.random.default_rng(seed)
    pitch = (np.pi / 6 / solid_fraction) ** (1 / 3)
    sites = np.stack(np.meshgrid(*[np.arange(c) for c in cells], indexing="ij"), -1).reshape(-1, 3)
    state = np.zeros((len(sites), 11))
    # within the jitter no two spheres can touch
    state[:, :3] = (sites + 0.5) * pitch + rng.uniform(-1, 1, sites.shape) * 0.499 * (pitch - 1)
    state[:, 3] = 0.5
    v = rng.normal(0, rms, sites.shape)
    state[:, 4:7] = v - v.mean(0)
    return state, ([0.0] * 3, [c * pitch for c in cells])


def close_pairs(x, box, r, gap):
    """All pairs of a periodic box with centre distance < r_i + r_j + gap."""
    edge = 2 * r.max() + gap
    cells = np.floor(box / edge).astype(int)
    if cells.min() < 3:
        raise SystemExit("the periodic box is too small for this radius ratio")
    c = np.minimum((x / box * cells).astype(int), cells - 1)
    key = (c[:, 2] * cells[1] + c[:, 1]) * cells[0] + c[:, 0]
    order = np.argsort(key, kind="stable")
    count = np.bincount(key, minlength=cells.prod())
    start = np.concatenate([[0], np.cumsum(count)])
    found = []
    half = [(dx, dy, dz) for dz in (-1, 0, 1) for dy in (-1, 0, 1) for dx in (-1, 0, 1) if (dz, dy, dx) >= (0, 0, 0)]
    for step in half:
        n = (c + step) % cells
        other = (n[:, 2] * cells[1] + n[:, 1]) * cells[0] + n[:, 0]
        for k in range(count.max()):
            i = np.nonzero(count[other] > k)[0]
            j = order[start[other[i]] + k]
            if step == (0, 0, 0):
                i, j = i[i < j], j[i < j]
            d = x[i] - x[j]
            d -= np.rint(d / box) * box
            near = (d * d).sum(1) < (r[i] + r[j] + gap) ** 2
            found.append(np.stack([i[near], j[near]]))
    return np.concatenate(found, 1)


def dense_pack(n, ratio, solid_fraction, sweeps=400, seed=1):
    """Random dense pack in a periodic box, radii uniform between 0.5 and 0.5 ratio: random points, overlaps pushed
    apart until the pack carries itself. At a jammed fraction small overlaps remain: they are the contacts."""
    rng = np.random.default_rng(seed)
    r = rng.uniform(0.5, 0.5 * ratio, n)
    side = (4 / 3 * np.pi * (r**3).sum() / solid_fraction) ** (1 / 3)
    box = np.full(3, side)
    x = rng.uniform(0, side, (n, 3))
    gap = 0.3
    pairs = close_pairs(x, box, r, gap)
    origin = x.copy()
    for sweep in range(sweeps):
        moved = x - origin
        moved -= np.rint(moved / box) * box
        if (moved * moved).sum(1).max() > (0.5 * gap) ** 2:
            pairs, origin = close_pairs(x, box, r, gap), x.copy()
        i, j = pairs
        d = x[i] - x[j]
        d -= np.rint(d / box) * box
        length = np.sqrt((d * d).sum(1))
        overlap = r[i] + r[j] - length
        touch = overlap > 0
        i, j, d, length, overlap = i[touch], j[touch], d[touch], length[touch], overlap[touch]
        # the smaller sphere gives way more (masses as r^3 would leave the large ones stuck)
        push = d * (0.7 * overlap / length)[:, None]
        share = (r[j] / (r[i] + r[j]))[:, None]
        shift = np.zeros_like(x)
        for a in range(3):
            shift[:, a] += np.bincount(i, (push * share)[:, a], n)
            shift[:, a] -= np.bincount(j, (push * (1 - share))[:, a], n)
        limit = 0.25 * r / np.maximum(np.sqrt((shift * shift).sum(1)), 1e-300)
        x = (x + shift * np.minimum(1, limit)[:, None]) % side
        if overlap.size == 0 or overlap.max() < 1e-4:
            break
    state = np.zeros((n, 11))
    state[:, :3], state[:, 3] = x, r
    state[:, 4:7] = rng.normal(0, 0.05, (n, 3))
    return state, ([0.0] * 3, [float(side)] * 3)


def read_vtp(path):
    """Columns of a .vtp file as Talus writes it (raw appended blocks with a 64 bit length)."""
    with open(path, "rb") as f:
        raw = f.read()
    at = raw.index(b"_", raw.index(b"<AppendedData")) + 1
    kinds = {"Float64": "<f8", "Int64": "<i8", "Int32": "<i4", "UInt8": "u1"}
    columns = {}
    arrays = rb'<DataArray type="(\w+)" Name="([^"]+)" NumberOfComponents="(\d+)" format="appended" offset="(\d+)"'
    for kind, name, components, offset in re.findall(arrays, raw[:at]):
        begin = at + int(offset)
        size = int.from_bytes(raw[begin:begin + 8], "little")
        values = np.frombuffer(raw[begin + 8:begin + 8 + size], kinds[kind.decode()])
        columns.setdefault(name.decode(), values.reshape(-1, int(components)) if components != b"1" else values)
    return columns


def relaxed(name, state, box, steps, settings=()):
    """The state after `steps` steps of Talus with the physics of perf/scenes/NAME.toml."""
    folder = os.path.join(FOLDER, name + ".run")
    start = os.path.join(FOLDER, name + ".start.csv.gz")
    write_csv(start, state)
    command = [TALUS, "run", os.path.join(HERE, "scenes", name + ".toml"), "--steps", str(steps), "--quiet", "--overwrite",
               "--out", folder]
    settings = list(settings) + [f"source.0.file={start}", f"output.particles_every={steps * 1e-4:.17g}", "output.vtp=true",
                                 "output.vtkhdf=false"]
    for key, corner in (("lower", box[0]), ("upper", box[1])):
        settings.append(f"domain.{key}=[{', '.join('%.17g' % v for v in corner)}]")
    for item in settings:
        command += ["--set", item]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(command)}\n{done.stdout}")
    frames = sorted(f for f in os.listdir(os.path.join(folder, "vtp")) if re.fullmatch(r"particles-0*%d\.vtp" % steps, f))
    if len(frames) != 1:
        raise SystemExit(f"{folder}/vtp: no frame of step {steps}")
    columns = read_vtp(os.path.join(folder, "vtp", frames[0]))
    with open(os.path.join(folder, "summary.json")) as f:
        summary = json.load(f)
    print(f"{name}: {summary['particles']} particles, {2 * summary['contacts'] / summary['particles']:.2f} contacts per "
          f"particle, kinetic energy {summary['kinetic_energy']:.4g} after {steps} steps", file=sys.stderr)
    order = np.argsort(columns["id"])
    out = np.zeros((len(order), 11))
    out[:, :3] = columns["Points" if "Points" in columns else "points"]
    out[:, 3] = columns["radius"]
    out[:, 4:7] = columns["velocity"]
    out[:, 7:10] = columns["omega"]
    if "fixed" in columns:
        out[:, 10] = columns["fixed"]
    shutil.rmtree(folder)
    os.remove(start)
    return out[order], box


def radii5():
    """A pack of 12.5k spheres tiled 2 x 2 x 2 on a fixed bottom layer, settled under gravity."""
    pack, box = dense_pack(12500, ratio=5, solid_fraction=0.62, sweeps=500)
    side = box[1][0]
    copies = []
    for k in range(8):
        copy = pack.copy()
        copy[:, :3] += side * np.array([k & 1, (k >> 1) & 1, (k >> 2) & 1])
        copies.append(copy)
    state = np.concatenate(copies)
    state[:, 10] = state[:, 2] < 2.5
    state[state[:, 10] == 1, 4:7] = 0
    # the pack is still tight: drag takes what the overlaps set free
    return relaxed("radii5", state, ([0.0] * 3, [2 * side, 2 * side, 2 * side + 20]), 5000, ["damping.viscous=20"])


def radii20():
    """The settled bed tiled 3 x 3 with a layer of spheres of 20 smallest radii in it, one per 10^4 small grains; the small
    ones that were in their place are left out."""
    bed, box = tiled("settle32", 3, 3)
    period = np.array(box[1][:2])
    radius = 20 * bed[:, 3].min()
    base = bed[:, 10] == 1
    bottom = (bed[base, 2] + bed[base, 3]).max() if base.any() else bed[:, 2].min()
    columns, rows = (int(round(p / (2 * radius))) for p in period)
    pitch = period / [columns, rows]
    coarse = np.zeros((columns * rows, 11))
    for k in range(len(coarse)):
        coarse[k, :2] = (np.array([k % columns, k // columns]) + 0.5) * pitch
    coarse[:, 2], coarse[:, 3] = bottom + radius, min(radius, 0.5 * pitch.min())
    keep = np.ones(len(bed), bool)
    for c in coarse:
        d = bed[:, :3] - c[:3]
        d[:, :2] -= np.rint(d[:, :2] / period) * period
        keep &= base | ((d * d).sum(1) > (c[3] + bed[:, 3]) ** 2)
    return relaxed("radii20", np.concatenate([bed[keep], coarse]), box, 50000, ["damping.viscous=2"])


def hopper(n=125000):
    """Slabs of the settled bed stacked in the silo, outlet open; 40000 steps later the seams have closed and the
    hopper discharges steadily."""
    bed, box = tiled("settle32", 2, 3)
    x = bed[:, :3] - [box[1][0] / 2, box[1][1] / 2, 0]
    low, high = 2.0, 30.0
    slab = x[(x[:, 2] >= low) & (x[:, 2] < high)] - [0, 0, low]
    slabs = []
    bottom = -HOPPER["cone_length"]
    while bottom + 0.1 * (high - low) < HOPPER["top"]:
        slabs.append(slab + [0, 0, bottom])
        bottom += high - low + 1.0  # no grain of one slab can touch a grain of the other
    x = np.concatenate(slabs)
    radius = np.hypot(x[:, 0], x[:, 1])
    slope = (HOPPER["radius"] - HOPPER["outlet"]) / HOPPER["cone_length"]
    wall = np.minimum(HOPPER["radius"], HOPPER["radius"] + slope * x[:, 2])
    # distance to the inclined wall is (wall - radius) cos(angle)
    inside = (wall - radius) / np.where(x[:, 2] < 0, np.hypot(1, slope), 1) > 0.5
    x = x[inside]
    x = x[np.argsort(x[:, 2], kind="stable")][:n]
    if len(x) < n or x[-1, 2] > HOPPER["top"] - 1:
        raise SystemExit(f"the silo holds only {len(x)} grains")
    state = np.zeros((n, 11))
    state[:, :3], state[:, 3] = x, 0.5
    state, (lower, upper) = relaxed("hopper125", state, ([-25.0, -25.0, -30.0], [25.0, 25.0, HOPPER["top"]]), 40000)
    # room below, so that no grain leaves the box while the codes are timed
    return state, ([lower[0], lower[1], -40.0], upper)


def cone_stl(path, segments=128):
    """The cone of the silo as triangles, for codes that have none. Around the cone, not inside it: facets that cut into the
    resting grains would set them in motion (64 inscribed segments gave 66 % more kinetic energy after 500 steps)."""
    t = np.arange(segments) * 2 * np.pi / segments
    around = 1 / np.cos(np.pi / segments)
    z, r = [0.0, -HOPPER["cone_length"]], [HOPPER["radius"] * around, HOPPER["outlet"] * around]
    ring = [np.stack([q * np.cos(t), q * np.sin(t), np.full(segments, h)], 1) for q, h in zip(r, z)]
    with open(path, "w") as f:
        f.write("solid cone\n")
        for k in range(segments):
            m = (k + 1) % segments
            for tri in ((ring[0][k], ring[1][k], ring[1][m]), (ring[0][k], ring[1][m], ring[0][m])):
                n = np.cross(tri[1] - tri[0], tri[2] - tri[0])
                n /= np.linalg.norm(n)
                f.write(f"facet normal {n[0]:.9g} {n[1]:.9g} {n[2]:.9g}\nouter loop\n")
                for p in tri:
                    f.write(f"vertex {p[0]:.9g} {p[1]:.9g} {p[2]:.9g}\n")
                f.write("endloop\nendfacet\n")
        f.write("endsolid cone\n")


# name -> (state, box); a scene of the same name is in perf/scenes
STATES = {
    "settle32": lambda: tiled("settle32", 1, 1),
    "settle128": lambda: tiled("settle32", 2, 2),
    "settle512": lambda: tiled("settle32", 4, 4),
    "chute32": lambda: tiled("chute32", 1, 1),
    "flow128": lambda: tiled("chute32", 2, 2),
    "gas128": gas,
    "radii5": radii5,
    "radii20": radii20,
    "hopper125": hopper,
}


def rows(state):
    """Text of every row: 12 digits, so that a tiled coordinate keeps all digits of the file it comes from."""
    for row in state:
        yield ["%.12g" % v for v in row]


def write_csv(path, state):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with gzip.open(path + ".part", "wt", compresslevel=1) as f:
        f.write(HEADER + "\n")
        f.writelines(",".join(row) + "\n" for row in rows(state))
    os.replace(path + ".part", path)


def write_lammps_data(path, state, box, density):
    """LAMMPS and LIGGGHTS read_data, atom_style sphere: type 1 free, type 2 fixed."""
    with open(path + ".part", "w") as f:
        f.write(f"state\n\n{len(state)} atoms\n2 atom types\n\n")
        for k, a in enumerate("xyz"):
            f.write(f"{box[0][k]:.12g} {box[1][k]:.12g} {a}lo {a}hi\n")
        text = list(rows(state))
        diameter = ["%.12g" % (2 * r) for r in state[:, 3]]
        f.write("\nAtoms\n\n")
        for i, t in enumerate(text):
            f.write(f"{i + 1} {1 + int(t[10])} {diameter[i]} {density:.12g} {t[0]} {t[1]} {t[2]}\n")
        f.write("\nVelocities\n\n")
        for i, t in enumerate(text):
            f.write(f"{i + 1} {' '.join(t[4:10])}\n")
    os.replace(path + ".part", path)


def csv_path(name):
    """The state as a CSV file, made if it is not there yet."""
    path = os.path.join(FOLDER, name + ".csv.gz")
    if not os.path.exists(path):
        state, box = STATES[name]()
        write_csv(path, state)
        np.save(os.path.join(FOLDER, name + ".box.npy"), np.array(box))
    return path


def load(name):
    """(state, box) from the CSV file, so that every code gets the numbers that Talus reads."""
    path = csv_path(name)
    with gzip.open(path, "rt") as f:
        f.readline()
        state = np.loadtxt(f, delimiter=",")
    box = np.load(os.path.join(FOLDER, name + ".box.npy"))
    return state, (box[0].tolist(), box[1].tolist())


if __name__ == "__main__":
    for name in sys.argv[1:] or STATES:
        if name not in STATES:
            raise SystemExit(f"unknown state '{name}'; there are {', '.join(STATES)}")
        print(csv_path(name))
