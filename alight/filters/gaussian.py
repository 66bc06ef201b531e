r"""Gaussian filter, lowered so that it reaches 0 at the radius.

.. math:: f(x, y) = g(x)\, g(y), \qquad
    g(x) = \max\bigl(0,\; e^{-x^2 / 2\sigma^2} - e^{-r^2 / 2\sigma^2}\bigr)

Source: PBR4 section 8.8.1.
"""

from __future__ import annotations

import math
from typing import ClassVar, Literal

import numpy as np

from alight.core.field_types import FilterRadius
from alight.core.maths import exp
from alight.core.spec import Filter
from alight.filters.inverse_cdf import LENGTH, sample_separable, tabulate
from lanewise.jit import kernel
from lanewise.simd import absolute, maximum, where

#: Where, behind the table of `inverse_cdf`, radius, -1 / (2 stddev^2), floor and 1 / integral are.
NUMBERS = LENGTH


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
    """Table of the kernels, see `inverse_cdf` and `NUMBERS`."""
    table = tabulate(lambda x: factor(spec, x), spec.radius)
    floor = np.exp(-0.5 * (spec.radius / spec.stddev) ** 2)
    bell = np.sqrt(2.0 * np.pi) * spec.stddev * math.erf(spec.radius / spec.stddev / np.sqrt(2.0))
    whole = bell - 2.0 * spec.radius * floor
    return np.append(table, [spec.radius, -0.5 / spec.stddev**2, floor, 1.0 / whole])


sample = sample_separable


@kernel
def profile(table, x):
    """The filter along one axis, with the integral 1."""
    g = (exp(table[NUMBERS + 1] * x * x) - table[NUMBERS + 2]) * table[NUMBERS + 3]
    return where(absolute(x) <= table[NUMBERS], maximum(g, 0.0), 0.0)


@kernel
def reach(table):
    """Distance beyond which the profile is 0, pixels."""
    return table[NUMBERS]
