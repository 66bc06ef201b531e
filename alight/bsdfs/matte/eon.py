r"""Energy-preserving Oren-Nayar (EON): grooves that lose no light, for clay, plaster and the Moon.

.. math::
    f &= \frac{\rho}{\pi} A \left(1 + r \frac{s}{t}\right) + \frac{\rho_m}{\pi}
        \frac{(1 - E(\omega_o)) (1 - E(\omega_i))}{1 - \bar E}, &
    A &= \frac{1}{1 + (1/2 - 2 / (3 \pi))\, r}, \\
    s &= \omega_o \cdot \omega_i - \cos\theta_o \cos\theta_i, &
    t &= \begin{cases} \max(\cos\theta_o, \cos\theta_i) & s > 0 \\ 1 & s \le 0 \end{cases}, \\
    E(\theta) &= A \left(1 + \frac{r}{\pi} G(\theta)\right), &
    G &= \sin\theta (\theta - \sin\theta \cos\theta)
        + \frac{2}{3} (\tan\theta\, (1 - \sin^3\theta) - \sin\theta), \\
    \bar E &= A \left(1 + \left(\frac{2}{3} - \frac{28}{15 \pi}\right) r\right), &
    \rho_m &= \frac{\rho^2 \bar E}{1 - \rho\,(1 - \bar E)}

The first part is light that met one wall, E what it carries away in all, and the second part is
what met more of them: it takes on the colour of each. White loses nothing at any roughness r, and
r = 0 is Lambert's law. Reciprocal; black from behind.

Source: Portsmouth, Kutz and Hill 2025, EON: A practical energy-preserving rough diffuse BRDF (JCGT
14:1), equations 14 to 24; after Oren and Nayar 1994 and Fujii. Directions are sampled by the cosine
alone.
"""

from __future__ import annotations

from typing import ClassVar, Literal, NamedTuple

from alight.bsdfs.flags import REFLECTION
from alight.core.constants import INV_PI
from alight.core.field_types import ColorTexture, UnitTexture
from alight.core.maths import arccos
from alight.core.parameters import loader, slots_of
from alight.core.spec import Bsdf
from alight.core.vec import Vec3
from alight.core.warps import square_to_cosine_hemisphere
from alight.textures.fetch import TexturedColor, TexturedScalar
from lanewise.jit import kernel
from lanewise.records import replace
from lanewise.simd import lanes_u32, lanes_vec3, maximum, minimum, sqrt, where


class Eon(Bsdf):
    """Rough matte surface that loses no light.

    Parameters
    ----------
    reflectance : ColorTexture, default 0.5
        Albedo of the grooves' walls, each channel in [0, 1].
    roughness : UnitTexture, default 0.5
        The r of the model; 1 are the steepest grooves.
    """

    one_sided: ClassVar[bool] = True
    matte: ClassVar[bool] = True
    type: Literal["eon"] = "eon"
    reflectance: ColorTexture = (0.5, 0.5, 0.5)
    roughness: UnitTexture = 0.5


EXAMPLES = (
    Eon(),
    Eon(reflectance=1.0, roughness=0.0),
    Eon(reflectance=1.0, roughness=0.3),
    Eon(reflectance=1.0, roughness=0.6),
    Eon(reflectance=(0.9, 0.5, 0.1), roughness=1.0),
)


# ---------------------------------------------------------------- laws, checked for every example


def is_lossless(spec: Eon) -> bool:
    """White at every roughness."""
    return spec.reflectance == (1.0, 1.0, 1.0)


def is_reciprocal(spec: Eon) -> bool:
    """f(wo, wi) = f(wi, wo)."""
    return True


# ---------------------------------------------------------------- tables


class Params(NamedTuple):
    """A row of the table."""

    reflectance: TexturedColor
    roughness: TexturedScalar


SLOTS = slots_of(Params)
_load_row = loader(Params)


def pack(spec: Eon, packer) -> None:
    """Fill the row of one material."""
    packer.color("reflectance", spec.reflectance)
    packer.scalar("roughness", spec.roughness)


@kernel
def load(scene, base, surface):
    """The parameters at a point of a surface."""
    row = _load_row(scene, base, surface)
    return replace(row, roughness=minimum(maximum(row.roughness, 0.0), 1.0))


# ---------------------------------------------------------------- scattering

_C1, _C2 = 0.287793409, 0.0724882124


@kernel
def _missing(a, r, cosine):
    """1 - E: what does not leave after one wall, towards a direction."""
    sine = sqrt(maximum(1.0 - cosine * cosine, 0.0))
    # tan (1 - sin^3), written so that it is finite at the horizon.
    steep = sine * cosine * (1.0 + sine + sine * sine) / (1.0 + sine)
    g = sine * (arccos(cosine) - sine * cosine) + 0.6666666667 * (steep - sine)
    return maximum(1.0 - a * (1.0 + r * INV_PI * g), 0.0)


@kernel
def _weight(params, wo, wi):
    """pi f for two directions above the surface."""
    r = params.roughness
    a = 1.0 / (1.0 + _C1 * r)
    s = wo.x * wi.x + wo.y * wi.y
    t = where(s > 0.0, maximum(maximum(wo.z, wi.z), 1e-9), 1.0)
    once = a * (1.0 + r * s / t)
    # 1 - mean of E; without grooves nothing is missing.
    mean = a * (_C1 - _C2) * r
    several = _missing(a, r, wo.z) * _missing(a, r, wi.z) / maximum(mean, 1e-9)
    rho = params.reflectance
    left = lanes_vec3(1.0) - rho * mean
    return rho * once + rho * rho * ((1.0 - mean) * several) / left


@kernel
def evaluate(params, wo, wi):
    """(f cos theta_i, pdf per steradian)."""
    above = (wo.z > 0.0) & (wi.z > 0.0)
    up = Vec3(0.0, 0.0, 1.0)
    pdf = where(above, INV_PI * wi.z, 0.0)
    return _weight(params, where(above, wo, up), where(above, wi, up)) * pdf, pdf


@kernel
def sample(params, wo, u, u2):
    """(wi, f cos theta_i / pdf, pdf per steradian, flags)."""
    wi = square_to_cosine_hemisphere(u2)
    above = (wo.z > 0.0) & (wi.z > 0.0)
    up = Vec3(0.0, 0.0, 1.0)
    # The cosine and 1 / pi cancel.
    weight = _weight(params, where(above, wo, up), where(above, wi, up))
    pdf = where(above, INV_PI * wi.z, 0.0)
    return wi, where(above, weight, 0.0), pdf, lanes_u32(REFLECTION)


@kernel
def albedo(params):
    """Reflected part of light from all around."""
    mean = (_C1 - _C2) * params.roughness / (1.0 + _C1 * params.roughness)
    rho = params.reflectance
    several = rho * rho * ((1.0 - mean) * mean) / (lanes_vec3(1.0) - rho * mean)
    return rho * (1.0 - mean) + several
