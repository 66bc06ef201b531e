"""Mitsuba's sunsky, projectors and textured spots, as lights of the native format."""

import math

import numpy as np
import pytest

from alight.lights.daylight import Daylight
from alight.lights.sun import disk
from tests.formats.mitsuba.reading import issues, node, read


def to_sun(body):
    """Unit vector to the sun in the world, of a scene that is one emitter."""
    found = node(read(body))
    assert isinstance(found.light, Daylight)
    return found.transform.matrix[:3, :3] @ found.light.to_sun


def test_version_3_has_its_sun_where_it_says_with_z_up():
    body = """<emitter type="sunsky"><vector name="sun_direction" x="1" y="2" z="2"/>
    <float name="sun_aperture" value="2"/></emitter>"""
    np.testing.assert_allclose(to_sun(body), [1 / 3, 2 / 3, 2 / 3], atol=1e-6)
    light = node(read(body)).light
    assert light.diameter == 2.0 and light.scale[0] * 106.857 == 1.0


def daylight(more, version="0.6.0"):
    """The light of a sunsky of version 0.6, and the unit vector to its sun in the world."""
    body = f'<emitter type="sunsky">{more}</emitter>'
    found = node(read(body, version))
    return found.light, found.transform.matrix[:3, :3] @ found.light.to_sun


def floats(**values):
    return "".join(f'<float name="{name}" value="{value}"/>' for name, value in values.items())


@pytest.mark.parametrize("version", ["0.6.0", "3.0.0"])
@pytest.mark.parametrize("turned", ['x="1" angle="40"', 'y="1" angle="90"'])
def test_the_sun_is_in_the_world_whatever_turns_the_sky(version, turned):
    old = version < "2"
    name, to_world = ("sunDirection", "toWorld") if old else ("sun_direction", "to_world")
    more = f'<transform name="{to_world}"><rotate {turned}/></transform>'
    more += f'<vector name="{name}" x="1" y="2" z="2"/>'
    np.testing.assert_allclose(daylight(more, version)[1], [1 / 3, 2 / 3, 2 / 3], atol=1e-6)


def test_a_wider_sun_of_version_0_6_gives_the_same_light():
    sun = '<vector name="sunDirection" x="1" y="2" z="2"/>'
    plain, wide = daylight(sun)[0], daylight(sun + floats(sunRadiusScale=4, scale=50))[0]
    assert wide.diameter == pytest.approx(4 * 0.5358)
    np.testing.assert_allclose(sun_light(wide), 50.0 * sun_light(plain), rtol=1e-6)
    assert daylight(sun + floats(sunRadiusScale=0))[0].diameter == 0.01


def sun_light(light):
    """W/m^2 on what faces the sun, in the units of the file: radiance times solid angle."""
    factor = np.multiply(light.scale, light.sun_scale)
    radiance = disk(light, light.diameter, factor, np.eye(4))[4:]
    return radiance * 2.0 * math.pi * (1.0 - math.cos(math.radians(0.5 * light.diameter)))


def test_scales_of_version_0_6_take_the_place_of_the_common_one():
    for more, sun, sky in (
        (floats(scale=50), 50, 50),
        (floats(scale=50, sunScale=2), 2, 50),
        (floats(scale=50, skyScale=0), 50, 0),
        (floats(scale=0, sunScale=3), 3, 0),
    ):
        light, _ = daylight(more)
        for scale, meant in ((light.sun_scale, sun), (light.sky_scale, sky)):
            np.testing.assert_allclose(np.multiply(light.scale, scale) * 106.857, meant, rtol=1e-6)


def test_the_date_gives_mitsubas_sun():
    # What Mitsuba 3.6 says: +x south, +y west.
    for hour, expected in ((9, (0.0983, -0.8102, 0.5778)), (15, (0.4004, 0.4304, 0.8090))):
        numbers = {"latitude": 52.5, "longitude": 13.4, "timezone": 2.0, "hour": float(hour)}
        body = "".join(f'<float name="{k}" value="{v}"/>' for k, v in numbers.items())
        for name, value in (("year", 2020), ("month", 6), ("day", 21)):
            body += f'<integer name="{name}" value="{value}"/>'
        found = to_sun(f'<emitter type="sunsky">{body}</emitter>')
        # The sun's disk is half a degree wide, and a sample of it is what we know.
        assert np.degrees(np.arccos(found @ expected / np.linalg.norm(expected))) < 0.4
        # Version 0.6 has +x in the east, +y up and +z in the south (its sunmodel.h, toSphere).
        found = daylight(body)[1]
        meant = np.array([-expected[1], expected[2], expected[0]])
        assert np.degrees(np.arccos(found @ meant / np.linalg.norm(meant))) < 0.4


