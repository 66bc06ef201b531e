"""A larger sun gives softer shadows and the same light."""

import numpy as np
import pytest

from alight.lights.daylight import DIAMETER
from alight.lights.misses import environment_pdf, environment_radiance
from alight.lights.sun import Sun
from alight.lights.sunsky import SunSky
from tests.lights.test_daylight import TURN, around
from tests.shapes.tracing import vec

DIRECTION = np.array([0.3, 0.8, 0.5]) / np.linalg.norm([0.3, 0.8, 0.5])
DIAMETERS = (0.01, DIAMETER, 3.0, 20.0, 60.0)


def cap(diameter):
    """Solid angle of a disk in the sky, sr."""
    return 4.0 * np.pi * np.sin(np.radians(0.25 * diameter)) ** 2


def beside(angle):
    """Directions (3, 4) at an angle from the sun, degrees, in the world."""
    s = np.cross(DIRECTION, [1.0, 0.0, 0.0])
    s /= np.linalg.norm(s)
    t, a = np.cross(DIRECTION, s), np.radians(angle)
    rim = [np.cos(a) * DIRECTION + np.sin(a) * w for w in (s, t, -s, -t)]
    return TURN[:3, :3] @ np.stack(rim, axis=1)


@pytest.mark.parametrize("diameter", DIAMETERS)
@pytest.mark.parametrize("model", [Sun, SunSky])
def test_the_light_of_the_sun_does_not_depend_on_its_size(model, diameter):
    fields = {} if model is Sun else {"sky_scale": 0.0, "ground": 0.0}
    light = model(sun_direction=tuple(DIRECTION), diameter=diameter, **fields)
    _, run = around(light)

    def seen(angle):
        d = vec(beside(angle))
        found = run(environment_radiance, d)
        pdf = np.asarray(run(environment_pdf, d, d), float) * np.ones(4)
        return np.array(np.broadcast_arrays(found.x, found.y, found.z), float), pdf

    half = 0.5 * diameter
    expected = np.array(light.of_the_sun) * cap(DIAMETER)
    for part in (0.0, 0.5, 0.98):
        radiance, pdf = seen(part * half)
        # Alike all over the disk, so its light is radiance times solid angle.
        light_of_all = radiance * cap(diameter)
        np.testing.assert_allclose(
            light_of_all, np.broadcast_to(expected[:, None], (3, 4)), rtol=1e-4
        )
        np.testing.assert_allclose(pdf, 1.0 / cap(diameter), rtol=2e-3)
    radiance, _ = seen(1.02 * half)
    assert np.all(radiance < 1e-6 * expected[:, None] / cap(diameter))
