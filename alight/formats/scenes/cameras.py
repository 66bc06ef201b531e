r"""Cameras of other programs -> ours.

Programs say how much a camera sees as an angle, as a focal length with the size of its film, or as
a window in the plane of the picture; all of them end in one angle,
:math:`2 \arctan(s / 2d)` for a picture of size s at distance d.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

Data = dict[str, Any]


def angle_of(size: float, distance: float) -> float:
    """Degrees that a picture of a size spans, seen from a distance."""
    return math.degrees(2.0 * math.atan(0.5 * size / distance))


@dataclass(frozen=True)
class Perspective:
    """A camera whose rays meet in a point, or in a lens.

    Attributes
    ----------
    fov : float, degrees
        Opening angle.
    axis : str
        Side of the picture that it spans, as the native format names it.
    lens_radius, focus_distance : float or None
        Of a thin lens, in the unit of the file; None for a pinhole.
    """

    fov: float
    axis: str = "y"
    lens_radius: float | None = None
    focus_distance: float | None = None

    def data(self) -> Data:
        """Description of the native format."""
        data: Data = {"type": "pinhole", "fov": self.fov, "fov_axis": self.axis}
        if self.lens_radius is not None:
            data |= {"type": "thin_lens", "aperture_radius": self.lens_radius}
            data["focus_distance"] = self.focus_distance
        return data


@dataclass(frozen=True)
class Parallel:
    """A camera whose rays are parallel.

    Attributes
    ----------
    height : float
        Of the picture, in the unit of the file.
    """

    height: float

    def data(self) -> Data:
        """Description of the native format."""
        return {"type": "orthographic", "height": self.height}
