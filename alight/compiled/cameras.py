"""From the description of a camera to the table that its kernel reads."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from alight.cameras.model import CAMERAS
from alight.core.spec import Camera
from lanewise.view import View


def compile_camera(camera: Camera, to_world: ArrayLike, size: tuple[int, int]) -> View:
    """Table of a camera (float32), as `generate_ray` reads it from ``scene.camera``.

    Parameters
    ----------
    camera : Camera
    to_world : (4, 4) float
        Camera to world, invertible; applied to the camera as to any geometry.
    size : (int, int)
        Width and height of the full film in pixels.
    """
    table = CAMERAS[camera.type_name()].pack(camera, size, np.asarray(to_world, np.float64))
    return View(np.ascontiguousarray(table, np.float32))
