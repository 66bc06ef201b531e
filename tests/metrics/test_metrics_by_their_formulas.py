"""Each metric of the registry once more, and what of it is shown."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from alight.metrics.model import METRICS, Pair, shown_of

LUMINANCE = np.array([0.212671, 0.715160, 0.072169])


def encoded(x):
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1.0 / 2.4) - 0.055)


def similarity(x, ref):
    """Wang et al. 2004: windows of 11 by 11 pixels, those that lie inside."""

    def window(plane):
        return gaussian_filter(plane, 1.5, radius=5)[5:-5, 5:-5]

    a, b = (encoded(np.clip(one, 0.0, 1.0) @ LUMINANCE) for one in (x, ref))
    m, n = window(a), window(b)
    covariance, spread = window(a * b) - m * n, window(a * a + b * b) - m * m - n * n
    bright = (2.0 * m * n + 0.01**2) / (m * m + n * n + 0.01**2)
    return (bright * (2.0 * covariance + 0.03**2) / (spread + 0.03**2)).mean()


#: By double entry (decision 38); FLIP has a reference of its own, in `test_flip`.
FORMULAS = {
    "mse": lambda x, r: ((x - r) ** 2).mean(),
    "rmse": lambda x, r: np.sqrt(((x - r) ** 2).mean()),
    "relmse": lambda x, r: ((x - r) ** 2 / (r**2 + (0.1 * r.mean()) ** 2)).mean(),
    "relmse_literature": lambda x, r: ((x - r) ** 2 / (r**2 + 0.01)).mean(),
    "smape": lambda x, r: (np.abs(x - r) / (np.abs(x) + np.abs(r) + 0.01)).mean(),
    "dssim": lambda x, r: (1.0 - similarity(x, r)) / 2.0,
}


@pytest.mark.parametrize("name", sorted({*METRICS} - {"flip"}))
def test_a_metric_is_its_formula(name):
    rng = np.random.default_rng(4)
    ref = rng.uniform(0.1, 0.9, (32, 24, 3))
    x = np.clip(ref + 0.1 * rng.standard_normal(ref.shape), 0.0, None)
    model = METRICS[name]
    found = model.evaluate(model.example, Pair(x, ref))
    assert found == pytest.approx(FORMULAS[name](x, ref), rel=2e-3)
    shown = similarity(x, ref) if name == "dssim" else found
    assert shown_of(name, found) == pytest.approx(shown, rel=2e-3)


def test_a_pair_is_shown_as_bright_as_its_exposure_says():
    x = np.array([[[0.1, 0.3, 0.8]]])
    seen = Pair(x, 0.5 * x, exposure=1.0).shown()
    np.testing.assert_allclose(seen.image, [[[0.2, 0.6, 1.0]]])
    np.testing.assert_allclose(seen.reference, x)
    assert (seen.exposure, seen.on_display) == (0.0, True)
