r"""A hemisphere of directions as a disk in which equal areas are equal solid angles.

The pole is the centre. A direction :math:`\theta` away from it is :math:`\sqrt{1 - \cos\theta}`
from the centre, in units of the disk's radius (Lambert's azimuthal projection).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Hemisphere(NamedTuple):
    """Directions at the centres of a disk's pixels.

    Attributes
    ----------
    w : (3, n) float64
        Unit directions in the shading frame.
    inside : (side, side) bool
        Which pixels they belong to, in their order.
    solid_angle : float
        Of each pixel, steradians.
    """

    w: np.ndarray
    inside: np.ndarray
    solid_angle: float

    def picture(self, values: np.ndarray, outside: float = np.nan) -> np.ndarray:
        """Values (n, ...) of the directions as a picture (side, side, ...)."""
        shown = np.full((*self.inside.shape, *values.shape[1:]), outside)
        shown[self.inside] = values
        return shown


def hemisphere(side: int, *, upper: bool = True, bottom: float = -0.5 * np.pi) -> Hemisphere:
    """The hemisphere around +z, or around -z as if seen through the surface.

    Parameters
    ----------
    side : int
        Pixels across the disk.
    upper : bool
    bottom : float
        Azimuth of the disk's lowest point, radians; without it x is to the right and y up.
    """
    x, down = np.meshgrid(*[(np.arange(side) + 0.5) * (2.0 / side) - 1.0] * 2)
    y, r2 = -down, x**2 + down**2
    inside = r2 < 1.0
    x, y, r2 = x[inside], y[inside], r2[inside]
    # sin(theta) / r, which is sqrt(2) at the centre.
    stretch = np.sqrt(2.0 - r2)
    c, s = -np.sin(bottom), np.cos(bottom)
    across, along = x * stretch, y * stretch
    height = (1.0 - r2) * (1.0 if upper else -1.0)
    w = np.stack([c * across - s * along, s * across + c * along, height])
    return Hemisphere(w, inside, 8.0 / side**2)
