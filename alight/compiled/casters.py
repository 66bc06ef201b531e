"""Where mirrors and clear glass are, which cast caustics."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from alight.bsdfs.nesting import leaves
from alight.bsdfs.specular import is_specular
from alight.compiled.boxes import box_of
from alight.core.spec import Bsdf
from alight.scene.flatten import FlatScene


def boxes_of_casters(flat: FlatScene) -> NDArray[np.float64]:
    """The boxes around shapes that are mirrors or clear glass, and finite.

    Returns
    -------
    (n, 6) float64, metres
        Lower and upper corner; of what moves, while the shutter is open.
    """
    boxes, numbers = boxes_by_shape(flat)
    for box, number in zip(boxes, numbers, strict=True):
        motion = flat.shapes[number].motion
        if motion:
            box[:] = np.concatenate(motion.bounds(box[:3], box[3:]))
    return boxes


def boxes_by_shape(flat: FlatScene) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """Boxes of casters at rest, (n, 6), and the numbers of their shapes in the scene, (n,) int."""
    bright = [is_caster(bsdf) for bsdf in flat.bsdfs]
    found, numbers = [], []
    for number, placed in enumerate(flat.shapes):
        box = box_of(flat, placed) if bright[placed.bsdf] else None
        if box is not None and np.isfinite(box).all():
            found.append(np.concatenate(box))
            numbers.append(number)
    return np.array(found, float).reshape(-1, 6), np.array(numbers, np.intp)


def is_caster(bsdf: Bsdf) -> bool:
    """Whether some of a material is a mirror or clear glass."""
    return any(is_specular(leaf.bsdf) for leaf in leaves(bsdf))
