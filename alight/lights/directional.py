r"""Directional light: parallel rays from infinity, as from a far sun.

.. math:: E(x) = E_\perp \cos\theta

Light travels along the local +z axis of its node. A path cannot hit it, so it is always sampled as
a light.

Source: PBR4 section 12.3; axis as in Mitsuba 3.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from alight.core.constants import INFINITY, PI
from alight.core.field_types import Color, Triple
from alight.core.spec import Light
from alight.core.vec import gather_vec3
from alight.lights.ball import across_the_ball
from alight.lights.tables import STRIDE, Emission, LightSample
from lanewise.jit import kernel
from lanewise.simd import lanes, lanes_mask, lanes_u32, lanes_vec3


class Directional(Light):
    """Parallel light along +z of its node.

    Parameters
    ----------
    irradiance : Color, W/m^2, default 1
        On a surface that faces the light.
    """

    type: Literal["directional"] = "directional"
    irradiance: Color = (1.0, 1.0, 1.0)


EXAMPLES = (Directional(), Directional(irradiance=(3.0, 2.0, 1.0)), Directional(irradiance=0.0))


#: Rays cannot hit it, so every mode finds it by light sampling.
DELTA = True
INFINITELY_FAR = True


def place(spec: Directional, to_world: np.ndarray) -> tuple[Triple, np.ndarray]:
    """Colour, and the unit direction to the light."""
    axis = to_world[:3, 2]
    return spec.irradiance, -axis / np.linalg.norm(axis)


def power(luminance: float, area: float, radius: float) -> float:
    """W that enter a scene of bounding radius `radius`, through pi r^2."""
    return PI * radius * radius * luminance


@kernel
def sample(scene, index, p, u, u2):
    """The one direction to the light; see `alight.lights.area.sample`."""
    one = lanes(1.0)
    # A lone light has a scalar index: what it gives must be lanes all the same.
    wi = lanes_vec3(0.0) + gather_vec3(scene.lights.data, index * STRIDE + 4)
    return LightSample(
        wi=wi,
        distance=INFINITY * one,
        radiance=lanes_vec3(1.0),
        pdf=one,
        delta=lanes_mask(True),
        cosine=one,
        error=lanes(0.0),
    )


@kernel
def emit(scene, index, u2, v2):
    """A ray into the scene's ball; see `alight.lights.model.LightModel`."""
    d = lanes_vec3(0.0) - gather_vec3(scene.lights.data, index * STRIDE + 4)
    p, area = across_the_ball(scene, d, u2)
    one = lanes(1.0)
    return Emission(
        p=p,
        n=d,
        o=p,
        d=d,
        flux=lanes_vec3(1.0) * area,
        light=lanes_u32(0),
        prim=lanes_u32(0),
        choice=one,
        pdf_position=1.0 / area,
        pdf_direction=one,
        delta_position=lanes_mask(False),
        delta_direction=lanes_mask(True),
    )


@kernel
def emit_pdf(scene, index, d):
    """1: there is one direction."""
    return lanes(1.0)
