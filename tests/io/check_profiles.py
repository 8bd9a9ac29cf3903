"""Checks the profiles of perf/report/: layers of spheres add up to their volume, also where the edges cut through them."""
import os
import sys

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path[:0] = [os.path.join(ROOT, "perf"), os.path.join(ROOT, "cases")]
from report.data import scene_keys  # noqa: E402
from report.frame_plots import layer_volumes, size_plot  # noqa: E402
from report.plots import MAX_POINTS, thinned  # noqa: E402
from report.view import visible_first  # noqa: E402

rng = np.random.default_rng(1)
z, r = rng.uniform(0, 1, 50), rng.uniform(0.02, 0.2, 50)
volume = np.sum(4 / 3 * np.pi * r ** 3)
assert abs(layer_volumes(z, r, np.linspace(-0.2, 1.2, 30)).sum() / volume - 1) < 1e-12
# Half a sphere below its centre, 5/32 of it in the lowest quarter of its diameter.
parts = layer_volumes(np.array([0.0]), np.array([1.0]), np.array([-1, -0.5, 0, 1])) / (4 / 3 * np.pi)
assert np.allclose(parts, [5 / 32, 11 / 32, 1 / 2], atol=1e-12), parts

# Two sizes, one grain large: half of the number, 8/9 of the volume.
plot = size_plot({"r": np.array([0.5, 1.0])})
shares = {c["label"]: c["values"] for c in plot.numbers["curves"]}
assert plot.numbers["at"] == [1, 1, 2, 2] and shares["of the number"] == [0, 0.5, 0.5, 1]
assert np.allclose(shares["of the volume"], [0, 1 / 9, 1 / 9, 1], atol=1e-5)
assert size_plot({"r": np.full(5, 0.1)}) is None

# A peak of one row is still there when a series is thinned.
y = np.zeros(100_000)
y[54_321] = 1
rows = thinned(np.arange(len(y)), [y])
assert 54_321 in rows and len(rows) <= MAX_POINTS + 2 and rows[0] == 0 and rows[-1] == len(y) - 1

# A cube of 20^3 grains: of 2400 that are shown all those on its surface.
g = np.stack(np.meshgrid(*[np.arange(20.0)] * 3), -1).reshape(-1, 3)
shown = visible_first(g, np.full(len(g), 0.4), 3000)
surface = np.flatnonzero(((g == 0) | (g == 19)).any(axis=1))
assert len(shown) == 3000 and np.isin(surface, shown).all()

# What --set replaced counts, as the run's copy of the scene has it.
keys = scene_keys("[contact]\nfriction = 0.5\n[[source]]\nnumber = 3\n#: how it was run\n#: set contact.friction=0.2\n#: set source.0.number=7\n#: set contact.model=hertz_mindlin\n")
assert keys == {"contact": {"friction": 0.2, "model": "hertz_mindlin"}, "source": [{"number": 7}]}, keys
