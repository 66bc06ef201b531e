"""Displays: known points of tone curves, exposure, range."""

import numpy as np
import pytest

from alight.core.errors import OptionError
from alight.core.srgb import decode_srgb, encode_srgb
from alight.options.render import RenderOptions
from alight.outputs.display import Display
from alight.tone_curves import DEFAULT
from alight.tone_curves.model import TONE_CURVES


def grey(value):
    return np.full((1, 1, 3), value)


def curve(name, rgb):
    return TONE_CURVES[name].apply(TONE_CURVES[name].spec(), rgb)


def test_without_a_word_pictures_have_the_familys_default():
    assert Display() == RenderOptions().display == Display(tone_map=DEFAULT.type_name())


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("none", 0.18, 0.18),
        ("none", 3.0, 1.0),
        ("reinhard", 1.0, 0.5),
        ("reinhard", 3.0, 0.75),
        ("aces", 1.0, 0.8037975),
        ("hable", 5.6, 1.0),
        ("hable", 0.0, 0.0),
        # 0.18 lies at position 0.606 of AgX's stops, where its curve is 0.4971.
        ("agx", 0.18, 0.2145),
    ],
)
def test_known_points(name, value, expected):
    assert curve(name, grey(value))[0, 0, 0] == pytest.approx(
        expected, abs=1e-4 if name == "agx" else 1e-6
    )


def test_reinhard_keeps_the_ratios_of_the_channels():
    colour = np.array([[[4.0, 2.0, 1.0]]])
    mapped = curve("reinhard", colour)
    np.testing.assert_allclose(mapped / mapped[..., 2:], colour)


def test_agx_keeps_grey_and_pales_bright_colours():
    shown = curve("agx", np.logspace(-3, 2, 50)[:, None, None] * np.ones(3))
    np.testing.assert_allclose(shown, shown.mean(axis=-1, keepdims=True) * np.ones(3), rtol=2e-3)
    dim, bright = (curve("agx", level * np.array([[[1.0, 0.0, 0.0]]]))[0, 0] for level in (0.1, 50))
    assert dim[1] / dim[0] < 0.1 < 0.5 < bright[1] / bright[0]


def test_one_stop_doubles():
    np.testing.assert_allclose(Display(1.0).apply(grey(0.2)), Display().apply(grey(0.4)))


def test_automatic_exposure_makes_the_middle_grey():
    picture = np.array([0.02, 0.5, 8.0, 0.0])[None, :, None] * np.ones(3)
    shown = decode_srgb(Display("auto").apply(picture))
    # The geometric mean of the lit pixels is 0.08^(1/3).
    expected = np.minimum(picture * 0.18 / 0.08 ** (1 / 3), 1.0)
    np.testing.assert_allclose(shown, expected, rtol=1e-6)
    assert Display("auto").developed(np.zeros((2, 2, 3))).exposure == 0.0


def test_parts_of_a_picture_are_developed_as_the_whole():
    picture = np.random.default_rng(1).uniform(0.0, 2.0, (8, 4, 3)) * np.array([1.0, 0.7, 0.3])
    display = Display("auto", "agx", white_balance="auto")
    development = display.developed(picture)
    parts = np.concatenate([development.apply(picture[:3]), development.apply(picture[3:])])
    np.testing.assert_array_equal(parts, display.apply(picture))


def test_srgb_and_back():
    linear = np.linspace(0, 1, 10_001)
    np.testing.assert_allclose(decode_srgb(encode_srgb(linear)), linear, atol=2e-8)
    assert encode_srgb(np.float64(1.0)) == pytest.approx(1.0)
    assert encode_srgb(np.float64(0.18)) == pytest.approx(0.4613561, abs=1e-6)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"tone_map": "acess"}, 'unknown tone map "acess"; did you mean "aces"'),
        ({"exposure": float("nan")}, r"\[-100, 100\] stops, got nan"),
        ({"exposure": 101.0}, r"\[-100, 100\] stops, got 101"),
        ({"exposure": "bright"}, r'auto or lie in \[-100, 100\] stops, got "bright"'),
        ({"white_balance": "900K"}, r'\[1000K, 15000K\] as 3200K, .*; got "900k"'),
        ({"white_balance": "3200"}, 'got "3200"'),
        ({"white_balance": "1,nan,1"}, 'got "1,nan,1"'),
        ({"white_balance": "0,0,0"}, 'got "0,0,0"'),
        ({"bits": 12}, "8 or 16, got 12"),
    ],
)
def test_wrong_options_are_refused(options, message):
    with pytest.raises(OptionError, match=message):
        Display(**options)
