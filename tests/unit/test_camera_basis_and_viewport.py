"""The camera's basis (u, v, w) and the viewport that the film covers, by hand."""

import numpy as np
import pytest

from alight.cameras.pinhole import Pinhole
from alight.cameras.rays import project, unproject
from alight.scene.transform import look_at

# Looking along world -x with +z up, image right is world +y.
MATRIX = look_at((5.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)).matrix
U, V, W = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])


def test_camera_basis():
    """W points backwards, u to the right, v up; right-handed and of unit length."""
    np.testing.assert_allclose(MATRIX[:3, :3], np.stack([U, V, W], -1), atol=1e-15)
    np.testing.assert_allclose(np.cross(MATRIX[:3, 0], MATRIX[:3, 1]), MATRIX[:3, 2], atol=1e-15)
    np.testing.assert_allclose(MATRIX[:3, 3], [5.0, 0.0, 0.0])


@pytest.mark.parametrize(
    ("raster", "x", "y"),
    [
        ((0.0, 0.0), -1.0, 1.0),
        ((200.0, 0.0), 1.0, 1.0),
        ((0.0, 100.0), -1.0, -1.0),
        ((200.0, 100.0), 1.0, -1.0),
        ((100.0, 50.0), 0.0, 0.0),
        ((150.0, 75.0), 0.5, -0.5),
    ],
)
def test_camera_viewport(raster, x, y):
    """Film coordinates start at the upper left corner; the vertical field of view is 60 degrees.

    At depth 3 half the viewport is 3 tan 30 degrees high and twice that wide.
    """
    camera, half_height = Pinhole(fov=60.0, fov_axis="y"), 3.0 * np.tan(np.radians(30.0))
    point = MATRIX[:3, 3] + 2.0 * x * half_height * U + y * half_height * V - 3.0 * W
    seen = project(camera, MATRIX, (200, 100), point)
    np.testing.assert_allclose(seen, [*raster, 3.0], atol=1e-12)
    np.testing.assert_allclose(unproject(camera, MATRIX, (200, 100), seen), point, atol=1e-12)
