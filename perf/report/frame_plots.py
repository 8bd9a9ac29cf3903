"""What frames show: pictures, size distribution, profiles over height."""
import numpy as np

from draw import COLOUR_NAMES, COLOURS, MATERIALS, draw, view_of, walls_at

from .data import scalars_of
from .plots import colour_bar, line_plot, png
from .style import grouped, plt


def pictures_of(run):
    """(three times by speed as [(image, caption)], their colour scale, the last frame by all else that differs between
    grains as [(image, caption, colour scale)])."""
    frames = run.frames
    walls = [walls_at(run.walls, f["time"]) for f in frames]
    camera, view = view_of(frames, walls)
    aspect = (view[3] - view[2]) / (view[1] - view[0])
    width = int(np.clip(np.sqrt(400_000 / aspect), 360, 1100))

    def shot(frame, wall, colours):
        return png(draw(frame, wall, camera, view, width, colours))

    names = {1: ["Only frame"], 2: ["First frame", "Last frame"], 3: ["First frame", "Middle frame", "Last frame"]}
    top_speed = max(np.percentile(f["speed"], 99.5) for f in frames)
    norm = plt.Normalize(0, top_speed if top_speed > 0 else 1)
    row = [(shot(f, wall, COLOURS(norm(f["speed"]))),
            f"{name}: t = {f['time']:.4g} s, step {grouped(f['step'])}, {grouped(len(f['r']))} particles")
           for f, wall, name in zip(frames, walls, names[len(frames)])]
    last, others = frames[-1], []
    for name, unit, values in scalars_of(last)[1:]:
        low, high = float(np.min(values)), float(np.max(values))
        if not high - low > 1e-3 * max(abs(low), abs(high)):
            continue
        scale = plt.Normalize(low, high)
        others.append((shot(last, walls[-1], COLOURS(scale(values))), f"Last frame by {'size' if name == 'diameter' else name}",
                       colour_bar(scale, COLOURS, f"{name} [{unit}]" if unit else name, "neither")))
    material = last["columns"].get("material")
    if material is not None and len(np.unique(material)) > 1:
        given = run.materials()
        legend = ", ".join(f"{COLOUR_NAMES[m % len(COLOUR_NAMES)]}: {given[m] if m < len(given) and given[m] else m}"
                           for m in np.unique(material).tolist())
        others.append((shot(last, walls[-1], MATERIALS[material.astype(int) % len(MATERIALS)]), f"Last frame by material ({legend})", ""))
    return row, colour_bar(norm, COLOURS, "speed [m/s]", "max"), others


def size_plot(frame):
    """Cumulative distribution of sizes in the frame; None where all grains are alike."""
    d = np.sort(2 * np.asarray(frame["r"], float))
    if not d[-1] > 1.001 * d[0]:
        return None
    sizes, counts = np.unique(d, return_counts=True)
    number = np.cumsum(counts) / len(d)
    mass = np.cumsum(counts * sizes ** 3)

    def stairs(share):
        return np.repeat(np.concatenate([[0], share]), 2)[1:-1]

    return line_plot(np.repeat(sizes, 2), [("of the volume", stairs(mass / mass[-1])), ("of the number", stairs(number))],
                     "Size distribution, last frame", "diameter [m]", "share that is not larger", zero=True)


def up_axis(keys):
    """The axis that gravity follows most; z without gravity."""
    g = keys.get("gravity")
    if not isinstance(g, list) or len(g) != 3 or not any(g):
        return 2
    return int(np.argmax(np.abs(g)))


def layer_volumes(z, r, edges):
    """Volume of spheres in every layer, exactly: differences of the caps below its edges [m³]."""
    below = np.zeros(len(edges))
    for k, edge in enumerate(edges):
        h = np.clip(edge - (z - r), 0, 2 * r)  # height of the cap below the edge
        below[k] = np.sum(np.pi * h * h * (r - h / 3))
    return np.diff(below)


def profile_plots(run):
    """Solid fraction and velocity over height in the last frame. The solid fraction is that of the domain's whole cross-section."""
    frame, axis = run.frames[-1], up_axis(run.keys)
    x, r, v = (np.asarray(frame[k], float) for k in ("x", "r", "v"))
    z = x[:, axis]
    low, high = np.min(z - r), np.max(z + r)
    layers = int(np.clip((high - low) / (2 * np.max(r)), 0, 60))
    if layers < 4:
        return []
    edges = np.linspace(low, high, layers + 1)
    middle = (edges[1:] + edges[:-1]) / 2
    label = f"height {'xyz'[axis]} [m]"
    plots = []
    domain = run.keys.get("domain") or {}
    try:
        size = np.array(domain["upper"], float) - np.array(domain["lower"], float)
        area = np.prod(np.delete(size, axis))
    except (KeyError, TypeError, ValueError):
        area = 0
    if area > 0:
        plots.append(line_plot(middle, [("solid fraction", layer_volumes(z, r, edges) / (area * np.diff(edges)))],
                               "Solid fraction of the domain's cross-section, last frame", label, "solid fraction", zero=True))
    layer = np.clip(np.digitize(z, edges) - 1, 0, layers - 1)
    mass = np.bincount(layer, r ** 3, layers)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = [np.bincount(layer, r ** 3 * c, layers) / mass for c in (np.asarray(frame["speed"], float), *v.T)]
    plots.append(line_plot(middle, list(zip(["speed", "velocity x", "velocity y", "velocity z"], mean)),
                           "Mean speed and velocity over height, last frame", label, "[m/s]"))
    return [p for p in plots if p]
