"""Crops where the arms differ, one exposure, and false colour that can be read back."""

import base64
import io
import math

import numpy as np
import pytest
from PIL import Image

from alight.core.constants import LUMINANCE
from alight.lab.report import pictures
from alight.lab.report.pictures import Scale, choose_crops, exposure_for, map_uri, picture_uri


def decoded(uri):
    assert uri.startswith("data:image/png;base64,")
    data = base64.b64decode(uri.split(",")[1])
    return np.asarray(Image.open(io.BytesIO(data)).convert("RGB")).astype(int)


def test_crops_lie_where_the_errors_of_the_arms_differ():
    errors = [np.full((100, 160), 0.01) for _ in range(3)]
    # All arms are bad here: nothing to see.
    for error in errors:
        error[60:90, 10:40] = 1.0
    errors[1][20:44, 100:124] = 0.5
    errors[2][70:94, 120:144] = 0.2
    first, second, _ = choose_crops(errors)
    assert first == (100, 20, 24, 24)
    assert second == (120, 70, 24, 24)


def test_crops_do_not_overlap_and_fit():
    rng = np.random.default_rng(1)
    crops = choose_crops([rng.random((50, 60)), rng.random((50, 60))], count=8)
    covered = np.zeros((50, 60), int)
    for x, y, w, h in crops:
        covered[y : y + h, x : x + w] += 1
        assert x + w <= 60
        assert y + h <= 50
    assert covered.max() == 1
    assert choose_crops([np.ones((3, 7))], count=2)[0][2:] == (3, 3)


@pytest.mark.parametrize(
    ("level", "stops"), [(0.5, 0.0), (0.8, 0.0), (0.05, 4.0), (14.0, -4.0), (0.0, 0.0)]
)
def test_exposure_moves_dark_and_bright_pictures_only(level, stops):
    assert exposure_for(np.full((4, 4, 3), level)) == stops


def test_pictures_are_shown_at_the_exposure():
    uri = picture_uri(np.full((2, 3, 3), 0.125), 3.0)
    assert decoded(uri).shape == (2, 3, 3)
    assert (decoded(uri) == 255).all()


def test_one_wild_map_does_not_wash_out_the_others():
    rng = np.random.default_rng(1)
    planes = [rng.normal(0, s, (50, 50)) for s in (1, 1, 1000)]
    scale = Scale.of(planes, "signed")
    assert scale.low == -scale.high
    assert 2 < scale.high < 15


def test_maps_are_monotonic_in_brightness_and_grey_where_unknown():
    plane = np.tile(np.geomspace(1e-4, 1.0, 64), (4, 1))
    plane[0, 0] = np.nan
    shown = decoded(map_uri(plane, Scale("log", 1e-4, 1.0)))
    brightness = shown[1] @ LUMINANCE
    assert (np.diff(brightness) > -1.5).all()
    assert brightness[-1] - brightness[0] > 120
    assert tuple(shown[0, 0]) == (214, 214, 214)
    signed = decoded(map_uri(np.array([[-1.0, 0.0, 1.0]]), Scale("signed", -1.0, 1.0)))[0]
    assert signed[0, 2] > signed[0, 0] + 50
    assert signed[2, 0] > signed[2, 2] + 50
    assert signed[1].min() > 240


@pytest.mark.parametrize("kind", ["signed", "log", "linear"])
def test_scales_of_constant_and_empty_maps_work(kind):
    for plane in (np.zeros((4, 4)), np.full((4, 4), 7.0), np.full((4, 4), np.nan)):
        scale = Scale.of([plane], kind)
        assert scale.low < scale.high
        assert map_uri(plane, scale)
        assert all(math.isfinite(t.percent) for t in pictures.color_bar(scale)["ticks"])


def test_large_maps_are_averaged_down():
    plane = np.arange(700.0 * 4).reshape(4, 700)
    plane[0, 0] = np.nan
    small = pictures.reduced(plane)
    assert small.shape == (2, 234)
    assert small[0, 1] == pytest.approx(plane[:3, 3:6].mean())
    assert small[0, 0] == pytest.approx(np.nanmean(plane[:3, :3]))
