r"""Area light: a finite shape whose surface emits the same radiance in every direction.

.. math:: L_e(x, \omega) = L(x) \quad \text{if } \omega \cdot n_g > 0, \text{ else } 0

It emits on the side of the normal only, and its shape scatters light with its BSDF like any other.
A texture makes the radiance vary over the shape; points are chosen by it, see
`alight.lights.area_map`.

Source: PBR4 section 12.4.
"""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from alight.core.constants import PI
from alight.core.field_types import RadianceTexture, Triple
from alight.core.spec import Light, Texture, largest_channel
from alight.lights.area_radiance import emitted_color, point_pdf, sample_point
from alight.lights.tables import LightSample
from lanewise.jit import kernel
from lanewise.simd import lanes_mask, lanes_vec3, where


class Area(Light):
    """Emission of the shape on the same node.

    Parameters
    ----------
    radiance : RadianceTexture, W/(m^2 sr), default 1
        Emitted radiance: a colour, or a texture over the shape.
    """

    placement: ClassVar[Literal["node", "shape", "environment"]] = "shape"
    type: Literal["area"] = "area"
    radiance: RadianceTexture = (1.0, 1.0, 1.0)

    def largest_radiance(self) -> float | None:
        """Bound of the radiance that it emits."""
        return largest_channel(self.radiance)


EXAMPLES = (Area(), Area(radiance=(18.0, 14.0, 7.0)), Area(radiance=0.0))

#: Rays hit its shape.
DELTA = False

#: Points are chosen by its texture.
IS_MAPPED = True


def place(spec: Area, to_world: np.ndarray) -> tuple[Triple, np.ndarray]:
    """Colour, 1 below a texture; its shape has the place."""
    color = (1.0, 1.0, 1.0) if texture(spec) else mean_color(spec)
    return color, np.zeros(3)


def texture(spec: Area) -> Texture | None:
    """The texture of its radiance; its values take the place of the colour."""
    if isinstance(spec.radiance, Texture) and spec.radiance.varies:
        return spec.radiance
    return None


def mean_color(spec: Area) -> Triple:
    """Mean radiance over the square of (u, v)."""
    if isinstance(spec.radiance, str):
        raise ValueError(f"the texture name {spec.radiance!r} must be resolved before compiling")
    return spec.radiance.mean() if isinstance(spec.radiance, Texture) else spec.radiance


def power(luminance: float, area: float, radius: float) -> float:
    """Emitted power in W: the cosine integrates to pi over the hemisphere."""
    return PI * area * luminance


@kernel
def sample(scene, index, p, u, u2):
    """Choose a point of an area light.

    Parameters
    ----------
    scene : namedtuple
        With the fields `shapes` and `lights`.
    index : uint32
        The light.
    p : Vec3
        Where it is seen from.
    u, u2
        Uniform in [0, 1): one number and a pair.

    Returns
    -------
    LightSample
        Without the probability of choosing this light; radiance over the light's colour (which the
        caller multiplies), 0 on the dark side.
    """
    s, color = sample_point(scene, index, p, u, u2)
    bright = where(s.cosine > 0.0, color, lanes_vec3(0.0))
    return LightSample(
        wi=s.wi,
        distance=s.distance,
        radiance=bright,
        pdf=s.pdf,
        delta=lanes_mask(False),
        cosine=s.cosine,
        error=s.error,
    )


@kernel
def pdf(scene, index, p, hit):
    """Density of `sample` per solid angle at a `ShapeHit`; 0 on the dark side."""
    density = point_pdf(scene, index, p, hit)
    return where(hit.cosine > 0.0, density, 0.0)


@kernel
def emitted(scene, index, surface, wo):
    """Radiance on the outer side: the same in all directions."""
    return emitted_color(scene, index, surface)
