"""Compiled light sampling against the same text in NumPy."""

import numpy as np
import pytest

from alight.core.vec import Vec3
from alight.lights.area import Area
from alight.lights.directional import Directional
from alight.lights.environment import EXAMPLES as ENVIRONMENTS
from alight.lights.hits import light_pdf
from alight.lights.misses import environment_pdf, environment_radiance
from alight.lights.point import Point
from alight.lights.sampling import sample_light, shadow_ray
from alight.lights.spot import Spot
from alight.scene.flatten import PlacedLight
from alight.scene.transform import rotate, translate
from alight.shapes.disk import Disk
from alight.shapes.hit import Surface
from alight.shapes.rectangle import Rectangle
from alight.shapes.sphere import Sphere
from lanewise.jit import instantiate, kernel
from lanewise.simd import LANES, lanes, lanes_mask, lanes_u32, store_lanes
from lanewise.view import View
from tests.lights.test_light_sampling import ROOF
from tests.shapes.tracing import PLACEMENTS, World, load_vec3, store_vec3
from tests.shapes.tracing import PROGRAM as CONSTANT_SKY

PROGRAM = CONSTANT_SKY._replace(lights=("point", "directional", "area", "spot", "environment"))
N = 4096
SHINING = Area(radiance=(2.0, 1.0, 0.5))
DOWN = rotate("x", 180).matrix


def everything():
    """One light of each kind, on each kind of shape."""
    turn, turn_only = PLACEMENTS["sheared"], rotate((1, 2, 3), 40).matrix
    return World(
        (Rectangle(), translate(3, 0, 0).matrix, SHINING),
        (Rectangle(), translate(-3, 0, 0).matrix @ turn, SHINING),
        (Sphere(), translate(0, 3, 0).matrix, SHINING),
        (Sphere(), translate(0, -3, 0).matrix @ turn, SHINING),
        (Disk(), translate(3, 3, 0).matrix @ turn, SHINING),
        (ROOF, translate(-3, 3, 0).matrix @ turn, SHINING),
        lights=[
            PlacedLight("point", Point(intensity=9.0), translate(0, 0, 6).matrix),
            PlacedLight("sun", Directional(irradiance=4.0), np.eye(4)),
            PlacedLight("spot", Spot(cutoff_angle=50.0), translate(0, 0, 7).matrix @ DOWN),
        ],
        environment=ENVIRONMENTS[0],
        environment_to_world=turn_only,
        selection="uniform",
    )


@kernel
def _root(scene, points, numbers, vectors, scalars, n):
    i = 0
    while i < n:
        p, up = load_vec3(points, i, n), Vec3(lanes(0.0), lanes(0.0), lanes(1.0))
        u = load_vec3(numbers, i, n)
        s = sample_light(scene, p, up, u.x, (u.y, u.z), lanes_mask(True))
        one, none = lanes(1.0), lanes_u32(0)
        here = Surface(
            p, 1e-6 * one, up, up, up, up, one, one, none, lanes_u32(1), none, none, p, (), (), ()
        )
        o, length = shadow_ray(here, s)
        # What the fourth light would say of a hit along the same ray.
        facing = Surface(
            p,
            one,
            -s.wi,
            up,
            up,
            up,
            one,
            one,
            none,
            lanes_u32(1),
            none,
            lanes_u32(4),
            p,
            (),
            (),
            (),
        )
        store_vec3(vectors, i, n, s.wi)
        store_vec3(vectors, 3 * n + i, n, s.radiance)
        store_vec3(vectors, 6 * n + i, n, o)
        store_lanes(scalars, i, s.distance)
        store_lanes(scalars, n + i, s.pdf)
        store_lanes(scalars, 2 * n + i, s.cosine)
        store_lanes(scalars, 3 * n + i, s.error)
        store_lanes(scalars, 4 * n + i, length)
        store_lanes(scalars, 5 * n + i, light_pdf(scene, facing.light, p, s.wi, one, facing))
        store_lanes(scalars, 6 * n + i, environment_pdf(scene, s.wi, s.wi))
        store_vec3(vectors, 9 * n + i, n, environment_radiance(scene, s.wi))
        i += LANES


@pytest.fixture(scope="module")
def both():
    """(vectors, scalars) of the compiled kernel and of NumPy."""
    rng = np.random.default_rng(1)
    points = rng.uniform(-4, 4, (3, N)).astype(np.float32)
    points[2] = np.abs(points[2]) + 1.5
    u, world, results = rng.random((3, N), np.float32), everything(), []
    for compiled in (True, False):
        vectors, scalars = View(np.zeros(12 * N, np.float32)), View(np.zeros(7 * N, np.float32))
        with np.errstate(all="ignore"):
            instantiate(_root, PROGRAM, compiled=compiled)(
                world.scene, View(points), View(u), vectors, scalars, N
            )
        results.append((vectors.array.reshape(12, N), scalars.array.reshape(7, N)))
    return results


def test_compiled_samples_are_those_of_numpy(both):
    (vectors, scalars), (vectors1, scalars1) = both
    assert np.mean(scalars1[1] > 0.0) > 0.4
    np.testing.assert_array_equal(np.isinf(scalars[0]), np.isinf(scalars1[0]))
    valid = (scalars[1] > 0.0) & (scalars1[1] > 0.0)
    assert np.mean((scalars[1] > 0.0) == (scalars1[1] > 0.0)) > 0.999
    close = np.isclose(vectors, vectors1, rtol=1e-3, atol=1e-4).all(0)
    with np.errstate(invalid="ignore"):
        close &= np.isclose(scalars, scalars1, rtol=5e-3, atol=1e-4).all(0)
    assert close[valid].mean() > 0.999


def test_dead_and_failed_lanes_are_no_nan(both):
    for vectors, scalars in both:
        assert not np.isnan(vectors).any()
        assert not np.isnan(scalars).any()
