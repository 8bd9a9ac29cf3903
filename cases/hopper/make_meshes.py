#!/usr/bin/env python3
"""Write the STL meshes of the hopper cases: silo, gate and chute for a round notch (cone) or a slot (wedge).

Standard library only. Lengths in metres. The defaults are the geometry of hopper-20k.toml and hopper-20k-wedge.toml;
the larger jobs load the same files with wall.scale. Without --family both families are written.

  python3 make_meshes.py                                   # the files in meshes/
  python3 make_meshes.py --family cone --notch 0.055       # another notch diameter (slot width for a wedge)
"""

import argparse
import math
import os
import struct


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    length = math.sqrt(sum(c * c for c in a))
    return tuple(c / length for c in a) if length > 0 else (0.0, 0.0, 0.0)


def polygon(*corners):
    """Fan of a planar convex polygon."""
    return [(corners[0], corners[i], corners[i + 1]) for i in range(1, len(corners) - 1)]


def ring(radius, z, segments):
    """Corners of a regular polygon with the area of the circle, so that mesh and primitive hold the same volume."""
    turn = 2 * math.pi / segments
    r = radius * math.sqrt(turn / math.sin(turn))
    return [(r * math.cos(turn * i), r * math.sin(turn * i), z) for i in range(segments)]


def band(low, high):
    """Quads between two rings with the same number of corners, cut into triangles."""
    out = []
    for i in range(len(low)):
        j = (i + 1) % len(low)
        out += [(low[i], low[j], high[j]), (low[i], high[j], high[i])]
    return out


