"""From the description of a camera to the table that its kernel reads."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from alight.cameras.model import CAMERAS
from alight.core.spec import Camera
from alight.scene.flatten import PlacedCamera
from lanewise.view import View

#: Pixels of a small view.
SMALL_VIEW = 2**14


class SmallView(NamedTuple):
    """The view of a camera in another, small picture.

    Attributes
    ----------
    camera : View
        As from `compile_camera`.
    size : (int, int)
        Width and height in pixels.
    """

    camera: View
    size: tuple[int, int]


def compile_camera(
    camera: Camera, to_world: ArrayLike, size: tuple[int, int], origin: ArrayLike = (0.0, 0.0, 0.0)
) -> View:
    """Table of a camera (float32), as `generate_ray` reads it from ``scene.camera``.

    Its last three numbers are `origin`.

    Parameters
    ----------
    camera : Camera
    to_world : (4, 4) float
        Camera to rendering space, invertible; applied to the camera as to any geometry.
    size : (int, int)
        Width and height of the full film in pixels.
    origin : (3,) float, metres
        Where in the world the origin of rendering space is (`alight.compiled.rendering_space`).
    """
    table = CAMERAS[camera.type_name()].pack(camera, size, np.asarray(to_world, np.float64))
    return View(np.concatenate([table, np.asarray(origin)]).astype(np.float32))


def small_view(placed: PlacedCamera, size: tuple[int, int]) -> SmallView:
    """The view in about `SMALL_VIEW` pixels, with the proportions of a film of that size."""
    width, height = size
    scale = (SMALL_VIEW / (width * height)) ** 0.5
    small = max(round(width * scale), 1), max(round(height * scale), 1)
    return SmallView(compile_camera(placed.camera, placed.to_world, small), small)
