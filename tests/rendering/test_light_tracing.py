"""Light tracing finds the light that path tracing finds, to the same bits however it is divided."""

from __future__ import annotations

import threading

import pytest

import alight
from alight.core.errors import OptionError, SceneError
from alight.films import Film
from alight.formats import loads
from alight.integrators.light import Light
from alight.integrators.path import Path
from tests.rendering.light_scenes import (
    BALL,
    CASES,
    DEPTH,
    LAMP,
    LONG_CASES,
    LOOK,
    ORTHO,
    PINHOLE,
    SCENE,
    SKY,
    p_value,
    pictures,
    same,
    small,
)
from tests.sampling.statistics import SIGNIFICANCE


def agreement(text):
    traced = pictures(text, Light(max_depth=DEPTH), 512, 1)
    return traced, pictures(text, Path(max_depth=DEPTH), 512, 2)


@pytest.mark.parametrize("name", CASES)
def test_it_finds_what_path_tracing_finds(name):
    traced, expected = agreement(CASES[name])
    assert p_value(traced, expected) > SIGNIFICANCE
    assert p_value(0.97 * traced, expected) < SIGNIFICANCE


@pytest.mark.proofs
@pytest.mark.parametrize("name", LONG_CASES)
def test_it_finds_what_path_tracing_finds_everywhere(name):
    traced, expected = agreement(LONG_CASES[name])
    assert p_value(traced, expected) > SIGNIFICANCE


# ---------------------------------------------------------------- bits


SHORT = Light(max_depth=4)


def test_threads_passes_and_merging_leave_the_bits():
    whole = alight.render(small(SHORT), spp=32, threads=1)
    assert whole.replicates == 16
    assert same(whole, alight.render(small(SHORT), spp=32, threads=3, spp_per_pass=5))
    parts = [alight.render(small(SHORT), spp=16, first_sample=first) for first in (16, 0)]
    assert same(whole, Film.merge(*parts))


def test_an_interrupted_render_goes_on(tmp_path):
    path = tmp_path / "half.alight"
    scene = small(SHORT)
    alight.render(scene, spp=16, checkpoint=path)
    assert same(alight.resume(path, spp=32, scene=scene), alight.render(scene, spp=32))


def test_a_pass_that_is_cut_short_leaves_nothing(monkeypatch):
    # A report after every part of a pass.
    monkeypatch.setattr("alight.rendering.main_loop.REPORT_EVERY", -1.0)
    cancel = threading.Event()

    def stop(progress):
        if progress.done_samples > 24 * 40 * 8:
            cancel.set()

    options = {"spp": 64, "spp_per_pass": 8, "threads": 1, "progress": stop}
    film = alight.render(small(SHORT), cancel=cancel, **options)
    assert (film.counts.sum(axis=2) == 8).all()
    assert same(film, alight.render(small(SHORT), spp=8))


def test_light_beside_the_window_is_lost():
    whole = alight.render(small(SHORT), spp=256, seed=3)
    part = alight.render(small(SHORT, crop=(8, 8, 16, 24)), spp=512, seed=4)
    a, b = whole.image[8:32, 8:24].mean(), part.image.mean()
    assert abs(a - b) < 0.03 * a


# ---------------------------------------------------------------- refusals


def refused(text, **options):
    scene = loads(text, "scene.yaml").replaced(integrator=Light(max_depth=3))
    with pytest.raises(OptionError) as caught:
        alight.render(scene, **(options or {"spp": 1}))
    return str(caught.value)


def test_what_light_paths_cannot_do_is_refused():
    lamp = CASES["a lamp"]
    assert "takes the same samples everywhere" in refused(lamp, error=0.1)
    assert "has no layers, and depth is asked for" in refused(lamp, spp=1, aovs=["depth"])
    plane = lamp.replace("shape: rectangle", "shape: plane", 1)
    assert "shapes without bounds" in refused(plane + SKY)
    assert "the surroundings in one direction" in refused(SCENE % ("box", ORTHO) + SKY)
    moving = lamp.replace(
        LOOK, "transform: {keyframes: [{time: 0}, {time: 1, translate: [1, 0, 0]}]}"
    )
    assert "the camera moves" in refused(moving)
    blend = "{type: blend, weight: 0.5, bsdfs: [{type: dielectric}, {type: diffuse}]}"
    assert "made of others" in refused(SCENE % ("box", PINHOLE) + BALL % blend + LAMP)


def test_media_and_traces_are_refused():
    fog = "medium: {type: homogeneous, sigma_t: 0.1}\n"
    with pytest.raises(SceneError, match="light does not see media"):
        alight.render(loads(CASES["a lamp"] + "integrator: light\n" + fog, "scene.yaml"), spp=1)
    with pytest.raises(OptionError, match="no path of light starts at a pixel"):
        alight.trace(small(SHORT), (1, 1))
    with pytest.raises(OptionError, match="light does not record where its light comes from"):
        alight.why(small(SHORT))
    with pytest.raises(OptionError, match="takes the same samples everywhere"):
        alight.plan(small(SHORT), error=0.1)


def test_the_ledger_says_what_is_missing():
    film = alight.render(small(SHORT), spp=16)
    assert any(bias.cause == "light paths" for bias in film.biases)
