r"""Cube [-1, 1]^3 with outward normals; each face has the parameters of a rectangle.

Size and place come from the transform of its node.

Source: the plug-in ``cube`` of Mitsuba 3 for the canonical placement.
"""

from __future__ import annotations

from typing import Literal

from alight.core.spec import Shape


class Cube(Shape):
    """Cube of side 2 around the origin.

    Parameters
    ----------
    flip_normals : bool, default False
        Point the normals inwards.
    """

    type: Literal["cube"] = "cube"


EXAMPLES = (Cube(), Cube(flip_normals=True))
