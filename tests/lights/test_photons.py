"""Photons: each tells by which way light of its own lamp has come to a place near by."""

import numpy as np

from alight.core.vec import Vec3
from alight.lights.photons import BUCKETS, way_of_photon
from alight.lights.targets import end_of_boxes, target_at
from lanewise.jit import instantiate
from tests.rendering.many_paths import compiled

DEPTH, ABOVE, WATER = 1.0, 2.0, 1.33
SCENE = """
alight: 1
integrator: {type: path, max_depth: 6, caustics: manifold}
camera: {type: pinhole, transform: {translate: [0, 9, 0]}}
nodes:
  floor: {shape: rectangle, transform: [{scale: 3}, {rotate: {axis: x, angle: -90}}]}
  %s
  bulb: {light: {type: point, intensity: 3}, transform: {translate: [0.8, 3, 0]}}
  ball:
    shape: {type: sphere, radius: 0.02, center: [-0.8, 3, 0]}
    light: {type: area, radiance: 2000}
  day:
    light: {type: directional, irradiance: 1}
    transform: [{rotate: {axis: x, angle: 60}}, {rotate: {axis: y, angle: 30}}]
"""
POOL = """water:
    shape: rectangle
    bsdf: {type: dielectric, int_ior: 1.33}
    transform: [{scale: 3}, {rotate: {axis: x, angle: -90}}, {translate: [0, 1, 0]}]"""
STILL = SCENE % POOL
N = 1 << 10


def _as_rows(v, n):
    return np.stack([np.broadcast_to(c, n) for c in (v.x, v.y, v.z)], axis=1).astype(float)


def _lamps(scene):
    """Rows and middles of the targets, and which are infinitely far."""
    rows = np.arange(3, dtype=np.uint32)
    target = instantiate(target_at, scene.program, compiled=False)(scene.tables, rows)
    middles = _as_rows(target.c, 3)
    return zip(rows, middles, np.broadcast_to(target.far, 3), strict=True)


def test_a_photon_tells_the_way_of_its_own_lamp():
    scene = compiled(STILL)
    way = np.errstate(all="ignore")(instantiate(way_of_photon, scene.program, compiled=False))
    first = instantiate(end_of_boxes, scene.program, compiled=False)(scene.tables)
    table = scene.tables.lights.targets.array
    starts, edge = table[first + 1 : first + BUCKETS + 2], 1.0 / table[first]
    assert len(table) == first + BUCKETS + 2 + 3 * starts[-1]
    random = np.random.default_rng(5)
    p = np.zeros((N, 3), np.float32)
    p[:, [0, 2]] = random.uniform(-1.0, 1.0, (N, 2))
    for row, middle, far in _lamps(scene):
        u = random.random(N, np.float32)
        there, to = way(scene.tables, Vec3(*p.T), np.full(N, row), u)
        assert there.mean() > 0.95
        last = (p + _as_rows(to, N))[there]
        # Its light has met the water, and was refracted towards some place of the same cell.
        mine = np.abs(last[:, 1] - DEPTH) < 1e-4
        d = -np.broadcast_to(middle, last.shape) if far else last - middle
        d = d / np.linalg.norm(d, axis=1)[:, None]
        sine = d[:, [0, 2]] / WATER
        tangent = sine / np.sqrt(1.0 - (sine**2).sum(axis=1))[:, None]
        miss = np.abs(last[:, [0, 2]] + DEPTH * tangent - p[there][:, [0, 2]]).max(axis=1)
        # Some cells share a bucket.
        assert (mine & (miss < 1.01 * edge)).mean() > 0.9
        # All photons of a cell are as likely.
        assert len(np.unique(last.round(5), axis=0)) > N // 4


def test_the_same_photons_every_time():
    tables = [compiled(STILL).tables.lights.targets.array for _ in range(2)]
    assert np.array_equal(*tables)


def test_without_mirrors_and_glass_there_are_none():
    scene = compiled(SCENE % "stone: {shape: sphere}")
    half = np.full(8, 0.5, np.float32)
    way = np.errstate(all="ignore")(instantiate(way_of_photon, scene.program, compiled=False))
    there, _ = way(scene.tables, Vec3(half, half, half), np.zeros(8, np.uint32), half)
    assert not np.any(there)
