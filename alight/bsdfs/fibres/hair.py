r"""Hair and fur: one fibre, seen from where its whole width is a point.

.. math::
    f \cos\theta_i = \sum_{p=0}^{3} M_p(\theta_o, \theta_i)\, A_p(h, \theta_o)\,
        N_p(\varphi_i - \varphi_o)

x is along the fibre, z the normal: theta is the height of a direction above the plane across the
fibre, phi its angle in that plane, and h = sin(gamma_o) = -wo_y / cos(theta_o) where between its
axis (0) and its rim (1) the fibre is met. p counts how often light has been inside: it is
mirrored (0), passes (1), comes back after one reflection inside (2), or after more (3).

- A_0 = F, A_1 = (1 - F)^2 T, A_2 = A_1 T F, and A_3 the rest of the series, with the Fresnel
  reflectance F at h and T = exp(-sigma_a 2 cos(gamma_t) / cos(theta_t)), sigma_a in units of one
  over the fibre's radius.
- M_p is d'Eon's lobe of variance v_p = v, v / 4, 4 v, 4 v. With a = cos(theta_o) cos(theta_i) / v
  it is exp(-a) I_0(a) exp(-d^2 / 2 v) / (v (1 - exp(-2 / v))), where d is the distance between wi
  and the mirrored wo once both are turned into one plane; nothing cancels then. Scales tilted by
  alpha turn theta_o by 2 alpha, -alpha and -4 alpha.
- N_p is a logistic distribution of scale s around 2 p gamma_t - 2 gamma_o + p pi, cut off at pi;
  N_3 is uniform.

A fibre that absorbs nothing loses no light. The same light is not seen from either end: h is where
the *viewer's* ray meets the fibre. Seen from inside, both directions are mirrored first.

Sources: Chiang, Bitterli, Tappan and Burley 2016, A practical and controllable hair and fur model
for production path tracing, Computer Graphics Forum 35(2), for the lobes, their scales and colours;
d'Eon et al. 2011, An energy-conserving hair reflectance model, for M_p, and 2013, Importance
sampling for physically-based hair fiber models, for its samples; Marschner et al. 2003, Light
scattering from human hair fibers; Abramowitz and Stegun 1964, 9.8.1 and 9.8.2, for I_0.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, NamedTuple, Self

from pydantic import model_validator

from alight.bsdfs.fibres.lobes import logistic, longitudinal, sample_logistic
from alight.bsdfs.flags import REFLECTION, TRANSMISSION
from alight.core.constants import INV_TWO_PI, PI, TWO_PI
from alight.core.field_types import Color, IndexOfRefraction, NonNegative, Reflectance
from alight.core.fields import Interval, invalid
from alight.core.frame import mirrored_if
from alight.core.fresnel import fresnel_dielectric
from alight.core.maths import arcsin, arctan2, exp, log, sincos, sincos_2pi
from alight.core.parameters import loader, slots_of
from alight.core.spec import Bsdf
from alight.core.vec import Vec3, quotient
from alight.textures.fetch import PlainColor, Scalar
from lanewise.jit import kernel
from lanewise.simd import (
    absolute,
    lanes,
    lanes_u32,
    lanes_vec3,
    maximum,
    minimum,
    sqrt,
    where,
)

#: What a unit of the two pigments absorbs: eumelanin (black, brown), pheomelanin (red, yellow).
EUMELANIN, PHEOMELANIN = (0.419, 0.697, 1.37), (0.187, 0.4, 1.05)

#: Eumelanin of brown hair, the default.
BROWN = 1.3

Roughness = Annotated[float, Interval(0.05, 1.0)]
Tilt = Annotated[float, Interval(-20.0, 20.0)]


class Hair(Bsdf):
    """One fibre of hair or fur; for `alight.shapes.curves`.

    At most one of `sigma_a`, `color` and the two pigments says what it absorbs; without any of them
    it is brown hair.

    Parameters
    ----------
    sigma_a : Color, optional
        Absorption coefficient, in units of one over the fibre's radius.
    color : Reflectance in (0, 1], optional
        Colour of much hair.
    eumelanin, pheomelanin : float >= 0, optional
        Concentrations of the dark and of the red pigment: blond hair has some 0.3 of the first,
        brown 1.3, black 8.
    beta_m, beta_n : float in [0.05, 1], defaults 0.3
        Roughness along the fibre and around it.
    alpha : float in [-20, 20], degrees, default 2
        Tilt of the scales, towards the root.
    ior : float in [1, 5], default 1.55
        Index of refraction.
    """

    transmissive = True
    type: Literal["hair"] = "hair"
    sigma_a: Color | None = None
    color: Reflectance | None = None
    eumelanin: NonNegative | None = None
    pheomelanin: NonNegative | None = None
    beta_m: Roughness = 0.3
    beta_n: Roughness = 0.3
    alpha: Tilt = 2.0
    ior: IndexOfRefraction = 1.55

    @model_validator(mode="after")
    def _has_one_color(self) -> Self:
        pigments = self.eumelanin is not None or self.pheomelanin is not None
        given = [self.sigma_a is not None, self.color is not None, pigments]
        if sum(given) > 1:
            raise invalid("takes one of sigma_a, color, and eumelanin with pheomelanin")
        if self.color is not None and min(self.color) <= 0.0:
            raise invalid(f"color must be in (0, 1], got {list(self.color)}: 0 absorbs without end")
        return self

    @property
    def absorption(self) -> tuple[float, float, float]:
        """sigma_a, whatever says it."""
        if self.sigma_a is not None:
            return self.sigma_a
        if self.color is not None:
            red, green, blue = (absorption_of(c, self.beta_n) for c in self.color)
            return red, green, blue
        eumelanin = self.eumelanin or 0.0
        if self.eumelanin is None and self.pheomelanin is None:
            eumelanin = BROWN
        red, green, blue = (
            eumelanin * e + (self.pheomelanin or 0.0) * p
            for e, p in zip(EUMELANIN, PHEOMELANIN, strict=True)
        )
        return red, green, blue


def absorption_of(color: float, beta_n: float) -> float:
    """What a fibre absorbs if much hair is of that colour: Chiang et al. 2016, equation 9."""
    b = beta_n
    fit = 5.969 - 0.215 * b + 2.532 * b**2 - 10.73 * b**3 + 5.574 * b**4 + 0.245 * b**5
    return (math.log(color) / fit) ** 2


EXAMPLES = (
    Hair(),
    Hair(sigma_a=0.0, beta_m=0.4, beta_n=0.5, alpha=0.0),
    Hair(color=(0.8, 0.5, 0.2), beta_m=0.6, beta_n=0.9, alpha=-3.0, ior=1.4),
)


# ---------------------------------------------------------------- laws, checked for every example


def is_lossless(spec: Hair) -> bool:
    """What is not absorbed leaves again."""
    return spec.absorption == (0.0, 0.0, 0.0)


def is_reciprocal(spec: Hair) -> bool:
    """The viewer's ray alone says where the fibre is met."""
    return False


