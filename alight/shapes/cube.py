r"""Cube [-1, 1]^3 with outward normals; each face has the parameters of a rectangle.

Size and place come from the transform of its node.

Source: the plug-in ``cube`` of Mitsuba 3 for the canonical placement.
"""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from alight.core.spec import Shape
from alight.shapes.rectangle import Rectangle


class Cube(Shape):
    """Cube of side 2 around the origin.

    Parameters
    ----------
    flip_normals : bool, default False
        Point the normals inwards.
    """

    closed: ClassVar[bool] = True
    type: Literal["cube"] = "cube"

    def parts(self) -> tuple[tuple[Shape, np.ndarray], ...]:
        """Six rectangles."""
        face = Rectangle(flip_normals=self.flip_normals)
        return tuple((face, side) for side in sides())


EXAMPLES = (Cube(), Cube(flip_normals=True))


def sides() -> list[np.ndarray]:
    """Rotations and shifts that take the rectangle to the six faces of [-1, 1]^3, z outwards."""
    sides = []
    for axis in range(3):
        for sign in (1.0, -1.0):
            side = np.eye(4)
            normal, first = np.zeros(3), np.zeros(3)
            normal[axis], first[(axis + 1) % 3] = sign, 1.0
            side[:3, 0], side[:3, 1] = first, np.cross(normal, first)
            side[:3, 2] = side[:3, 3] = normal
            sides.append(side)
    return sides
