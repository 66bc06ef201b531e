r"""Mitchell and Netravali's cubic filter: sharp, with small negative lobes.

.. math::
    6 m(x) = \begin{cases}
      (12 - 9B - 6C) |x|^3 + (-18 + 12B + 6C) |x|^2 + (6 - 2B) & |x| < 1 \\
      (-B - 6C) |x|^3 + (6B + 30C) |x|^2 + (-12B - 48C) |x| + (8B + 24C) & 1 \le |x| < 2
    \end{cases}

with x in units of half the radius and f(x, y) = m(x) m(y).

Source: Mitchell and Netravali, Reconstruction filters in computer graphics, SIGGRAPH 1988;
PBR4 section 8.8.1.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from alight.core.field_types import FilterRadius, UnitInterval
from alight.core.spec import Filter
from alight.filters.inverse_cdf import LENGTH, sample_separable, tabulate
from lanewise.jit import kernel
from lanewise.simd import absolute, where

#: Where, behind the table of `inverse_cdf`, radius, B and C are.
NUMBERS = LENGTH


class Mitchell(Filter):
    """Cubic with negative lobes.

    Parameters
    ----------
    radius : float in [0.1, 16], pixels, default 2
        Distance at which the weight reaches 0.
    b, c : float in [0, 1], default 1/3
        The paper's parameters B (blur) and C (ringing).
    """

    type: Literal["mitchell"] = "mitchell"
    radius: FilterRadius = 2.0
    b: UnitInterval = 1.0 / 3.0
    c: UnitInterval = 1.0 / 3.0


EXAMPLES = (Mitchell(), Mitchell(b=0.0, c=0.5), Mitchell(b=1.0, c=0.0, radius=3.0))


def polynomial(x, b, c):
    """6 m(x) of the formula above, x in half radii."""
    x = np.abs(x)
    inner = ((12 - 9 * b - 6 * c) * x + (-18 + 12 * b + 6 * c)) * x**2 + (6 - 2 * b)
    outer = (((-b - 6 * c) * x + (6 * b + 30 * c)) * x + (-12 * b - 48 * c)) * x + (8 * b + 24 * c)
    return np.where(x < 1.0, inner, np.where(x < 2.0, outer, 0.0))


def sign_change(b, c):
    """Distance in half radii beyond which m < 0 (2 if it is nowhere).

    For |x| >= 1, 6 m(x) = (2 - x)^2 (B (2 - x) - 6 C (x - 1)); below it, m > 0 for all B and C
    in [0, 1] (m is linear in them, and positive at the four corners).
    """
    return (2 * b + 6 * c) / (b + 6 * c) if c > 0.0 else 2.0


def value(spec, x, y):
    """The filter, up to a factor."""
    half = 0.5 * spec.radius
    return polynomial(x / half, spec.b, spec.c) * polynomial(y / half, spec.b, spec.c)


def pack(spec):
    """Table of the kernels, see `inverse_cdf` and `NUMBERS`."""
    half = 0.5 * spec.radius
    change = half * sign_change(spec.b, spec.c)
    table = tabulate(lambda x: polynomial(x / half, spec.b, spec.c), spec.radius, change)
    return np.append(table, [spec.radius, spec.b, spec.c])


sample = sample_separable


@kernel
def profile(table, x):
    """The filter along one axis, with the integral 1: 6 m(x) has the integral 6 half radii."""
    radius, b, c = table[NUMBERS], table[NUMBERS + 1], table[NUMBERS + 2]
    x = absolute(x) * (2.0 / radius)
    inner = ((12.0 - 9.0 * b - 6.0 * c) * x + (-18.0 + 12.0 * b + 6.0 * c)) * x * x
    outer = ((-b - 6.0 * c) * x + (6.0 * b + 30.0 * c)) * x * x
    outer = outer - (12.0 * b + 48.0 * c) * x + (8.0 * b + 24.0 * c)
    m = where(x < 1.0, inner + (6.0 - 2.0 * b), where(x < 2.0, outer, 0.0))
    return m * (1.0 / 3.0) / radius


@kernel
def reach(table):
    """Distance beyond which the profile is 0, pixels."""
    return table[NUMBERS]
