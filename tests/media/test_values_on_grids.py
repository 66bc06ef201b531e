"""What varies on a grid is looked up where a path collides: albedo, emission and density."""

import numpy as np
import pytest

from alight.compiled.scene import compile_scene
from alight.formats import loads
from alight.media.grid import Grid
from alight.media.sampling import fly
from alight.media.tables import Segment, Stream
from alight.media.voxels import emission
from alight.scene import flatten, rotate, scale, translate
from lanewise.jit import instantiate
from lanewise.vec3 import Vec3

N = 4000
SCENE = """
alight: 1
camera: {type: pinhole}
integrator: {type: volpath}
media: {here: {type: homogeneous}}
nodes: {ball: {shape: sphere, bsdf: {type: "null"}, interior: here}}
environment: {type: constant}
"""
_RNG = np.random.default_rng(1)
#: Counts of cells along z, y and x: each table has its own.
DENSITIES = 0.3 + 0.7 * _RNG.random((3, 4, 5))
ALBEDOS = _RNG.random((2, 5, 3, 3))
EMISSIONS = 4.0 * _RNG.random((4, 2, 6, 3))
TURNED = (
    translate(1.0, -2.0, 0.5)
    @ rotate((1, 2, 3), 50.0)
    @ scale(1.5, 0.8, 1.1)
    @ rotate((1, 1, 0), 30)
).matrix
PLACES = {
    "box": {"low": (-1.0, 0.5, 2.0), "high": (0.0, 2.5, 3.5)},
    "turned": {"matrix": tuple(TURNED[:3].ravel())},
}


def grid(place):
    """The medium, and its matrix from the unit cube to the world."""
    fields = {"values": DENSITIES, "albedo_values": ALBEDOS, "emission_values": EMISSIONS}
    spec = Grid(**fields, sigma_t=(1.5, 0.9, 0.4), **PLACES[place])
    if place == "turned":
        return spec, TURNED
    matrix = np.diag([*np.subtract(spec.high, spec.low), 1.0])
    matrix[:3, 3] = spec.low
    return spec, matrix


def between_centres(values, p):
    """Rows of a table (nz, ny, nx, c) between the centres of its cells, p (3, n) in [0, 1]."""
    counts = np.array(values.shape[2::-1])[:, None]
    at = np.clip(p * counts - 0.5, 0.0, counts - 1.0)
    first = np.minimum(at.astype(int), np.maximum(counts - 2, 0))
    part = at - first
    total = 0.0
    for corner in np.ndindex(2, 2, 2):
        step = np.array(corner)[:, None]
        x, y, z = np.minimum(first + step, counts - 1)
        total = total + values[z, y, x] * np.prod(np.where(step, part, 1.0 - part), axis=0)[:, None]
    return total.T


@pytest.mark.parametrize("place", PLACES)
def test_values_are_those_of_the_place_of_the_collision(place):
    spec, matrix = grid(place)
    scene = loads(SCENE, "grid")
    compiled = compile_scene(flatten(scene.replaced(media={"here": spec})), structure="list")
    run_fly, run_emission = (
        np.errstate(all="ignore")(instantiate(root, compiled.program, compiled=False))
        for root in (fly, emission)
    )
    rng = np.random.default_rng(2)
    middle, radius = matrix[:3, :3] @ np.full(3, 0.5) + matrix[:3, 3], 3.0
    o = rng.normal(size=(3, N))
    o = middle[:, None] + radius * o / np.linalg.norm(o, axis=0)
    d = matrix[:3, :3] @ rng.random((3, N)) + matrix[:3, 3:] - o
    o, d = o.astype(np.float32), (d / np.linalg.norm(d, axis=0)).astype(np.float32)
    rows, every = np.ones(N, np.uint32), np.ones(N, bool)
    channel = rng.integers(0, 3, N).astype(np.uint32)
    stream = Stream(*(rng.integers(0, 2**32, N, np.uint32) for _ in range(3)))
    far = np.full(N, 100.0, np.float32)
    u = rng.random(N, np.float32)
    segment = Segment(Vec3(*o), Vec3(*d), far, rows, channel, stream)
    flight = run_fly(compiled.tables, segment, u, every)
    hit = flight.scattered
    assert 0.15 < hit.mean() < 0.9
    p = o + np.where(hit, flight.t, 0.0) * d
    inverse = np.linalg.inv(matrix)
    cube = inverse[:3, :3] @ p + inverse[:3, 3:]
    assert np.all(np.abs(cube[:, hit] - 0.5) < 0.5 + 1e-5)
    albedo = np.stack([flight.albedo.x, flight.albedo.y, flight.albedo.z])
    np.testing.assert_allclose(albedo[:, hit], between_centres(ALBEDOS, cube)[:, hit], atol=2e-5)
    light = run_emission(compiled.tables, rows, Vec3(*p.astype(np.float32)))
    shines = np.stack([light.x, light.y, light.z])
    np.testing.assert_allclose(shines[:, hit], between_centres(EMISSIONS, cube)[:, hit], atol=1e-4)
