"""Light tracing finds the light that path tracing finds, to the same bits however it is divided."""

from __future__ import annotations

import threading

import numpy as np
import pytest

import alight
from alight.core.errors import OptionError, SceneError
from alight.films import Film
from alight.formats import loads
from alight.integrators.light import Light
from alight.integrators.path import Path
from alight.metrics.statistics import student_t_tail
from tests.sampling.statistics import SIGNIFICANCE

REPLICATES, BLOCK, DEPTH = 32, 8, 6

SCENE = """
alight: 1
film: {size: [48, 48], filter: %s}
sampler: independent
camera: {%s}
nodes:
  floor:
    shape: rectangle
    bsdf: {type: diffuse, reflectance: [0.6, 0.5, 0.4]}
    transform: [{rotate: {axis: x, angle: -90}}, {scale: 4}]
  block:
    shape: cube
    bsdf: {type: plastic}
    transform: [{scale: 0.4}, {rotate: {axis: y, angle: 30}}, {translate: [0.8, 0.4, 0.3]}]
"""
LOOK = "transform: {look_at: {origin: [0, 2, 5], target: [0, 0.6, 0]}}"
PINHOLE, ORTHO = f"type: pinhole, fov: 50, {LOOK}", f"type: orthographic, height: 4, {LOOK}"
LENS = f"type: thin_lens, fov: 50, aperture_radius: 0.3, focus_distance: 3.5, {LOOK}"
BALL = "  ball: {shape: {type: sphere, center: [-0.7, 0.6, 0], radius: 0.6}, bsdf: %s}\n"
LAMP = """
  lamp:
    shape: disk
    light: {type: area, radiance: 15}
    transform: [{rotate: {axis: x, angle: 90}}, {scale: 0.7}, {translate: [0, 3, 1]}]
"""
SPOT = """
  spot:
    light: {type: spot, intensity: [60, 40, 30], cutoff_angle: 30}
    transform: {look_at: {origin: [2, 4, 3], target: [0, 0, 0]}}
  bulb: {light: {type: point, intensity: [9, 10, 15]}, transform: {translate: [-1.5, 2.5, 1]}}
  far:
    light: {type: directional, irradiance: [2, 2, 1]}
    transform: {rotate: {axis: x, angle: 60}}
"""
#: An octahedron that is shaded as a ball: shading normals far from those of its faces.
GEM = """
  gem:
    bsdf: {type: diffuse, reflectance: 0.8}
    transform: [{scale: 0.7}, {translate: [-0.7, 0.7, 0]}]
    shape:
      type: mesh
      vertices: [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]
      normals: [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]
      faces: [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4],
              [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
"""
SKY = "environment: {type: sunsky, sun_direction: [0.4, 1, 0.6], scale: 0.02}\n"
HOLES = "{type: mask, opacity: 0.4, bsdf: {type: diffuse, reflectance: 0.7}}"
ROUGH = "{type: rough_dielectric, alpha: 0.4}"

#: Everything is below the surface of water but the lamp.
UNDER_WATER = """
alight: 1
film: {size: [48, 48]}
sampler: independent
camera: {type: pinhole, fov: 60, transform: {look_at: {origin: [0, 1, 2], target: [0, 0, 0]}}}
nodes:
  floor: {shape: rectangle, transform: [{rotate: {axis: x, angle: -90}}, {scale: 3}]}
  surface:
    shape: rectangle
    bsdf: {type: dielectric, int_ior: 1.5}
    transform: [{rotate: {axis: x, angle: -90}}, {scale: 50}, {translate: [0, 1.5, 0]}]
  lamp:
    shape: rectangle
    light: {type: area, radiance: 3}
    transform: [{rotate: {axis: x, angle: 90}}, {scale: 2}, {translate: [0, 3, 0]}]
"""

