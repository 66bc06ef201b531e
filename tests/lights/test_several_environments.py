"""Environments that add up: what rays see, the density of the mixture, and pictures."""

import numpy as np
import pytest

import alight
from alight.compiled.program import Program
from alight.formats import loads
from alight.lights.constant import Constant
from alight.lights.environment import Environment
from alight.lights.misses import environment_pdf, environment_radiance
from alight.lights.point import Point
from alight.lights.sampling import sample_light
from alight.lights.sun import Sun
from alight.lights.sunsky import SunSky
from alight.scene.flatten import PlacedLight
from alight.scene.transform import rotate
from lanewise.jit import instantiate
from tests.lights.test_environment import expected, sky
from tests.sampling.statistics import LARGEST_Z, SIGNIFICANCE, chi_square
from tests.shapes.tracing import World, directions, rows, vec

TURN = rotate((1, 2, 3), 70).matrix
SMALL = np.random.default_rng(2).random((5, 4, 3))
SUN = Sun(sun_direction=(1.0, 1.0, 0.5), diameter=25.0, scale=0.003)


def around(*lights):
    """Environments that are turned, each otherwise."""
    turns = (TURN, np.eye(4), rotate("y", 30).matrix)
    return [PlacedLight("around", light, turns[k % 3]) for k, light in enumerate(lights)]


#: name: environments.
SUMS = {
    "two maps": (Environment(pixels=sky(sun=40.0), scale=(1, 2, 0.5)), Environment(pixels=SMALL)),
    "map and sun": (Environment(pixels=SMALL, rotate=50.0), SUN),
    "all kinds": (
        Constant(radiance=(0.1, 0.3, 0.2)),
        SunSky(sun_direction=(0.0, 1.0, 1.0), diameter=30.0, scale=0.01),
        Environment(pixels=SMALL),
        SUN,
    ),
}
each_sum = pytest.mark.parametrize("name", SUMS)
each_selection = pytest.mark.parametrize("selection", ["power", "tree"])
N = 60_000


class Around:
    """A world of nothing but environments, and perhaps a lamp, with its program."""

    def __init__(self, name, selection="power", lamp=False):
        lights = [PlacedLight("lamp", Point(intensity=0.5), np.eye(4))] if lamp else []
        placed = around(*SUMS[name])
        self.scene = World(around=placed, lights=lights, selection=selection).scene
        kinds = [light.type_name() for light in SUMS[name]]
        kinds = tuple("environment" if kind == "sky" else kind for kind in kinds)
        names = (*kinds, "point") if lamp else kinds
        self.program = Program(
            lights=tuple(dict.fromkeys(names)), environments=kinds, light_tree=selection == "tree"
        )

    def run(self, text, *arguments):
        """A kernel, in NumPy."""
        with np.errstate(all="ignore"):
            return instantiate(text, self.program, compiled=False)(*arguments)

    def pdf(self, d):
        """Density at directions (3, n)."""
        found = self.run(environment_pdf, self.scene, vec(0.0 * d), vec(d))
        return np.broadcast_to(found, d.shape[1]).astype(float)

    def seen(self, d):
        """Radiance (3, n) from directions (3, n)."""
        return rows(self.run(environment_radiance, self.scene, vec(d))).reshape(3, -1)

    def samples(self, seed=1):
        """N samples of the lights from (0, 3, 0)."""
        u = np.random.default_rng(seed).random((3, N), np.float32)
        at, up = (vec(np.tile([[0.0], [y], [0.0]], N)) for y in (3.0, 1.0))
        return self.run(sample_light, self.scene, at, up, u[0], (u[1], u[2]), np.ones(N, bool))


def test_rays_see_the_sum():
    d = directions(4000, np.random.default_rng(3))
    found = Around("two maps").seen(d)
    first = expected(sky(sun=40.0), TURN[:3, :3].T @ d) * [[1.0], [2.0], [0.5]]
    np.testing.assert_allclose(found, first + expected(SMALL, d), rtol=1e-3, atol=2e-3)


@each_sum
@each_selection
def test_samples_bring_the_light_of_all(name, selection):
    world = Around(name, selection)
    s = world.samples()
    wi = rows(s.wi)
    assert np.all(s.pdf > 0.0)
    # The edge of a cell, or of the sun, may round to its other side.
    assert np.isclose(world.pdf(wi), s.pdf, rtol=2e-3).mean() > 0.999
    assert np.isclose(rows(s.radiance), world.seen(wi), rtol=2e-3, atol=1e-5).mean() > 0.999


