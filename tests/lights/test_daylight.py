"""Sun and sky: where the sun stands, how bright both are, and how they are sampled."""

from datetime import datetime, timedelta, timezone

import numpy as np
import pytest

from alight.core.errors import SceneError
from alight.lights.atmosphere import sky_radiance, sun_radiance, sun_transmittance
from alight.lights.daylight import DIAMETER, picture, solid_angle
from alight.lights.misses import environment_pdf, environment_radiance
from alight.lights.sampling import sample_light
from alight.lights.sky import Sky
from alight.lights.solar_position import solar_angles, sun_direction
from alight.lights.sun import Sun
from alight.lights.sunsky import SunSky
from alight.scene.transform import rotate
from lanewise.jit import instantiate
from tests.sampling.statistics import LARGEST_Z, length_error
from tests.shapes.tracing import PROGRAM, World, vec

LUMINANCE = np.array([0.212671, 0.715160, 0.072169])
N = 40_000


def zone(hours):
    """A time zone east of Greenwich."""
    return timezone(timedelta(hours=hours))


def test_position_of_the_sun_in_golden():
    # The example of Reda and Andreas, Solar position algorithm (NREL 2003): zenith angle
    # 50.11162 with 0.016 of refraction, azimuth 194.34024.
    time = datetime(2003, 10, 17, 12, 30, 30, tzinfo=zone(-7))
    elevation, azimuth = np.degrees(solar_angles(time, 39.742476, -105.1786))
    assert 90.0 - elevation == pytest.approx(50.128, abs=0.01)
    assert azimuth % 360.0 == pytest.approx(194.340, abs=0.01)


@pytest.mark.parametrize(
    ("moment", "declination"),
    [("2000-06-21T01:48+00:00", 23.438), ("2000-12-21T13:37+00:00", -23.438),
     ("2000-03-20T07:35+00:00", 0.0), ("2000-09-22T17:28+00:00", 0.0)],
)  # fmt: skip
def test_solstices_and_equinoxes(moment, declination):
    # At the pole the elevation is the declination.
    elevation, _ = solar_angles(datetime.fromisoformat(moment), 90.0, 0.0)
    assert np.degrees(elevation) == pytest.approx(declination, abs=0.01)


def test_the_sun_rises_in_the_east_and_is_in_the_south_at_noon():
    morning = sun_direction(datetime(2026, 3, 20, 7, tzinfo=zone(0)), 45.0, 0.0)
    noon = sun_direction(datetime(2026, 3, 20, 12, tzinfo=zone(0)), 45.0, 0.0)
    assert morning[0] > 0.9 and noon[2] > 0.7 and abs(noon[0]) < 0.05
    assert np.linalg.norm(noon) == pytest.approx(1.0)


def test_sunlight_is_as_bright_as_measured():
    # 126 klx stand above the air; 100 klx arrive from the zenith through clear air.
    sun = np.array(sun_radiance(np.pi / 2, 2.0))
    assert sun @ LUMINANCE * solid_angle(DIAMETER) * 683.0 == pytest.approx(100e3, rel=0.03)
    above = sun_transmittance(np.pi / 2, 2.0)
    assert above[0] < above[17] < above[-1]
    # The lower, the redder.
    low = np.array(sun_radiance(np.radians(10), 2.0))
    assert low[2] / low[0] < 0.5 * sun[2] / sun[0]


def test_the_sky_is_preethams():
    # The zenith by the closed form: 4.0453 T - 4.9710 times tan chi, with the sun at 45 degrees.
    up, sun = np.array([[0.0, 1.0, 0.0]]), np.array([0.0, 1.0, 1.0]) / np.sqrt(2.0)
    chi = (4.0 / 9.0 - 3.0 / 120.0) * np.pi / 2.0
    expected = (4.0453 * 3.0 - 4.9710) * np.tan(chi) - 0.2155 * 3.0 + 2.4192
    found = sky_radiance(up, sun, 3.0) @ LUMINANCE
    assert found[0] == pytest.approx(1000.0 * expected / 683.0, rel=1e-3)
    # Blue above, brightest around the sun.
    assert sky_radiance(up, sun, 3.0)[0, 2] > 2.0 * sky_radiance(up, sun, 3.0)[0, 0]
    near = sky_radiance(sun[None], sun, 3.0) @ LUMINANCE
    assert near[0] > 3.0 * found[0]


def test_the_ground_reflects_what_falls_on_it():
    light = SunSky(sun_direction=(0.3, 1.0, 0.2))
    pixels = picture(light, (1.0, 1.0, 1.0), (1.0, 1.0, 1.0), (0.5, 0.2, 0.0))
    rng = np.random.default_rng(1)
    z = np.sqrt(rng.random(N))
    r, phi = np.sqrt(1.0 - z * z), 2.0 * np.pi * rng.random(N)
    d = np.stack([r * np.cos(phi), z, r * np.sin(phi)], axis=-1)
    sky = np.pi * sky_radiance(d, light.to_sun, 3.0)
    disk = np.array(light.of_the_sun) * solid_angle(DIAMETER) * light.to_sun[1]
    expected = (sky.mean(axis=0) + disk) * [0.5, 0.2, 0.0] / np.pi
    error = sky.std(axis=0) / np.sqrt(N)
    assert np.all(np.abs(pixels[-1, 0] - expected) <= LARGEST_Z * error + 2e-3 * expected)


