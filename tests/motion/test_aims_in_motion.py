"""What walks aim at while it moves: at each instant that of the scene that rests there."""

import numpy as np
import pytest

from alight.compiled.at_times import tables_at
from alight.core.vec import Vec3
from alight.lights.photons import SLOTS, way_of_photon
from alight.lights.targets import FINE, end_at_point, end_of_boxes, target_at, way_to_caster
from lanewise.jit import instantiate
from tests.motion.moving import compiled

N = 1 << 11
TIMES = (0.0, 0.37, 0.9)
HEAD = """
alight: 1
integrator: {type: path, max_depth: 6, caustics: manifold}
camera: {type: pinhole, shutter: [%s, %s], transform: {translate: [0, 9, 0]}}
nodes:
"""
TURNING = """
  wheel:
    transform: {keyframes: [{time: 0, rotate: {axis: [1, 2, 3], angle: 10}},
                            {time: 0.5, translate: [0, 1, 0], rotate: {axis: y, angle: 150}},
                            {time: 1, translate: [0, 2, 0], rotate: {axis: x, angle: 40}}]}
    children:
      ball: {shape: {type: sphere, radius: 0.5, center: [0, 3, 1]}, light: area}
      mesh: {transform: {translate: [2, 2, 0]}, light: area,
             shape: {type: mesh, vertices: [[-1, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0]],
                     faces: [[0, 1, 2], [0, 1, 3]]}}
      bulb: {light: {type: point, intensity: 3}, transform: {translate: [1, 0, 1]}}
      spot: {light: {type: spot, cutoff_angle: 170}, transform: {translate: [0, 0, 1]}}
      day: {light: {type: directional, irradiance: 2}}
      mirror: {shape: {type: sphere, radius: 0.25, center: [-2, -1, 4]}, bsdf: {type: mirror}}
  still:
    {shape: {type: sphere, radius: 0.1, center: [0, -5, 0]}, light: area, bsdf: {type: mirror}}
"""
#: The lights that have none, the ball at rest, the one that moves, and half of the mesh's diagonal.
SIZES = [FINE, FINE, FINE, 0.1, 0.5, np.sqrt(2.0)]
LIGHTS = len(SIZES)


def twin_of(root, scene):
    """The kernel in NumPy."""
    return np.errstate(all="ignore")(instantiate(root, scene.program, compiled=False))


def rows(v, n):
    """A vector of lanes, (n, 3)."""
    return np.stack([np.broadcast_to(c, n) for c in (v.x, v.y, v.z)], axis=1).astype(float)


def scenes(text):
    """At each time: (the tables of what moves there, that scene; of what rests there)."""
    moving = compiled(HEAD % (0, 1) + text)
    for time in TIMES:
        still = compiled(HEAD % (time, time) + text)
        assert not still.program.motion
        yield moving, still, tables_at(moving.tables, np.full(N, time, np.float32))


@pytest.fixture(scope="module")
def turning():
    return list(scenes(TURNING))


def test_lamps_are_aimed_at_where_they_are(turning):
    index = np.arange(LIGHTS, dtype=np.uint32)
    for moving, still, at in turning:
        found = twin_of(target_at, moving)(at._replace(time=at.time[:LIGHTS]), index)
        wanted = twin_of(target_at, still)(still.tables, index)
        np.testing.assert_allclose(rows(found.c, LIGHTS), rows(wanted.c, LIGHTS), atol=2e-5)
        np.testing.assert_array_equal(found.far, wanted.far)
        # They keep their sizes: the box around the mesh is that before it turns.
        np.testing.assert_allclose(np.sort(found.radius), SIZES, rtol=1e-4)


