"""Tables of the bodies that absorb light, and where they are."""

from __future__ import annotations

from collections import namedtuple

import numpy as np

from alight.bsdfs.interiors.bodies import NO_BODY, BodyTables, body_below
from alight.compiled.boxes import box_of
from alight.compiled.materials import MaterialTables
from alight.scene.flatten import FlatScene
from lanewise.view import View

#: Materials of scenes with bodies that absorb light.
AbsorbingMaterials = namedtuple("AbsorbingMaterials", (*MaterialTables._fields, "bodies"))


def with_bodies(materials: MaterialTables, flat: FlatScene) -> AbsorbingMaterials:
    """The tables of a scene in which bodies absorb light."""
    bodies = [body_below(bsdf) for bsdf in flat.bsdfs]
    numbers = np.array([body or NO_BODY for body in bodies], np.float32)
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for placed in flat.shapes:
        if any(bodies[placed.bsdf] or ()):
            box = None if placed.motion else box_of(flat, placed)
            around = box or (np.full(3, -np.inf), np.full(3, np.inf))
            low, high = np.minimum(low, around[0]), np.maximum(high, around[1])
    corners = np.concatenate([low, high]).astype(np.float32)
    return AbsorbingMaterials(*materials, BodyTables(View(numbers.ravel()), View(corners)))