LIGHTS = {
    "sky": Sky(sun_direction=(0.3, 0.8, 0.5)),
    "sun": Sun(sun_direction=(0.3, 0.8, 0.5)),
    "sunsky": SunSky(sun_direction=(0.3, 0.8, 0.5), scale=(1.0, 0.9, 0.8)),
    "large sun": SunSky(sun_direction=(0.3, 0.8, 0.5), diameter=20.0),
    "no sun": SunSky(sun_direction=(0.3, 0.8, 0.5), sun_scale=0.0),
    "no sky": SunSky(sun_direction=(0.3, 0.8, 0.5), sky_scale=0.0, ground=0.0),
}
TURN = rotate((1, 2, 3), 40).matrix


def around(light):
    """Its world, and a function that runs a kernel there in NumPy."""
    world = World(environment=light, environment_to_world=TURN)
    program = PROGRAM._replace(lights=world.lights.kinds, single_light=True)

    def run(text, *arguments):
        with np.errstate(all="ignore"):
            return instantiate(text, program, compiled=False)(world.scene, *arguments)

    return world, run


def sampled(run, seed=1):
    """Directions (3, N), radiance (3, N) and density."""
    u = np.random.default_rng(seed).random((3, N), np.float32)
    p = vec(np.zeros((3, N)))
    s = run(sample_light, p, p, u[0], (u[1], u[2]), np.ones(N, bool))
    return (
        np.stack([s.wi.x, s.wi.y, s.wi.z]),
        np.stack([s.radiance.x, s.radiance.y, s.radiance.z]).astype(float),
        np.asarray(s.pdf, float),
    )


@pytest.mark.parametrize("light", LIGHTS.values(), ids=LIGHTS)
def test_samples_and_rays_agree(light):
    _, run = around(light)
    wi, radiance, pdf = sampled(run)
    assert length_error(wi) < 1e-6
    np.testing.assert_allclose(run(environment_pdf, vec(wi), vec(wi)), pdf, rtol=2e-3)
    seen = run(environment_radiance, vec(wi))
    np.testing.assert_allclose([seen.x, seen.y, seen.z], radiance, rtol=1e-3, atol=1e-4)


@pytest.mark.parametrize("light", LIGHTS.values(), ids=LIGHTS)
def test_light_sampling_finds_all_the_light(light):
    _, run = around(light)
    wi, radiance, pdf = sampled(run)
    lit = pdf > 0.0
    value = np.where(lit, (radiance[1]) / np.where(lit, pdf, 1.0), 0.0)
    # All light over the sphere: what the power was made of.
    sky = light.sky_scale if isinstance(light, SunSky) else (1.0, 1.0, 1.0)
    sun = light.sun_scale if isinstance(light, SunSky) else (1.0, 1.0, 1.0)
    expected = 0.0
    if not isinstance(light, Sun):
        below = (0.0, 0.0, 0.0) if isinstance(light, Sky) else sun
        pixels = picture(light, sky, below, light.ground).astype(float)
        theta = np.linspace(0.0, np.pi, len(pixels))
        weights = np.sin(theta) * (np.pi / (len(pixels) - 1)) * 2.0 * np.pi
        expected += float((pixels[:, :, 1].mean(axis=1) * weights).sum())
    if not isinstance(light, Sky):
        expected += light.of_the_sun[1] * sun[1] * solid_angle(DIAMETER)
    expected *= light.scale[1]
    error = value.std(ddof=1) / np.sqrt(N)
    assert abs(value.mean() - expected) < LARGEST_Z * error + 2e-3 * expected
    # A uniform direction finds the same density: it integrates to 1.
    z = 2.0 * np.random.default_rng(3).random(N) - 1.0
    phi = 2.0 * np.pi * np.random.default_rng(4).random(N)
    d = np.stack([np.sqrt(1 - z * z) * np.cos(phi), z, np.sqrt(1 - z * z) * np.sin(phi)])
    share = 0.0
    if not isinstance(light, Sky):
        # The sun's part by its own solid angle.
        to_sun, edge = TURN[:3, :3] @ light.to_sun, np.cos(np.radians(0.5 * light.diameter))
        d = d[:, d.T @ to_sun < edge]
        share = float(np.mean(wi.T @ to_sun > edge))
    density = np.asarray(run(environment_pdf, vec(d), vec(d)), float) * np.ones(d.shape[1])
    total = 4.0 * np.pi * density.sum() / N + share
    spread = 4.0 * np.pi * density.std() / np.sqrt(N) + 1.0 / np.sqrt(N)
    assert abs(total - 1.0) < LARGEST_Z * spread


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({}, "needs sun_direction, or time, latitude and longitude"),
        ({"sun_direction": (0, 1, 0), "time": "2026-01-01T12:00Z"}, "takes either"),
        ({"sun_direction": (0, 0, 0)}, "must not have length 0"),
        ({"sun_direction": (0, -0.1, 1)}, "below the horizon"),
        ({"time": "noon", "latitude": 1, "longitude": 1}, "must be a date and time"),
        ({"time": "2026-01-01T12:00", "latitude": 1, "longitude": 1}, "needs its zone"),
        ({"time": "1826-01-01T12:00Z", "latitude": 1, "longitude": 1}, "between the years"),
        ({"time": "2026-01-01T00:00Z", "latitude": 50, "longitude": 0}, "degrees below"),
        ({"sun_direction": (0, 1, 0), "turbidity": 1}, "[2, 10]"),
    ],
)
def test_days_that_cannot_be(fields, words):
    with pytest.raises(SceneError, match=words.replace("[", r"\[")):
        SunSky(**fields)