def relative_ior(spec: Hair) -> float:
    """Light leaves into the medium that it came from."""
    return 1.0


def features(spec: Hair) -> tuple[str, ...]:
    """It is not the same all around the normal."""
    return ("anisotropic",)


# ---------------------------------------------------------------- tables


class Params(NamedTuple):
    """A row of the table: absorption, v, s, sin and cos of alpha, and eta."""

    sigma_a: PlainColor
    variance: Scalar
    scale: Scalar
    sine: Scalar
    cosine: Scalar
    eta: Scalar


SLOTS = slots_of(Params)
load = loader(Params)


def pack(spec: Hair, packer) -> None:
    """Fill the row of one material: scales of Chiang et al. 2016, equations 7 and 8."""
    m, n, alpha = spec.beta_m, spec.beta_n, math.radians(spec.alpha)
    packer.numbers("sigma_a", *spec.absorption)
    packer.numbers("variance", (0.726 * m + 0.812 * m**2 + 3.7 * m**20) ** 2)
    packer.numbers("scale", math.sqrt(math.pi / 8.0) * (0.265 * n + 1.194 * n**2 + 5.372 * n**22))
    packer.numbers("sine", math.sin(alpha))
    packer.numbers("cosine", math.cos(alpha))
    packer.numbers("eta", spec.ior)


