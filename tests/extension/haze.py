r"""A user's medium, one file: haze that gets thinner with height.

.. math:: \rho(y) = e^{-y / h}, \qquad
    D(t) = \int_0^t \rho = \rho(y_0) \frac{h}{d_y} \left(1 - e^{-t d_y / h}\right)

Distances are chosen as in a homogeneous medium, with D in the place of t.
"""

from typing import Literal

import numpy as np

from alight.core.field_types import Positive
from alight.core.maths import exp, log
from alight.core.vec import Vec3, gather_vec3
from alight.media.coefficients import Coefficients
from alight.media.tables import (
    ALBEDO,
    EXTINCTION,
    FARTHEST,
    LARGEST,
    STRIDE,
    Crossing,
    Flight,
    decay,
    pick,
    share,
)
from lanewise.jit import kernel
from lanewise.simd import absolute, gather, lanes, lanes_vec3, maximum, minimum, where


class Haze(Coefficients):
    """Density that falls with the height above y = 0.

    Parameters
    ----------
    height : float > 0, metres, default 1
        Over which it falls to 1/e.
    """

    type: Literal["haze"] = "haze"
    height: Positive = 1.0


EXAMPLES = (Haze(), Haze(sigma_t=(2.0, 1.0, 0.5), albedo=0.9, height=0.3), Haze(height=50.0))


def pack(spec: Haze, packer) -> None:
    """The height, where grids have their largest density."""
    packer.data[LARGEST] = spec.height


def density_at(spec: Haze, points: np.ndarray) -> np.ndarray:
    """Factor of the coefficients."""
    return np.exp(-points[:, 1] / spec.height)


@kernel
def rate(scene, segment):
    """Density at the origin, and what it falls by per metre, logarithmically; never quite 0."""
    per_height = 1.0 / maximum(gather(scene.media.data, segment.medium * STRIDE + LARGEST), 1e-30)
    falls = segment.d.y * per_height
    falls = where(absolute(falls) < 1e-4 * per_height, 1e-4 * per_height, falls)
    return exp(minimum(-segment.o.y * per_height, 80.0)), falls


@kernel
def depth(density, falls, t):
    """The integral D(t)."""
    return density * (1.0 - exp(minimum(-t * falls, 80.0))) / falls


@kernel
def fly(scene, segment, u, active):
    """A `Flight` to the surface at the end of a `Segment`."""
    extinction = gather_vec3(scene.media.data, segment.medium * STRIDE + EXTINCTION)
    chosen = pick(extinction, segment.channel)
    density, falls = rate(scene, segment)
    whole = depth(density, falls, minimum(segment.length, FARTHEST))
    wanted = -log(1.0 - u) / maximum(chosen, 1e-30)
    scattered = active & (wanted < whole) & (chosen > 0.0)
    left = maximum(1.0 - wanted * falls / density, 1e-30)
    t = where(scattered, minimum(-log(left) / falls, segment.length), segment.length)
    reached = where(scattered, wanted, whole)
    passed = decay(extinction, chosen, reached)
    factor = where(scattered, passed * share(extinction, chosen), passed)
    light = where(scattered, 1.0, exp(chosen * reached))
    albedo = gather_vec3(scene.media.data, segment.medium * STRIDE + ALBEDO)
    return Flight(scattered, t, factor, lanes_vec3(1.0) * light, albedo)


@kernel
def cross(scene, segment, active):
    """A `Crossing` along the `Segment` of a shadow ray."""
    extinction = gather_vec3(scene.media.data, segment.medium * STRIDE + EXTINCTION)
    density, falls = rate(scene, segment)
    reached = depth(density, falls, minimum(segment.length, FARTHEST))
    passed = Vec3(
        exp(-extinction.x * reached), exp(-extinction.y * reached), exp(-extinction.z * reached)
    )
    return Crossing(passed, lanes_vec3(1.0), lanes(1.0))
