r"""Gaussian filter, lowered so that it reaches 0 at the radius.

.. math:: f(x, y) = g(x)\, g(y), \qquad
    g(x) = \max\bigl(0,\; e^{-x^2 / 2\sigma^2} - e^{-r^2 / 2\sigma^2}\bigr)

Source: PBR4 section 8.8.1.
"""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from alight.core.spec import Filter, FilterRadius
from alight.filters.inverse_cdf import sample_separable, tabulate


class Gaussian(Filter):
    """Bell curve.

    Parameters
    ----------
    stddev : float in [0.1, 16], pixels, default 0.5
        Standard deviation of the curve before it is cut off.
    radius : float in [0.1, 16], pixels, default 2
        Distance at which the weight reaches 0.
    """

    largest_weight: ClassVar[float | None] = 1.0
    type: Literal["gaussian"] = "gaussian"
    stddev: FilterRadius = 0.5
    radius: FilterRadius = 2.0


EXAMPLES = (Gaussian(), Gaussian(stddev=1.0, radius=3.0), Gaussian(stddev=4.0, radius=1.0))


def factor(spec, x):
    """g(x) of the formula above, for distances within the radius."""
    floor = np.exp(-0.5 * (spec.radius / spec.stddev) ** 2)
    return np.exp(-0.5 * (x / spec.stddev) ** 2) - floor


def value(spec, x, y):
    """The filter."""
    return np.maximum(factor(spec, x), 0.0) * np.maximum(factor(spec, y), 0.0)


def pack(spec):
    """Table of the kernel, see `inverse_cdf`."""
    return tabulate(lambda x: factor(spec, x), spec.radius)


sample = sample_separable
