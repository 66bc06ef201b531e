"""Where mirrors and clear glass are, which cast caustics."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from alight.bsdfs.nesting import leaves
from alight.bsdfs.specular import is_specular
from alight.compiled.suspicious_bodies import box_of
from alight.core.spec import Bsdf
from alight.scene.flatten import FlatScene


def boxes_of_casters(flat: FlatScene) -> NDArray[np.float64]:
    """The boxes around shapes that are mirrors or clear glass, and finite.

    Returns
    -------
    (n, 6) float64, metres
        Lower and upper corner; of what moves, while the shutter is open.
    """
    bright = [is_caster(bsdf) for bsdf in flat.bsdfs]
    rows = []
    for placed in flat.shapes:
        box = box_of(flat, placed) if bright[placed.bsdf] else None
        if box is not None and np.isfinite(box).all():
            rows.append(np.concatenate(placed.motion.bounds(*box) if placed.motion else box))
    return np.array(rows, float).reshape(-1, 6)


def is_caster(bsdf: Bsdf) -> bool:
    """Whether some of a material is a mirror or clear glass."""
    return any(is_specular(leaf.bsdf) for leaf in leaves(bsdf))
