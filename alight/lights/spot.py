r"""Spot light: a point light that shines into a cone and fades out towards its edge.

.. math::
    I(\theta) = I \min\left(1, \max\left(0,
    \frac{\theta_\text{cutoff} - \theta}{\theta_\text{cutoff} - \theta_\text{beam}}\right)\right),
    \qquad E(x) = I(\theta) \cos\theta_s / d^2

It stands at the origin of its node and shines along the local +z axis. A path cannot hit it, so it
is always sampled as a light.

Source: Mitsuba 3's ``spot`` for the falloff, linear in the angle; PBR4 section 12.2.1.
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

import numpy as np
from pydantic import model_validator

from alight.core.constants import PI
from alight.core.jit import kernel
from alight.core.maths import arctan2
from alight.core.simd import gather, lanes, lanes_mask, lanes_vec3, maximum, minimum, sqrt
from alight.core.spec import Color, Interval, Light, Triple, invalid
from alight.core.vec import cross, dot, gather_vec3, length_squared
from alight.lights.tables import STRIDE, LightSample

CutoffAngle = Annotated[float, Interval(0.001, 180.0)]
BeamWidth = Annotated[float, Interval(0.0, 180.0)]


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
    """

    type: Literal["spot"] = "spot"
    intensity: Color = (1.0, 1.0, 1.0)
    cutoff_angle: CutoffAngle = 20.0
    beam_width: BeamWidth | None = None

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
    Spot(intensity=(10.0, 5.0, 0.0), cutoff_angle=60.0, beam_width=60.0),
    Spot(intensity=3.0, cutoff_angle=180.0, beam_width=0.0),
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
    """Colour; position, unit axis, cutoff in radians and 1 / (cutoff - beam)."""
    cutoff, beam = angles(spec)
    axis = to_world[:3, 2] / np.linalg.norm(to_world[:3, 2])
    fade = 1.0 / max(cutoff - beam, _NARROWEST)
    return spec.intensity, np.concatenate([to_world[:3, 3], axis, [cutoff, fade]])


def mean_color(spec: Spot) -> Triple:
    r"""Mean intensity over the sphere.

    With c and b the angles of cutoff and beam, the integral of the falloff over directions is
    :math:`2 \pi (1 - (\sin c - \sin b) / (c - b))`, which for c = b is that of a cap.
    """
    c, b = angles(spec)
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
def sample(scene, index, p, u, u2):
    """The one direction to the light; see `alight.lights.area.sample`."""
    data, k = scene.lights.data, index * STRIDE
    to_light = gather_vec3(data, k + 4) - p
    # At the light itself there is no direction; the square must not underflow to 1 / 0.
    squared = maximum(length_squared(to_light), 1e-30)
    distance = sqrt(squared)
    wi = to_light * (1.0 / distance)
    # By its tangent, because the cosine of a small angle does not tell it.
    axis = gather_vec3(data, k + 7)
    theta = arctan2(sqrt(length_squared(cross(axis, wi))), -dot(axis, wi))
    falloff = minimum(maximum((gather(data, k + 10) - theta) * gather(data, k + 11), 0.0), 1.0)
    one = lanes(1.0)
    return LightSample(
        wi,
        distance,
        lanes_vec3(1.0) * (falloff / squared),
        one,
        lanes_mask(True),
        one,
        lanes(0.0),
    )
