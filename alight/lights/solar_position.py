r"""Position of the sun, by time and place.

With n days since noon (UT) of 1 January 2000, the sun's mean longitude L and anomaly g give its
ecliptic longitude :math:`\lambda = L + 1.915° \sin g + 0.020° \sin 2g`; the obliquity of the
ecliptic gives its right ascension and declination, sidereal time the hour angle. Between 1950 and
2050 it is right to 0.01 degrees, but for refraction, which is left out: it lifts a sun on the
horizon by 0.5.

Source: Michalsky, The Astronomical Almanac's algorithm for approximate solar position (1950-2050),
Solar Energy 40(3), 1988.
"""

from __future__ import annotations

from datetime import UTC, datetime

import numpy as np

from alight.core.field_types import Triple

_EPOCH = datetime(2000, 1, 1, 12, tzinfo=UTC)


def solar_angles(time: datetime, latitude: float, longitude: float) -> tuple[float, float]:
    """Elevation above the horizon, and azimuth from north over east, radians.

    Parameters
    ----------
    time : datetime
        With its time zone.
    latitude, longitude : float, degrees
        North and east are positive.
    """
    n = (time - _EPOCH).total_seconds() / 86400.0
    anomaly = np.radians(357.528 + 0.9856003 * n)
    mean_longitude = 280.460 + 0.9856474 * n
    wobble = 1.915 * np.sin(anomaly) + 0.020 * np.sin(2.0 * anomaly)
    ecliptic = np.radians(mean_longitude + wobble)
    obliquity = np.radians(23.439 - 0.0000004 * n)
    ascension = np.arctan2(np.cos(obliquity) * np.sin(ecliptic), np.cos(ecliptic))
    declination = np.arcsin(np.sin(obliquity) * np.sin(ecliptic))
    # Sidereal time turns by one day a year more than the hours of UT, which n has as well.
    sidereal = np.radians(15.0 * (18.697375 + 24.0657098242 * n) + longitude)
    hour = sidereal - ascension
    phi = np.radians(latitude)
    north = np.sin(declination) * np.cos(phi) - np.cos(declination) * np.sin(phi) * np.cos(hour)
    east = -np.cos(declination) * np.sin(hour)
    up = np.sin(declination) * np.sin(phi) + np.cos(declination) * np.cos(phi) * np.cos(hour)
    return float(np.arctan2(up, np.hypot(north, east))), float(np.arctan2(east, north))


def sun_direction(time: datetime, latitude: float, longitude: float) -> Triple:
    """Unit vector to the sun: +y up, +x east, -z north; parameters as of `solar_angles`."""
    elevation, azimuth = solar_angles(time, latitude, longitude)
    flat = np.cos(elevation)
    x, y, z = flat * np.sin(azimuth), np.sin(elevation), -flat * np.cos(azimuth)
    return float(x), float(y), float(z)
