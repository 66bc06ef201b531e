"""Layers of a file: channels of one name together, up to as many as a colour has."""

import numpy as np
import pytest

from alight.outputs.picture import Picture
from alight.view.layers import FileLayers


@pytest.mark.parametrize("count", range(1, 7))
def test_what_has_more_channels_than_a_colour_is_shown_channel_by_channel(count):
    planes = np.random.default_rng(count).random((count, 3, 5)).astype(np.float32)
    layers = {f"many.{name}": plane for name, plane in zip("abcdef", planes, strict=False)}
    found = FileLayers(Picture(np.zeros((3, 5, 3), np.float32), layers))
    if count <= 4:
        np.testing.assert_array_equal(found.plane("many"), np.moveaxis(planes, 0, -1))
    else:
        assert "many" not in found.names
        for number, plane in enumerate(planes):
            np.testing.assert_array_equal(found.plane(f"many.{number}")[..., 0], plane)
