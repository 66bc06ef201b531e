r"""Subsurface scattering: skin, wax, marble, milk; light enters, is scattered inside, and leaves.

.. math::
    \text{from outside:}\quad f(\omega_o, \omega_i) &= \begin{cases}
        \dfrac{F D\, G_1(\omega_o) G_1(\omega_i)}{4 \cos\theta_o \cos\theta_i}
            & \omega_i \text{ outside} \\[1ex]
        T(\cos\theta_o) / \pi & \omega_i \text{ inside}
    \end{cases} \\
    \text{from inside:}\quad f(\omega_o, \omega_i) &=
        \frac{T(\cos\theta_i)}{\pi\,\bar T}, \qquad \bar T = \int_0^1 2 \mu\, T(\mu)\, d\mu

These formulas describe the surface only. A coat of GGX facets reflects the part E of the light from
a direction; the rest, T = 1 - E, enters the body with the distribution of a matte surface, and
leaves it in the same way. With index 1 there is no coat. In between, paths take a random walk
through the body (`alight.integrators.interiors.body_walk`), which scatters light equally in all
directions, with the mean free path `radius`.

The albedo alpha of one scattering is chosen so that a flat, deep body has the colour A that is
asked for, by van de Hulst's approximation

.. math::
    A = \frac{(1 - s)(1 - 0.139 s)}{1 + 1.17 s}, \qquad s = \sqrt{1 - \alpha} .

It differs from Chandrasekhar's exact albedo for diffuse light by less than 0.0025 everywhere. So
where a body is thick, and lit evenly over a few radii, it looks like `diffuse` of the same colour.

The shape has to be closed, with normals that point outwards. Inside out, it is black; where it is
open, light leaves by the opening and is scattered on and on. There are warnings of both. A radius
is measured in the world, however a node or an instance scales the shape. Shapes
inside are met, but light between them and the surface is not scattered, nor is that of a camera
inside.

Source: van de Hulst 1974, The spherical albedo of a planet covered with a homogeneous cloud layer;
Kulla and Conty 2017, Revisiting Physically Based Shading at Imageworks, for its inverse; Chiang,
Kutz and Burley 2016, Practical and Controllable Subsurface Scattering for Production Path Tracing,
for colour and radius; Kelemen and Szirmay-Kalos 2001 for the shape of the diffuse part.
"""

from __future__ import annotations

from collections import namedtuple
from functools import cache, lru_cache
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from alight.bsdfs.flags import REFLECTION, TRANSMISSION
from alight.bsdfs.microfacets.albedo_rows import STEPS
from alight.bsdfs.microfacets.albedo_table import place_of, read_plain_curve
from alight.bsdfs.microfacets.visible_facets import bounce, see_facets
from alight.bsdfs.model import Inside
from alight.bsdfs.rows import rows_at, rows_in_slots
from alight.core.constants import INV_PI
from alight.core.field_types import (
    SMOOTHEST,
    ColorTexture,
    IndexOfRefraction,
    Positive,
    PositiveColor,
    UnitInterval,
)
from alight.core.fresnel import fresnel_dielectric
from alight.core.microfacet import (
    FEATURES,
    Facets,
    facet_density,
    sample_visible_facet,
    visible_area,
)
from alight.core.parameters import loader, slots_of
from alight.core.spec import Bsdf
from alight.core.vec import Vec3, dot, normalize, quotient, reflect
from alight.core.warps import square_to_cosine_hemisphere
from alight.textures.fetch import PlainColor, Scalar, TexturedColor
from lanewise.jit import kernel
from lanewise.simd import absolute, lanes, lanes_u32, lanes_vec3, maximum, minimum, sqrt, where


