"""The example of the page on lanewise: machine code, its twin, and NumPy's complex numbers."""

from pathlib import Path

import numpy as np
import pytest

from lanewise.jit import instantiate
from lanewise.view import View

PAGE = Path(__file__).parents[2] / "docs" / "lanewise.md"


@pytest.fixture(scope="module")
def example():
    """The names that the first block of the page defines."""
    text = PAGE.read_text(encoding="utf-8").split("```python\n")[1].split("```")[0]
    scope = {}
    exec(compile(text, str(PAGE), "exec"), scope)
    return scope


def escape_times(width, height, step, most):
    """The same set with complex numbers."""
    y, x = np.mgrid[:height, :width].astype(np.float32) * np.float32(step)
    c, z = (x - 2.0) + 1j * (y - 1.2), np.zeros((height, width), complex)
    n, inside = np.zeros((height, width), np.uint32), np.ones((height, width), bool)
    for _ in range(most):
        z[inside] = z[inside] ** 2 + c[inside]
        n += inside
        inside &= np.abs(z) < 2.0
    return n


def test_it_is_the_mandelbrot_set(example):
    expected = escape_times(128, 96, 0.025, 100)
    # On its rim the rounding of float32 decides.
    assert np.mean(example["picture"] != expected) < 0.02
    assert (example["picture"] == 100).sum() == pytest.approx((expected == 100).sum(), rel=0.01)


def test_the_twin_draws_the_same(example):
    twin = np.zeros_like(example["picture"])
    instantiate(example["mandelbrot"], compiled=False)(View(twin), 128, 96, 0.025, 100)
    assert np.mean(example["picture"] != twin) < 0.02


def test_two_lanes_of_the_text(example):
    found = example["escape_time"](np.float32([0.0, 1.0]), np.float32([0.0, 1.0]), 100)
    assert found.tolist() == [100, 2]
