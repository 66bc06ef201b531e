"""Layers as colours: every kind by its rule, in closed form."""

import numpy as np
import pytest

from alight.outputs.display import Display
from alight.view.shades import _SCALE, shaded

DISPLAY = Display(exposure=2.0)


def random_plane(channels):
    return np.random.default_rng(channels).normal(size=(5, 7, channels)).astype(np.float32)


def byte(x):
    """A share of 255, to the nearest whole number."""
    return np.rint(255.0 * np.asarray(x, float))


@pytest.mark.parametrize("name", ["normal", "geometric_normal", "normal_through"])
def test_directions_are_moved_from_their_cube_into_that_of_colours(name):
    plane = random_plane(4)
    plane[0, 0] = [1.0, -1.0, 0.0, 1.0]
    plane[0, 1] = np.nan
    found = shaded(name, plane, DISPLAY)
    expected = byte(np.clip(np.nan_to_num(0.5 * (plane[..., :3] + 1.0), nan=0.5), 0.0, 1.0))
    np.testing.assert_allclose(found.rgba[..., :3], expected, atol=1.0)
    assert found.rgba[0, 0].tolist() == [255, 0, 128, 255]
    assert (found.low, found.high) == (None, None)


@pytest.mark.parametrize(("name", "channels"), [("position", 3), ("uv", 2), ("id", 3)])
def test_places_go_from_the_least_to_the_largest_of_each_channel(name, channels):
    plane = random_plane(channels)
    # Nothing is known of one pixel, and all are alike in one channel.
    plane[2, 3, 0], plane[..., 1] = np.nan, 4.0
    found = shaded(name, plane, DISPLAY).rgba
    known = np.nan_to_num(plane.astype(float))
    expected = np.zeros((5, 7, 3))
    for k in (0, 2)[: channels - 1]:
        spread = known[..., k] - known[..., k].min()
        expected[..., k] = byte(spread / spread.max())
    np.testing.assert_allclose(found[..., :3], expected, atol=1.0)
    assert (found[..., 3] == 255).all()


@pytest.mark.parametrize("channels", [1, 2])
def test_single_numbers_go_along_the_scale(channels):
    """Evenly from its first colour to the last one, which the brightest 0.5 % share."""
    levels = np.linspace(3.0, 15.0, 1201)
    plane = np.zeros((1, 1202, channels), np.float32)
    plane[0, :-1, 0], plane[0, -1, 0] = levels, np.inf
    found = shaded("depth", plane, DISPLAY)
    assert (found.low, found.high) == (3.0, pytest.approx(np.percentile(levels, 99.5)))
    place = np.minimum((levels - found.low) / (found.high - found.low), 1.0) * (len(_SCALE) - 1)
    expected = [np.interp(place, np.arange(len(_SCALE)), _SCALE[:, k]) for k in range(3)]
    np.testing.assert_allclose(found.rgba[0, :-1, :3], np.transpose(expected), atol=1.0)
    # Of what is infinite nothing is known: it is black, and moves no end of the scale.
    assert found.rgba[0, -1].tolist() == [0, 0, 0, 255]


def test_a_layer_of_one_value_is_in_the_middle_and_one_of_none_is_black():
    even = shaded("depth", np.full((2, 3, 1), 7.0), DISPLAY)
    assert (even.low, even.high) == (7.0, 7.0)
    assert (even.rgba == [*np.rint(_SCALE[3]), 255]).all()
    none = shaded("depth", np.full((2, 3, 1), np.nan), DISPLAY)
    assert (none.low, none.high) == (0.0, 0.0)
    assert (none.rgba == [0, 0, 0, 255]).all()


@pytest.mark.parametrize("channels", [3, 4])
def test_only_radiance_is_developed(channels):
    plane = np.abs(random_plane(channels))
    for name, display in (
        ("direct", DISPLAY),
        ("albedo", Display()),
        ("albedo_through", Display()),
    ):
        found = shaded(name, plane, DISPLAY).rgba
        np.testing.assert_array_equal(found[..., :3], byte(display.apply(plane[..., :3])))
