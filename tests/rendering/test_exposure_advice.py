"""A picture that shows nothing of most of what it holds says how to see it."""

import numpy as np
import pytest

from alight.outputs.display import Display
from alight.rendering.writing import exposure_advice


def picture(*values):
    """Grey pixels in a row."""
    return np.repeat(np.array(values, np.float32)[None, :, None], 3, axis=2)


@pytest.mark.parametrize(
    ("values", "word"),
    [
        ((40.0, 50.0, 0.5), "67 % of what has light is cut at white"),
        ((1e-6, 1e-5, 0.5), "67 % of what has light is too dark to be seen"),
        ((40.0, 50.0, 0.0, 0.0, 0.0), "100 % of what has light is cut at white"),
    ],
)
def test_lost_pictures_are_told_of(values, word):
    [line] = exposure_advice(Display(), picture(*values))
    assert word in line
    assert "--exposure auto shows it" in line


def test_the_stops_are_those_of_automatic_exposure():
    [line] = exposure_advice(Display(), picture(18.0, 18.0))
    assert "(-6.6 stops)" in line


@pytest.mark.parametrize(
    "values", [(0.0, 0.0), (0.5, 0.5, 40.0, 40.0), (0.2, 0.3, 1e-7, 0.0), (np.nan, 0.4)]
)
def test_pictures_that_show_what_they_hold_are_left_alone(values):
    assert exposure_advice(Display(), picture(*values)) == []


def test_what_the_display_shows_counts():
    bright = picture(40.0, 50.0)
    assert exposure_advice(Display(), bright)
    assert not exposure_advice(Display(exposure=-7.0), bright)
    # One channel that is cut leaves the others to be seen.
    assert not exposure_advice(Display(), bright * np.array([1.0, 0.001, 0.001], np.float32))
