"""Pictures with media: bits at any scale and in the twin; without media those of `path`."""

import numpy as np
import pytest

import alight
from alight.compiled.scene import compile_scene
from alight.films import Film
from alight.integrators.path import Path
from alight.integrators.volpath import VolPath
from alight.laws.integrators import picture, room
from alight.rendering.tiles.tile_kernel import Tile
from alight.scene import flatten
from tests.media.scenes import HIGH, agree, bodies, columns
from tests.rendering.interrupted import cancelled_after


@pytest.fixture(scope="module")
def scene():
    return bodies((0.9, 0.7, 0.5), g=0.3)


@pytest.fixture(scope="module")
def whole(scene):
    return alight.render(scene, spp=12, threads=1)


def test_threads_and_parts_do_not_change_a_bit(scene, whole):
    again = alight.render(scene, spp=12, threads=2, spp_per_pass=5)
    np.testing.assert_array_equal(again.sums, whole.sums)
    parts = [alight.render(scene, spp=7), alight.render(scene, spp=5, first_sample=7)]
    np.testing.assert_array_equal(Film.merge(*parts).sums, whole.sums)


def test_a_stopped_render_goes_on_to_the_same_bits(scene, whole, tmp_path, monkeypatch):
    alight.save(scene, tmp_path / "bodies.yaml")
    loaded = alight.load(tmp_path / "bodies.yaml")
    assert loaded == scene
    path = tmp_path / "film.alight"
    with cancelled_after(3, monkeypatch) as cancel:
        film = alight.render(
            loaded, spp=12, checkpoint=path, cancel=cancel, threads=1, spp_per_pass=5
        )
    assert 0 < film.spp < 12
    np.testing.assert_array_equal(alight.resume(path).sums, whole.sums)


def test_machine_code_gives_the_picture_of_the_twin(scene):
    compiled = compile_scene(flatten(scene), structure="list")
    tile = Tile(0, 8, 96, 16)
    found, expected = (picture(compiled, tile, compiled=c).sum(axis=2) for c in (True, False))
    # A path whose choice hangs on a rounding error goes another way: very few do.
    close = np.isclose(found, expected, rtol=1e-3, atol=1e-4).all(axis=-1)
    assert close.mean() >= 0.97
    np.testing.assert_allclose(found.mean((0, 1)), expected.mean((0, 1)), rtol=0.02)


def test_without_media_it_is_the_path_tracer():
    """Same random numbers, same weights: the same picture, within rounding."""
    tile = Tile(0, 0, 16, 16)
    ours = picture(room(VolPath()), tile)
    expected = picture(room(Path(heuristic="balance")), tile)
    np.testing.assert_allclose(ours, expected, rtol=2e-4, atol=1e-5)


@pytest.mark.proofs
@pytest.mark.parametrize("light_sampling", ["mis", "bsdf", "emitter"])
def test_all_strategies_give_a_white_furnace(light_sampling):
    scene = bodies(1.0, g=0.6)
    scene = scene.replaced(integrator=scene.integrator.replaced(light_sampling=light_sampling))
    image = alight.render(scene, spp=2048).image
    for body in columns():
        agree(image[:, body], np.ones((HIGH, HIGH, 3)), np.ones((HIGH, HIGH), bool), 0.015)
