r"""Box filter: every sample within `radius` counts the same.

.. math:: f(x, y) = 1 \quad \text{if } |x|, |y| \le r

Radius 0.5 is the mean over the pixel's own square.

Source: PBR4 section 8.8.1.
"""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from alight.core.field_types import FilterRadius
from alight.core.spec import Filter
from lanewise.jit import kernel
from lanewise.simd import absolute, lanes, where


class Box(Filter):
    """Mean over a square.

    Parameters
    ----------
    radius : float in [0.1, 16], pixels, default 0.5
        Half the side of the square.
    """

    largest_weight: ClassVar[float | None] = 1.0
    type: Literal["box"] = "box"
    radius: FilterRadius = 0.5


EXAMPLES = (Box(), Box(radius=1.5), Box(radius=0.1))


def pack(spec):
    """Table of the kernel: the radius."""
    return [spec.radius]


def value(spec, x, y):
    """The filter."""
    return np.where(np.maximum(np.abs(x), np.abs(y)) <= spec.radius, 1.0, 0.0)


@kernel
def sample(table, u2):
    """Offsets dx, dy in [-r, r) and the weight 1."""
    r = table[0]
    return r * (2.0 * u2[0] - 1.0), r * (2.0 * u2[1] - 1.0), lanes(1.0)


@kernel
def profile(table, x):
    """The filter along one axis, with the integral 1."""
    return where(absolute(x) <= table[0], 0.5 / table[0], 0.0)


@kernel
def reach(table):
    """Distance beyond which the profile is 0, pixels."""
    return table[0]