# ---------------------------------------------------------------- the fibre as wo sees it


class Fibre(NamedTuple):
    """What wo decides: sine and cosine of theta_o, phi_o, gamma_o, gamma_t, the attenuations."""

    sine: object
    cosine: object
    phi: object
    gamma_o: object
    gamma_t: object
    a0: object
    a1: object
    a2: object
    a3: object


@kernel(strict=True)
def fibre_of(params, wo):
    """The `Fibre` that is met from wo, above."""
    sine = minimum(maximum(wo.x, -1.0), 1.0)
    cosine = sqrt(maximum(1.0 - sine * sine, 1e-12))
    phi = arctan2(wo.z, wo.y)
    h = minimum(maximum(-wo.y / cosine, -1.0), 1.0)
    # Bravais: the index as it is in the plane across the fibre.
    eta = params.eta
    across = sqrt(maximum(eta * eta - sine * sine, 1e-12)) / cosine
    sin_gamma = h / across
    cos_gamma = sqrt(maximum(1.0 - sin_gamma * sin_gamma, 0.0))
    sin_inside = sine / eta
    cos_inside = sqrt(maximum(1.0 - sin_inside * sin_inside, 1e-12))
    path = 2.0 * cos_gamma / cos_inside
    s = params.sigma_a * -path
    passes = Vec3(exp(s.x), exp(s.y), exp(s.z))
    f, _ = fresnel_dielectric(cosine * sqrt(maximum(1.0 - h * h, 0.0)), eta)
    a1 = passes * ((1.0 - f) * (1.0 - f))
    a2 = a1 * passes * f
    left = lanes_vec3(1.0) - passes * f
    a3 = a2 * passes * f
    a3 = Vec3(
        a3.x / maximum(left.x, 1e-6), a3.y / maximum(left.y, 1e-6), a3.z / maximum(left.z, 1e-6)
    )
    return Fibre(
        sine=sine,
        cosine=cosine,
        phi=phi,
        gamma_o=arcsin(h),
        gamma_t=arcsin(sin_gamma),
        a0=lanes_vec3(1.0) * f,
        a1=a1,
        a2=a2,
        a3=a3,
    )


@kernel(strict=True)
def shares_of(fibre):
    """Probabilities of the four lobes, by what they send out in all channels."""
    y0, y1 = fibre.a0.x + fibre.a0.y + fibre.a0.z, fibre.a1.x + fibre.a1.y + fibre.a1.z
    y2, y3 = fibre.a2.x + fibre.a2.y + fibre.a2.z, fibre.a3.x + fibre.a3.y + fibre.a3.z
    inverse = 1.0 / maximum(y0 + y1 + y2 + y3, 1e-20)
    return y0 * inverse, y1 * inverse, y2 * inverse, y3 * inverse


@kernel(strict=True)
def tilted(params, fibre):
    """Sines and cosines of theta_o for p = 0, 1 and 2: turned by 2 alpha, -alpha and -4 alpha."""
    s1, c1 = params.sine, params.cosine
    s2, c2 = 2.0 * s1 * c1, c1 * c1 - s1 * s1
    s4, c4 = 2.0 * s2 * c2, c2 * c2 - s2 * s2
    s, c = fibre.sine, fibre.cosine
    first = s * c2 - c * s2, absolute(c * c2 + s * s2)
    second = s * c1 + c * s1, absolute(c * c1 - s * s1)
    third = s * c4 + c * s4, absolute(c * c4 - s * s4)
    return first, second, third


# ---------------------------------------------------------------- scattering


@kernel(strict=True)
def middle_of(fibre, p):
    """The angle phi_i - phi_o around which lobe p lies."""
    return 2.0 * p * fibre.gamma_t - 2.0 * fibre.gamma_o + p * PI


