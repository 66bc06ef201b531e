r"""Homogeneous medium: the same everywhere.

.. math:: T(t) = e^{-\sigma_t t}, \qquad p(t) = \sigma_t e^{-\sigma_t t}

Source: Beer's law; PBR4 sections 11.2 and 11.4.
"""

from __future__ import annotations

from typing import Literal, Self

import numpy as np

from alight.core.maths import exp, log
from alight.core.vec import Vec3, gather_vec3
from alight.media.coefficients import Coefficients
from alight.media.tables import (
    ALBEDO,
    EXTINCTION,
    FARTHEST,
    STRIDE,
    Crossing,
    Flight,
    decay,
    pick,
    share,
)
from alight.phases import FORWARD
from lanewise.jit import kernel
from lanewise.simd import lanes, lanes_vec3, maximum, minimum, where


class Homogeneous(Coefficients):
    """The same everywhere."""

    type: Literal["homogeneous"] = "homogeneous"

    def moved(self, shift: np.ndarray) -> Self:
        """It has no place."""
        return self


EXAMPLES = (
    Homogeneous(),
    Homogeneous(sigma_t=2.0, albedo=(0.9, 0.5, 0.1), phase=FORWARD),
    Homogeneous(sigma_a=(0.0, 0.1, 1.0), sigma_s=(1.0, 0.5, 0.0), scale=10.0),
    Homogeneous(sigma_a=0.3),
)


def pack(spec: Homogeneous, packer) -> None:
    """Nothing beyond the coefficients."""


def density_at(spec: Homogeneous, points: np.ndarray) -> np.ndarray:
    """1 everywhere."""
    return np.ones(len(points))


@kernel
def fly(scene, segment, u, active):
    """A `Flight` to the surface at the end of a `Segment`."""
    extinction = gather_vec3(scene.media.data, segment.medium * STRIDE + EXTINCTION)
    chosen = pick(extinction, segment.channel)
    t = -log(1.0 - u) / maximum(chosen, 1e-30)
    scattered = active & (t < segment.length) & (chosen > 0.0)
    distance = minimum(where(scattered, t, segment.length), FARTHEST)
    passed = decay(extinction, chosen, distance)
    factor = where(scattered, passed * share(extinction, chosen), passed)
    # Light sampling would have come all the way.
    light = where(scattered, 1.0, exp(chosen * distance))
    albedo = gather_vec3(scene.media.data, segment.medium * STRIDE + ALBEDO)
    return Flight(scattered, distance, factor, lanes_vec3(1.0) * light, albedo)


@kernel
def cross(scene, segment, active):
    """A `Crossing` along the `Segment` of a shadow ray."""
    extinction = gather_vec3(scene.media.data, segment.medium * STRIDE + EXTINCTION)
    distance = minimum(segment.length, FARTHEST)
    passed = Vec3(
        exp(-extinction.x * distance),
        exp(-extinction.y * distance),
        exp(-extinction.z * distance),
    )
    return Crossing(passed, lanes_vec3(1.0), lanes(1.0))
