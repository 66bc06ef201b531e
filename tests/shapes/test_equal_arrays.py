"""Shapes of arrays are equal where all of their fields are, number by number."""

import numpy as np
import pytest

from alight.shapes.curves import Curves
from alight.shapes.mesh import Mesh

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
LINE = np.array([[0, 0, 0], [1, 0, 0], [2, 1, 0], [3, 1, 1]])
#: Of a shape: all fields, and another value of each.
FIELDS = {
    Mesh: {
        "vertices": (CORNERS, CORNERS + 1), "faces": ([[0, 1, 2]], [[0, 2, 1]]),
        "normals": (CORNERS + 1, CORNERS + 2), "uvs": (CORNERS[:, :2], CORNERS[:, 1:]),
        "more_uvs": ([CORNERS[:, :2]], [CORNERS[:, 1:]]), "colors": (0.1 * CORNERS, 0.2 * CORNERS),
        "displacement": (0.5, 0.25), "displacement_scale": (1.0, 2.0),
        "displacement_midlevel": (0.0, 0.5), "displacement_edge": (0.1, 0.2),
    },
    Curves: {
        "points": (LINE, LINE + 1), "radii": ([0.1] * 4, [0.1, 0.1, 0.1, 0.2]),
        "counts": ([4], [2, 2]), "basis": ("linear", "b_spline"),
    },
}  # fmt: skip
CASES = [(shape, name) for shape, fields in FIELDS.items() for name in fields]


@pytest.mark.parametrize(("shape", "name"), CASES, ids=[f"{s.__name__}-{n}" for s, n in CASES])
def test_shapes_differ_if_any_field_does(shape, name):
    first = {key: value for key, (value, _) in FIELDS[shape].items()}
    spec, again = (shape(**first) for _ in range(2))
    assert spec == again
    assert hash(spec) == hash(again)
    other = shape(**first | {name: FIELDS[shape][name][1]})
    assert spec != other
    assert hash(spec) != hash(other)
