"""FLIP by its authors' package, and what is said where that is missing."""

import importlib.util

import numpy as np
import pytest

from alight.core.errors import OptionError
from alight.metrics.flip import flip


def _pictures():
    rng = np.random.default_rng(3)
    reference = rng.random((24, 32, 3)).astype(np.float32)
    return np.clip(reference + rng.normal(0, 0.05, reference.shape), 0, 1), reference


def test_without_the_package_the_remedy_is_named(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(OptionError, match=r'pip install ".*\[lab\]"'):
        flip(*_pictures())


@pytest.mark.parametrize("dynamic_range", ["ldr", "hdr"])
def test_flip_is_zero_for_equal_pictures_and_grows_with_the_error(dynamic_range):
    pytest.importorskip("flip_evaluator")
    image, reference = _pictures()
    near, far = (flip(v, reference, dynamic_range) for v in (image, np.sqrt(image)))
    assert flip(reference, reference, dynamic_range).mean == 0.0
    assert 0.0 < near.mean < far.mean < 1.0
    assert near.error.shape == (24, 32)
    assert near.mean == pytest.approx(near.error.mean(), rel=1e-4)


def test_ldr_compares_what_a_display_shows():
    """The package wants sRGB-encoded values: its own figure for those is the same."""
    package = pytest.importorskip("flip_evaluator")
    from alight.core.srgb import encode_srgb

    image, reference = _pictures()
    encoded = [encode_srgb(v).astype(np.float32) for v in (reference, image)]
    _, expected, _ = package.evaluate(*encoded, "LDR")
    assert flip(image, reference, "ldr").mean == pytest.approx(expected, rel=1e-6)
    assert flip(image * 3.0, np.ones_like(image), "ldr").mean < 1.0


def test_black_pictures_have_no_exposure_but_a_flip():
    pytest.importorskip("flip_evaluator")
    black = np.zeros((16, 16, 3))
    assert flip(black, black, "hdr").mean == 0.0
    assert flip(black + 1.0, black, "hdr").mean > 0.5


def test_wrong_calls_are_refused():
    image, reference = _pictures()
    with pytest.raises(ValueError, match="dynamic range"):
        flip(image, reference, "mdr")
    with pytest.raises(ValueError, match="one shape"):
        flip(image[1:], reference)
    with pytest.raises(ValueError, match="one shape"):
        flip(image[:, 1:], reference)
