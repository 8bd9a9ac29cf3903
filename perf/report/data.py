"""What the folder of a run offers; missing and damaged parts are named, not fatal."""
import csv
import json
import os
import re
import tomllib

import numpy as np

from draw import bodies_at, wall_frames
from frames import open_frames


class Run:
    """Everything the folder offers; missing parts are None and named in `notes`."""

    def __init__(self, folder, with_frames=True):
        self.folder, self.notes = folder, []
        self.summary = self._part("summary.json", read_summary) or {}
        self.scene = self._part("scene.toml", lambda p: open(p, encoding="utf-8", errors="replace").read())
        self.series = self._part("series.csv", read_series)
        self.frames = self._frames("particles", read_frames) if with_frames else None
        for frame in self.frames or []:
            frame["bodies"] = self._part("bodies.pvd", lambda _, at=frame["time"]: bodies_at(folder, at), wanted=False)
        self.walls = self._frames("walls", wall_frames, wanted=False) if with_frames else None
        self.keys = scene_keys(self.scene)

    def _part(self, name, reader, wanted=True):
        path = os.path.join(self.folder, name)
        if not os.path.exists(path):
            if wanted:
                self.notes.append(f"{name} is missing")
            return None
        try:
            return reader(path)
        except Exception as error:  # a report of the rest is worth more than none
            self.notes.append(f"{name} cannot be read: {error}")
            return None

    def _frames(self, stem, reader, wanted=True):
        try:
            source = open_frames(self.folder, stem)
            if source is None:
                if wanted:
                    self.notes.append(f"there are no {stem} over time")
                return None
            return reader(source)
        except Exception as error:
            self.notes.append(f"{stem} over time cannot be read: {error}")
            return None

    def title(self):
        return self.summary.get("title") or self.keys.get("title") or os.path.basename(os.path.abspath(self.folder))

    def materials(self):
        """Names in the order of the scene."""
        sections = self.keys.get("material")
        sections = sections if isinstance(sections, list) else [sections]
        return [str(m.get("name", "")) for m in sections if isinstance(m, dict)]


def read_summary(path):
    with open(path, encoding="utf-8") as f:
        summary = json.load(f)
    if not isinstance(summary, dict):
        raise ValueError("it is no JSON object")
    return summary


def scene_keys(text):
    """The scene as nested tables, with what --set replaced (the lines "#: set KEY=VALUE" at its end); {} where it is
    missing or damaged (the run that wrote it has read it)."""
    try:
        keys = tomllib.loads(text or "")
    except tomllib.TOMLDecodeError:
        return {}
    for path, value in re.findall(r"^#: set ([^=\s]+)=(.*)$", text or "", flags=re.M):
        replace(keys, path.split("."), value)
    return keys


def replace(table, path, text):
    """Puts a value at a path such as source.0.size.diameter; a path that leads nowhere is left out."""
    try:
        value = tomllib.loads("v = " + text)["v"]
    except tomllib.TOMLDecodeError:
        value = text  # a word without quotes
    for name in path[:-1]:
        if isinstance(table, list):
            if not name.isdigit() or int(name) >= len(table):
                return
            table = table[int(name)]
        else:
            table = table.setdefault(name, {})
        if not isinstance(table, (dict, list)):
            return
    if isinstance(table, dict):
        table[path[-1]] = value


def read_series(path):
    with open(path, newline="", encoding="utf-8") as f:
        rows = list(csv.reader(f))
    header, body = rows[0], [r for r in rows[1:] if len(r) == len(rows[0])]
    if not body:
        raise ValueError("it has no rows")
    values = np.array(body, dtype=float)
    return {name: values[:, k] for k, name in enumerate(header)}


def read_frames(source):
    """First, middle and last frame with particles."""
    filled = [k for k in range(len(source)) if source.count(k) > 0]
    if not filled:
        raise ValueError("no frame has particles")
    frames = []
    for k in sorted({filled[0], filled[len(filled) // 2], filled[-1]}):
        points, columns, _ = source.read(k)
        frames.append({
            "index": k, "of": len(source), "time": float(source.times[k]), "step": source.step(k), "x": points,
            "r": columns["radius"], "v": columns["velocity"], "speed": np.linalg.norm(columns["velocity"], axis=1),
            "columns": columns,
        })
    return frames


def scalars_of(frame):
    """(name, unit, values) by which grains can be coloured, speed and size first; the others as the frames have them."""
    found = [("speed", "m/s", frame["speed"]), ("diameter", "m", 2 * frame["r"])]
    units = {"temperature": "K", "coordination": ""}
    for name, values in sorted(frame["columns"].items()):
        if name in ("id", "radius", "diameter", "velocity", "fixed", "material") or values.ndim != 1:
            continue
        found.append((name, units.get(name, ""), values))
    return found
