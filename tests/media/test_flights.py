"""Free flights and shadow rays, by the text of the kernels alone: many lanes at once, no compiler.

Weighted by the densities that they carry, what comes through is the transmittance in every channel,
whichever of them chose the distances.
"""

import numpy as np
import pytest

from alight.compiled.scene import compile_scene
from alight.media.homogeneous import Homogeneous
from alight.media.sampling import cross, fly
from alight.media.tables import CHROMATIC, Segment, Stream
from alight.scene import flatten
from lanewise.jit import instantiate
from lanewise.simd import lanes
from lanewise.vec3 import Vec3
from tests.media.scenes import DENSITIES, SIGMAS, bodies

COUNT = 80_000
#: Thick enough for the roulette of shadow rays, and thicker in one channel than in another.
EXTINCTION = (6.0, 3.0, 0.5)
HOMOGENEOUS, GRID = 1, 2


class Bench:
    """The kernels of a scene, ready for lanes of one ray."""

    def __init__(self, extinction=EXTINCTION, facts=()):
        compiled = compile_scene(flatten(bodies(0.5, extinction)), structure="list")
        program = compiled.program
        program = program._replace(media=tuple(dict.fromkeys((*program.media, *facts))))
        self.scene, self.media = compiled.tables, program.media
        self.fly, self.cross = (
            np.errstate(all="ignore")(instantiate(k, program, compiled=False)) for k in (fly, cross)
        )

    def arguments(self, medium, origin, direction, length):
        rng = np.random.default_rng(4)
        ones = np.ones(COUNT, np.float32)
        o = Vec3(*(np.float32(c) * ones for c in origin))
        d = Vec3(*(np.float32(c) * ones for c in direction))
        channel = rng.integers(0, 3, COUNT).astype(np.uint32)
        u = rng.random(COUNT, np.float32)
        keys = (rng.integers(0, 2**32, COUNT, np.uint32) for _ in range(3))
        rows = np.full(COUNT, medium, np.uint32)
        return Segment(o, d, lanes(length) * ones, rows, channel, Stream(*keys)), u


@pytest.fixture(scope="module")
def bench():
    return Bench()


#: A ray of 1.2 m in the medium without cells; in the box of the other one that enters and leaves,
#: one that ends inside, and one that begins there and ends before the far side.
RAYS = {
    "homogeneous": (HOMOGENEOUS, (0.0, 0.0, 0.0), (0.0, 0.6, 0.8), 1.2),
    "grid": (GRID, (0.9, 0.15, -0.3), (0.96, 0.0, 0.28), 3.0),
    "into the grid": (GRID, (0.9, 0.15, -0.3), (0.96, 0.0, 0.28), 1.1),
    "within the grid": (GRID, (2.0, 0.15, -0.3), (-0.6, 0.8, 0.0), 0.5),
}


def optical_depth(medium, origin, direction, length):
    """Density times distance along a ray, by small steps in float64."""
    if medium == HOMOGENEOUS:
        return length
    n = 200_000
    t = (np.arange(n) + 0.5) / n * length
    p = (np.array(origin) + t[:, None] * np.array(direction) - (1.2, -0.8, -0.8)) / 1.6
    inside = ((p >= 0.0) & (p <= 1.0)).all(1)
    values = np.array(DENSITIES)
    counts = np.array(values.shape[::-1])
    at = np.clip(p * counts - 0.5, 0, counts - 1)
    first = np.minimum(at.astype(int), counts - 2)
    f = at - first
    total = 0.0
    for corner in np.ndindex(2, 2, 2):
        weight = np.prod(np.where(corner, f, 1.0 - f), axis=1)
        i, j, k = (first + corner).T
        total = total + weight * values[k, j, i]
    return float((total * inside).mean() * length)


def assert_mean(samples, expected):
    mean, error = samples.mean(), samples.std() / np.sqrt(len(samples))
    assert abs(mean - expected) < SIGMAS * error + 2e-6 * expected, (mean / expected, error)


def columns(v):
    return np.stack([np.broadcast_to(np.float64(part), COUNT) for part in (v.x, v.y, v.z)], 1)


