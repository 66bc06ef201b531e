"""SSIM against its definition, window by window, and the plain mean squared error."""

import numpy as np
import pytest

from alight.metrics.mse import mse
from alight.metrics.ssim import ssim, ssim_map


def _planes(seed=1, shape=(13, 15)):
    rng = np.random.default_rng(seed)
    a = rng.random(shape)
    return a, np.clip(0.8 * a + 0.1 * rng.random(shape), 0, 1)


def test_map_is_the_definition_in_every_window():
    a, b = _planes()
    x = np.arange(-5, 6)
    window = np.exp(-0.5 * (x[:, None] ** 2 + x[None] ** 2) / 1.5**2)
    window /= window.sum()
    expected = np.zeros((3, 5))
    for i in range(3):
        for j in range(5):
            p, q = a[i : i + 11, j : j + 11], b[i : i + 11, j : j + 11]
            m, n = (window * p).sum(), (window * q).sum()
            vp, vq = (window * (p - m) ** 2).sum(), (window * (q - n) ** 2).sum()
            cov = (window * (p - m) * (q - n)).sum()
            top = (2 * m * n + 1e-4) * (2 * cov + 9e-4)
            expected[i, j] = top / ((m * m + n * n + 1e-4) * (vp + vq + 9e-4))
    assert np.allclose(ssim_map(a, b), expected, rtol=1e-12, atol=1e-12)
    assert ssim(a, b) == pytest.approx(expected.mean())


def test_equal_pictures_score_one_and_negatives_less_than_zero():
    a, _ = _planes()
    assert ssim(a, a) == pytest.approx(1.0)
    assert ssim(np.zeros((11, 11)), np.zeros((11, 11))) == 1.0
    assert ssim(a, 1 - a) < 0


@pytest.mark.parametrize("shape", [(10, 20), (20, 10), (20, 20, 3)])
def test_planes_too_small_for_the_window_are_refused(shape):
    with pytest.raises(ValueError, match="11x11"):
        ssim(np.zeros(shape), np.zeros(shape))


def test_other_shapes_are_refused():
    with pytest.raises(ValueError, match="one shape"):
        ssim(np.zeros((11, 11)), np.zeros((12, 11)))
    with pytest.raises(ValueError, match="one shape"):
        mse(np.zeros((2, 2, 3)), np.zeros((3, 2, 3)))


def test_mse_is_its_formula():
    assert mse(np.array([[[1.0, 2.0, 3.0]]]), np.array([[[1.0, 0.0, 0.0]]])) == pytest.approx(
        13 / 3
    )
