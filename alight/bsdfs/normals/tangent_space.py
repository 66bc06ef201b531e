"""How the picture of a map of normals lies on a surface, for the rows of materials."""

from __future__ import annotations

import math

from alight.core.spec import Texture

#: Of a picture that lies along (u, v), however large.
UNTURNED = (1.0, 0.0, 1.0)


def turn_of(texture: object) -> tuple[float, float, float]:
    """How a picture lies in (u, v), as `shading_normals.axes_of_map` reads it."""
    found = texture.lookup() if isinstance(texture, Texture) else None
    if found is None:
        return UNTURNED
    (a, b), (c, d) = found[:, :2]
    determinant, length = a * d - b * c, math.hypot(c, d)
    if determinant == 0.0 or length == 0.0:
        return UNTURNED
    # The first column of the inverse.
    side = math.copysign(1.0, determinant)
    return side * d / length, -side * c / length, side


def set_of(texture: object) -> int:
    """The number of the set of texture coordinates that a picture is looked up by."""
    return (texture.set_of_coordinates() or 0) if isinstance(texture, Texture) else 0
