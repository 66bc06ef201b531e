"""Guides in media: densities, records and pictures, against what is known without them."""

from functools import partial

import numpy as np
import pytest

import alight
from alight.accel import intersect_closest
from alight.compiled.scene import compile_scene
from alight.core.constants import INFINITY
from alight.core.equal_area import sphere_to_square, square_to_sphere
from alight.core.vec import Vec3, luminance
from alight.guiding.gain import Unguided
from alight.guiding.records import add_records
from alight.guiding.tables import RECORD
from alight.integrators.guided import Vertex, guide_at, mixed_density, write_guided_scatter
from alight.integrators.interiors.collisions import evaluate_anywhere, sample_anywhere
from alight.integrators.walk import empty_paths, make_settings, vertex_dimension
from alight.laws.statistics import LARGEST_Z
from alight.media.sampling import evaluate_phase
from alight.rendering import main_loop
from alight.rendering.training import guide_training as training
from alight.rendering.training import trainer
from alight.samplers.state import sampler_state
from alight.scene import flatten
from alight.shapes.surfaces import make_surface
from lanewise.jit import instantiate, kernel
from lanewise.records import replace
from lanewise.simd import lanes
from tests.guiding.smoky_room import FOG, ROOM, room
from tests.guiding.test_guided_renders import bits, blocks, proof
from tests.guiding.test_tree import FRAME, random_tree


@pytest.fixture(autouse=True)
def short_training(monkeypatch):
    """Four rounds are enough for laws."""
    monkeypatch.setattr(main_loop, "trained", partial(training.trained, rounds=4))


# ---------------------------------------------------------------- densities


@kernel
def turn_in_fog(scene, settings, path, p):
    """Paths that have collided at p: where the mixture leads them, told and looked up."""
    hit = intersect_closest(scene, path.o, path.d, lanes(INFINITY), path.active)
    surface = make_surface(scene, hit, path.o, path.d, path.active)
    here = guide_at(settings, p)
    vertex = Vertex(p, surface, path.d, vertex_dimension(path.depth + 1), path.active)
    found, w, unguided = SCATTER(scene, settings, path, here, vertex, path.active)
    again = evaluate_phase(scene, path.medium, path.d, w, path.active)
    return found, w, unguided, again, mixed_density(settings, here, w, again, path.active)


@kernel
def density_in_fog(scene, settings, path, p, w):
    """Of the mixture, for the directions w."""
    of_phase = evaluate_phase(scene, path.medium, path.d, w, path.active)
    return mixed_density(settings, guide_at(settings, p), w, of_phase, path.active)


SCATTER = write_guided_scatter(False, sample_anywhere, evaluate_anywhere)


def paths_in_fog(scene, n):
    """So many paths along one direction, each with random numbers of its own."""
    zero, yes = np.zeros(n, np.uint32), np.ones(n, bool)
    at = Vec3(*np.zeros((3, n), np.float32))
    d = Vec3(*(np.full(n, v, np.float32) for v in (0.6, 0.0, -0.8)))
    index = np.arange(n, dtype=np.uint32)
    sampler = sampler_state(zero, zero, index, zero, zero)
    path = instantiate(start, scene.program, compiled=False)(yes)
    nothing = np.zeros(n, np.float32)
    path = replace(path, unguided=Unguided(nothing, nothing + 1.0, nothing, nothing))
    return replace(path, o=at, d=d, sampler=sampler, active=yes, medium=zero + 1)


@kernel
def start(mask):
    """Paths with whatever they keep."""
    return empty_paths()


