"""Environment maps in pictures: strategies have one mean, importance lowers the variance."""

import numpy as np
import pytest

import alight
from alight.compiled.scene import compile_scene
from alight.formats import loads
from alight.scene import flatten
from tests.sampling.statistics import LARGEST_Z

SEEDS, SPP = 16, 128

SCENE = """
alight: 1
camera: {transform: {look_at: {origin: [0, 1.5, 4.5], target: [0, 0.6, 0]}}}
film: {size: [32, 32]}
sampler: independent
integrator: {type: path, max_depth: 3}
environment: {type: environment, pixels: [[1]]}
nodes:
  floor:
    transform: [{scale: 3}, {rotate: {axis: x, angle: -90}}]
    shape: rectangle
  dull:
    shape: {type: sphere, center: [-0.8, 0.7, 0], radius: 0.7}
    bsdf: {type: diffuse, reflectance: 0.6}
  glossy:
    shape: {type: sphere, center: [0.8, 0.7, 0], radius: 0.7}
    bsdf: {type: phong, diffuse: 0.2, specular: 0.7, exponent: 50}
  lamp:
    transform: {translate: [0, 3, 2]}
    light: {type: point, intensity: 1}
"""


def sky(sun):
    """A sky above dark ground, with a sun of 2 x 2 texels."""
    height, width = 32, 64
    y, _ = np.mgrid[:height, :width]
    color = np.array([0.3, 0.5, 0.9]) * (1.2 - y / height)[..., None]
    texels = np.where((y < height // 2)[..., None], color, (0.12, 0.1, 0.08))
    texels[8:10, 15:17] = np.array([1.0, 0.9, 0.7]) * sun
    return texels


def scene_of(sun, strategy="mis", **fields):
    scene = loads(SCENE)
    light = scene.environment.replaced(pixels=sky(sun), rotate=20.0, **fields)
    integrator = scene.integrator.replaced(light_sampling=strategy)
    return scene.replaced(environment=light, integrator=integrator)


def pictures(sun, strategy="mis", **fields):
    """Luminance (seeds, 8, 8) of blocks of the picture, one seed each."""
    scene = scene_of(sun, strategy, **fields)
    films = (alight.render(scene, spp=SPP, spp_per_pass=SPP, seed=seed) for seed in range(SEEDS))
    stack = np.stack([film.image.astype(float) @ (0.2126, 0.7152, 0.0722) for film in films])
    return stack.reshape(SEEDS, 8, 4, 8, 4).mean((2, 4))


@pytest.fixture(scope="module")
def dim():
    """A sun that all strategies find."""
    return pictures(20.0, compensation=False)


@pytest.fixture(scope="module")
def bright():
    return pictures(300.0, compensation=False)


def scores(a, b):
    """Standard errors between the means of two stacks, block by block."""
    error = np.sqrt((a.var(0, ddof=1) + b.var(0, ddof=1)) / SEEDS)
    return (a.mean(0) - b.mean(0)) / np.maximum(error, 1e-6)


@pytest.mark.parametrize(
    ("strategy", "fields"),
    [
        ("mis", {"compensation": True}),
        ("mis", {"sampling": "uniform"}),
        ("emitter", {}),
        ("emitter", {"sampling": "uniform"}),
        ("bsdf", {}),
    ],
)
def test_strategies_have_one_mean(dim, strategy, fields):
    found = pictures(20.0, strategy, **fields)
    # Sixteen seeds: Student's t has heavier tails than the normal distribution.
    assert np.abs(scores(found, dim)).max() < 1.4 * LARGEST_Z
    whole = found.mean((1, 2)), dim.mean((1, 2))
    assert abs(scores(*whole)) < LARGEST_Z
    # A mean that is 1 % off is found.
    assert all(3.0 * w.std(ddof=1) / np.sqrt(SEEDS) < 0.01 * w.mean() for w in whole)


def variance(stack):
    """Mean of the blocks' variances."""
    return np.mean(stack.var(0, ddof=1))


def test_importance_lowers_the_variance_five_times(dim):
    assert variance(pictures(20.0, sampling="uniform")) > 5.0 * variance(dim)


def test_compensation_gains_under_a_bright_sun(bright):
    compensated = pictures(300.0, compensation=True)
    assert variance(compensated) < 0.8 * variance(bright)
    assert np.abs(scores(compensated, bright)).max() < 1.4 * LARGEST_Z


@pytest.mark.parametrize("strategy", ["mis", "emitter", "bsdf"])
def test_only_combined_sampling_is_compensated(strategy):
    maps = []
    for compensation in (True, False):
        scene = scene_of(20.0, strategy, compensation=compensation)
        maps.append(compile_scene(flatten(scene)).tables.lights.map.array)
    assert np.array_equal(*maps) == (strategy != "mis")
