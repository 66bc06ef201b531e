"""Layers of a file, and of a film that has only begun."""

import numpy as np
import pytest

from alight.films import Film
from alight.outputs.picture import Picture
from alight.view.layers import PICTURE, FileLayers
from alight.view.live import COARSER, GrowingLayers


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


@pytest.mark.parametrize("size", [(21, 9), (9, 21)])
def test_pixels_without_a_sample_show_the_small_picture(size):
    width, height = size
    rows, columns = -(-height // COARSER), -(-width // COARSER)
    small = np.random.default_rng(3).random((rows, columns, 3)).astype(np.float32)
    shown = GrowingLayers(Film(width, height), small).plane(PICTURE)
    for y, x in np.ndindex(height, width):
        np.testing.assert_array_equal(shown[y, x], small[y // COARSER, x // COARSER])
