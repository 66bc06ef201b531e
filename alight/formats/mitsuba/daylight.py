"""``<emitter type="sunsky">`` and its parts -> lights of the native format.

Mitsuba 3 has the sky of Hosek and Wilkie (2012) in its tables, ours is Preetham's (1999). At
turbidity 3 and a sun at 45 degrees a horizontal surface gets 1.6 times the light of its sky here,
and 0.87 to 0.91 times that of its sun; at 15 degrees 0.6 times. The units are Mitsuba's: mean
spectral radiance.

``sunDirection`` is a direction of the world, whatever ``toWorld`` says, in 0.6 as in version 3. In
0.6 ``sunScale`` and ``skyScale`` are ``scale`` unless they are given, and ``sunRadiusScale`` widens
the sun without changing its power.

Source: documentation of the plug-ins sun, sky and sunsky of Mitsuba 0.6, and of sunsky of Mitsuba
3.
"""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

import numpy as np

from alight.formats.mitsuba.draft import Draft
from alight.formats.mitsuba.transforms import Step, matrix_of, steps_of
from alight.lights.solar_position import sun_direction
from alight.scene.transform import is_singular

#: Nanometres: ours over Mitsuba's radiance is the integral of the CIE's y.
UNIT = 106.857
#: Degrees across the sun in 0.6, which ``sunRadiusScale`` multiplies.
APPARENT_DIAMETER = 0.5358
#: Degrees that our sun may have.
DIAMETERS = 0.01, 60.0

_DIFFERENCE = (
    "the sky is Preetham's (1999), not Hosek and Wilkie's (2012): about 1.6 times as bright on the "
    "ground, its sun 0.9 times"
)
#: What Mitsuba 3 takes where the file says nothing: name -> value.
_PLACE = {"latitude": 35.6894, "longitude": 139.6917, "timezone": 9.0}
_TIME = {"year": 2010, "month": 7, "day": 10, "hour": 15.0, "minute": 0.0, "second": 0.0}


def sky_and_sun(light: Draft) -> list[Step]:
    """Fill in a light of the types sunsky, sky or sun; the steps of its node."""
    p, kind, old = light.properties, light.element.type, light.element.old
    light.context.report.warn(light.element, _DIFFERENCE)
    p.ignore("the map of the sky has half a degree a texel", "resolution", "samples_per_channel")
    p.ignore("the sun is a disk of even radiance", "complex_sun", "stretch")
    # Version 0.6 has +y up as we have, version 3 has +z.
    steps = [*([] if old else [{"rotate": {"axis": "x", "angle": 90.0}}]), *steps_of(p)]
    light.number("turbidity", 3.0)
    turbidity = light.data["turbidity"]
    light.data["turbidity"] = limited = float(np.clip(turbidity, 2.0, 10.0))
    if limited != turbidity:
        light.context.report.warn(light.element, f"its turbidity {turbidity:g} became {limited:g}")
    light.put("sun_direction", _direction(light, old, steps))
    factor = p.number("scale", 1.0)
    # Of 0.6: what is given for one of the two takes the place of the common factor.
    both, each = (1.0, factor) if old and kind == "sunsky" else (factor, 1.0)
    light.data["scale"] = [both / UNIT] * 3
    if kind != "sun":
        # Mitsuba's albedo brightens the sky, which is black below the horizon.
        albedo = p.find("albedo")
        if albedo is not None:
            text = "is left out: the sky does not depend on the ground's albedo"
            light.context.report.warn(albedo, text)
        light.data["ground"] = [0.0] * 3
    if kind == "sunsky":
        sun, sky = p.number("sun_scale", each), p.number("sky_scale", each)
        light.data |= {"sun_scale": [sun] * 3, "sky_scale": [sky] * 3}
    if kind != "sky":
        _diameter(light)
    else:
        p.ignore("a sky has no sun", "sun_aperture", "sun_radius_scale")
    return steps


def _diameter(light: Draft) -> None:
    """The angle across the sun, in degrees or as a multiple of that of the real one."""
    p = light.properties
    light.put("diameter", p.number("sun_aperture"), "sun_aperture")
    times = p.number("sun_radius_scale")
    if times is not None:
        wanted = APPARENT_DIAMETER * times
        light.put("diameter", float(np.clip(wanted, *DIAMETERS)), "sun_radius_scale")
        if wanted > DIAMETERS[1] or wanted < 0.0:
            text = f"a sun of {wanted:g} degrees became one of {light.data['diameter']:g}"
            light.context.report.warn(p.named["sun_radius_scale"], text)


def _direction(light: Draft, old: bool, steps: list[Step]) -> list[float]:
    p = light.properties
    given = p.triple("sun_direction")
    place = {name: p.number(name, value) for name, value in _PLACE.items()}
    time = {name: p.number(name, value) for name, value in _TIME.items()}
    if given is not None:
        turn = matrix_of(steps)
        if is_singular(turn):
            # Told of as any node's transform is.
            return [0.0, 1.0, 0.0]
        ours = (np.linalg.inv(turn[:3, :3]) @ given).tolist()
        # What is nought but for rounding lies on the horizon.
        ours = [0.0 if abs(c) < 1e-12 * max(map(abs, ours)) else c for c in ours]
    else:
        east, up, south = _by_date(light, place, time)
        # Version 3: +x is south and +y west; turned as `sky_and_sun` turns it back.
        ours = [east, up, south] if old else [south, up, east]
    if ours[1] < 0.0 or not any(ours):
        text = "the sun is below the horizon"
        light.context.report.not_covered(light.element, text, "it is put on the horizon")
        ours[1] = 0.0 if ours[0] or ours[2] else 1.0
    return [float(c) for c in ours]


def _by_date(light: Draft, place: dict, time: dict) -> tuple[float, float, float]:
    try:
        day = datetime(int(time["year"]), int(time["month"]), int(time["day"]), tzinfo=UTC)
        hours = time["hour"] - place["timezone"]
        moment = day + timedelta(hours=hours, minutes=time["minute"], seconds=time["second"])
    except (OverflowError, ValueError) as error:
        light.context.report.error(light.element, f"is not a date: {error}")
        return 0.0, 1.0, 0.0
    if not abs(place["latitude"]) <= 90.0 or not abs(place["longitude"]) <= 180.0:
        text = "latitude must be in [-90, 90] and longitude in [-180, 180]"
        got = f"{place['latitude']:g} and {place['longitude']:g}"
        light.context.report.error(light.element, f"{text}, got {got}")
        return 0.0, 1.0, 0.0
    return sun_direction(moment, place["latitude"], place["longitude"])
