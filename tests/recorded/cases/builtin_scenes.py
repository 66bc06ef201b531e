"""Small pictures of the built-in scenes, by the NumPy reading of the kernels."""

from functools import partial
from pathlib import Path

import numpy as np

import alight
from alight.scene import builtin
from tests.twin import picture_of

#: The twin tests thousands of shapes one by one.
TOO_LARGE = {"instances", "many-lights", "milk", "transform-tree", "under-water"}

NAMES = {path.stem for path in Path(builtin.__path__[0]).glob("*.yaml")}


def picture(name: str) -> np.ndarray:
    """Mean radiance (height, width, 3)."""
    return picture_of(alight.load(name, ["film.size=[12, 8]"]), 4)


CASES = {name: partial(picture, name) for name in sorted(NAMES - TOO_LARGE)}