def cone_family(p):
    notch, n = p.notch / 2, p.segments
    junction = (p.bin / 2 - notch) * math.tan(math.radians(p.angle))
    lip, knee, top = ring(notch, 0.0, n), ring(p.bin / 2, junction, n), ring(p.bin / 2, p.top, n)
    silo = band(lip, knee) + band(knee, top)
    rim = ring(notch + p.gate_margin, 0.0, n // 2)
    gate = [((0.0, 0.0, 0.0), rim[i], rim[(i + 1) % len(rim)]) for i in range(len(rim))]
    # The chute: an upright collar below the notch, and a pipe that descends at 45 degrees. The pipe's upper end is cut
    # square, so its rim is low on the side that the gate moves to: the collar stops the grains that the gate drags along, and
    # the rim stays 5 cm away from where the jet lands, so that no grain hops over it.
    c = math.sqrt(0.5)

    def place(q, along):
        across, side = q[0], q[1]
        return (p.chute_x + c * (across + along), side, p.chute_z + c * (across - along))

    start = [place(q, 0.0) for q in ring(p.chute_radius, 0.0, n // 2)]
    end = [place(q, p.chute_length) for q in ring(p.chute_radius, 0.0, n // 2)]
    collar = band(ring(p.collar_radius, p.collar_bottom, n // 2), ring(p.collar_radius, -p.collar_gap, n // 2))
    return {"cone-silo": silo, "cone-gate": gate, "cone-chute": band(start, end) + collar}


def wedge_family(p):
    half, wide, y = p.notch / 2, p.bin / 2, p.depth / 2
    junction = (wide - half) * math.tan(math.radians(p.angle))
    silo = []
    for s in (-1, 1):
        silo += polygon((s * half, -y, 0.0), (s * half, y, 0.0), (s * wide, y, junction), (s * wide, -y, junction))
        silo += polygon((s * wide, -y, junction), (s * wide, y, junction), (s * wide, y, p.top), (s * wide, -y, p.top))
        silo += polygon((-half, s * y, 0.0), (half, s * y, 0.0), (wide, s * y, junction), (-wide, s * y, junction))
        silo += polygon((-wide, s * y, junction), (wide, s * y, junction), (wide, s * y, p.top), (-wide, s * y, p.top))
    g = half + p.gate_margin
    gate = polygon((-g, -y, 0.0), (g, -y, 0.0), (g, y, 0.0), (-g, y, 0.0))
    # The chute is a trough that descends at 45 degrees from behind the notch, with a back wall and two cheeks. The cheeks
    # stand up beside the silo and the back wall leaves less than a grain below the gate, or grains that bounce off the
    # trough hop over the rim now and then.
    x0, z0 = -half - p.chute_back, p.chute_z
    x1, z1 = x0 + p.chute_length * math.sqrt(0.5), z0 - p.chute_length * math.sqrt(0.5)
    rim = -p.gate_gap
    chute = polygon((x0, -y, z0), (x1, -y, z1), (x1, y, z1), (x0, y, z0))
    chute += polygon((x0, -y, z0), (x0, y, z0), (x0, y, rim), (x0, -y, rim))
    for s in (-1, 1):
        chute += polygon((x0, s * y, z0), (x1, s * y, z1), (x1, s * y, z1 + p.chute_cheek),
                         (-x0, s * y, p.chute_top), (x0, s * y, p.chute_top))
    return {"wedge-silo": silo, "wedge-gate": gate, "wedge-chute": chute}


def write_stl(path, name, facets):
    with open(path, "wb") as f:
        f.write(("Talus hopper: " + name).encode("ascii").ljust(80))
        f.write(struct.pack("<I", len(facets)))
        for a, b, c in facets:
            f.write(struct.pack("<12fH", *unit(cross(sub(b, a), sub(c, a))), *a, *b, *c, 0))


DEFAULTS = {
    "cone": dict(notch=0.070, bin=0.160, angle=60.0, top=0.32, gate_margin=0.002, chute_x=-0.016, chute_z=-0.084,
                 chute_length=0.28, chute_radius=0.090),
    "wedge": dict(notch=0.050, bin=0.200, angle=60.0, top=0.45, gate_margin=0.005, chute_z=-0.060, chute_length=0.28),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--family", choices=["cone", "wedge"], help="default: both")
    parser.add_argument("--out", default=os.path.join(os.path.dirname(os.path.abspath(__file__)), "meshes"))
    parser.add_argument("--notch", type=float, help="notch diameter (cone) or slot width (wedge)")
    parser.add_argument("--bin", type=float, help="bin diameter or width")
    parser.add_argument("--angle", type=float, help="slope of the narrowed section above the horizontal [degrees]")
    parser.add_argument("--top", type=float, help="height of the bin's upper rim above the notch")
    parser.add_argument("--depth", type=float, default=0.080, help="wedge: length of the slot")
    parser.add_argument("--segments", type=int, default=72, help="cone: corners of a circle")
    parser.add_argument("--gate-margin", type=float, help="how far the gate reaches past the notch")
    parser.add_argument("--gate-gap", type=float, default=0.003, help="wedge: clearance between gate and chute")
    parser.add_argument("--chute-x", type=float, help="cone: middle of the chute's upper end")
    parser.add_argument("--chute-z", type=float, help="height of the chute's upper end")
    parser.add_argument("--chute-length", type=float)
    parser.add_argument("--chute-radius", type=float, help="cone: radius of the pipe")
    parser.add_argument("--collar-radius", type=float, default=0.045, help="cone: radius of the collar")
    parser.add_argument("--collar-bottom", type=float, default=-0.085, help="cone: height of the collar's lower end")
    parser.add_argument("--collar-gap", type=float, default=0.0015, help="cone: clearance between gate and collar")
    parser.add_argument("--chute-back", type=float, default=0.035, help="wedge: back wall to the edge of the notch")
    parser.add_argument("--chute-top", type=float, default=0.050, help="wedge: height of the cheeks beside the silo")
    parser.add_argument("--chute-cheek", type=float, default=0.060, help="wedge: height of the cheeks at the lower end")
    args = parser.parse_args()
    if args.segments < 8 or args.segments % 2:
        parser.error("--segments must be even and at least 8")
    os.makedirs(args.out, exist_ok=True)
    for family in [args.family] if args.family else ["cone", "wedge"]:
        p = argparse.Namespace(**vars(args))
        for key, value in DEFAULTS[family].items():
            if getattr(p, key) is None:
                setattr(p, key, value)
        if not 0 < p.notch < p.bin:
            parser.error("the notch must be narrower than the bin")
        if p.top <= (p.bin - p.notch) / 2 * math.tan(math.radians(p.angle)):
            parser.error("--top must be above the narrowed section")
        for name, facets in (cone_family(p) if family == "cone" else wedge_family(p)).items():
            write_stl(os.path.join(args.out, name + ".stl"), name, facets)


if __name__ == "__main__":
    main()