@pytest.mark.parametrize("ray", RAYS.values(), ids=RAYS)
def test_flights_come_through_as_the_transmittance_says(bench, ray):
    active = np.ones(COUNT, bool)
    segment, u = bench.arguments(*ray)
    flight = bench.fly(bench.scene, segment, u, active)
    factor, through = columns(flight.factor), ~flight.scattered
    expected = np.exp(-optical_depth(*ray) * np.array(EXTINCTION))
    weight = factor / factor.mean(1, keepdims=True)
    for c in range(3):
        assert_mean(np.where(through, weight[:, c], 0.0), expected[c])
        # And all that does not come through is scattered.
        assert_mean(np.where(through, 0.0, weight[:, c]), 1.0 - expected[c])
    # The densities of light sampling are those of ratio tracking: their mean over paths is 1.
    light = columns(flight.light)
    for c in range(3):
        own = through & (segment.channel == c)
        assert_mean(own / (segment.channel == c).mean() * light[:, c], 1.0)


@pytest.mark.parametrize("ray", RAYS.values(), ids=RAYS)
def test_grey_media_are_coloured_ones_of_three_equal_channels(ray):
    """Where no medium of a scene has a colour, shorter kernels give the same numbers."""
    short, long = Bench((3.0, 3.0, 3.0)), Bench((3.0, 3.0, 3.0), (CHROMATIC,))
    assert CHROMATIC not in short.media
    active = np.ones(COUNT, bool)
    segment, u = short.arguments(*ray)
    for name, more in (("fly", (u,)), ("cross", ())):
        mine, other = (getattr(b, name)(b.scene, segment, *more, active) for b in (short, long))
        for field, a, b in zip(mine._fields, mine, other, strict=True):
            a, b = (columns(v) if isinstance(v, Vec3) else np.asarray(v) for v in (a, b))
            np.testing.assert_allclose(a, b, rtol=2e-6, err_msg=f"{name}: {field}")


@pytest.mark.parametrize("ray", RAYS.values(), ids=RAYS)
def test_shadow_rays_come_through_as_the_transmittance_says(bench, ray):
    active = np.ones(COUNT, bool)
    segment, _ = bench.arguments(*ray)
    crossing = bench.cross(bench.scene, segment, active)
    passed = columns(crossing.passed) * np.broadcast_to(crossing.weight, COUNT)[:, None]
    light = columns(crossing.light)
    weight = passed / light.mean(1, keepdims=True)
    expected = np.exp(-optical_depth(*ray) * np.array(EXTINCTION))
    for c in range(3):
        assert_mean(weight[:, c], expected[c])


def test_a_flight_knows_what_the_shadow_ray_of_the_same_numbers_does(bench):
    """Both meet the same collisions; what passes by chance here is weighted there by 1 - real."""
    active = np.ones(COUNT, bool)
    segment, u = bench.arguments(*RAYS["grid"])
    flight = bench.fly(bench.scene, segment, u, active)
    crossing = bench.cross(bench.scene, segment, active)
    # Without roulette.
    alike = ~flight.scattered & (np.broadcast_to(crossing.weight, COUNT) == 1.0)
    alike &= crossing.passed.x > 0.0
    assert alike.mean() > 0.05
    passed, light = columns(crossing.passed)[alike], columns(crossing.light)[alike]
    np.testing.assert_allclose(columns(flight.factor)[alike], light, rtol=1e-5)
    np.testing.assert_allclose(columns(flight.light)[alike] * passed, light * light, rtol=1e-4)
    # Some met nothing, and some several.
    kept = passed[:, 0] / light[:, 0]
    assert (kept == 1.0).any() and (kept < 0.9).any()


def test_each_of_several_media_has_its_own_extinction_and_albedo(bench):
    scene = bodies(0.5)
    media = {
        name: Homogeneous(sigma_t=1.0 + i, albedo=(0.9, 0.5, 0.1 + 0.2 * i))
        for i, name in enumerate(scene.media)
    }
    assert len(media) >= 2
    compiled = compile_scene(flatten(scene.replaced(media=media)), structure="list")
    run = np.errstate(all="ignore")(instantiate(fly, compiled.program, compiled=False))
    found = set()
    for medium in range(1, len(media) + 1):
        segment, u = bench.arguments(medium, (0.0, 0.0, 0.0), (0.0, 0.6, 0.8), 100.0)
        flight = run(compiled.tables, segment, u, np.ones(COUNT, bool))
        mean = float(np.mean(flight.t))
        found.add((round(1.0 / mean), round(float(np.max(flight.albedo.z)), 3)))
    assert found == {(1 + i, round(0.1 + 0.2 * i, 3)) for i in range(len(media))}
