"""What the lights of the sun and of the sky share: where the sun is, and what the air does."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator

from alight.core.field_types import Triple, Vector3
from alight.core.fields import Interval, invalid
from alight.core.spec import Light
from alight.lights.atmosphere import sky_radiance, sun_radiance
from alight.lights.solar_position import solar_angles, sun_direction

#: Rows and columns of the map of the sky: a bit over half a degree a texel.
MAP_SIZE = 257, 512

#: Angle across the sun seen from the earth, degrees.
DIAMETER = 0.533

Turbidity = Annotated[float, Interval(2.0, 10.0)]
Diameter = Annotated[float, Interval(0.01, 60.0)]
Latitude = Annotated[float, Interval(-90.0, 90.0)]
Longitude = Annotated[float, Interval(-180.0, 180.0)]


class Daylight(Light):
    """Base class of the lights of a clear day.

    Parameters
    ----------
    sun_direction : Vector3, optional
        To the sun, +y up; of any length. Or, in its place, the following three.
    time : str, optional
        ISO 8601 with the time zone, as "2026-06-21T15:30:00+02:00".
    latitude, longitude : float, degrees, optional
        North and east are positive; -z is north then, +x east.
    turbidity : float in [2, 10], default 3
        Haze: 2 is very clear air, 10 is haze.
    """

    placement: ClassVar[Literal["node", "shape", "environment"]] = "environment"
    sun_direction: Vector3 | None = None
    time: str | None = None
    latitude: Latitude | None = None
    longitude: Longitude | None = None
    turbidity: Turbidity = 3.0

    @model_validator(mode="after")
    def _sun_is_up(self) -> Self:
        by_date = (self.time, self.latitude, self.longitude)
        given = sum(value is not None for value in by_date)
        if self.sun_direction is not None:
            if given:
                raise invalid("takes either sun_direction or time, latitude and longitude")
            if not any(self.sun_direction):
                raise invalid("sun_direction must not have length 0")
            if self.sun_direction[1] < 0.0:
                raise invalid("sun_direction must not point below the horizon: its y must be >= 0")
        elif given < 3:
            raise invalid("needs sun_direction, or time, latitude and longitude")
        else:
            self._check_date()
        return self

    def _check_date(self) -> None:
        assert self.time is not None and self.latitude is not None and self.longitude is not None
        try:
            time = datetime.fromisoformat(self.time)
        except ValueError:
            text = 'time must be a date and time as "2026-06-21T15:30:00+02:00"'
            raise invalid(f'{text}, got "{self.time}"') from None
        if time.tzinfo is None:
            raise invalid(f'time needs its zone, as "{self.time}+00:00", or ends in Z')
        if not 1950 <= time.year <= 2050:
            raise invalid(f"time must lie between the years 1950 and 2050, got {time.year}")
        height = np.degrees(solar_angles(time, self.latitude, self.longitude)[0])
        if height < 0.0:
            raise invalid(
                f"the sun is {-height:.1f} degrees below the horizon there at {self.time}: "
                "choose another time"
            )

    @property
    def to_sun(self) -> NDArray[np.float64]:
        """Unit vector to the sun, in the space of the node."""
        if self.sun_direction is not None:
            return np.asarray(self.sun_direction) / np.linalg.norm(self.sun_direction)
        assert self.time is not None and self.latitude is not None and self.longitude is not None
        time = datetime.fromisoformat(self.time)
        return np.array(sun_direction(time, self.latitude, self.longitude))

    @property
    def of_the_sun(self) -> Triple:
        """Radiance of the sun's disk at its true size, W/(m^2 sr)."""
        return sun_radiance(float(np.arcsin(min(self.to_sun[1], 1.0))), self.turbidity)


def solid_angle(diameter: float) -> float:
    """Solid angle of a disk this many degrees across, sr."""
    return float(4.0 * np.pi * np.sin(np.radians(0.25 * diameter)) ** 2)


def picture(light: Daylight, sky: Triple, sun: Triple, ground: Triple) -> NDArray[np.float32]:
    """A map of sky and ground, without the sun's disk.

    Parameters
    ----------
    light : Daylight
    sky, sun : triple
        Factors of the light of both.
    ground : triple
        Reflectance of the ground that is seen below the horizon; both light it.

    Returns
    -------
    (257, 512, 3) float32, W/(m^2 sr)
        See `alight.lights.environment`.
    """
    rows, columns = MAP_SIZE
    theta = np.linspace(0.0, np.pi, rows)[:, None]
    phi = 2.0 * np.pi * (np.arange(columns) + 0.5) / columns
    sine = np.sin(theta)
    up = np.broadcast_to(np.cos(theta), (rows, columns))
    directions = np.stack([sine * np.sin(phi), up, -sine * np.cos(phi)], axis=-1)
    to_sun = light.to_sun
    # The horizon's row, in the middle, is sky.
    above = rows // 2 + 1
    pixels = np.zeros((rows, columns, 3))
    pixels[:above] = sky_radiance(directions[:above], to_sun, light.turbidity) * sky
    weights = (np.cos(theta) * sine)[:above] * (np.pi / (rows - 1)) * (2.0 * np.pi / columns)
    irradiance = (pixels[:above] * weights[..., None]).sum(axis=(0, 1))
    disk = np.array(light.of_the_sun) * sun
    irradiance += disk * solid_angle(DIAMETER) * to_sun[1]
    pixels[above:] = np.asarray(ground) * irradiance / np.pi
    return pixels.astype(np.float32)
