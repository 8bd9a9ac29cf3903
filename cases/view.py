"""A run in ParaView 5.10 or newer: grains as spheres coloured by speed, each wall under its own name.

    TALUS_RUN=results/hopper-20k paraview --script=cases/view.py
    pvpython cases/view.py RUN [PICTURE.png]

Walls can be hidden and coloured one by one in the pipeline browser. `--check` instead of a picture only loads everything
and says what is there (no screen needed).
"""
import csv
import os
import re
import sys

from paraview import simple


def wall_names(folder):
    """In the order of the walls: the series names all of them."""
    try:
        with open(os.path.join(folder, "series.csv"), newline="", encoding="utf-8") as f:
            header = next(csv.reader(f))
    except (OSError, StopIteration):
        return []
    return [m.group(1) for m in (re.fullmatch(r"wall\.(.*)\.force_x", c) for c in header) if m]


def file_of(folder, stem):
    for ending in (".pvd", ".vtkhdf"):
        path = os.path.join(folder, stem + ending)
        if os.path.exists(path):
            return path
    return None


def load(folder):
    """(spheres, {wall name: piece}) in the pipeline."""
    path = file_of(folder, "particles")
    if path is None:
        raise SystemExit(f"error: {folder}: no particle frames (run with output.particles_every > 0)")
    grains = simple.OpenDataFile(path)
    simple.RenameSource("grains", grains)
    spheres = simple.Glyph(Input=grains, GlyphType="Sphere")
    spheres.GlyphMode = "All Points"
    spheres.ScaleArray = ["POINTS", "diameter"]
    spheres.OrientationArray = ["POINTS", "No orientation array"]
    spheres.ScaleFactor = 1.0
    spheres.GlyphType.ThetaResolution = spheres.GlyphType.PhiResolution = 12
    simple.RenameSource("spheres", spheres)
    walls, path = {}, file_of(folder, "walls")
    if path is not None:
        surface = simple.OpenDataFile(path)
        simple.RenameSource("all walls", surface)
        surface.UpdatePipeline()
        last = int(surface.CellData["wall"].GetRange(0)[1]) if "wall" in surface.CellData.keys() else -1
        names = wall_names(folder)
        for k in range(last + 1):
            piece = simple.Threshold(Input=surface, Scalars=["CELLS", "wall"], LowerThreshold=k, UpperThreshold=k)
            name = names[k] if k < len(names) else f"wall {k}"
            simple.RenameSource(name, piece)
            walls[name] = piece
    return spheres, walls


def show(spheres, walls, view):
    display = simple.Show(spheres, view)
    simple.ColorBy(display, ("POINTS", "velocity", "Magnitude"))
    display.RescaleTransferFunctionToDataRange(True)
    display.SetScalarBarVisibility(view, True)
    for piece in walls.values():
        d = simple.Show(piece, view)
        d.Opacity = 0.15
        simple.ColorBy(d, None)
    view.Background = [1, 1, 1]
    simple.GetAnimationScene().UpdateAnimationUsingDataTimeSteps()
    simple.GetAnimationScene().GoToLast()
    view.ViewUp, view.CameraPosition = [0, 0, 1], [0.6, -2, 0.5]
    view.CameraFocalPoint = [0, 0, 0]
    simple.ResetCamera(view)


def main():
    folder = os.environ.get("TALUS_RUN") or (sys.argv[1] if len(sys.argv) > 1 else ".")
    spheres, walls = load(folder)
    if "--check" in sys.argv:
        times = list(simple.FindSource("grains").TimestepValues)
        simple.FindSource("grains").UpdatePipeline(times[-1])
        points = simple.FindSource("grains").GetDataInformation().GetNumberOfPoints()
        print(f"{len(times)} frames, {points} grains in the last, walls: {', '.join(walls) or 'none'}")
        return
    view = simple.GetActiveViewOrCreate("RenderView")
    show(spheres, walls, view)
    pictures = [a for a in sys.argv[1:] if a.endswith(".png")]
    if pictures:
        simple.SaveScreenshot(pictures[0], view, ImageResolution=[1000, 800])


if __name__ in ("__main__", "__vtkconsole__"):
    main()
