"""What a guide gains, against what is known without it, and the choice that follows."""

from itertools import product

import numpy as np
import pytest

import alight
from alight.compiled.scene import compile_scene
from alight.formats import loads
from alight.guiding.gain import EPSILON, Moments, moments_without
from alight.guiding.tables import RECORD, Log
from alight.integrators.walk import make_settings
from alight.lab.measure import add_tiles, film_for
from alight.rendering.tile import make_kernels
from alight.rendering.tiles import tiles_of
from alight.rendering.trainer import LEAST_GAIN, Trainer
from alight.rendering.training import trained, untrained
from alight.scene import flatten
from lanewise.view import View


def finished(rows, unguided):
    """A log of finished samples, by what they gather with the weights of paths without a guide."""
    unguided = np.asarray(unguided, np.float32)
    return Log(
        rows=View(np.asarray(rows, np.float32).reshape(-1, RECORD)),
        count=View(np.zeros(2, np.int64)),
        ends=View(np.full_like(unguided, 7.0)),
        unguided=View(unguided),
        window=View(np.zeros(6, np.uint32)),
    )


def random_walks(rng, vertices):
    """All walks of so many vertices that have two ways each: log, chances, and E[L^2] without.

    A walk gathers some light at each vertex, divided by the densities of the ways that led there.
    """
    p, b = rng.uniform(0.1, 0.9, (2, vertices))
    densities = np.stack([[p, 1 - p], [b, 1 - b]])
    light, first = rng.exponential(1.0, (vertices, 2)), 0.3
    rows, ends, chances, square = [], [], [], 0.0
    for number, ways in enumerate(product((0, 1), repeat=vertices)):
        of_guide, of_bsdf = (densities[i, ways, range(vertices)] for i in (0, 1))
        found = light[range(vertices), ways]
        gathered = first + np.r_[0.0, np.cumsum(found / np.cumprod(of_guide))]
        mine = np.zeros((vertices, RECORD), np.float32)
        mine[:, 6], mine[:, 7], mine[:, 12] = of_guide, of_bsdf, gathered[:-1]
        mine[:, 11] = np.array(number, np.uint32).view(np.float32)
        rows.append(mine)
        ends.append(gathered[-1])
        chances.append(of_guide.prod())
        square += of_bsdf.prod() * (first + (found / np.cumprod(of_bsdf)).sum()) ** 2
    # As packets leave them: the first vertices of all walks, then the second ones.
    return finished(np.swapaxes(rows, 0, 1), ends), np.array(chances), square


@pytest.mark.parametrize("seed", range(4))
def test_the_second_moment_without_a_guide_is_exact(seed):
    """The mean over all walks. Catches a product one vertex too long, or of other samples."""
    log, chances, expected = random_walks(np.random.default_rng(seed), 1 + seed)
    found = (chances * moments_without(log)).sum()
    assert found == pytest.approx(expected, rel=1e-5)


def test_samples_that_are_no_numbers_say_nothing():
    rows = np.zeros((2, RECORD), np.float32)
    rows[:, 6], rows[0, 7] = 0.5, 0.25
    rows[1, 11] = np.array(1, np.uint32).view(np.float32)
    # The second was drawn where the BSDF scatters nothing.
    assert moments_without(finished(rows, [np.inf, 2.0])).tolist() == [np.inf, 4.0]
    assert moments_without(finished([], [1.0, 2.0])).tolist() == [1.0, 4.0]


def test_a_guide_is_worth_the_ratio_of_relative_variances():
    """Two pixels, of variances 1 and 2 with the guide, 3 and 20 without."""
    means, count = np.array([[2.0, 1.0]]), 10
    square = count * means**2
    moments = Moments(
        count * means, square + count * np.array([[1, 2]]), square + count * [[3, 20]], count
    )
    weight = 1.0 / (means**2 + EPSILON)
    expected = (weight * [[3, 20]]).sum() / (weight * [[1, 2]]).sum()
    assert moments.fewer_samples(means) == pytest.approx(expected)
    nothing = np.zeros((1, 2))
    assert Moments(nothing, nothing, nothing, count).fewer_samples(nothing) == 1.0


