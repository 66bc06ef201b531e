"""Layers of a file, and of a film that has only begun."""

import numpy as np
import pytest

import alight
from alight.films import Film
from alight.outputs.picture import Picture
from alight.view.layers import (
    COARSER,
    PICTURE,
    FileLayers,
    FilmLayers,
    GrowingLayers,
    relative_error,
)


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


def test_the_error_is_told_over_the_value_or_a_tenth_of_the_mean():
    """The mean of squares over channels, over the mean of channels; the mean of the pixels is 1."""
    grey = np.array([[-1.0, 0.0, 0.05, 0.0999, 0.1001, 0.5, 2.0, 5.25]])
    grey[0, 1:] *= 8.0 / np.maximum(grey[0], 0.0).sum()
    image = grey[..., None] * np.ones(3)
    image[0, -1] *= [0.5, 1.0, 1.5]
    error = np.broadcast_to([0.03, 0.0, 0.04], (1, 8, 3))
    scale = np.maximum(np.maximum(grey, 0.0), 0.1)
    assert (scale == 0.1).sum() >= 3 and scale.max() > 5.0
    wanted = np.sqrt((0.03**2 + 0.04**2) / 3.0) / scale
    np.testing.assert_allclose(relative_error(image, error)[..., 0], wanted, rtol=1e-12)
    assert np.isnan(relative_error(np.zeros((2, 2, 3)), np.ones((2, 2, 3)))).all()


@pytest.mark.parametrize(
    ("given", "wanted"),
    [("BGR", "RGB"), ("bgra", "rgba"), ("ABGR", "RGBA"), ("zyx", "xyz"), ("ZYX", "XYZ"),
     ("VU", "UV"), ("ba", "ab")],
)  # fmt: skip
def test_channels_stand_in_the_order_of_colours_and_axes(given, wanted):
    layers = {f"it.{c}": np.full((1, 1), float(wanted.index(c)), np.float32) for c in given}
    found = FileLayers(Picture(np.zeros((1, 1, 3), np.float32), layers)).plane("it")
    assert found.ravel().tolist() == list(range(len(wanted)))


def test_a_pixel_of_a_film_lies_between_the_ends_of_its_interval():
    film = alight.render("cornell-box", size=(8, 6), spp=8, progress=None)
    found = FilmLayers(film).values(5, 2)
    low, value, high = (np.array(found[name]) for name in ("95 % from", PICTURE, "95 % to"))
    np.testing.assert_array_equal(value, film.image[2, 5])
    assert (low <= value).all() and (value <= high).all() and (low < high).any()


@pytest.mark.parametrize("size", [(21, 9), (9, 21)])
def test_pixels_without_a_sample_show_the_small_picture(size):
    width, height = size
    rows, columns = -(-height // COARSER), -(-width // COARSER)
    small = np.random.default_rng(3).random((rows, columns, 3)).astype(np.float32)
    shown = GrowingLayers(Film(width, height), small).plane(PICTURE)
    for y, x in np.ndindex(height, width):
        np.testing.assert_array_equal(shown[y, x], small[y // COARSER, x // COARSER])


def test_samples_that_come_while_a_picture_is_painted_leave_no_holes():
    """The film grows in other threads: here, as soon as its picture or its counts were read."""

    class Growing(Film):
        def grown(self, read):
            self.counts[:] += 1
            self.sums[..., 0] += 256
            return read

        image = property(lambda self: self.grown(Film.image.fget(self)))
        sample_count = property(lambda self: self.grown(Film.sample_count.fget(self)))

    small = np.full((2, 2, 3), 0.5, np.float32)
    assert (GrowingLayers(Growing(8, 8), small).plane(PICTURE) > 0.0).all()
