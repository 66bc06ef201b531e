"""Textures at the edges of their ranges, at coordinates far outside of their squares."""

from __future__ import annotations

import numpy as np
import pytest

from alight.core.registry import modules, type_name_of
from tests.edges.specs import at_the_edges
from tests.textures.lookup import look_up

#: Around whole numbers, and up to the largest coordinates that a mesh may have.
COORDINATES = np.float32(
    [0.0, 0.5, 1.0 - 2.0**-24, 1.0, 1.0 + 2.0**-23, -1e-30, -1.0, -7.3, 2.0**24, -(2.0**31), 1e15]
)


@pytest.mark.parametrize("model", modules("textures"), ids=type_name_of)
def test_values_stay_between_zero_and_the_maximum_wherever_they_are_looked_up(model):
    u, v = (axis.ravel() for axis in np.meshgrid(COORDINATES, COORDINATES))
    for spec in dict.fromkeys(found for e in model.EXAMPLES for found in at_the_edges(e)):
        # Further sets of coordinates are those of meshes.
        if dict(spec).get("uv_set", 0) == 0:
            values = look_up(spec, u, v)
            assert np.isfinite(values).all() and (values >= 0.0).all(), spec
            assert (values <= np.array(spec.maximum()) * (1.0 + 1e-5)).all(), spec