SCENE = """
alight: 1
film: {size: [24, 16]}
sampler: independent
camera:
  {type: pinhole, fov: 60, transform: {look_at: {origin: [0, 0, 0.9], target: [0, -0.3, -1]}}}
integrator: {type: path, max_depth: 8, rr_depth: 3, guiding: auto}
bsdfs:
  grey: {type: diffuse, reflectance: 0.6}
nodes:
  room: {shape: {type: cube, flip_normals: true}, bsdf: grey}
"""
#: All light comes through a globe of glass: light sampling finds nothing.
GLOBE = """
  globe: {shape: {type: sphere, radius: 0.15}, bsdf: {type: dielectric}}
  lamp: {shape: {type: sphere, radius: 0.06}, light: {type: area, radiance: 100}}
"""
#: Light sampling finds all that is bright.
LAMP = """
  lamp: {light: {type: point, intensity: 1}}
"""


def scene_with(light, **options):
    scene = loads(SCENE + light, "room.yaml")
    return scene.replaced(integrator=scene.integrator.replaced(**options))


def means(film):
    return film.mean.tobytes()


def test_a_guide_that_does_not_pay_is_left_out():
    """The picture is that of a path tracer, to the bit, and so are its kernels."""
    found = alight.render(scene_with(LAMP), spp=8, seed=3, threads=2)
    told = found.stats["guide"]
    assert not told["used"] and 0.3 < told["gain"] < LEAST_GAIN and "not used" in told["line"]
    alone = alight.render(scene_with(LAMP, guiding="off"), spp=8, seed=3, threads=2)
    assert means(found) == means(alone)
    assert found.stats["program"] == alone.stats["program"]


def test_a_guide_that_pays_is_used():
    """It is the guide that one gets who asks for it."""
    auto, took = trained(compile_scene(flatten(scene_with(GLOBE))), seed=3, threads=2, rounds=6)
    assert took.used and took.gain > 2.0 * LEAST_GAIN and auto.guide is not None
    _, asked = trained(
        compile_scene(flatten(scene_with(GLOBE, guiding="on"))), seed=3, threads=1, rounds=6
    )
    assert asked.hash == took.hash and asked.gain == took.gain


#: Light sampling and directions share what is bright.
CEILING = """
  ceiling:
    shape: rectangle
    transform: [{scale: 0.8}, {rotate: {axis: x, angle: 90}}, {translate: [0, 0.9, -0.3]}]
    light: {type: area, radiance: 5}
"""


def test_paths_with_a_guide_tell_mean_and_second_moment_without_it():
    """Weights of multiple importance sampling are those of the BSDF, for lamps and for lights."""
    plain = scene_with(CEILING, guiding="on", russian_roulette="none", max_depth=4)
    compiled = untrained(compile_scene(flatten(plain)))
    trainer = Trainer(compiled, threads=2)
    guide = trainer.train(5, 6)
    assert guide.leaves.shaped[:, 0].max() > 0.5
    told, seen = [], []
    for own, found in ((guide, told), (compiled.guide, seen)):
        settings = make_settings(compiled.integrator, seed=7, replicates=1, guide=own)
        for tile in trainer.tiles:
            log, _, without = trainer._tile(settings, tile, 0, 16, True)
            found.append(np.stack([log.unguided.array, without]))
    # A guide that is never asked: its paths are those without one.
    np.testing.assert_allclose(without, log.ends.array.astype(float) ** 2, rtol=1e-5, atol=1e-10)
    (a, b), n = (np.concatenate(one, axis=1).astype(float) for one in (told, seen)), 2**18
    assert a.shape[1] == b.shape[1] and a.shape[1] > 0.9 * n
    spread = np.sqrt((a.var(axis=1) + b.var(axis=1)) / a.shape[1])
    assert (np.abs(a.mean(axis=1) - b.mean(axis=1)) < 4.0 * spread).all()
    # With weights of the mixture they are 2.6 and 14 % too high.
    assert (spread < 0.005 * b.mean(axis=1)).all()


def test_a_guide_that_knows_nothing_changes_nothing():
    """Not even roulette: the rays of training's first round are those of a path tracer."""
    found = []
    for guiding in ("off", "on"):
        scene = compile_scene(flatten(scene_with(LAMP, guiding=guiding)))
        scene = untrained(scene) if guiding == "on" else scene
        film = film_for(scene, 1, 1)
        settings = make_settings(scene.integrator, seed=1, replicates=1, guide=scene.guide)
        parts = [(tile, np.full((2, 3, 2), (0, 64))) for tile in tiles_of(film.crop)]
        add_tiles(1, make_kernels(scene), scene, settings, film, parts)
        found.append(film.mean[..., :3])
    # Densities are multiplied and divided again: a rounding, and at times another turn.
    assert (np.abs(found[0] - found[1]) <= 1e-5 * found[0]).mean() > 0.99
