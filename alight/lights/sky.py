r"""Sky: the light of a clear sky without the sun itself, as an environment.

.. math:: L_e(\omega) = L_\text{Preetham}(\theta, \gamma)

It is turned into a map once (`alight.lights.daylight.picture`) and is then an `environment`.

Source: Preetham, Shirley and Smits 1999; see `alight.lights.atmosphere`.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from alight.core.field_types import Color, Reflectance, Triple
from alight.lights.daylight import Daylight, picture
from alight.lights.environment import Environment
from alight.lights.environment import left_out as left_out
from alight.lights.environment import map_of as map_of_picture
from alight.lights.environment import pdf as pdf
from alight.lights.environment import power as power
from alight.lights.environment import radiance as radiance
from alight.lights.environment import sample as sample
from alight.lights.environment_map import EnvironmentMap
from alight.textures.images import Image


class Sky(Daylight):
    """Clear sky without the sun.

    Parameters
    ----------
    sun_direction, time, latitude, longitude, turbidity
        See `alight.lights.daylight.Daylight`.
    scale : Color, default 1
        Factor of its radiance.
    ground : Reflectance, default 0.3
        What is seen below the horizon reflects so much of the sky's light.
    """

    type: Literal["sky"] = "sky"
    scale: Color = (1.0, 1.0, 1.0)
    ground: Reflectance = (0.3, 0.3, 0.3)

    @property
    def is_black(self) -> bool:
        """Whether it emits nothing."""
        return self.scale == (0.0, 0.0, 0.0)


EXAMPLES = (
    Sky(sun_direction=(0.0, 1.0, 1.0)),
    Sky(sun_direction=(1.0, 0.2, 0.5), turbidity=8.0, scale=(0.5, 0.7, 1.0), ground=0.0),
    Sky(time="2026-06-21T12:00:00+02:00", latitude=52.5, longitude=13.4),
)

#: A ray that leaves the scene finds it.
DELTA = False


def place(spec: Sky, to_world: np.ndarray) -> tuple[Triple, np.ndarray]:
    """Colour; its map has the rest."""
    return spec.scale, np.zeros(3)


def map_of(spec: Sky, to_world: np.ndarray, compensated: bool) -> EnvironmentMap:
    """The tables of its picture; see `alight.lights.environment.map_of`."""
    pixels = picture(spec, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0), spec.ground)
    drawn = Environment(pixels=Image(pixels), scale=spec.scale)
    return map_of_picture(drawn, to_world, compensated)