class Subsurface(Bsdf):
    """Translucent body.

    Parameters
    ----------
    color : ColorTexture, default 0.8
        What a thick body reflects of the light that enters, each channel in [0, 1].
    radius : PositiveColor, metres, default (1, 0.35, 0.2) / 100
        Mean free path of light inside: how far it goes between two scatterings, on average.
    scale : float > 0, default 1
        Factor of `radius`.
    ior : float in [1, 5], default 1.4
        Index of refraction of the coat; 1 for none.
    roughness : float in [0, 1], default 0.5
        Root of the coat's alpha, which is at least 0.0001.
    """

    transmissive: ClassVar[bool] = True
    type: Literal["subsurface"] = "subsurface"
    color: ColorTexture = (0.8, 0.8, 0.8)
    radius: PositiveColor = (0.01, 0.0035, 0.002)
    scale: Positive = 1.0
    ior: IndexOfRefraction = 1.4
    roughness: UnitInterval = 0.5

    @property
    def matte(self) -> bool:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Whether its coat reflects less than 1/9 straight on."""
        return self.ior <= 2.0

    @property
    def alpha(self) -> float:
        """Roughness of the facets."""
        return max(self.roughness * self.roughness, SMOOTHEST)


EXAMPLES = (
    Subsurface(),
    Subsurface(color=(0.9, 0.5, 0.2), radius=(1.0, 0.3, 0.1), ior=1.0),
    Subsurface(color=1.0, radius=0.1, ior=1.0),
    Subsurface(color=(1.0, 0.0, 0.5), radius=1e-6, scale=10.0, ior=5.0, roughness=1.0),
    Subsurface(color=1.0, radius=100.0, ior=1.5, roughness=0.4),
)


# ---------------------------------------------------------------- laws, checked for every example


def is_lossless(spec: Subsurface) -> bool:
    """All light that arrives at the surface leaves it again; a coat's table errs by 0.05 %."""
    return spec.ior == 1.0


# ---------------------------------------------------------------- tables


class Row(NamedTuple):
    """A row of the table."""

    color: TexturedColor
    extinction: PlainColor
    eta: Scalar
    alpha: Scalar
    leaving: Scalar
    entering: Annotated[Any, rows_in_slots("entering")]


SLOTS = slots_of(Row)
_load_row = loader(Row)
#: leaving: 1 over the mean of T; coat: the `Rows` of T.
Params = namedtuple("SubsurfaceParams", "color eta facets leaving coat")


@cache
def _nodes_and_weights() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Of Gauss and Legendre's rule from 0 to 1: the same for all materials, and slow to find."""
    y, weight = np.polynomial.legendre.leggauss(512)
    return 0.5 * (y + 1.0), 0.5 * weight


@lru_cache(maxsize=64)
def entering_row(alpha: float, ior: float) -> tuple[NDArray[np.float32], float]:
    """T at `STEPS` cosines (j / (STEPS - 1))^4, and the mean of 2 mu T as kernels read it."""
    facets, root = Facets(alpha, alpha, 0.0), np.linspace(0.0, 1.0, STEPS)
    seen = see_facets(facets, np.maximum(root**4, 1e-6))
    through = 1.0 - bounce(seen, ior, refracts=False).reflected if ior > 1.0 else np.ones(STEPS)
    # mu = y^4: the cosine and its differential make 8 y^7.
    y, weight = _nodes_and_weights()
    mean = float(np.sum(weight * 8.0 * y**7 * np.interp(y, root, through)))
    return through.astype(np.float32), mean


def pack(spec: Subsurface, packer) -> None:
    """Fill the row of one material."""
    through, mean = entering_row(spec.alpha, spec.ior)
    packer.color("color", spec.color)
    packer.numbers("extinction", *(1.0 / (spec.scale * radius) for radius in spec.radius))
    packer.numbers("eta", spec.ior)
    packer.numbers("alpha", spec.alpha)
    packer.numbers("leaving", 1.0 / mean)
    packer.curve("entering", through)
    packer.numbers("last_entering", 0)


