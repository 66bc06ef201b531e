r"""A user's light that rays can hit, one file: a surface that shines the more the straighter.

.. math:: L_e(x, \omega) = L \cos^n\theta \quad \text{on the side of the normal}
"""

from typing import Annotated, ClassVar, Literal

import numpy as np

from alight.core.constants import PI
from alight.core.field_types import Color
from alight.core.fields import Interval
from alight.core.maths import pow
from alight.core.spec import Light
from alight.core.vec import dot, gather_vec3
from alight.lights.area import pdf as pdf
from alight.lights.shining import sample_shape
from alight.lights.tables import INFO, STRIDE, LightSample
from lanewise.jit import kernel
from lanewise.simd import gather, lanes_mask, lanes_vec3, maximum, where


class Beam(Light):
    """Emission of the shape on the same node, mostly along its normals.

    Parameters
    ----------
    radiance : Color, W/(m^2 sr), default 1
        Along the normal.
    exponent : float in [0, 50], default 4
        The n above.
    """

    placement: ClassVar[Literal["node", "shape", "environment"]] = "shape"
    type: Literal["beam"] = "beam"
    radiance: Color = (1.0, 1.0, 1.0)
    exponent: Annotated[float, Interval(0.0, 50.0)] = 4.0

    def largest_radiance(self) -> float | None:
        """Along the normal."""
        return max(self.radiance)


EXAMPLES = (Beam(), Beam(radiance=(3.0, 2.0, 1.0), exponent=20.0), Beam(radiance=0.0))

#: Rays hit its shape.
DELTA = False

#: Place of the exponent in the light's row.
EXPONENT = 4


def place(spec: Beam, to_world: np.ndarray):
    """Colour, and the exponent."""
    return spec.radiance, np.array([spec.exponent])


def mean_color(spec: Beam):
    """Of all that is emitted: the cosines integrate to 2 pi / (n + 2) in the place of pi."""
    r, g, b = (c * 2.0 / (spec.exponent + 2.0) for c in spec.radiance)
    return r, g, b


def power(luminance: float, area: float, radius: float) -> float:
    """Emitted power in W."""
    return PI * area * luminance


@kernel
def strength(scene, index, cosine):
    """Radiance over that along the normal."""
    return pow(maximum(cosine, 1e-9), gather(scene.lights.data, index * STRIDE + EXPONENT))


@kernel
def sample(scene, index, p, u, u2):
    """Choose a point of the shape; see `alight.lights.area.sample`."""
    info = scene.lights.info
    shape, start = gather(info, index * INFO + 1), gather(info, index * INFO + 3)
    s = sample_shape(scene.shapes, scene.lights.cdf, start, shape, p, u, u2)
    bright = where(s.cosine > 0.0, strength(scene, index, s.cosine), 0.0)
    radiance = lanes_vec3(1.0) * bright
    return LightSample(s.wi, s.distance, radiance, s.pdf, lanes_mask(False), s.cosine, s.error)


@kernel
def emitted(scene, index, surface, wo):
    """Radiance on the outer side."""
    color = gather_vec3(scene.lights.data, index * STRIDE)
    return color * strength(scene, index, dot(wo, surface.ng))
