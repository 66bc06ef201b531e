"""Pictures of what moves, against closed forms and quadrature."""

import numpy as np
import pytest

from alight.films import fixed_point
from tests.motion.moving import HEAD, SIZE, centres, check_shares, compiled, partial_film, picture

LAMP = "light: {type: area, radiance: 1}"


def across(begin, end, first, last):
    """Part of the time in which a strip of half width 1 covers the columns, while it moves."""
    x = np.arange(-4.0, 5.0)
    # Covered while |x - centre(t)| <= 1; linear in x between whole numbers here.
    speed = last - first
    times = np.sort([(x - 1.0 - first) / speed, (x + 1.0 - first) / speed], axis=0)
    covered = np.clip(times[1], begin, end) - np.clip(times[0], begin, end)
    return 0.5 * (covered[1:] + covered[:-1]) / (end - begin)


@pytest.mark.parametrize(
    ("shutter", "expected"),
    [("[0, 1]", across(0.0, 1.0, -2.0, 2.0)), ("[0.25, 0.75]", across(0.25, 0.75, -2.0, 2.0))],
)
def test_a_strip_that_moves_across_pixels_covers_each_as_long_as_it_is_there(shutter, expected):
    """Every time of the shutter is equally likely, and no other is seen."""
    text = (
        HEAD.replace("height: 8", f"height: 8, shutter: {shutter}")
        + f"""
nodes:
  strip:
    transform:
      keyframes: [{{time: 0, scale: [1, 9, 1], translate: [-2, 0, 0]}},
                  {{time: 1, scale: [1, 9, 1], translate: [2, 0, 0]}}]
    shape: rectangle
    {LAMP}
"""
    )
    spp = 256
    found, _ = picture(text, spp)
    check_shares(found, np.tile(expected, (SIZE, 1)), spp)


def test_before_and_after_the_keyframes_nothing_moves():
    """Half of this shutter lies before the first one."""
    text = (
        HEAD.replace("height: 8", "height: 8, shutter: [-1, 1]")
        + f"""
nodes:
  strip:
    transform: {{keyframes: [{{time: 0, translate: [-2, 0, 0]}},
                             {{time: 1, translate: [2, 0, 0]}}]}}
    children:
      strip: {{transform: {{scale: [1, 9, 1]}}, shape: rectangle, {LAMP}}}
"""
    )
    resting = ((np.arange(SIZE) >= 1) & (np.arange(SIZE) < 3)).astype(float)
    expected = 0.5 * resting + 0.5 * across(0.0, 1.0, -2.0, 2.0)
    spp = 256
    check_shares(picture(text, spp)[0], np.tile(expected, (SIZE, 1)), spp)


def test_a_blade_turns_about_the_hub_above_it_in_the_graph():
    """A child of a turning node goes around in a circle, not along the chord."""
    text = f"""
nodes:
  hub:
    transform: {{keyframes: [{{time: 0}}, {{time: 1, rotate: {{axis: z, angle: 120}}}}]}}
    children:
      blade:
        transform: [{{scale: [1.5, 0.4, 1]}}, {{translate: [2, 0, 0]}}]
        shape: rectangle
        {LAMP}
"""
    spp = 512
    x, y = centres()
    expected = np.zeros((SIZE, SIZE))
    angles = np.radians(120.0) * (np.arange(400) + 0.5) / 400
    for a in angles:
        u, v = np.cos(a) * x + np.sin(a) * y, np.cos(a) * y - np.sin(a) * x
        expected += ((np.abs(u - 2.0) < 1.5) & (np.abs(v) < 0.4)).mean(axis=2) / len(angles)
    check_shares(picture(text, spp)[0], expected, spp)


def test_moving_parts_of_moving_parts_and_stretches():
    """A chain of two links that does not keep its shape, against its formula."""
    text = """
nodes:
  outer:
    transform: {scale: [1, 0.5, 1]}
    children:
      arm:
        transform: {keyframes: [{time: 0}, {time: 1, rotate: {axis: z, angle: 90}}]}
        children:
          disk:
            transform:
              keyframes: [{time: 0, translate: [1, 0, 0]},
                          {time: 0.5, scale: 1.5, translate: [2, 0, 0]},
                          {time: 1, scale: 0.5, translate: [3, 0, 0]}]
            shape: disk
environment: {type: constant, radiance: 1}
"""
    spp = 512
    x, y = centres()
    expected = np.zeros((SIZE, SIZE))
    times = (np.arange(400) + 0.5) / 400
    for t in times:
        a = 0.5 * np.pi * t
        u, v = np.cos(a) * x + np.sin(a) * 2.0 * y, np.cos(a) * 2.0 * y - np.sin(a) * x
        radius = np.interp(t, [0.0, 0.5, 1.0], [1.0, 1.5, 0.5])
        expected += (np.hypot(u - 1.0 - 2.0 * t, v) < radius).mean(axis=2) / len(times)
    # The disk is dark, what is around it shines.
    assert "rigid" not in compiled(text).program.motion
    check_shares(1.0 - picture(text, spp)[0], expected, spp)


