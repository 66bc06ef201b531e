r"""Sun and sky together: the light of a clear day.

.. math:: L_e(\omega) = L_\text{sky}(\omega) + L_\text{sun} [\omega \cdot \omega_s \ge \cos\alpha]

A direction is drawn to the sun's disk or from the map of the sky; its density is that of the
mixture. The sun gets its share of the light on the ground, but neither less than a quarter.

Source: Preetham, Shirley and Smits 1999; see `alight.lights.atmosphere`.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from alight.core.field_types import Color, Reflectance, Triple
from alight.core.vec import luminance
from alight.lights.bright_disk import Disk
from alight.lights.daylight import DIAMETER, Daylight, Diameter, picture, solid_angle
from alight.lights.environment import Environment
from alight.lights.environment import left_out as left_out_of_sky
from alight.lights.environment import map_of as map_of_picture
from alight.lights.environment import pdf as pdf_of_sky
from alight.lights.environment import power as power
from alight.lights.environment import radiance as radiance_of_sky
from alight.lights.environment import sample as sample_sky
from alight.lights.environment_map import EnvironmentMap
from alight.lights.sun import SHARE, TO_SUN, disk, seen_disk, to_the_disk
from alight.lights.sun import pdf as pdf_of_sun
from alight.lights.sun import radiance as radiance_of_sun
from alight.lights.tables import from_infinity, row_of
from alight.textures.images import Image
from lanewise.jit import kernel
from lanewise.simd import where
from lanewise.vec3 import Vec3


class SunSky(Daylight):
    """Clear day.

    Parameters
    ----------
    sun_direction, time, latitude, longitude, turbidity
        See `alight.lights.daylight.Daylight`.
    scale : Color, default 1
        Factor of all its radiance.
    sun_scale, sky_scale : Color, default 1
        Further factors of the sun's and the sky's.
    diameter : float in [0.01, 60], degrees, default 0.533
        Angle across the sun; a larger one gives softer shadows and the same light.
    ground : Reflectance, default 0.3
        What is seen below the horizon reflects so much of the light of both.
    """

    type: Literal["sunsky"] = "sunsky"
    scale: Color = (1.0, 1.0, 1.0)
    sun_scale: Color = (1.0, 1.0, 1.0)
    sky_scale: Color = (1.0, 1.0, 1.0)
    diameter: Diameter = DIAMETER
    ground: Reflectance = (0.3, 0.3, 0.3)

    @property
    def is_black(self) -> bool:
        """Whether it emits nothing."""
        none = (0.0, 0.0, 0.0)
        return self.scale == none or (self.sun_scale == none and self.sky_scale == none)


EXAMPLES = (
    SunSky(sun_direction=(0.0, 1.0, 1.0)),
    SunSky(sun_direction=(1, 0.2, 0.5), turbidity=8.0, scale=(0.5, 0.7, 1), diameter=20.0),
    SunSky(sun_direction=(1.0, 1.0, 0.0), sun_scale=0.0, ground=0.0),
    SunSky(sun_direction=(1.0, 1.0, 0.0), sky_scale=0.0),
)

#: A ray that leaves the scene finds it.
DELTA = False

# Of the samples, unless one of the two is black.
_LEAST_SHARE, _MOST_SHARE = 0.25, 0.75


def place(spec: SunSky, to_world: np.ndarray) -> tuple[Triple, np.ndarray]:
    """Colour; the sun's disk, and its share of the samples."""
    numbers = disk(spec, spec.diameter, spec.sun_scale, to_world)
    return spec.scale, np.append(numbers, _share_of_sun(spec))


def _share_of_sun(spec: SunSky) -> float:
    # On the ground: the map's lower half then is a white ground's radiance.
    half = picture(spec, spec.sky_scale, (0.0, 0.0, 0.0), (1.0, 1.0, 1.0))[-1, 0]
    sky = float(luminance(Vec3(*half.astype(float)))) * np.pi
    sun = [a * b for a, b in zip(spec.of_the_sun, spec.sun_scale, strict=True)]
    direct = float(luminance(Vec3(*sun))) * solid_angle(DIAMETER) * float(spec.to_sun[1])
    none = (0.0, 0.0, 0.0)
    if spec.sun_scale == none:
        return 0.0
    # Below a black sky the ground may still shine.
    if sky <= 0.0 and spec.ground == none:
        return 1.0
    return min(max(direct / (direct + sky), _LEAST_SHARE), _MOST_SHARE)


def map_of(spec: SunSky, to_world: np.ndarray, compensated: bool) -> EnvironmentMap:
    """The tables of sky and ground; see `alight.lights.environment.map_of`."""
    pixels = picture(spec, spec.sky_scale, spec.sun_scale, spec.ground)
    drawn = Environment(pixels=Image(pixels), scale=spec.scale)
    return map_of_picture(drawn, to_world, compensated)


def beside_the_map(spec: SunSky) -> Triple:
    """Mean radiance of the sun over all directions, without the light's colour."""
    share = solid_angle(DIAMETER) / (4.0 * np.pi)
    r, g, b = (float(a * c) * share for a, c in zip(spec.of_the_sun, spec.sun_scale, strict=True))
    return r, g, b


def disk_of(spec: SunSky, to_world: np.ndarray) -> Disk:
    """The sun; see `alight.lights.model.LightModel`."""
    return seen_disk(spec, spec.diameter, beside_the_map(spec), to_world)


def share_all_around(numbers: np.ndarray) -> float:
    """What is left by the sun."""
    return 1.0 - float(numbers[SHARE - TO_SUN])


@kernel
def sample(scene, back, p, u, u2):
    """Choose a direction; see `alight.lights.environment.sample`."""
    share = scene.lights.data[row_of(scene, back) + SHARE]
    to_sun = u < share
    rest = where(to_sun, u, u - share) / where(to_sun, share, 1.0 - share)
    of_sky = sample_sky(scene, back, p, rest, u2)
    wi = where(to_sun, to_the_disk(scene, back, u2), of_sky.wi)
    return from_infinity(wi, radiance(scene, back, wi), pdf(scene, back, p, wi))


@kernel
def pdf(scene, back, p, d):
    """Density of `sample` per solid angle."""
    share = scene.lights.data[row_of(scene, back) + SHARE]
    return share * pdf_of_sun(scene, back, p, d) + (1.0 - share) * pdf_of_sky(scene, back, p, d)


@kernel
def left_out(scene, back):
    """Share of its light that `sample` leaves to BSDF sampling."""
    share = scene.lights.data[row_of(scene, back) + SHARE]
    return (1.0 - share) * left_out_of_sky(scene, back)


@kernel
def radiance(scene, back, d):
    """Radiance that arrives from the unit direction d, without the light's colour."""
    return radiance_of_sun(scene, back, d) + radiance_of_sky(scene, back, d)