@kernel(strict=True)
def values(params, fibre, wi):
    """(f cos theta_i, pdf) for wo above."""
    sine = minimum(maximum(wi.x, -1.0), 1.0)
    cosine = sqrt(maximum(1.0 - sine * sine, 0.0))
    turn = arctan2(wi.z, wi.y) - fibre.phi
    v, s = params.variance, params.scale
    first, second, third = tilted(params, fibre)
    m0 = longitudinal(first[0], first[1], sine, cosine, v)
    m1 = longitudinal(second[0], second[1], sine, cosine, 0.25 * v)
    m2 = longitudinal(third[0], third[1], sine, cosine, 4.0 * v)
    m3 = longitudinal(fibre.sine, fibre.cosine, sine, cosine, 4.0 * v)
    w0 = m0 * logistic(turn - middle_of(fibre, 0.0), s)
    w1 = m1 * logistic(turn - middle_of(fibre, 1.0), s)
    w2 = m2 * logistic(turn - middle_of(fibre, 2.0), s)
    w3 = m3 * INV_TWO_PI
    q0, q1, q2, q3 = shares_of(fibre)
    f_cos = w0 * fibre.a0 + w1 * fibre.a1 + w2 * fibre.a2 + w3 * fibre.a3
    return f_cos, w0 * q0 + w1 * q1 + w2 * q2 + w3 * q3


@kernel(strict=True)
def evaluate(params, wo, wi):
    """(f cos theta_i, pdf per steradian)."""
    below = wo.z < 0.0
    return values(params, fibre_of(params, mirrored_if(below, wo)), mirrored_if(below, wi))


@kernel(strict=True)
def sample(params, wo, u, u2):
    """(wi, f cos theta_i / pdf, pdf per steradian, flags): one of the lobes, chosen by u."""
    below = wo.z < 0.0
    fibre = fibre_of(params, mirrored_if(below, wo))
    q0, q1, q2, q3 = shares_of(fibre)
    c1, c2 = q0 + q1, q0 + q1 + q2
    is0, is1, is2 = u < q0, (u >= q0) & (u < c1), (u >= c1) & (u < c2)
    start = where(is0, 0.0, where(is1, q0, where(is2, c1, c2)))
    share = where(is0, q0, where(is1, q1, where(is2, q2, q3)))
    # What is left of u once it has chosen.
    rest = minimum(maximum((u - start) / maximum(share, 1e-12), 0.0), 1.0)
    first, second, third = tilted(params, fibre)
    sin_o = where(is0, first[0], where(is1, second[0], where(is2, third[0], fibre.sine)))
    cos_o = where(is0, first[1], where(is1, second[1], where(is2, third[1], fibre.cosine)))
    v = params.variance * where(is0, 1.0, where(is1, 0.25, 4.0))
    # Around the mirrored wo, with the density exp(x / v) of the cosine x to it.
    x = 1.0 + v * log(maximum(u2[0] + (1.0 - u2[0]) * exp(-2.0 / v), 1e-30))
    x = minimum(maximum(x, -1.0), 1.0)
    _, around = sincos_2pi(u2[1])
    sine = -x * sin_o + sqrt(maximum(1.0 - x * x, 0.0)) * around * cos_o
    sine = minimum(maximum(sine, -1.0), 1.0)
    cosine = sqrt(maximum(1.0 - sine * sine, 0.0))
    p = where(is0, lanes(0.0), where(is1, 1.0, 2.0))
    uniform = TWO_PI * rest - PI
    turn = where(
        is0 | is1 | is2, middle_of(fibre, p) + sample_logistic(rest, params.scale), uniform
    )
    s, c = sincos(fibre.phi + turn)
    wi = Vec3(sine, cosine * c, cosine * s)
    f_cos, pdf = values(params, fibre, wi)
    flags = where(wi.z < 0.0, lanes_u32(TRANSMISSION), lanes_u32(REFLECTION))
    return mirrored_if(below, wi), quotient(f_cos, pdf), pdf, flags


@kernel(strict=True)
def albedo(params):
    """About what a fibre sends out: light that passes it once, through its middle."""
    s = params.sigma_a * -2.0
    return Vec3(exp(s.x), exp(s.y), exp(s.z))
