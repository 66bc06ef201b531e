"""What three numbers lose of a spectrum."""

import numpy as np
import pytest

from alight.core.spectra import blackbody, reduction_error, to_linear_srgb

WIDE = np.array([300.0, 900.0])


def line(first, last):
    """1 between two wavelengths, 0 outside."""
    return np.array([first - 1e-3, first, last, last + 1e-3]), np.array([0.0, 1.0, 1.0, 0.0])


def notch(first, last):
    """0 between two wavelengths, 1 outside: its square is the same spectrum."""
    places, values = line(first, last)
    return np.concatenate([[300.0], places, [900.0]]), np.pad(1.0 - values, 1, constant_values=1.0)


@pytest.mark.parametrize("value", [0.2, 0.7])
def test_a_grey_is_off_by_the_reduction_of_white_alone(value):
    white = np.array(to_linear_srgb(WIDE, np.ones(2), shines=False))
    seen, again = reduction_error(WIDE, np.full(2, value), shines=False)
    assert seen == 0.0
    assert again == pytest.approx((white - white**2).max() / white.max(), rel=1e-6)


def test_a_spectrum_that_is_its_own_square_is_off_by_its_colour_less_the_square_of_that():
    pairs = notch(560.2, 600.2)
    color = np.array(to_linear_srgb(*pairs, shines=False))
    assert color.min() > 0.1
    # Without its yellow, white has more blue than sRGB can show.
    kept = np.minimum(color, 1.0)
    seen, again = reduction_error(*pairs, shines=False)
    assert seen == pytest.approx((color - kept).max() / color.max(), rel=1e-9)
    assert seen > 0.03
    assert again == pytest.approx((color - kept**2).max() / color.max(), rel=1e-9)


def test_what_srgb_cannot_show_is_what_a_line_is_off_by():
    """530 nm: its red is negative; CIE 1931 xy is (0.1547, 0.8059)."""
    x, y = 0.1547, 0.8059
    xyz = np.array([x / y, 1.0, (1.0 - x - y) / y])
    channels = np.linalg.solve(
        [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750],
         [0.0193339, 0.1191920, 0.9503041]], xyz,
    )  # fmt: skip
    seen, again = reduction_error(*line(529.8, 530.2), shines=True)
    assert seen == pytest.approx(-channels.min() / channels.max(), abs=0.01)
    assert again == 0.0


def test_darkness_is_not_off():
    assert reduction_error(WIDE, np.zeros(2), shines=True) == (0.0, 0.0)
    assert reduction_error(WIDE, np.zeros(2), shines=False) == (0.0, 0.0)


@pytest.mark.parametrize("temperature", [1000.0, 2856.0, 6504.0, 40_000.0])
def test_a_black_body_shines_by_plancks_law(temperature):
    """With the constants that define the units."""
    planck, light, boltzmann = 6.62607015e-34, 299_792_458.0, 1.380649e-23
    nanometres, radiance = blackbody(temperature)
    metres = 1e-9 * nanometres
    quanta = planck * light / (metres * boltzmann * temperature)
    per_metre = 2.0 * planck * light**2 / (metres**5 * (np.exp(quanta) - 1.0))
    np.testing.assert_allclose(radiance, 1e-9 * per_metre, rtol=1e-9)
    assert nanometres[0] < 400.0 < 700.0 < nanometres[-1]