def features(spec: Subsurface) -> tuple[str, ...]:
    """What must be compiled for this material beyond the model's usual path."""
    return (FEATURES["ggx"],)


@kernel
def load(scene, base, surface):
    """The parameters at a point of a surface."""
    row = _load_row(scene, base, surface)
    facets = Facets(row.alpha, row.alpha, lanes(0.0))
    coat = rows_at(row.entering, lanes(0.0), STEPS)
    return Params(row.color, row.eta, facets, row.leaving, coat)


@kernel
def single_albedo(color):
    """Albedo of one scattering that gives a deep body this colour."""
    A = minimum(maximum(color, 0.0), 1.0)
    s = 4.09712 + 4.20863 * A - sqrt(9.59217 + A * (41.6808 + A * 17.7126))
    return minimum(maximum(1.0 - s * s, 0.0), 1.0)


@kernel
def inside(scene, base, surface):
    """The body below a point of a surface."""
    row = _load_row(scene, base, surface)
    albedo = Vec3(
        single_albedo(row.color.x), single_albedo(row.color.y), single_albedo(row.color.z)
    )
    return Inside(row.extinction, albedo)


# ---------------------------------------------------------------- scattering


@kernel
def _entering(params, cosine):
    """T: what the coat leaves to the body."""
    return read_plain_curve(params.coat, lanes_u32(0), place_of(cosine))


@kernel
def evaluate(params, wo, wi):
    """(f cos theta_i, pdf per steradian)."""
    outside = wo.z > 0.0
    reflects, enters = outside & (wi.z > 0.0), outside & (wi.z < 0.0)
    leaves = (wo.z < 0.0) & (wi.z > 0.0)
    cosine = INV_PI * absolute(wi.z)
    # The coat. Elsewhere, the overhead direction replaces others; the result is not used.
    up = Vec3(0.0, 0.0, 1.0)
    through = _entering(params, absolute(wo.z))
    wo, to = where(reflects, wo, up), where(reflects, wi, up)
    wm = normalize(wo + to)
    density = 0.25 * facet_density(params.facets, wm) / visible_area(params.facets, wo)
    fresnel, _ = fresnel_dielectric(minimum(maximum(dot(wo, wm), 0.0), 1.0), params.eta)
    masking = to.z / visible_area(params.facets, to)
    coat = fresnel * masking * density
    out = _entering(params, absolute(wi.z)) * params.leaving * cosine
    f = where(reflects, coat, where(enters, through * cosine, where(leaves, out, 0.0)))
    of_coat, of_body = (1.0 - through) * density, through * cosine
    pdf = where(reflects, of_coat, where(enters, of_body, where(leaves, cosine, 0.0)))
    return lanes_vec3(1.0) * f, pdf


@kernel
def sample(params, wo, u, u2):
    """(wi, f cos theta_i / pdf, pdf per steradian, flags): the coat or the body, chosen by u."""
    outside = wo.z > 0.0
    reflects = outside & (u >= _entering(params, wo.z))
    above = where(reflects, wo, Vec3(0.0, 0.0, 1.0))
    glossy = normalize(reflect(above, sample_visible_facet(params.facets, above, u2)))
    matte = square_to_cosine_hemisphere(u2)
    matte = where(outside, -matte, matte)
    wi = where(reflects, glossy, matte)
    # A coat's sample below the horizon is none of those that enter: in the surface it fails.
    wi = where(reflects & (wi.z <= 0.0), Vec3(1.0, 0.0, 0.0), wi)
    f_cos, pdf = evaluate(params, wo, wi)
    stays = reflects | (wo.z == 0.0)
    flags = where(stays, lanes_u32(REFLECTION), lanes_u32(TRANSMISSION))
    return wi, quotient(f_cos, pdf), pdf, flags


@kernel
def albedo(params):
    """Reflected part of light that arrives at right angles."""
    through = _entering(params, lanes(1.0))
    return params.color * through + (1.0 - through)
