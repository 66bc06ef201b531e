"""Renders with a guide: unbiased, the same bits in any order, resumed and merged."""

import hashlib
from functools import partial

import numpy as np
import pytest

import alight
from alight.compiled.scene import compile_scene
from alight.core.errors import AlightError
from alight.formats import loads
from alight.laws.statistics import LARGEST_Z
from alight.rendering import main_loop
from alight.rendering.training.guide_training import trained
from alight.scene import flatten

#: A room lit through a gap, with a mirror, glass, a material of both lobes, and a lobe that is
#: narrow.
ROOM = """
alight: 1
camera: {type: pinhole, fov: 70, transform: {look_at: {origin: [0, 0, 0.9], target: [0, -0.2, -1]}}}
film: {size: [40, 32]}
sampler: independent
integrator: {type: path, max_depth: 7, guiding: "on"}
bsdfs:
  grey: {type: two_sided, bsdf: {type: diffuse, reflectance: 0.7}}
  shiny: {type: two_sided, bsdf: {type: plastic, diffuse_reflectance: [0.6, 0.3, 0.2]}}
  gold: {type: rough_conductor, metal: gold, alpha: 0.15}
nodes:
  floor: {shape: rectangle, bsdf: shiny, transform: [{scale: 2}, {rotate: {axis: x, angle: -90}}, {translate: [0, -1, -1]}]}
  ceiling: {shape: rectangle, bsdf: grey, transform: [{scale: 2}, {rotate: {axis: x, angle: 90}}, {translate: [0, 1, -1]}]}
  left: {shape: rectangle, bsdf: grey, transform: [{scale: 2}, {rotate: {axis: y, angle: 90}}, {translate: [-1, 0, -1]}]}
  right: {shape: rectangle, bsdf: grey, transform: [{scale: 2}, {rotate: {axis: y, angle: -90}}, {translate: [1, 0, -1]}]}
  far: {shape: rectangle, bsdf: grey, transform: [{scale: 1}, {translate: [0, 0, -3]}]}
  near: {shape: rectangle, bsdf: grey, transform: [{scale: 1}, {translate: [0, 0, 1]}]}
  wall: {shape: rectangle, bsdf: grey, transform: [{scale: 1}, {translate: [-0.6, 0, -1]}]}
  ball: {shape: {type: sphere, radius: 0.3}, bsdf: gold, transform: {translate: [0.5, -0.7, -0.4]}}
  glass: {shape: {type: sphere, radius: 0.25}, bsdf: {type: dielectric}, transform: {translate: [-0.4, -0.7, -0.3]}}
  lamp:
    shape: rectangle
    light: {type: area, radiance: 30}
    transform: [{scale: 0.25}, {rotate: {axis: x, angle: 90}}, {translate: [-0.5, 0.98, -2]}]
"""  # noqa: E501


@pytest.fixture(scope="module", autouse=True)
def short_training():
    """Four rounds are enough for laws."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(main_loop, "trained", partial(trained, rounds=4))
        yield


@pytest.fixture(scope="module")
def whole(short_training):
    """A guided film of the room."""
    return alight.render(room(), spp=16, seed=7, threads=2)


def proof(*values):
    """A case of `make proofs`."""
    return pytest.param(*values, marks=pytest.mark.proofs)


def room(**options):
    """The room with other options of its integrator."""
    scene = loads(ROOM, "room.yaml")
    return scene.replaced(integrator=scene.integrator.replaced(**options))


def compiled(**options):
    """The same, compiled."""
    return compile_scene(flatten(room(**options)))


def bits(film):
    """A hash of the film's exact sums."""
    return hashlib.sha256(np.ascontiguousarray(film.mean).tobytes()).hexdigest()