def test_directions_in_fog_have_the_density_of_the_mixture():
    """Chi-squared of the mixture with a phase function, at a dozen places."""
    scene = compile_scene(flatten(room(light_sampling="bsdf")), structure="list")
    tree, rng = random_tree(3), np.random.default_rng(5)
    settings = make_settings(scene.integrator, seed=1, replicates=1, guide=tree.guide(FRAME))
    n, grid, fine, worst = 4096, 8, 128, []
    run = partial(instantiate, program=scene.program, compiled=False)
    path, many = paths_in_fog(scene, n), paths_in_fog(scene, fine * fine)
    shares = []
    for point in FRAME.box[:3] + rng.random((60, 3)) / FRAME.box[3:]:
        p = [Vec3(*np.tile(point[:, None], k).astype(np.float32)) for k in (n, fine * fine)]
        with np.errstate(all="ignore"):
            found, w, unguided, again, told = run(turn_in_fog)(scene.tables, settings, path, p[0])
        share = guide_at(settings, p[0]).share[0]
        if share == 0.0 or len(worst) == 12:
            continue
        shares.append(share)
        np.testing.assert_allclose(unguided.pdf, again, 2e-3)
        np.testing.assert_allclose(unguided.rarity, found.pdf / unguided.pdf, 1e-5)
        # Directions at the border of a quadrant may be rounded into the next one.
        assert (np.abs(found.pdf - told) > 2e-3 * told).mean() < 0.01
        np.testing.assert_allclose(found.weight.x * found.pdf, unguided.pdf, 1e-4)
        x, y = sphere_to_square(w)
        drawn, _, _ = np.histogram2d(x, y, grid, range=[(0, 1), (0, 1)])
        a, b = (np.indices((fine, fine))[::-1] + rng.random((2, fine, fine))) / fine
        v = square_to_sphere(a.ravel().astype(np.float32), b.ravel().astype(np.float32))
        density = 4.0 * np.pi * run(density_in_fog)(scene.tables, settings, many, p[1], v)
        cells = density.reshape(grid, fine // grid, grid, fine // grid).transpose(2, 0, 1, 3)
        cells = cells.reshape(grid, grid, -1)
        expected = n * cells.mean(2) / grid**2
        error = n * cells.std(2) / grid**2 / (fine // grid)
        assert abs(expected.sum() - n) < 6.0 * np.sqrt((error**2).sum()) + 1e-3 * n
        known = (expected > 5) & (error < 0.2 * np.sqrt(expected))
        chi2 = ((drawn - expected)[known] ** 2 / expected[known]).sum()
        worst.append((chi2 - known.sum()) / np.sqrt(2.0 * known.sum()))
    assert len(worst) == 12 and max(shares) > min(shares)
    # Standard normal, but for a tail to the right.
    assert abs(np.mean(worst)) < 4.5 / np.sqrt(len(worst)) and max(worst) < 7.0


# ---------------------------------------------------------------- records


def logs_of(text, rounds):
    """What the rounds of a training leave: lists of (guide, rows, number of the sample)."""
    found = []
    with pytest.MonkeyPatch.context() as patch:

        def watched(root, *rest):
            made = instantiate(root, *rest)
            if root is not add_records:
                return made

            def add(guide, densities, log, totals, unit):
                rows = log.rows.shaped.reshape(-1, RECORD)[: int(log.count.array[0])]
                number = rows[:, 11].copy().view(np.uint32)
                found.append((guide, rows.astype(float), number))
                made(guide, densities, log, totals, unit)

            return add

        patch.setattr(trainer, "instantiate", watched)
        training.trained(compile_scene(flatten(room(text))), seed=5, threads=1, rounds=rounds)
    return found


def test_a_record_in_fog_has_the_throughput_of_its_channels():
    """Of the first vertex, in the first round: all three channels over the mean of their densities.

    Catches a transmittance that is left out or counted twice, and densities of one channel alone.
    """
    # What stands in the way stands elsewhere.
    clear = ROOM
    for at in ("[0.5, -0.4, -0.4]", "[-0.4, -0.7, -0.3]", "[0.7, 0, -1.2]"):
        clear = clear.replace(f"translate: {at}", "translate: [0, 40, 0]")
    # What has mirrors is behind the eye: the first vertex leaves the first record.
    clear = clear.replace(
        "floor: {shape: rectangle, bsdf: shiny", "floor: {shape: rectangle, bsdf: grey"
    )
    clear = clear.replace(
        "near: {shape: rectangle, bsdf: grey", "near: {shape: rectangle, bsdf: shiny"
    )
    eye, checked = np.array([0.0, 0.0, 0.9]), 0
    for _, rows, number in logs_of(clear, 1):
        if not len(rows):
            continue
        first = np.unique(number, return_index=True)[1]
        rows = rows[first]
        p, weight, beta = rows[:, :3], rows[:, 8], rows[:, 9]
        # Not at the walls of the room, nor at that with the gap.
        off = np.abs(p + np.array([0.0, 0.0, 1.0]))
        collided = (off < [0.999, 0.999, 1.999]).all(1) & (off[:, 2] > 1e-3)
        t = np.linalg.norm(p - eye, axis=1)[:, None]
        sigma_t, albedo = np.array(FOG.sigma_t), np.array(FOG.albedo)
        density = sigma_t * np.exp(-sigma_t * t)
        expected = luminance(Vec3(*(density * albedo / density.mean(1, keepdims=True)).T))
        found = beta / weight
        np.testing.assert_allclose(found[collided], expected[collided], rtol=2e-4)
        checked += collided.sum()
    assert checked > 3000


def test_borders_without_a_vertex_leave_no_records():
    """Neither glass nor the border of a cloud; but what is within them does."""
    at_borders, within = np.zeros(2, int), np.zeros(2, int)
    for _, rows, _ in logs_of(ROOM, 3):
        for i, (centre, radius) in enumerate(
            (([-0.4, -0.7, -0.3], 0.25), ([0.5, -0.4, -0.4], 0.3))
        ):
            distance = np.linalg.norm(rows[:, :3] - centre, axis=1) if len(rows) else np.ones(1)
            at_borders[i] += (np.abs(distance - radius) < 2e-6).sum()
            within[i] += (distance < radius - 1e-3).sum()
    assert (within > 2000).all()
    assert (at_borders < 5 + 1e-3 * within).all()


# ---------------------------------------------------------------- pictures


@pytest.mark.parametrize(
    ("options", "spp"),
    [
        ({}, 512),
        proof({}, 2048),
        proof({"light_sampling": "emitter", "russian_roulette": "none"}, 1024),
        proof({"light_sampling": "bsdf", "max_depth": 5}, 1024),
    ],
)
def test_a_guided_picture_of_media_is_that_of_a_path_tracer(options, spp):
    """Blocks of pixels, and the whole picture: fog, a cloud, tea in glass, a curtain with holes.

    Catches light sampling in media that does not know the guide, holes that do not carry the light
    of directions that the guide took, survivors that do not carry the light of the others.
    """
    means, squares = [], []
    for guiding, seed in (("on", 1), ("off", 2)):
        film = alight.render(
            room(**options, guiding=guiding), spp=spp, seed=seed, replicates=16, threads=2
        )
        assert film.invalid == 0
        means.append(film.mean)
        squares.append(film.standard_error**2)
    difference, variance = means[0] - means[1], squares[0] + squares[1]
    z = blocks(difference) / np.sqrt(blocks(variance) / 64)
    assert np.abs(z).max() < LARGEST_Z
    error = np.sqrt(variance.mean((0, 1)) / variance[..., 0].size)
    assert (np.abs(difference.mean((0, 1))) < 4.0 * error).all()
    if not options:
        # A darker picture would be found: by two percent, by one as a proof.
        assert error[0] < (0.01 if spp > 512 else 0.02) / 4.0 * means[1].mean((0, 1))[0]


def test_light_sampling_in_fog_knows_the_guide():
    """Thick fog under a large lamp, found by both ways: their weights must sum to one."""
    text = ROOM.replace("sigma_t: [0.3, 0.5, 0.8]", "sigma_t: [1.5, 1.5, 1.5]")
    text = text.replace("g: 0.6", "g: -0.5").replace("reflectance: 0.7", "reflectance: 0.02")
    text = text.replace("scale: 0.6", "scale: 0.95").replace("[-0.2, 0.98, -1.9]", "[0, 0.9, -0.4]")
    guided, free = (
        alight.render(room(text, guiding=way, max_depth=2), spp=512, seed=seed, threads=2)
        for way, seed in (("on", 1), ("off", 2))
    )
    variance = (guided.standard_error**2 + free.standard_error**2).mean((0, 1)) / (40 * 32)
    difference = (guided.mean - free.mean).mean((0, 1))
    assert (np.abs(difference) < 4.5 * np.sqrt(variance)).all()
    assert (np.sqrt(variance) < 4e-3 * free.mean.mean((0, 1))).all()


def test_parts_resumed_and_threads_have_the_bits_of_one_render(tmp_path, monkeypatch):
    """The guide of a resumed render is the same again, whoever adds its records."""
    scene = room()
    whole = alight.render(scene, spp=8, seed=7, threads=2)
    path = tmp_path / "half.ckpt"
    alight.render(scene, spp=4, seed=7, threads=1, checkpoint=str(path))
    rest = alight.resume(str(path), scene=scene, spp=8, threads=2)
    assert bits(rest) == bits(whole)
    assert rest.options["guide"] == whole.options["guide"]
