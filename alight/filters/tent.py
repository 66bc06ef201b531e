r"""Tent filter: weights fall linearly from the centre.

.. math:: f(x, y) = \max(0, r - |x|) \max(0, r - |y|)

Source: PBR4 section 8.8.1 (there called triangle filter).
"""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from alight.core.field_types import FilterRadius
from alight.core.spec import Filter
from lanewise.jit import kernel
from lanewise.simd import absolute, lanes, maximum, sqrt, where


class Tent(Filter):
    """Linear fall-off.

    Parameters
    ----------
    radius : float in [0.1, 16], pixels, default 1
        Distance at which the weight reaches 0.
    """

    largest_weight: ClassVar[float | None] = 1.0
    type: Literal["tent"] = "tent"
    radius: FilterRadius = 1.0


EXAMPLES = (Tent(), Tent(radius=2.0), Tent(radius=0.5))


def pack(spec):
    """Table of the kernel: the radius."""
    return [spec.radius]


def value(spec, x, y):
    """The filter."""
    return np.maximum(spec.radius - np.abs(x), 0.0) * np.maximum(spec.radius - np.abs(y), 0.0)


@kernel
def sample(table, u2):
    """Offsets dx, dy by inversion of the distribution, and the weight 1."""
    return table[0] * _position(u2[0]), table[0] * _position(u2[1]), lanes(1.0)


@kernel
def _position(u):
    # F(x) = (1 + x)^2 / 2 on the left, its mirror image on the right.
    left = u < 0.5
    distance = 1.0 - sqrt(2.0 * where(left, u, 1.0 - u))
    return where(left, -distance, distance)


@kernel
def profile(table, x):
    """The filter along one axis, with the integral 1."""
    return maximum(table[0] - absolute(x), 0.0) / (table[0] * table[0])


@kernel
def reach(table):
    """Distance beyond which the profile is 0, pixels."""
    return table[0]