def blocks(picture):
    """Means of blocks of 8x8 pixels."""
    h, w, c = picture.shape
    return picture.reshape(h // 8, 8, w // 8, 8, c).mean((1, 3))


@pytest.mark.parametrize(
    ("options", "spp"),
    [
        ({}, 4096),
        proof({"light_sampling": "emitter", "russian_roulette": "none"}, 1024),
        proof({"light_sampling": "bsdf", "max_depth": 4}, 1024),
    ],
)
def test_a_guided_picture_is_that_of_a_path_tracer(options, spp):
    """Blocks of pixels, and the whole picture. Catches what makes light wrong by a percent.

    A density without the Jacobian, a guide that the weights of light sampling do not know, delta
    lobes that the guide would have to find, survivors that do not carry the light of the others.
    """
    means, squares = [], []
    # Without a guide, few paths by the BSDF alone find the caustic, and a picture that has none yet
    # knows nothing of its error: it needs many more of them.
    rays = 16 if options.get("light_sampling") == "bsdf" else 1
    for guiding, seed, count in (("on", 1, spp), ("off", 2, spp * rays)):
        film = alight.render(
            room(**options, guiding=guiding), spp=count, seed=seed, replicates=16, threads=2
        )
        assert film.invalid == 0
        means.append(film.mean)
        squares.append(film.standard_error**2)
    difference, variance = means[0] - means[1], squares[0] + squares[1]
    z = blocks(difference) / np.sqrt(blocks(variance) / 64)
    assert np.abs(z).max() < LARGEST_Z
    pixels = variance[..., 0].size
    error = np.sqrt(variance.mean((0, 1)) / pixels)
    assert (np.abs(difference.mean((0, 1))) < 4.0 * error).all()
    if not options:
        # A picture that is a percent too dark would be found.
        assert (error < 0.01 / 4.0 * means[1].mean((0, 1))).all()


def test_light_sampling_knows_the_guide():
    """A large lamp in view, found by both ways: their weights must sum to one."""
    text = ROOM.replace("[-0.5, 0.98, -2]", "[0.2, 0.98, -0.4]").replace(
        "scale: 0.25", "scale: 0.6"
    )
    scene = loads(text, "room.yaml")
    guided, free = (
        alight.render(
            scene.replaced(integrator=scene.integrator.replaced(guiding=way, max_depth=3)),
            spp=1024, seed=seed, threads=2,
        )
        for way, seed in (("on", 1), ("off", 2))
    )  # fmt: skip
    variance = (guided.standard_error**2 + free.standard_error**2).mean((0, 1)) / (40 * 32)
    difference = (guided.mean - free.mean).mean((0, 1))
    assert (np.abs(difference) < 4.5 * np.sqrt(variance)).all()
    assert (np.sqrt(variance) < 1e-3 * free.mean.mean((0, 1))).all()


def test_a_guide_is_the_same_for_any_threads_and_film_size():
    """Catches sums that depend on the order of tiles, and training by what is rendered."""
    scene = compiled()
    one, report = trained(scene, seed=3, threads=1, rounds=4)
    two, again = trained(scene, seed=3, threads=2, rounds=4)
    assert report.hash == again.hash
    for a, b in zip(one.guide, two.guide, strict=True):
        assert (a.array == b.array).all()
    large = room()
    large = large.replaced(film=large.film.replaced(size=(80, 64)))
    _, other = trained(compile_scene(flatten(large)), seed=3, threads=2, rounds=4)
    assert other.hash == report.hash
    _, different = trained(scene, seed=4, threads=2, rounds=4)
    assert different.hash != report.hash
    assert report.leaves > 20
    assert report.nodes > 20 * report.leaves
    assert report.bytes < 1 << 20


def test_a_guide_may_learn_from_the_camera_alone():
    """The same rounds without a light path; catches light paths that train it all the same."""
    scenes = {way: compiled(guiding=way) for way in ("on", "camera")}
    both, alone = (trained(scene, seed=3, threads=2, rounds=3)[1] for scene in scenes.values())
    assert both.arrivals > 0
    assert alone.arrivals == 0
    assert alone.used
    assert alone.hash != both.hash
    assert alone.paths == both.paths


def test_vertices_of_mirrors_leave_no_records():
    """Where only delta lobes scatter light, a guide has nothing to say."""
    head, lamp = ROOM.split("nodes:")[0], ROOM.split("  lamp:")[1]
    text = f"{head}nodes:\n  ball: {{shape: sphere, bsdf: {{type: mirror}}}}\n  lamp:{lamp}"
    scene = compile_scene(flatten(loads(text, "room.yaml")))
    _, report = trained(scene, seed=1, threads=2, rounds=2)
    assert report.paths > 1 << 15
    # Only the lamp scatters light, and half of the paths that meet it see its back.
    assert report.vertices < 0.05 * report.paths


def test_parts_resumed_and_merged_have_the_bits_of_one_render(whole, tmp_path):
    """8 + 8 samples are 16: the guide of a resumed render is the same again."""
    scene = room()
    path = tmp_path / "half.ckpt"
    alight.render(scene, spp=8, seed=7, threads=1, checkpoint=str(path))
    rest = alight.resume(str(path), scene=scene, spp=16, threads=2)
    assert bits(rest) == bits(whole)
    assert rest.options["guide"] == whole.options["guide"]
    assert whole.stats["guide"]["bytes"] < 1 << 20
    assert whole.stats["guide"]["paths"] > 1 << 17


def test_films_of_different_guides_are_not_one_film(whole):
    """Another guide has other samples; merging says what differs."""
    free = alight.render(room(guiding="off"), spp=4, seed=7)
    with pytest.raises(AlightError, match="cannot merge"):
        alight.Film.merge(whole, free)


def test_bounds_of_samples_are_not_claimed():
    """The guide's density may be small where the BSDF's is large: no bound of a sample is known."""
    spec = room().integrator
    assert spec.replaced(guiding="off").largest_sample(1.0, 1.0, 1.0) is not None
    assert spec.largest_sample(1.0, 1.0, 1.0) is None


def test_a_dark_scene_has_a_guide_too():
    """Nothing is learnt, nothing goes wrong."""
    text = ROOM.replace("radiance: 30", "radiance: 0")
    film = alight.render(loads(text, "room.yaml"), spp=2)
    assert film.invalid == 0
    assert film.mean.max() == 0.0
