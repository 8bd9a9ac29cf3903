"""Pictures show superquadrics by small spheres inside that touch the surface: cases/bodies.py against the equation."""
import os
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "cases"))
from bodies import dressed, rotation  # noqa: E402

axes = np.array([[2.0, 1.0, 0.5], [0, 0, 0], [1.0, 1.5, 3.0]])  # the second row is a clump's
exponents = np.array([[2.0, 2.0], [0, 0], [4.0, 6.0]])
turns = np.array([[0.5, 0.5, -0.5, 0.5], [1, 0, 0, 0], [0.8, 0, 0.6, 0]])
centres = np.array([[10.0, 0, 0], [0, 0, 0], [0, 20.0, 0]])
bodies = (centres, {"id": np.array([7, 3, 5]), "semi_axes": axes, "exponents": exponents, "orientation": turns}, None)
points = np.array([[0, 20.0, 0], [0, 0, 0.1], [10.0, 0, 0]])
columns = {"id": np.array([5, 3, 7]), "radius": np.array([3.5, 0.25, 2.0])}

x, r, normal, row = dressed(points, columns, bodies, 24)
one = np.flatnonzero(row == 1)
assert len(one) == 1 and np.all(x[one[0]] == points[1]) and r[one[0]] == 0.25 and np.isnan(normal[one[0]]).all()
for k, of in ((0, 2), (2, 0)):
    mine = row == of
    assert mine.sum() == 24 * 13
    n1, n2 = exponents[k]
    turn = rotation(turns[k])
    assert np.allclose(turn @ turn.T, np.eye(3), atol=1e-12)
    at = (x[mine] + r[mine][:, None] * normal[mine] - centres[k]) @ turn / axes[k]  # in the body's own axes
    value = (np.abs(at[:, 0]) ** n2 + np.abs(at[:, 1]) ** n2) ** (n1 / n2) + np.abs(at[:, 2]) ** n1
    assert np.abs(value - 1).max() < 1e-9, np.abs(value - 1).max()
    if n1 == 2:  # an ellipsoid's gradient in closed form
        gradient = at / axes[k]
        gradient /= np.linalg.norm(gradient, axis=1)[:, None]
        assert np.abs(gradient @ turn.T - normal[mine]).max() < 1e-9

plain = dressed(points, columns, None)
assert np.all(plain[0] == points) and np.all(plain[3] == np.arange(3))
