"""Gradient noise: nought at the corners of cells, smooth across their sides; its patterns."""

import numpy as np
import pytest

from alight.textures.noise import Noise, noise_at
from lanewise.jit import instantiate
from lanewise.vec3 import Vec3
from tests.textures.lookup import look_up

N = 400
AT = instantiate(noise_at, compiled=False)


def values(points):
    found = AT(*np.float32(points.T), Vec3(*np.zeros((3, 1), np.uint32)))
    return np.broadcast_to(found, len(points)).astype(float)


@pytest.fixture
def corners():
    return np.random.default_rng(1).integers(-50, 50, (N, 3)).astype(float)


def test_corners_of_cells_are_nought(corners):
    np.testing.assert_allclose(values(corners), 0.0, atol=1e-6)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_it_goes_on_smoothly_from_cell_to_cell(axis, corners):
    """Value and slope on both sides of a side; a power of two keeps the float's digits."""
    step = 2.0**-8
    places = corners + np.random.default_rng(axis).random((N, 3))
    places[:, axis] = corners[:, axis]
    aside = np.eye(3)[axis] * step
    before, here, after = (values(places + k * aside) for k in (-1.0, 0.0, 1.0))
    assert np.abs(after - here).max() < 4.0 * step
    np.testing.assert_allclose(after - here, here - before, atol=30.0 * step**2)


def test_it_is_even_about_nought_and_within_one(corners):
    found = values(corners + np.random.default_rng(5).random((N, 3)))
    assert np.abs(found).max() <= 1.0
    assert abs(found.mean()) < 4.0 * found.std() / np.sqrt(N)
    assert found.std() > 0.1


@pytest.mark.parametrize("pattern", ["fbm", "turbulence"])
@pytest.mark.parametrize(("octaves", "gain"), [(1, 0.5), (3, 0.7)])
def test_patterns_are_weighted_means_of_octaves(pattern, octaves, gain):
    rng = np.random.default_rng(6)
    scale, offset, ends = rng.uniform(0.5, 2.0, 3), rng.uniform(0.1, 0.9, 3), rng.random((2, 3))
    texture = Noise(
        space="uv", pattern=pattern, octaves=octaves, gain=gain, scale=tuple(scale),
        offset=tuple(offset), color0=tuple(ends[0]), color1=tuple(ends[1]),
    )  # fmt: skip
    u, v = rng.uniform(-3.0, 3.0, (2, N)).astype(np.float32)
    points = np.stack([u, v, np.zeros(N)], axis=1) * scale + offset
    waves = np.stack([values(2.0**k * points) for k in range(octaves)])
    sizes = gain ** np.arange(octaves)
    waves = np.abs(waves) if pattern == "turbulence" else waves
    mean = (sizes @ waves) / sizes.sum()
    weight = np.clip(mean if pattern == "turbulence" else 0.5 + 0.5 * mean, 0.0, 1.0)[:, None]
    expected = ends[0] * (1.0 - weight) + ends[1] * weight
    np.testing.assert_allclose(look_up(texture, u, v), expected, atol=1e-4)


@pytest.mark.parametrize("space", ["world", "uv"])
@pytest.mark.parametrize("pattern", ["fbm", "turbulence"])
def test_a_pattern_stands_in_the_world_wherever_places_are_measured_from(space, pattern):
    """All numbers have so few digits that float32 rounds none of them."""
    rng = np.random.default_rng(98_601)
    texture = Noise(
        space=space, pattern=pattern, octaves=3, gain=0.7, scale=(1.5, -2.0, 0.75),
        offset=(0.25, -7.5, 3.0),
    )  # fmt: skip
    origin = np.array([4096.0, -2048.0, 8192.0])
    u, v, z = rng.integers(-512, 512, (3, N)) / 64.0
    away = origin if space == "world" else np.zeros(3)
    there = look_up(texture, u + away[0], v + away[1], z + away[2])
    np.testing.assert_allclose(look_up(texture, u, v, z, origin), there, atol=1e-5)
    assert np.ptp(there) > 0.1


def test_cells_far_away_have_all_their_digits():
    """At 2^40 cells whole numbers are counted modulo 2^32, and what is left is as near as here."""
    texture = Noise(octaves=1, scale=256.0)
    u, v, z = np.random.default_rng(98_602).integers(-512, 512, (3, N)) / 2.0**12
    far, near = (look_up(texture, u, v, z, np.array([x, 0.0, 0.0])) for x in (2.0**32, 2.0**24))
    np.testing.assert_array_equal(far, near)
    np.testing.assert_array_equal(near, look_up(texture, u, v, z))