def test_lamps_without_a_size_shine_from_where_they_are(turning):
    """Rays from anywhere to them, and what they find."""
    random = np.random.default_rng(3)
    o = random.uniform(-1.0, 1.0, (N, 3)).astype(np.float32)
    index = random.integers(0, LIGHTS, N).astype(np.uint32)
    t, last = np.full(N, np.inf, np.float32), np.ones(N, bool)
    for moving, still, at in turning:
        target = twin_of(target_at, still)(still.tables, index)
        to = np.where(target.far[:, None], rows(target.c, N), rows(target.c, N) - o)
        d = to / np.linalg.norm(to, axis=1)[:, None]
        ray = Vec3(*o.T), Vec3(*d.astype(np.float32).T), t, last
        wanted = rows(twin_of(end_at_point, still)(still.tables, target, *ray)[1], N)
        aim = twin_of(target_at, moving)(at, index)
        found = rows(twin_of(end_at_point, moving)(at, aim, *ray)[1], N)
        lit = wanted.max(axis=1) > 0.0
        assert set(index[lit]) == set(index[target.delta])
        np.testing.assert_allclose(found, wanted, rtol=1e-3)


def test_mirrors_are_aimed_at_where_they_are(turning):
    half = np.full(N, 0.5, np.float32)
    u = (np.arange(N, dtype=np.float32) + 0.5) / N
    for moving, still, at in turning:
        points = []
        for scene, tables in ((moving, at), (still, still.tables)):
            middle = twin_of(way_to_caster, scene)(tables, Vec3(half, half, half), u, (half,) * 3)
            points.append(rows(middle[1], N))
        np.testing.assert_allclose(*points, atol=2e-5)
        assert np.ptp(points[0][:, 1]) > 1.0


#: Water that rises, and lamps that pass above it.
WATER, RISE, SPEED = 1.33, 0.4, 2.0
POOL = """
  floor: {shape: rectangle, transform: [{scale: 3}, {rotate: {axis: x, angle: -90}}]}
  flood:
    transform: {keyframes: [{time: 0, translate: [0, 1, 0]}, {time: 1, translate: [0, %g, 0]}]}
    children:
      water: {shape: rectangle, bsdf: {type: dielectric, int_ior: %g},
              transform: [{scale: 3}, {rotate: {axis: x, angle: -90}}]}
  bulb:
    light: {type: point, intensity: 3}
    transform: {keyframes: [{time: 0, translate: [-1, 3, 0]}, {time: 1, translate: [%g, 3, 0]}]}
"""


def test_photons_tell_the_way_at_the_time_of_the_path():
    scene = compiled(HEAD % (0, 1) + POOL % (1.0 + RISE, WATER, SPEED - 1.0))
    random = np.random.default_rng(5)
    time = random.random(N, np.float32)
    time[-1] = np.float32(1.0) - np.float32(2.0**-24)
    at = tables_at(scene.tables, time)
    first = twin_of(end_of_boxes, scene)(scene.tables)
    edge = 1.0 / scene.tables.lights.targets.array[first]
    p = np.zeros((N, 3), np.float32)
    p[:, [0, 2]] = random.uniform(-0.5, 0.5, (N, 2))
    p[:, 0] += SPEED * time - 1.0
    there, to = twin_of(way_of_photon, scene)(
        at, Vec3(*p.T), np.zeros(N, np.uint32), random.random(N, np.float32)
    )
    assert there.mean() > 0.75
    last = (p + rows(to, N))[there]
    # It has gone along with the water.
    depth = 1.0 + RISE * time[there]
    mine = np.abs(last[:, 1] - depth) < 1e-5
    assert mine.mean() > 0.98
    # Its light was refracted towards a place of the same cell, from where the lamp is at some time
    # of the same slot; where it strays by x, the light on the ground does by less than this part.
    strays = SPEED / SLOTS * (1.0 + RISE) / (2.0 - RISE) / WATER
    lamp = np.stack([SPEED * time[there] - 1.0, np.full(len(last), 3.0), np.zeros(len(last))], 1)
    d = last - lamp
    sine = d[:, [0, 2]] / np.linalg.norm(d, axis=1)[:, None] / WATER
    tangent = sine / np.sqrt(1.0 - (sine**2).sum(axis=1))[:, None]
    miss = np.abs(last[:, [0, 2]] + depth[:, None] * tangent - p[there][:, [0, 2]]).max(axis=1)
    # Some cells share a bucket. Of photons of any time, half would be as near.
    assert (miss < edge + strays).mean() > 0.75
