"""What the renderer takes from the file of a camera."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from alight.core.registry import Kernel, Record, Records


@dataclass(frozen=True, eq=False, kw_only=True)
class CameraModel(Record):
    """A camera.

    Attributes
    ----------
    half_extents : (spec, int, int) -> (float, float)
        Half the sides of a film of that width and height in pixels: at distance 1 from the
        viewpoint (perspective), or in metres.
    pack : (spec, (int, int), (4, 4) float64) -> (n,) float
        Table of its kernel, from the film's size and the matrix camera to world.
    generate_ray : kernel ``(table, film_x, film_y, u_lens) -> (o, d)``
        Origin and unit direction of the ray through a point of the film.
    connect : kernel ``(table, p, u_lens) -> Connection``
        How a point of the scene is seen from a point of the lens; without it light paths cannot
        reach the camera.
    connect_far : kernel ``(table, d, u_lens) -> Connection``
        The same of what lies infinitely far along the unit direction d, where each point of the
        film sees directions of its own.
    PERSPECTIVE : bool
        Rays through the centre of the lens meet in a point.
    """

    half_extents: Callable[[Any, int, int], tuple[float, float]]
    pack: Callable[[Any, tuple[int, int], np.ndarray], np.ndarray]
    generate_ray: Kernel
    PERSPECTIVE: bool
    connect: Kernel | None = None
    connect_far: Kernel | None = None


#: All cameras, by name.
CAMERAS = Records("cameras", CameraModel)
