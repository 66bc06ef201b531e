r"""Sun: a disk in the sky, as large and as red as the air leaves it; all else is black.

.. math:: L_e(\omega) = L \quad \text{if } \omega \cdot \omega_s \ge \cos\alpha, \text{ else } 0

A larger disk gives softer shadows and the same light: its radiance falls as its solid angle grows.

Source: Preetham, Shirley and Smits 1999; see `alight.lights.atmosphere`.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from alight.core.constants import INV_TWO_PI, PI
from alight.core.field_types import Color, Triple
from alight.core.frame import frame_from_normal
from alight.core.vec import length_squared, renormalize, row_vec3
from alight.core.warps import square_to_uniform_cone
from alight.lights.bright_disk import Disk
from alight.lights.daylight import DIAMETER, Daylight, Diameter, solid_angle
from alight.lights.tables import from_infinity, row_of
from lanewise.jit import kernel
from lanewise.simd import lanes_vec3, where

#: Numbers of the light's row: unit vector to the sun, 1 - cos of its half angle, its radiance over
#: the light's colour; of a sky's sun also the probability that it is sampled.
TO_SUN, SIZE, RADIANCE, SHARE = 4, 7, 8, 11


class Sun(Daylight):
    """The sun without the sky.

    Parameters
    ----------
    sun_direction, time, latitude, longitude, turbidity
        See `alight.lights.daylight.Daylight`.
    scale : Color, default 1
        Factor of its radiance.
    diameter : float in [0.01, 60], degrees, default 0.533
        Angle across it.
    """

    type: Literal["sun"] = "sun"
    scale: Color = (1.0, 1.0, 1.0)
    diameter: Diameter = DIAMETER


EXAMPLES = (
    Sun(sun_direction=(0.0, 1.0, 1.0)),
    Sun(sun_direction=(1.0, 0.3, 0.5), turbidity=8.0, scale=(0.5, 0.7, 1.0), diameter=10.0),
    Sun(sun_direction=(0.0, 1.0, 0.0), scale=0.0),
)

#: A ray that leaves the scene finds it.
DELTA = False


def disk(light: Daylight, diameter: float, factor: Triple, to_world: np.ndarray) -> np.ndarray:
    """The numbers of the row up to `SHARE`."""
    turned = to_world[:3, :3] @ light.to_sun
    smaller = solid_angle(DIAMETER) / solid_angle(diameter)
    radiance = np.array(light.of_the_sun) * factor * smaller
    size = 2.0 * np.sin(np.radians(0.25 * diameter)) ** 2
    return np.concatenate([turned / np.linalg.norm(turned), [size], radiance])


def place(spec: Sun, to_world: np.ndarray) -> tuple[Triple, np.ndarray]:
    """Colour; the disk."""
    return spec.scale, disk(spec, spec.diameter, (1.0, 1.0, 1.0), to_world)


def mean_color(spec: Sun) -> Triple:
    """Mean radiance over all directions."""
    share = solid_angle(DIAMETER) / (4.0 * PI)
    r, g, b = (float(a * c) * share for a, c in zip(spec.of_the_sun, spec.scale, strict=True))
    return r, g, b


def disk_of(spec: Sun, to_world: np.ndarray) -> Disk:
    """The disk itself; see `alight.lights.model.LightModel`."""
    return seen_disk(
        spec, spec.diameter, mean_color(spec.replaced(scale=(1.0, 1.0, 1.0))), to_world
    )


def seen_disk(light: Daylight, diameter: float, mean: Triple, to_world: np.ndarray) -> Disk:
    """The `disk` of a light as paths aim at it."""
    turned = to_world[:3, :3] @ light.to_sun
    return Disk(turned / np.linalg.norm(turned), float(np.radians(0.5 * diameter)), mean)


def power(luminance: float, area: float, radius: float) -> float:
    """W that enter a scene of bounding radius `radius`: 4 pi directions through pi r^2."""
    return 4.0 * PI * PI * radius * radius * luminance


def share_all_around(numbers: np.ndarray) -> float:
    """None: a window shows it or not."""
    return 0.0


@kernel
def in_the_disk(scene, back, d):
    """Where unit directions point to the sun."""
    k = row_of(scene, back)
    # By the chord: the cosine of a small angle does not tell it.
    return length_squared(d - row_vec3(scene.lights.data, k + TO_SUN)) <= (
        2.0 * scene.lights.data[k + SIZE]
    )


@kernel
def to_the_disk(scene, back, u2):
    """Directions to the sun, all equally likely."""
    k = row_of(scene, back)
    axis = lanes_vec3(1.0) * row_vec3(scene.lights.data, k + TO_SUN)
    s, t = frame_from_normal(axis)
    w = square_to_uniform_cone(u2, scene.lights.data[k + SIZE])
    return renormalize(w.x * s + w.y * t + w.z * axis)


@kernel
def sample(scene, back, p, u, u2):
    """Choose a direction; see `alight.lights.environment.sample`."""
    wi = to_the_disk(scene, back, u2)
    return from_infinity(wi, radiance(scene, back, wi), pdf(scene, back, p, wi))


@kernel
def pdf(scene, back, p, d):
    """Density of `sample` per solid angle."""
    size = scene.lights.data[row_of(scene, back) + SIZE]
    return where(in_the_disk(scene, back, d), INV_TWO_PI / size, 0.0)


@kernel
def radiance(scene, back, d):
    """Radiance that arrives from the unit direction d, without the light's colour."""
    bright = row_vec3(scene.lights.data, row_of(scene, back) + RADIANCE)
    return where(in_the_disk(scene, back, d), bright, lanes_vec3(0.0))
