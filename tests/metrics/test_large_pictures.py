"""Machine code for large pictures: it says what NumPy says of the same picture."""

from __future__ import annotations

import numpy as np
import pytest

from alight.metrics import own_error
from alight.metrics.few_pixels import FewPixels
from alight.metrics.large_pictures import Loops
from alight.metrics.own_error import relmse_of
from alight.metrics.survey import survey


def picture(seed, size, replicates, kind):
    """Replicates of a patchy picture, and their counts."""
    rng = np.random.default_rng(seed)
    h, w = size
    patches = np.exp(rng.normal(0.0, 1.0, (h // 4 + 1, w // 4 + 1, 1, 1)))
    patches = patches.repeat(4, axis=0).repeat(4, axis=1)[:h, :w]
    shape, counts = (h, w, replicates, 3), np.full((h, w, replicates), 16)
    noise = {
        "noisy": lambda: rng.gamma(0.5, 2.0, shape),
        "precise": lambda: rng.gamma(200.0, 0.005, shape),
        "of both signs": lambda: rng.normal(0.3, 1.0, shape),
        "uneven": lambda: rng.gamma(5.0, 0.2, shape),
    }[kind]()
    means = (noise * patches).astype(np.float32)
    means[3, 5] = 0.0
    if kind == "uneven":
        counts = rng.integers(1, 30, (h, w, replicates))
        # Each of them has no sample somewhere.
        for r in range(replicates):
            counts[5:9, 4 * r : 4 * r + 3, r] = 0
            means[5:9, 4 * r : 4 * r + 3, r] = 0.0
    return means, counts


def sums_of(passes, weights, replicates):
    """Everything that both passes find."""
    few = FewPixels(replicates, replicates // 2)
    classes, *others = passes.learn()
    spread = passes.multiply(weights, few)
    return [*classes, *others, spread, few.at_least(0.0, 1.0), few.at_least(1.0, 1e3)]


@pytest.mark.parametrize(
    ("replicates", "kind", "compiled"),
    [
        (4, "noisy", True),
        (4, "precise", True),
        (8, "of both signs", True),
        (5, "noisy", True),
        (4, "uneven", True),
        (4, "uneven", False),
    ],
)
def test_machine_code_adds_up_what_numpy_does(monkeypatch, replicates, kind, compiled):
    """Rows that are no whole cell or packet, unknown pixels, and halves of different sizes."""
    size = (69, 43) if compiled else (10, 19)
    monkeypatch.setattr(own_error, "_LARGE", 0)
    seen = survey(*picture(1, size, replicates, kind))
    halvings = list(own_error._halvings(replicates))[:1]
    weights = np.linspace(0.5, 3.0, 12)
    by_numpy = sums_of(own_error._Sums(seen, 0.02, halvings), weights, replicates)
    by_loops = sums_of(Loops(seen, 0.02, compiled), weights, replicates)
    for found, expected in zip(by_loops, by_numpy, strict=True):
        np.testing.assert_allclose(found, expected, rtol=3e-5, atol=1e-4 * np.abs(expected).max())


def test_a_large_picture_is_judged_alike_by_both(monkeypatch):
    seen = survey(*picture(2, (260, 260), 4, "noisy"))
    by_loops = relmse_of(seen, literature=False).figure
    monkeypatch.setattr(own_error, "WIDEST", 1 << 30)
    by_numpy = relmse_of(seen, literature=False).figure
    np.testing.assert_allclose(by_loops, by_numpy, rtol=1e-5)