WORLD = """
alight: 1
film: {size: [8, 8]}
sampler: independent
integrator: {type: path, max_depth: 1}
environment: {type: constant, radiance: 0.1}
camera: rig/camera
nodes:
  rig:
    transform: %s
    children:
      camera:
        transform: [{rotate: {axis: y, angle: 20}}, {translate: [1, 0, 4]}]
        camera: {type: thin_lens, fov: 60, aperture_radius: 0.2, focus_distance: 4}
  outer:
    transform: %s
    children:
      inner:
        transform: %s
        children:
          ball:
            transform: {translate: [0.5, 0, 0]}
            shape: {type: sphere, radius: 1.2}
            light: {type: area, radiance: {type: checkerboard, to_uv: {scale: 4}}}
          wall:
            transform: [{scale: 3}, {translate: [0, 0, -2]}]
            shape: rectangle
            light: {type: area, radiance: {type: checkerboard, to_uv: {scale: 3}}}
"""


def test_a_moving_camera_sees_what_a_moving_scene_shows():
    """Relative motion alone counts: the same samples give the same values.

    The camera's T R is undone by the inverse of R after that of T.
    """
    until = "{keyframes: [{time: 0}, {time: 1, %s}]}"
    turn, back = (f"rotate: {{axis: [1, 2, 3], angle: {angle}}}" for angle in (40, -40))
    there = turn + ", translate: [0.5, 1, -0.5]"
    rest, away = "{translate: [0, 0, 0]}", "translate: [-0.5, -1, 0.5]"
    one, _ = picture(WORLD % (until % there, rest, rest), 64)
    other, _ = picture(WORLD % (rest, until % back, until % away), 64)
    still, _ = picture(WORLD % (rest, rest, rest), 64)
    assert 0.2 < one.mean() < 0.95
    assert np.abs(one - still).max() > 0.2
    # A sample on an edge may fall to either side.
    np.testing.assert_allclose(one, other, atol=1.5 / 64, rtol=0.0)
    assert np.abs(one - other).mean() < 1e-3


def test_keyframes_that_do_not_differ_are_a_transform_that_rests():
    """No time is drawn, no table added: the picture of the still scene, bit for bit."""
    still = "{translate: [1, 0.5, 0]}"
    nodes = "\nnodes: {a: {transform: %s, shape: sphere, light: area}}"
    frames = "{keyframes: [{time: 0, translate: [1, 0.5, 0]}, {time: 1, translate: [1, 0.5, 0]}]}"
    rest, same = compiled(nodes % still), compiled(nodes % frames)
    assert rest.program == same.program
    assert rest.program.motion == ()
    assert same.tables._fields == rest.tables._fields
    np.testing.assert_array_equal(picture(nodes % still, 8)[0], picture(nodes % frames, 8)[0])


def test_a_shutter_that_closes_at_once_shows_one_moment():
    """It is the picture of a scene that rests where it is then."""
    frames = "{keyframes: [{time: 0}, {time: 2, translate: [2, 4, 0]}]}"
    nodes = "\nnodes: {a: {transform: %s, shape: sphere, light: area}}"
    sharp = HEAD.replace("height: 8", "height: 8, shutter: [1, 1]") + nodes % frames
    assert compiled(sharp).program.motion == ()
    np.testing.assert_array_equal(
        picture(sharp, 8)[0], picture(nodes % "{translate: [1, 2, 0]}", 8)[0]
    )


# ---------------------------------------------------------------- layers