CASES = {
    "a lamp": SCENE % ("box", PINHOLE) + BALL % "{type: phong}" + LAMP,
    "points and directions by a lens, shading normals": SCENE % ("tent", LENS) + GEM + SPOT,
    "under water": UNDER_WATER,
}
LONG_CASES = {
    "sun and sky": SCENE % ("gaussian", PINHOLE) + BALL % "{type: diffuse}" + SKY,
    "holes, in parallel": SCENE % ("box", ORTHO) + BALL % HOLES + LAMP,
    "rough glass": SCENE % ("box", PINHOLE) + BALL % ROUGH + LAMP,
}


def pictures(text, integrator, spp, seed):
    """Means of the replicates, (48, 48, REPLICATES, 3)."""
    scene = loads(text, "scene.yaml").replaced(integrator=integrator)
    film = alight.render(scene, spp=spp, seed=seed, replicates=REPLICATES)
    assert film.invalid == 0
    return film.replicate_means()[0].astype(float)


def p_value(mine, other):
    """Of the largest difference of blocks, and of the picture's channels, by Student's test."""
    n = len(mine) // BLOCK
    whole = [p.mean(axis=(0, 1)) for p in (mine, other)]
    parts = [
        p.reshape(n, BLOCK, n, BLOCK, REPLICATES, 3).mean(axis=(1, 3, 5)) for p in (mine, other)
    ]
    worst = 1.0
    for (a, b), axis in ((whole, 0), (parts, 2)):
        gap = np.abs(a.mean(axis=axis) - b.mean(axis=axis))
        error = np.sqrt((a.var(axis=axis, ddof=1) + b.var(axis=axis, ddof=1)) / REPLICATES)
        t = np.where(gap > 0.0, gap / np.maximum(error, 1e-12), 0.0)
        tail = 2.0 * student_t_tail(float(t.max()), REPLICATES - 1.0)
        worst = min(worst, tail * t.size)
    return worst


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


def small(**changes):
    scene = loads(CASES["a lamp"], "scene.yaml").replaced(integrator=Light(max_depth=4))
    return scene.replaced(film=scene.film.replaced(size=(24, 40), **changes))


def same(a, b):
    return np.array_equal(a.sums, b.sums) and np.array_equal(a.counts, b.counts)


def test_threads_passes_and_merging_leave_the_bits():
    whole = alight.render(small(), spp=32, threads=1)
    assert whole.replicates == 16
    assert same(whole, alight.render(small(), spp=32, threads=3, spp_per_pass=5))
    parts = [alight.render(small(), spp=16, first_sample=first) for first in (16, 0)]
    assert same(whole, Film.merge(*parts))


def test_an_interrupted_render_goes_on(tmp_path):
    path = tmp_path / "half.alight"
    scene = small()
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
    film = alight.render(small(), cancel=cancel, **options)
    assert (film.counts.sum(axis=2) == 8).all()
    assert same(film, alight.render(small(), spp=8))


def test_light_beside_the_window_is_lost():
    whole = alight.render(small(), spp=256, seed=3)
    part = alight.render(small(crop=(8, 8, 16, 24)), spp=512, seed=4)
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
    assert "glass is blended" in refused(SCENE % ("box", PINHOLE) + BALL % blend + LAMP)


def test_media_and_traces_are_refused():
    fog = "medium: {type: homogeneous, sigma_t: 0.1}\n"
    with pytest.raises(SceneError, match="light does not see media"):
        alight.render(loads(CASES["a lamp"] + "integrator: light\n" + fog, "scene.yaml"), spp=1)
    with pytest.raises(OptionError, match="no path of light starts at a pixel"):
        alight.trace(small(), (1, 1))
    with pytest.raises(OptionError, match="light does not record where its light comes from"):
        alight.why(small())
    with pytest.raises(OptionError, match="takes the same samples everywhere"):
        alight.plan(small(), error=0.1)


def test_the_ledger_says_what_is_missing():
    film = alight.render(small(), spp=16)
    assert any(bias.cause == "light paths" for bias in film.biases)
