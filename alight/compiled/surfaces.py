"""The names of what is seen, and to which of them each row of the shapes' tables belongs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from alight.compiled.shapes import CompiledShapes
from alight.scene.flatten import FlatScene


class Surfaces(NamedTuple):
    """Placed shapes as a Cryptomatte counts them.

    Attributes
    ----------
    names : tuple of (str, str)
        Of each placed shape its path and what its material is called.
    of_row : ndarray of int64
        Placed shape of each row; the faces of a cube share one.
    """

    names: tuple[tuple[str, str], ...]
    of_row: np.ndarray


def surfaces_of(flat: FlatScene, shapes: CompiledShapes) -> Surfaces:
    """Name the surfaces of a scene."""
    names = tuple((placed.name, placed.material) for placed in flat.shapes)
    return Surfaces(names, np.array([row.source for row in shapes.rows], np.int64))