def test_normals_and_depths_are_those_of_the_time():
    """A wall that turns by 60 degrees about y, and comes nearer by 2 m."""
    text = """
nodes:
  wall:
    transform:
      keyframes: [{time: 0, rotate: {axis: y, angle: -30}, translate: [0, 0, -2]},
                  {time: 1, rotate: {axis: y, angle: 30}}]
    children: {wall: {transform: {scale: 30}, shape: rectangle}}
environment: {type: constant}
"""
    film = partial_film(text, 256, aovs=("normal", "depth"))
    normal, depth = (fixed_point.to_float(film.aovs[name]) / 256 for name in ("normal", "depth"))
    normal, depth = normal.reshape(-1, 3).mean(axis=0), depth.mean()
    samples = 256 * SIZE * SIZE
    half = np.radians(30.0)
    mean = np.sin(half) / half
    spread = np.sqrt(0.5 + np.sin(2.0 * half) / (4.0 * half) - mean**2)
    assert abs(normal[2] - mean) < 4.0 * spread / np.sqrt(samples)
    assert abs(normal[0]) < 4.0 * np.sqrt(1.0 - mean**2) / np.sqrt(samples)
    # The plane through the moving centre: x tan(angle) adds up to nothing over the picture.
    assert abs(depth - 10.0) < 4.0 * 1.4 / np.sqrt(samples)


# ---------------------------------------------------------------- light

FLOOR = """
alight: 1
film: {size: [8, 8]}
sampler: independent
integrator: {type: path, max_depth: 2, light_sampling: %s}
camera: {type: orthographic, height: 0.02, transform: {translate: [0, 0, 0.3]}}
nodes:
  floor: {shape: rectangle, bsdf: {type: diffuse, reflectance: 0.5}}
  lamp:
    transform: {keyframes: [{time: 0, translate: [-2, 0, 2]}, {time: 1, translate: [3, 0, 2]}]}
    children: {lamp: {%s}}
"""


def mean_over_time(values):
    """The mean over x from -2 to 3, at the height of 2 m."""
    x = -2.0 + 5.0 * (np.arange(20000) + 0.5) / 20000
    return values(x, np.hypot(x, 2.0)).mean()


@pytest.mark.parametrize("how", ["mis", "emitter", "bsdf"])
def test_a_moving_ball_of_light_lights_the_floor_by_its_formula(how):
    """E = pi L (r / d)^2 cos, whatever finds the light; so pdf and sample agree at every time."""
    lamp = "shape: {type: sphere, radius: 1.5}, light: {type: area, radiance: 1}"
    expected = 0.5 * mean_over_time(lambda x, d: (1.5 / d) ** 2 * 2.0 / d)
    _, replicates = picture(FLOOR % (how, lamp), 256)
    parts = replicates.reshape(-1)
    error = parts.std() / np.sqrt(len(parts))
    assert error < 0.02 * expected
    assert abs(parts.mean() - expected) < 4.0 * error


def test_a_moving_point_of_light_lights_the_floor_by_its_formula():
    """E = I cos / d^2; only light sampling finds it."""
    expected = 0.5 / np.pi * mean_over_time(lambda x, d: 2.0 / d**3)
    _, replicates = picture(FLOOR % ("mis", "light: {type: point, intensity: 1}"), 128)
    parts = replicates.reshape(-1)
    error = parts.std() / np.sqrt(len(parts))
    assert error < 0.01 * expected
    assert abs(parts.mean() - expected) < 4.0 * error


def test_fog_goes_along_with_the_shape_that_bounds_it():
    """A block of fog that moves along the view takes the same light at all times."""
    text = """
alight: 1
film: {size: [8, 8]}
sampler: independent
integrator: volpath
camera: {type: orthographic, height: 1, transform: {translate: [0, 0, 9]}}
environment: {type: constant}
nodes:
  block:
    transform: {keyframes: [{time: 0, translate: [0, 0, -3]},
                            {time: 1, rotate: {axis: z, angle: 90}, translate: [0, 0, 3]}]}
    shape: cube
    bsdf: {type: "null"}
    interior: {type: homogeneous, sigma_a: 0.4, sigma_s: 0}
"""
    found, _ = picture(text, 32)
    mean, n = np.exp(-0.8), 32 * SIZE * SIZE
    assert abs(found.mean() - mean) < 4.0 * np.sqrt(mean * (1.0 - mean) / n)


def test_the_sums_of_a_tile_do_not_depend_on_how_time_is_used_elsewhere():
    """The time of a sample is a dimension of its own: still parts have their values bit for bit."""
    still = "\nnodes: {a: {shape: sphere, light: area}%s}"
    aside = ", b: {transform: {keyframes: [{time: 0, translate: [0, 0, 90]}, {time: 1, translate: "
    aside += "[1, 0, 90]}]}, shape: sphere}"
    one, two = partial_film(still % "", 16), partial_film(still % aside, 16)
    np.testing.assert_array_equal(fixed_point.to_float(one.sums), fixed_point.to_float(two.sums))
