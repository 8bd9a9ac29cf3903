"""A run in ParaView 5.10 or newer: grains coloured by speed, each wall under its own name. Superquadrics have their surfaces
(surfaces.pvd, made where it is missing or old), all other grains are spheres.

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

# ParaView may run this text without a file name of its own.
HERE = os.path.dirname(os.path.abspath(globals().get("__file__", "cases/view.py")))

# Rows of bodies that have a surface get no sphere.
WITHOUT_SURFACE = """
import numpy as np
grains, bodies = inputs[0].PointData, inputs[1].PointData
flat = bodies["id"][bodies["semi_axes"][:, 0] > 0] if "semi_axes" in bodies.keys() else np.zeros(0)
output.PointData.append(1.0 * np.isin(grains["body"], flat), "has_surface")
"""


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


def surfaces_of(folder):
    """The surfaces of superquadrics in the pipeline; None where there are none."""
    bodies, path = (os.path.join(folder, name) for name in ("bodies.pvd", "surfaces.pvd"))
    if not os.path.exists(bodies):
        return None
    if not os.path.exists(path) or os.path.getmtime(path) < os.path.getmtime(bodies):
        sys.path[:0] = [os.path.join(HERE, "shapes")]
        import surfaces
        if surfaces.make(folder) == 0:
            return None
    found = simple.OpenDataFile(path)
    simple.RenameSource("superquadrics", found)
    return found


def spheres_beside(surfaces, folder, grains):
    """The rows of grains that have no surface."""
    if surfaces is None:
        return grains
    bodies = simple.OpenDataFile(file_of(folder, "bodies"))
    marked = simple.ProgrammableFilter(Input=[grains, bodies], Script=WITHOUT_SURFACE, CopyArrays=1)
    return simple.Threshold(Input=marked, Scalars=["POINTS", "has_surface"], LowerThreshold=0, UpperThreshold=0)


def load(folder):
    """(spheres, surfaces or None, {wall name: piece}) in the pipeline."""
    path = file_of(folder, "particles")
    if path is None:
        raise SystemExit(f"error: {folder}: no particle frames (run with output.particles_every > 0)")
    grains = simple.OpenDataFile(path)
    simple.RenameSource("grains", grains)
    surfaces = surfaces_of(folder)
    spheres = simple.Glyph(Input=spheres_beside(surfaces, folder, grains), GlyphType="Sphere")
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
    return spheres, surfaces, walls


def show(spheres, surfaces, walls, view):
    # The last frame first: colours and camera fit what is seen, and in the first frame often nothing moves.
    animation = simple.GetAnimationScene()
    animation.UpdateAnimationUsingDataTimeSteps()
    animation.GoToLast()
    for grains in filter(None, (spheres, surfaces)):
        grains.UpdatePipeline(animation.AnimationTime)
        if grains.GetDataInformation().GetNumberOfPoints() == 0:
            continue
        display = simple.Show(grains, view)
        simple.ColorBy(display, ("POINTS", "velocity", "Magnitude"))
        display.RescaleTransferFunctionToDataRange(True)
        display.SetScalarBarVisibility(view, True)
    colours = simple.GetColorTransferFunction("velocity")
    colours.ApplyPreset("Viridis (matplotlib)", True)
    bar = simple.GetScalarBar(colours, view)
    bar.Title, bar.ComponentTitle = "speed [m/s]", ""
    bar.TitleFontSize = bar.LabelFontSize = 14
    bar.Orientation, bar.WindowLocation = "Horizontal", "Lower Center"
    bar.TitleColor = bar.LabelColor = [0, 0, 0]
    for piece in walls.values():
        d = simple.Show(piece, view)
        d.Opacity = 0.15
        d.ColorArrayName = ["POINTS", ""]  # one colour; ColorBy(d, None) fails in 5.11 where there were no colours yet
        d.DiffuseColor = [0.5, 0.5, 0.5]
    view.UseColorPaletteForBackground = 0
    view.Background = [1, 1, 1]
    view.CameraViewUp, view.CameraPosition = [0, 0, 1], [0.6, -2, 0.5]
    view.CameraFocalPoint = [0, 0, 0]
    simple.ResetCamera(view)


def points_of(source, times):
    if source is None:
        return 0
    source.UpdatePipeline(times[-1])
    return source.GetDataInformation().GetNumberOfPoints()


def main():
    given = [a for a in sys.argv[1:] if os.path.isdir(a)]
    folder = given[0] if given else os.environ.get("TALUS_RUN", ".")
    spheres, surfaces, walls = load(folder)
    if "--check" in sys.argv:
        times = list(simple.FindSource("grains").TimestepValues)
        print(f"{len(times)} frames, {points_of(spheres.Input, times)} spheres and {points_of(surfaces, times)} points of surfaces "
              f"in the last, walls: {', '.join(walls) or 'none'}")
        return
    view = simple.GetActiveViewOrCreate("RenderView")
    pictures = [a for a in sys.argv[1:] if a.endswith(".png")]
    if pictures:
        view.ViewSize = [1000, 800]
    show(spheres, surfaces, walls, view)
    if pictures:
        simple.SaveScreenshot(pictures[0], view, ImageResolution=[1000, 800])


if __name__ in ("__main__", "__vtkconsole__"):
    main()