def test_what_is_left_out_is_said():
    scene = read('<emitter type="sky"><vector name="sun_direction" x="0" y="0" z="1"/></emitter>')
    assert node(scene).light.type_name() == "sky"
    [warning] = scene.source.remarks.warnings
    assert "Preetham" in warning
    body = '<float name="turbidity" value="{}"/><rgb name="albedo" value="0.5"/>'
    scene = read(f'<emitter type="sunsky">{body.format(40)}</emitter>')
    assert node(scene).light.turbidity == 10.0
    found = " ".join(scene.source.remarks.warnings)
    assert "turbidity 40 became 10" in found and "albedo" in found
    body = '<emitter type="sun"><vector name="sun_direction" x="0" y="1" z="-1"/></emitter>'
    [issue] = issues(body)
    assert "below the horizon" in issue.message
    [issue] = issues('<emitter type="sunsky"><integer name="month" value="13"/></emitter>')
    assert "is not a date" in issue.message
    late = '<integer name="year" value="9999"/><integer name="month" value="12"/>'
    late += '<integer name="day" value="31"/><float name="hour" value="48"/>'
    [issue] = issues(f'<emitter type="sunsky">{late}</emitter>')
    assert "is not a date" in issue.message
    [issue] = issues('<emitter type="sunsky"><float name="latitude" value="140"/></emitter>')
    assert "latitude must be in [-90, 90]" in issue.message and "got 140" in issue.message


def test_projectors():
    body = """<emitter type="projector"><float name="fov" value="60"/>
    <float name="scale" value="2"/>
    <texture type="bitmap" name="irradiance"><string name="filename" value="sky.exr"/></texture>
    </emitter>"""
    light = node(read(body)).light
    assert light.file == "sky.exr" and light.fov == 60.0 and light.evenness == "screen"
    # On a screen at distance 1 Mitsuba's gives pi times the picture.
    assert light.scale == (2 * math.pi,) * 3


@pytest.mark.parametrize("kind", ["spot", "projector"])
def test_cones_that_a_scale_would_deform(kind):
    inside = '<texture type="bitmap" name="{}"><string name="filename" value="sky.exr"/></texture>'
    texture = inside.format("irradiance" if kind == "projector" else "texture")
    for scale, told in (('value="3"', False), ('x="2" y="0.7" z="1.3"', True)):
        turn = '<rotate x="1" angle="30"/><translate z="2"/>'
        to_world = f'<transform name="to_world"><scale {scale}/>{turn}</transform>'
        scene = read(f'<emitter type="{kind}">{to_world}{texture}</emitter>')
        warnings = scene.source.remarks.warnings
        assert [("uneven scale" in text) for text in warnings] == [True] * told


def test_spots_with_a_texture():
    body = """<emitter type="spot"><float name="cutoff_angle" value="40"/>
    <texture type="bitmap" name="texture"><string name="filename" value="sky.exr"/></texture>
    </emitter>"""
    found = node(read(body))
    light = found.light
    assert (light.fov, light.cutoff_angle, light.beam_width) == (80.0, 40.0, 30.0)
    assert light.evenness == "intensity" and light.aspect == 1.0
    # Upside down.
    np.testing.assert_allclose(np.diag(found.transform.matrix), [-1, -1, 1, 1], atol=1e-6)


def test_scales_of_version_3_are_factors_of_the_common_one():
    for more, sun, sky in (
        (floats(scale=50), 50, 50),
        (floats(scale=50, sun_scale=2), 100, 50),
        (floats(scale=50, sky_scale=0), 50, 0),
    ):
        light, _ = daylight(more, "3.0.0")
        for scale, meant in ((light.sun_scale, sun), (light.sky_scale, sky)):
            np.testing.assert_allclose(np.multiply(light.scale, scale) * 106.857, meant, rtol=1e-6)