@each_sum
@each_selection
def test_directions_follow_the_density_of_the_mixture(name, selection):
    world = Around(name, selection)
    side, fine = 16, 24
    z, phi = (np.mgrid[: side * fine, : side * fine] + 0.5) / (side * fine)
    z, phi = 2.0 * z.ravel() - 1.0, 2.0 * np.pi * (phi.ravel() - 0.5)
    d = np.stack([np.sqrt(1 - z * z) * np.sin(phi), z, np.sqrt(1 - z * z) * np.cos(phi)])
    share = world.pdf(d).reshape(side, fine, side, fine).mean((1, 3)).ravel()
    share *= 4.0 * np.pi / side**2
    assert share.sum() == pytest.approx(1.0, abs=4e-3)
    q = rows(world.samples().wi)
    turn = np.arctan2(q[0], q[2]) / (2.0 * np.pi) + 0.5
    cell = [np.clip((c * side).astype(int), 0, side - 1) for c in (0.5 * q[1] + 0.5, turn)]
    counts = np.bincount(cell[0] * side + cell[1], minlength=side * side)
    # The sun's edge goes through some cells, whose share is less certain: they are put together.
    sharp = world.pdf(d).reshape(side, fine, side, fine).std((1, 3)).ravel() > 0.5 * share.mean()
    counts = np.append(counts[~sharp], counts[sharp].sum())
    share = np.append(share[~sharp], share[sharp].sum())
    assert chi_square(np.append(counts, 0), share / share.sum()) > SIGNIFICANCE


@each_sum
@pytest.mark.parametrize("lamp", [False, True])
@each_selection
def test_light_sampling_finds_all_of_it(name, lamp, selection):
    world = Around(name, selection, lamp=lamp)
    s = world.samples()
    lit = s.pdf > 0.0
    value = np.where(lit, s.radiance.y / np.where(lit, s.pdf, 1.0), 0.0).astype(float)
    d = directions(400_000, np.random.default_rng(5))
    by_chance = 4.0 * np.pi * world.seen(d)[1]
    # The lamp stands 3 m below.
    wanted = by_chance.mean() + (0.5 / 9.0 if lamp and selection == "power" else 0.0)
    error = np.hypot(by_chance.std() / np.sqrt(by_chance.size), value.std() / np.sqrt(N))
    assert abs(value.mean() - wanted) < LARGEST_Z * error


SCENE = """
alight: 1
camera: {transform: {look_at: {origin: [0, 1.5, 4.5], target: [0, 0.6, 0]}}}
film: {size: [16, 16]}
sampler: independent
integrator: {type: path, max_depth: 3}
environment: {type: environment, pixels: [[[0.2, 0.3, 0.4]], [[0.5, 0.4, 0.3]], [[0.1, 0.1, 0.1]]]}
nodes:
  floor: {shape: rectangle, transform: [{scale: 3}, {rotate: {axis: x, angle: -90}}]}
  dull: {shape: {type: sphere, center: [-0.8, 0.7, 0], radius: 0.7}}
  glossy:
    shape: {type: sphere, center: [0.8, 0.7, 0], radius: 0.7}
    bsdf: {type: phong, diffuse: 0.2, specular: 0.7, exponent: 50}
  sun: {light: {type: sun, sun_direction: [1, 1, 1], diameter: 30, scale: 0.002}}
  dim: {light: {type: constant, radiance: 0.1}}
"""


def pictures(strategy, seeds=12):
    """Means of 4 x 4 blocks, one seed each."""
    scene = loads(SCENE)
    scene = scene.replaced(integrator=scene.integrator.replaced(light_sampling=strategy))
    stack = [alight.render(scene, spp=128, seed=seed).image.astype(float) for seed in range(seeds)]
    return np.mean(stack, axis=-1).reshape(seeds, 4, 4, 4, 4).mean((2, 4))


def test_strategies_have_one_mean():
    """By chance, and by light sampling with it: light sampling alone has its means above."""
    a, b = (pictures(strategy) for strategy in ("bsdf", "mis"))
    error = np.sqrt((a.var(0, ddof=1) + b.var(0, ddof=1)) / len(a))
    z = (a.mean(0) - b.mean(0)) / np.maximum(error, 1e-6)
    assert np.abs(z).max() < 1.4 * LARGEST_Z
    whole = a.mean((1, 2)) - b.mean((1, 2))
    assert abs(whole.mean()) < LARGEST_Z * whole.std(ddof=1) / np.sqrt(len(a))
    # A mean that is 1 % off is found.
    assert 3.0 * whole.std(ddof=1) / np.sqrt(len(a)) < 0.01 * b.mean()
