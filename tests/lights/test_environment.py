"""Environment maps: what they show, and their sampling against its density and quadrature."""

import numpy as np
import pytest

from alight.compiled.program import Program
from alight.core.errors import SceneError
from alight.lights.environment import EXAMPLES, Environment, map_of
from alight.lights.misses import environment_pdf, environment_radiance
from alight.lights.sampling import sample_light
from alight.scene.transform import rotate, scale
from lanewise.jit import instantiate
from tests.sampling.statistics import LARGEST_Z, SIGNIFICANCE, chi_square, length_error, z_of_mean
from tests.shapes.tracing import World, directions, rows, vec

PROGRAM = Program(lights=("environment",), single_light=True)
TURN = rotate((1, 2, 3), 70).matrix @ scale(2.0).matrix


def sky(height=8, width=12, sun=400.0):
    """A blue sky over dark ground, with a sun."""
    rng = np.random.default_rng(1)
    up = np.linspace(1.0, -1.0, height)[:, None, None]
    texels = np.where(up > 0.0, (0.3, 0.5, 0.9), (0.1, 0.08, 0.05)) * rng.random((height, width, 1))
    texels[height // 3, width // 4] = (sun, 0.9 * sun, 0.7 * sun)
    return texels.astype(np.float32)


MAPS = {
    "sky": sky(),
    "noise": np.random.default_rng(2).random((5, 4, 3)),
    "poles": np.array([[[9.0], [1.0]], [[0.0], [0.2]], [[0.0], [0.0]], [[3.0], [7.0]]]),
    "row": np.array([[[1.0], [2.0], [0.0]]]),
    "column": np.array([[[1.0]], [[4.0]], [[0.0]]]),
    "texel": np.array([[[2.0]]]),
}
SAMPLINGS = ("importance", "compensated", "uniform")
each_map = pytest.mark.parametrize("name", MAPS)
each_sampling = pytest.mark.parametrize("sampling", SAMPLINGS)


def world_of(texels, sampling="importance", to_world=TURN, **fields):
    """A world of nothing but an environment."""
    compensated = sampling == "compensated"
    light = Environment(pixels=texels, sampling="importance" if compensated else sampling, **fields)
    return World(environment=light, environment_to_world=to_world, compensated=compensated)


def run(kernel, *arguments):
    """A kernel of the common program, in NumPy."""
    with np.errstate(all="ignore"):
        return instantiate(kernel, PROGRAM, compiled=False)(*arguments)


def sample(world, n, seed=1):
    """n samples of the environment."""
    u = np.random.default_rng(seed).random((3, n), np.float32)
    at = vec(np.zeros((3, n)))
    return run(sample_light, world.scene, at, at, u[0], (u[1], u[2]), np.ones(n, bool))


def pdf(world, d):
    """Density at directions (3, n)."""
    found = run(environment_pdf, world.scene, vec(0.0 * d), vec(d))
    return np.broadcast_to(found, d.shape[1]).astype(float)


def seen(world, d):
    """Radiance (3, n) from directions (3, n)."""
    return rows(run(environment_radiance, world.scene, vec(d))).reshape(3, -1)


def expected(texels, d):
    """The definition, in float64: `d` in the space of the map."""
    texels = np.broadcast_to(np.asarray(texels, float), (*np.shape(texels)[:2], 3))
    height, width = texels.shape[:2]
    x = (np.arctan2(d[0], -d[2]) / (2.0 * np.pi) % 1.0) * width - 0.5
    y = np.arccos(np.clip(d[1], -1, 1)) / np.pi * (height - 1)
    column, row = np.floor(x).astype(int), np.minimum(y.astype(int), max(height - 2, 0))
    x, y, below = (x - column)[:, None], (y - row)[:, None], np.minimum(row + 1, height - 1)
    left, right = column % width, (column + 1) % width
    upper = (1.0 - x) * texels[row, left] + x * texels[row, right]
    lower = (1.0 - x) * texels[below, left] + x * texels[below, right]
    return ((1.0 - y) * upper + y * lower).T


@each_map
def test_map_shows_its_texels(name):
    d = directions(4000, np.random.default_rng(3))
    world = world_of(MAPS[name], scale=(1.0, 2.0, 0.5))
    found = seen(world, TURN[:3, :3] @ d / 2.0)
    wanted = expected(MAPS[name], d) * [[1.0], [2.0], [0.5]]
    largest = np.max(MAPS[name])
    np.testing.assert_allclose(found, wanted, rtol=1e-4, atol=1e-4 * largest)


def test_middle_of_the_map_is_along_z_and_its_left_half_towards_x():
    # Eight columns of their own brightness; the horizon is the middle row.
    texels = np.tile(np.arange(8.0)[None, :, None], (3, 1, 3))
    texels[0], texels[2] = 100.0, 200.0
    world = world_of(texels, to_world=np.eye(4))
    points = {(0, 1, 0): 100.0, (0, -1, 0): 200.0, (0, 0, 1): 3.5, (1, 0, 0): 1.5, (-1, 0, 0): 5.5}
    for d, value in points.items():
        assert seen(world, np.reshape(d, (3, 1)).astype(float))[0, 0] == pytest.approx(value, 1e-5)
    # Rotation about +y takes +z to +x.
    turned = world_of(texels, to_world=np.eye(4), rotate=90.0)
    assert seen(turned, np.array([[1.0], [0.0], [0.0]]))[0, 0] == pytest.approx(3.5, 1e-5)


@each_map
@each_sampling
def test_density_integrates_to_one(name, sampling):
    world = world_of(MAPS[name], sampling)
    # Stratified in solid angle, so that the error is far below that of random directions.
    n, rng = 400, np.random.default_rng(4)
    z, phi = (np.mgrid[:n, :n] + rng.random((2, n, n))) / n
    z, phi = 2.0 * z.ravel() - 1.0, 2.0 * np.pi * phi.ravel()
    d = np.stack([np.sqrt(1 - z * z) * np.cos(phi), z, np.sqrt(1 - z * z) * np.sin(phi)])
    found = pdf(world, TURN[:3, :3] @ d / 2.0)
    assert found.mean() * 4.0 * np.pi == pytest.approx(1.0, abs=2e-3)


@each_map
@each_sampling
def test_directions_follow_the_density(name, sampling):
    world = world_of(MAPS[name], sampling)
    s = sample(world, 60_000)
    assert np.all(s.pdf > 0.0)
    wi = rows(s.wi)
    assert length_error(wi) < 1e-6
    q = TURN[:3, :3].T @ wi / 2.0
    # Cells finer than the map's, of equal solid angle; their share by 12 x 12 points each.
    side, fine = 16, 12
    z, phi = (np.mgrid[: side * fine, : side * fine] + 0.5) / (side * fine)
    z, phi = 2.0 * z.ravel() - 1.0, 2.0 * np.pi * (phi.ravel() - 0.5)
    d = np.stack([np.sqrt(1 - z * z) * np.sin(phi), z, np.sqrt(1 - z * z) * np.cos(phi)])
    share = pdf(world, TURN[:3, :3] @ d / 2.0).reshape(side, fine, side, fine).mean((1, 3))
    share = share.ravel() * 4.0 * np.pi / side**2
    turn = np.arctan2(q[0], q[2]) / (2.0 * np.pi) + 0.5
    cell = [np.clip((c * side).astype(int), 0, side - 1) for c in (0.5 * q[1] + 0.5, turn)]
    counts = np.bincount(cell[0] * side + cell[1], minlength=side * side)
    assert chi_square(np.append(counts, 0), share / share.sum()) > SIGNIFICANCE


@each_map
@each_sampling
def test_samples_carry_density_and_radiance_of_their_direction(name, sampling):
    world = world_of(MAPS[name], sampling)
    s = sample(world, 20_000)
    wi = rows(s.wi)
    assert np.all(np.isinf(s.distance)) and not np.any(s.delta)
    # The corner of a cell may round into the next one.
    close = np.isclose(pdf(world, wi), s.pdf, rtol=2e-3)
    assert close.mean() > 0.999
    radiance = np.isclose(rows(s.radiance), seen(world, wi), rtol=1e-3, atol=1e-5)
    assert radiance.mean() > 0.999


@each_map
@pytest.mark.parametrize("sampling", ["importance", "uniform"])
def test_light_sampling_finds_the_light_of_the_map(name, sampling):
    world = world_of(MAPS[name], sampling)
    s, d = sample(world, 60_000), directions(200_000, np.random.default_rng(5))
    found, by_chance = rows(s.radiance) / s.pdf, 4.0 * np.pi * seen(world, d)
    for values, weight, wanted in (
        (found[0], np.ones(60_000), by_chance[0]),
        (found[2], rows(s.wi)[1] ** 2, by_chance[2] * d[1] ** 2),
    ):
        # Of an even map nothing varies but the rounding.
        error = np.hypot(wanted.std() / np.sqrt(wanted.size), 1e-6 * wanted.mean())
        assert abs(z_of_mean(values * weight, wanted.mean(), error)) < LARGEST_Z


def test_importance_has_little_variance():
    s = sample(world_of(sky()), 60_000)
    found = rows(s.radiance)[1] / s.pdf
    assert found.std() < 0.1 * found.mean()


def test_darkest_texels_beside_the_brightest_are_still_drawn():
    texels = np.full((9, 64, 3), 1e-3)
    texels[4, 7] = 1e6
    world = world_of(texels)
    cdf = world.scene.lights.cdf.array[2:]
    conditional = np.diff(cdf[: 8 * 65].reshape(8, 65))
    marginal = np.diff(cdf[8 * 65 : 8 * 65 + 9])
    assert conditional.min() >= 2.0**-24 and marginal.min() >= 2.0**-24


def test_compensation_leaves_out_what_is_darker_than_the_mean():
    texels = sky(sun=1.0)
    world = world_of(texels, "compensated")
    d = directions(20_000, np.random.default_rng(6))
    luminance = [0.212671, 0.715160, 0.072169] @ seen(world, d)
    found = pdf(world, d)
    mean = luminance.mean()
    assert np.all(found[luminance > 1.3 * mean] > 0.0)
    # Cells with one brighter corner are drawn as a whole.
    assert np.mean(found[luminance < 0.3 * mean] == 0.0) > 0.6
    off = world_of(texels, "compensated", compensation=False)
    assert np.all(pdf(off, d) > 0.0)


def test_compensation_of_an_even_map_changes_nothing():
    texels = np.full((4, 8, 1), 3.0)
    d = directions(1000, np.random.default_rng(7))
    np.testing.assert_allclose(pdf(world_of(texels, "compensated"), d), 0.25 / np.pi, rtol=1e-4)


def test_black_map_is_defined():
    world = world_of(np.zeros((3, 4, 3)))
    assert world.lights.is_dark
    s = sample(world, 1000)
    assert np.all(rows(s.radiance) == 0.0) and np.all(np.isfinite(s.pdf))
    assert Environment(pixels=np.zeros((3, 4))).is_black
    assert [light.is_black for light in EXAMPLES] == [False, False, False, True]


@pytest.mark.parametrize("bad", [np.nan, np.inf, -1.0])
def test_bad_texels_are_refused(bad):
    texels = np.ones((3, 4, 3))
    texels[1, 2, 0] = bad
    with pytest.raises(SceneError, match="row 1, column 2"):
        Environment(pixels=texels)


def test_power_is_that_of_the_mean_radiance():
    texels = sky()
    d = directions(400_000, np.random.default_rng(8))
    mean = seen(world_of(texels), d).mean(1)
    made = map_of(Environment(pixels=texels), np.eye(4), False)
    error = seen(world_of(texels), d).std(1) / np.sqrt(d.shape[1])
    assert np.all(np.abs(mean - made.mean) < LARGEST_Z * error)
