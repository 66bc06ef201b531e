r"""Spot light: a point light that shines into a cone and fades out towards its edge.

.. math::
    E(x) = I f(t(\theta)) \cos\theta_s / d^2, \qquad
    t = \min\left(1, \max\left(0,
    \frac{m_\text{cutoff} - m(\theta)}{m_\text{cutoff} - m_\text{beam}}\right)\right)

It sits at the origin of its node and shines along the local +z axis. A path cannot hit it, so it
is always sampled as a light. Renderers fade out differently, so there is a choice of

============= ====================== ===================
falloff       m                      f
============= ====================== ===================
``linear``    :math:`\theta`         t
``smooth``    :math:`1-\cos\theta`   :math:`t^2 (3 - 2t)`
``quadratic`` :math:`1-\cos\theta`   :math:`t^2`
``quartic``   :math:`1-\cos\theta`   :math:`t^4`
============= ====================== ===================

Source: Mitsuba 3's ``spot`` is linear; PBR4 section 12.2.1 smooth, its third edition quartic; the
glTF extension KHR_lights_punctual quadratic.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import model_validator

from alight.core.constants import PI
from alight.core.field_types import Color, Triple
from alight.core.fields import Interval, invalid
from alight.core.frame import frame_from_normal, to_world
from alight.core.maths import arctan2, sincos
from alight.core.spec import Light
from alight.core.vec import cross, dot, gather_vec3, length_squared, normalize
from alight.core.warps import square_to_uniform_cone, uniform_cone_pdf
from alight.lights.at_point import way_to
from alight.lights.tables import STRIDE, LightSample, from_point
from lanewise.jit import kernel
from lanewise.simd import gather, lanes, lanes_mask, lanes_vec3, maximum, minimum, sqrt, where

CutoffAngle = Annotated[float, Interval(0.001, 180.0)]
BeamWidth = Annotated[float, Interval(0.0, 180.0)]
Falloff = Literal["linear", "smooth", "quadratic", "quartic"]
#: Each with the integral of f over t from 0 to 1. Their order is their number in the row.
FALLOFFS: dict[Falloff, float] = {
    "linear": 1 / 2,
    "smooth": 1 / 2,
    "quadratic": 1 / 3,
    "quartic": 1 / 5,
}


class Spot(Light):
    """Cone of light along +z of its node.

    Parameters
    ----------
    intensity : Color, W/sr, default 1
        Radiant intensity inside the beam; not changed by a scale of the node.
    cutoff_angle : float in [0.001, 180], degrees, default 20
        Angle from the axis beyond which it is dark.
    beam_width : float in [0, cutoff_angle], degrees, optional
        Angle from the axis up to which it has its full intensity; 3/4 of the cutoff by default.
    falloff : {"linear", "smooth", "quadratic", "quartic"}, default "linear"
        How it fades out between the two: linearly in the angle, or by a polynomial in its cosine.
    """

    type: Literal["spot"] = "spot"
    intensity: Color = (1.0, 1.0, 1.0)
    cutoff_angle: CutoffAngle = 20.0
    beam_width: BeamWidth | None = None
    falloff: Falloff = "linear"

    @model_validator(mode="after")
    def _fades_outwards(self) -> Self:
        if self.beam_width is not None and self.beam_width > self.cutoff_angle:
            raise invalid(
                f"beam_width must be at most cutoff_angle = {self.cutoff_angle:g}, "
                f"got {self.beam_width:g}"
            )
        return self


EXAMPLES = (
    Spot(),
    Spot(intensity=(10.0, 5.0, 0.0), cutoff_angle=60.0, beam_width=60.0, falloff="quadratic"),
    Spot(intensity=3.0, cutoff_angle=180.0, beam_width=0.0),
    Spot(cutoff_angle=70.0, beam_width=5.0, falloff="smooth"),
    Spot(cutoff_angle=100.0, beam_width=0.0, falloff="quartic"),
    Spot(intensity=0.0),
)

#: Rays cannot hit it, so every mode finds it by light sampling.
DELTA = True

# A hard edge: so narrow in radians that no float32 angle falls into it.
_NARROWEST = 1e-9


def angles(spec: Spot) -> tuple[float, float]:
    """Half angles of the cutoff and of the beam, radians."""
    beam = 0.75 * spec.cutoff_angle if spec.beam_width is None else spec.beam_width
    return float(np.radians(spec.cutoff_angle)), float(np.radians(beam))


def place(spec: Spot, to_world: np.ndarray) -> tuple[Triple, np.ndarray]:
    """Colour; position, unit axis, m of the cutoff, 1 / (m of cutoff - m of beam), falloff."""
    edge, beam = _measured(spec)
    axis = to_world[:3, 2] / np.linalg.norm(to_world[:3, 2])
    narrowest = _NARROWEST if spec.falloff == "linear" else _NARROWEST**2
    fade = 1.0 / max(edge - beam, narrowest)
    number = list(FALLOFFS).index(spec.falloff)
    return spec.intensity, np.concatenate([to_world[:3, 3], axis, [edge, fade, number]])


def _measured(spec: Spot) -> tuple[float, float]:
    """m of the cutoff and of the beam."""
    cutoff, beam = angles(spec)
    if spec.falloff == "linear":
        return cutoff, beam
    # 1 - cos, to all digits for small angles.
    return 2.0 * math.sin(0.5 * cutoff) ** 2, 2.0 * math.sin(0.5 * beam) ** 2


def mean_color(spec: Spot) -> Triple:
    r"""Mean intensity over the sphere.

    With c and b the angles of cutoff and beam, the integral of the linear falloff over directions
    is :math:`2 \pi (1 - (\sin c - \sin b) / (c - b))`, which for c = b is that of a cap; those in
    the cosine have the integral :math:`2 \pi (m_b + (m_c - m_b) \int_0^1 f)`.
    """
    c, b = angles(spec)
    if spec.falloff != "linear":
        edge, beam = _measured(spec)
        mean = 0.5 * (beam + (edge - beam) * FALLOFFS[spec.falloff])
        return mean * spec.intensity[0], mean * spec.intensity[1], mean * spec.intensity[2]
    slope = (np.sin(c) - np.sin(b)) / (c - b) if c - b > _NARROWEST else np.cos(c)
    r, g, b = (float(0.5 * (1.0 - slope)) * channel for channel in spec.intensity)
    return r, g, b


def power(luminance: float, area: float, radius: float) -> float:
    """Emitted power in W: the mean intensity over the whole sphere."""
    return 4.0 * PI * luminance


def cone(spec: Spot) -> tuple[float, float]:
    """Half angle of the beam, and how far beyond it it is dark; see `alight.lights.point.cone`."""
    cutoff, beam = angles(spec)
    return beam, cutoff - beam


@kernel
def falloff_of(data, k, wi):
    """Share of the intensity that goes from the lights with rows at k along -wi."""
    # By its tangent, because the cosine of a small angle does not tell it.
    axis = gather_vec3(data, k + 7)
    theta = arctan2(sqrt(length_squared(cross(axis, wi))), -dot(axis, wi))
    number = gather(data, k + 12)
    # 1 - cos, which for a small angle the cosine does not tell.
    chord = axis + wi
    m = where(number == 0.0, theta, 0.5 * length_squared(chord))
    t = minimum(maximum((gather(data, k + 10) - m) * gather(data, k + 11), 0.0), 1.0)
    squared_t = t * t
    return where(
        number == 0.0,
        t,
        where(
            number == 1.0,
            squared_t * (3.0 - 2.0 * t),
            where(number == 2.0, squared_t, squared_t * squared_t),
        ),
    )


@kernel
def sample(scene, index, p, u, u2):
    """The one direction to the light; see `alight.lights.area.sample`."""
    data, k = scene.lights.data, index * STRIDE
    wi, distance, falling = way_to(gather_vec3(data, k + 4) - p)
    one = lanes(1.0)
    return LightSample(
        wi=wi,
        distance=distance,
        radiance=lanes_vec3(1.0) * (falloff_of(data, k, wi) * falling),
        pdf=one,
        delta=lanes_mask(True),
        cosine=one,
        error=lanes(0.0),
    )


@kernel
def opening_of(data, k):
    """1 - cos of the cutoff, of the lights with rows at k."""
    edge = gather(data, k + 10)
    half_sine, _ = sincos(0.5 * edge)
    return where(gather(data, k + 12) == 0.0, 2.0 * half_sine * half_sine, edge)


@kernel
def emit(scene, index, u2, v2):
    """A ray within the cutoff, all directions alike; see `alight.lights.model.LightModel`."""
    data, k = scene.lights.data, index * STRIDE
    axis, opening = lanes_vec3(0.0) + gather_vec3(data, k + 7), opening_of(data, k)
    s, t = frame_from_normal(axis)
    d = normalize(to_world(s, t, axis, square_to_uniform_cone(v2, opening)))
    density = lanes(0.0) + uniform_cone_pdf(opening)
    flux = lanes_vec3(1.0) * (falloff_of(data, k, -d) / density)
    return from_point(gather_vec3(data, k + 4), d, flux, density)


@kernel
def emit_pdf(scene, index, d):
    """Density of `emit` per steradian."""
    data, k = scene.lights.data, index * STRIDE
    opening = opening_of(data, k)
    chord = d - gather_vec3(data, k + 7)
    inside = 0.5 * length_squared(chord) <= opening
    return where(inside, uniform_cone_pdf(opening), 0.0)
