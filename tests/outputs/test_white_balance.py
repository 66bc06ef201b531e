"""White balance: whites against Planck's law, and what adaptation must do to them."""

import numpy as np
import pytest

from alight.core.constants import LUMINANCE
from alight.core.srgb import decode_srgb
from alight.formats.materials.spectra import blackbody, to_linear_srgb
from alight.outputs.display import Display
from alight.outputs.white_balance import adaptation, black_body_white, grey_world


@pytest.mark.parametrize("temperature", [1000.0, 1900.0, 2856.0, 5000.0, 6504.0, 15000.0])
def test_black_bodies_have_the_colour_of_plancks_law(temperature):
    exact = np.array(to_linear_srgb(*blackbody(temperature), shines=True))
    exact /= LUMINANCE @ exact
    # Below 1 900 K blue is negative, which the exact one cuts off.
    white = np.maximum(black_body_white(temperature), 0.0)
    np.testing.assert_allclose(white, exact, rtol=0.011, atol=5e-4)


@pytest.mark.parametrize("temperature", [2000.0, 3200.0, 9000.0])
def test_the_light_becomes_neutral_and_keeps_its_luminance(temperature):
    white = black_body_white(temperature)
    shown = adaptation(0.4 * white) @ white
    np.testing.assert_allclose(shown, np.ones(3), atol=2e-4)


def test_a_neutral_light_changes_nothing():
    np.testing.assert_allclose(adaptation(np.full(3, 7.0)), np.eye(3), atol=1e-12)


def test_adaptation_is_not_a_gain_for_each_channel():
    """Bradford's cones, not von Kries in RGB: a warm light's red stays redder."""
    matrix = adaptation(black_body_white(2856.0))
    assert np.abs(matrix - np.diag(np.diag(matrix))).max() > 0.02


def test_grey_world_makes_the_mean_grey():
    picture = np.random.default_rng(3).uniform(0.1, 0.3, (16, 16, 3)) * np.array([1.0, 0.6, 0.3])
    shown = decode_srgb(Display(white_balance="auto").apply(picture)).mean(axis=(0, 1))
    np.testing.assert_allclose(shown, np.full(3, LUMINANCE @ picture.mean(axis=(0, 1))), rtol=1e-3)


def test_a_picture_without_light_has_no_white():
    assert grey_world(np.zeros((2, 2, 3))) is None
    assert not Display(white_balance="auto").apply(np.zeros((2, 2, 3))).any()


def test_colours_and_temperatures_are_read():
    color = np.array([[[0.9, 0.5, 0.2]]])
    by_color = Display(white_balance=" 0.9, 0.5,0.2 ").apply(color)
    np.testing.assert_allclose(by_color, by_color.mean() * np.ones((1, 1, 3)), atol=1e-3)
    by_name = Display(white_balance="3200 k").apply(color)
    by_value = Display(white_balance=",".join(map(str, black_body_white(3200.0)))).apply(color)
    np.testing.assert_allclose(by_name, by_value, atol=1e-9)
