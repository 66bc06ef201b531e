r"""Point light: the same intensity in every direction, from one point.

.. math:: E(x) = I \cos\theta / |x - x_\text{light}|^2

A path cannot hit it, so it is always sampled as a light. It sits at the origin of its node.

Source: PBR4 section 12.2.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from alight.core.constants import INV_FOUR_PI, PI
from alight.core.field_types import Color, Triple
from alight.core.spec import Light
from alight.core.vec import gather_vec3
from alight.core.warps import square_to_uniform_sphere
from alight.lights.at_point import way_to
from alight.lights.tables import STRIDE, LightSample, from_point
from lanewise.jit import kernel
from lanewise.simd import lanes, lanes_mask, lanes_vec3


class Point(Light):
    """Isotropic point light.

    Parameters
    ----------
    intensity : Color, W/sr, default 1
        Radiant intensity; not changed by a scale of the node.
    """

    type: Literal["point"] = "point"
    intensity: Color = (1.0, 1.0, 1.0)


EXAMPLES = (Point(), Point(intensity=(10.0, 5.0, 0.0)), Point(intensity=0.0))


#: Rays cannot hit it, so every mode finds it by light sampling.
DELTA = True


def place(spec: Point, to_world: np.ndarray) -> tuple[Triple, np.ndarray]:
    """Colour, and the position in the world, metres."""
    return spec.intensity, to_world[:3, 3]


def power(luminance: float, area: float, radius: float) -> float:
    """Emitted power in W: the intensity over the whole sphere."""
    return 4.0 * PI * luminance


def cone(spec: Point) -> tuple[float, float]:
    """Half angle of the directions that it faces, and how far beyond them it is dark, radians."""
    return PI, 0.0


@kernel
def sample(scene, index, p, u, u2):
    """The one direction to the light; see `alight.lights.area.sample`."""
    wi, distance, falling = way_to(gather_vec3(scene.lights.data, index * STRIDE + 4) - p)
    one = lanes(1.0)
    return LightSample(
        wi=wi,
        distance=distance,
        radiance=lanes_vec3(1.0) * falling,
        pdf=one,
        delta=lanes_mask(True),
        cosine=one,
        error=lanes(0.0),
    )


@kernel
def emit(scene, index, u2, v2):
    """A ray in any direction; see `alight.lights.model.LightModel`."""
    p = gather_vec3(scene.lights.data, index * STRIDE + 4)
    flux = lanes_vec3(1.0 / INV_FOUR_PI)
    return from_point(p, square_to_uniform_sphere(v2), flux, lanes(INV_FOUR_PI))


@kernel
def emit_pdf(scene, index, d):
    """Density of `emit` per steradian."""
    return lanes(INV_FOUR_PI)
