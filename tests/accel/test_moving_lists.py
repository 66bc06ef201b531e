"""The list of what moves: each mesh has its own corners there, however often it is placed."""

import numpy as np

from alight.accel.accelerator import build_accelerator
from alight.accel.layout import TRIANGLES
from alight.accel.moving import MOVING_ROW
from alight.accel.primitives import Moving


def test_rows_of_moving_meshes_point_at_their_own_triangles():
    rng = np.random.default_rng(3)
    sizes, placed = (2, 5, 3), (1, 0, 2, 1)
    geometries = [
        (rng.random((n + 2, 3), np.float32), rng.integers(0, n + 2, (n, 3)).astype(np.int32))
        for n in sizes
    ]
    moving = [Moving(TRIANGLES, 7 + k, row, k, [0] * 3, [1] * 3) for k, row in enumerate(placed)]
    made = build_accelerator(geometries=geometries, moving=moving, structure="list")[0]
    rows = np.asarray(made.moving.array).reshape(-1, MOVING_ROW)
    # One number more, as the last corner is read as four.
    corners = np.asarray(made.moving_corners.array)[:-1].reshape(-1, 3, 3)
    assert len(corners) == sum(sizes) and len(rows) == len(placed)
    for (_, shape, motion, first, count), number, row in zip(rows, range(4), placed, strict=True):
        vertices, faces = geometries[row]
        assert (shape, motion) == (7 + number, number)
        np.testing.assert_array_equal(corners[first : first + count], vertices[faces])
