"""Every random number of a path serves one purpose, and behind the camera it is asked for once.

All integrators, in scenes with all that asks for random numbers: motion, a lens, media of three
channels and on grids, holes, mixtures, layers, many lights, several environments, roulette.
"""

from __future__ import annotations

import sys
from contextlib import contextmanager

import numpy as np
import pytest

from alight.compiled.scene import compile_scene
from alight.core.registry import modules
from alight.formats import loads
from alight.integrators import shadow_catcher, walk
from alight.integrators.both_ends.light_subpath import OTHER_HALF
from alight.integrators.both_ends.splats import LENS_POINT, PIXEL
from alight.integrators.guided import GUIDE
from alight.integrators.interiors.volume_walk import CHANNEL, FREE_FLIGHT
from alight.integrators.moments import TIME
from alight.integrators.shadow_catcher import ShadowFilm, _write_catch
from alight.integrators.walk import (
    BSDF_CHOICE,
    BSDF_DIRECTION,
    CAMERA_DIMENSIONS,
    FILTER,
    LENS,
    LIGHT_CHOICE,
    LIGHT_POINT,
    ROULETTE,
    VERTEX_DIMENSIONS,
    make_settings,
    vertex_dimension,
)
from alight.lights.ground import SHADOW
from alight.media import tables
from alight.samplers import independent
from alight.scene import flatten
from lanewise.jit import instantiate, kernel, specialised
from tests.rendering.many_paths import begin, compiled, followed

SPP = 2
SURFACES = """
alight: 1
camera: {type: thin_lens, fov: 60, aperture_radius: 0.1, focus_distance: 4, shutter: [0, 1],
         transform: {look_at: {origin: [0, 1, 4], target: [0, 1, 0]}}}
film: {size: [6, 6], filter: gaussian}
sampler: independent
environment: {type: constant, radiance: 0.2}
bsdfs:
  layers: {type: principled, roughness: 0.4, clearcoat: 0.5, sheen_color: 0.3, transmission: 0.5,
           iridescence: 0.5, anisotropy: 0.5}
  veil: {type: mask, opacity: 0.5, bsdf: {type: blend, weight: 0.5, bsdfs: [{type: plastic},
         {type: rough_dielectric, alpha: 0.2}]}}
  tiles: {type: diffuse, reflectance: {type: checkerboard, color0: 0.9, color1: 0.6}}
nodes:
  floor: {shape: plane, bsdf: tiles, transform: {rotate: {axis: x, angle: -90}}}
  ball: {shape: {type: sphere, center: [-0.6, 0.6, 0], radius: 0.6}, bsdf: layers,
         transform: {keyframes: [{time: 0}, {time: 1, translate: [0.3, 0, 0]}]}}
  block: {shape: cube, bsdf: veil, transform: [{scale: 0.5}, {translate: [0.8, 0.5, 0]}]}
  lamp: {shape: disk, light: {type: area, radiance: 20},
         transform: [{rotate: {axis: x, angle: 90}}, {scale: 0.5}, {translate: [0, 3, 1]}]}
  egg: {shape: sphere, light: {type: area, radiance: 5},
        transform: [{scale: [0.1, 0.3, 0.2]}, {translate: [1, 2, 0]}]}
  bulb: {light: {type: point, intensity: 3}, transform: {translate: [-2, 2, 1]}}
  window: {light: portal, transform: [{rotate: {axis: x, angle: 90}}, {translate: [0, 4, 0]}]}
"""
#: Panes that are not there, so many that a shadow ray through all has a long list of segments.
PANES = 24
MEDIA = (
    SURFACES
    + """
  cloud: {shape: cube, bsdf: {type: "null"}, interior: grid,
          transform: [{scale: 0.7}, {translate: [0, 1.8, 0.5]}]}
"""
    + "".join(
        f'  pane{i}: {{shape: rectangle, bsdf: {{type: "null"}}, interior: grid, exterior: grid,\n'
        f"         transform: [{{scale: 0.68}}, {{rotate: {{axis: x, angle: 90}}}}, "
        f"{{translate: [0, {1.15 + 0.05 * i:.2f}, 0.5]}}]}}\n"
        for i in range(PANES)
    )
    + """
media:
  fog: {type: homogeneous, sigma_t: [0.1, 0.2, 0.3], albedo: 0.8}
  grid: {type: grid, values: [[[0.1, 1.0], [0.7, 0.3]], [[0.4, 0.0], [1.0, 0.2]]], sigma_t: 2,
         albedo: 0.9, low: [-0.7, 1.1, -0.2], high: [0.7, 2.5, 1.2]}
medium: fog
"""
)
EXAMPLES = {
    f"{type(spec).type_name()}-{i}": spec
    for model in modules("integrators")
    for i, spec in enumerate(model.EXAMPLES)
    # Paths from lights do not start at pixels; see the last test.
    if not spec.splats
}


class Recorder:
    """Which sample asked for which number, and from which line."""

    def __init__(self):
        self.active, self.sites, self.edges = np.zeros(0, bool), {}, 0
        self.uses, self.steps = [], []

    def asked(self, dimension, width, site, asking):
        """Some samples ask for numbers of the sampler."""
        number = self.sites.setdefault(site, len(self.sites))
        lanes = np.flatnonzero(self.active & asking)
        first = np.broadcast_to(dimension, self.active.shape)[lanes].astype(np.int64)
        for k in range(width):
            self.uses.append(np.stack([lanes, first + k, np.full_like(first, number)]))

    def stepped(self, a, b, counter, going):
        """Some samples ask for the numbers of a step through a medium."""
        rows = np.broadcast_arrays(a, b, counter, going & self.active)
        lanes = np.flatnonzero(rows[3])
        self.steps.append(np.stack([lanes, *(row[lanes].astype(np.int64) for row in rows[:3])]))


@contextmanager
def recorded():
    """A `Recorder` of all random numbers while it lasts."""
    recorder = Recorder()

    def watched(hash_, width):
        def look(a, b, dimension):
            frame = sys._getframe(1)
            while "samplers" in frame.f_code.co_filename:
                frame = frame.f_back
            # Where light is looked for or scattered, some samples only look on.
            asking = frame.f_locals.get("active", True)
            recorder.asked(dimension, width, (frame.f_code.co_filename, frame.f_lineno), asking)
            return hash_(a, b, dimension)

        return look

    def step_numbers(a, b, counter):
        # The caller's caller is the loop of a tracking.
        recorder.stepped(a, b, counter, sys._getframe(2).f_locals["going"])
        return own_hash(a, b, counter)

    own_hash = tables.hash_2
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(independent, "hash_1", watched(independent.hash_1, 1))
        patch.setattr(independent, "hash_2", watched(independent.hash_2, 2))
        patch.setattr(tables, "hash_2", step_numbers)
        yield recorder


def record(text, integrator):
    """All that the samples of a scene ask for."""
    scene = compiled(text, integrator)
    with recorded() as recorder:
        recorder.active = np.ones(scene.size[0] * scene.size[1] * SPP, bool)
        for path in followed(scene, SPP):
            recorder.active = np.broadcast_to(path.active, recorder.active.shape)
            recorder.edges += 1
    return recorder


def check(recorder):
    """Nothing is used for two purposes, nor twice."""
    lanes, dimensions, sites = np.concatenate(recorder.uses, axis=1)
    reads = np.unique(np.stack([lanes, dimensions, sites]), axis=1, return_counts=True)
    (_, dimension, site), count = reads
    names = list(recorder.sites)
    purposes = {int(d): {names[s] for s in set(site[dimension == d])} for d in set(dimension)}
    # Dimensions of a vertex are those of one purpose in all samples.
    shared = {d: found for d, found in purposes.items() if len(found) > 1}
    assert not shared, shared
    again = set(dimension[(count > 1) & (dimension >= CAMERA_DIMENSIONS)])
    assert not again, {d: purposes[d] for d in again}
    # Sequences are good in their first dimensions: none is left out.
    assert max(purposes) < CAMERA_DIMENSIONS + VERTEX_DIMENSIONS * (recorder.edges + 1)
    if recorder.steps:
        _, steps = np.unique(np.concatenate(recorder.steps, axis=1), axis=1, return_counts=True)
        assert steps.max(initial=0) <= 1, f"{(steps > 1).sum()} numbers of steps are used twice"
    return {int(d) for d in set(dimension)}


@pytest.mark.parametrize("name", EXAMPLES)
def test_no_number_is_used_for_two_purposes(name):
    spec = EXAMPLES[name]
    found = check(record(SURFACES, spec))
    assert {FILTER, FILTER + 1, LENS, LENS + 1, TIME} <= found
    if spec.sees_media and spec.max_depth:
        recorder = record(MEDIA, spec)
        assert CHANNEL in check(recorder)
        assert recorder.steps


def test_dimensions_of_the_camera_lie_before_those_of_vertices():
    places = [FILTER, FILTER + 1, LENS, LENS + 1, TIME, CHANNEL]
    assert len(set(places)) == len(places)
    assert max(places) < CAMERA_DIMENSIONS


@pytest.mark.parametrize(
    "own",
    [
        {PIXEL: 2, LENS_POINT: 2},
        {GUIDE: 1},
        {FREE_FLIGHT: 1},
        # Light paths beside camera paths, at the light and on their way.
        {OTHER_HALF + LIGHT_CHOICE: 1, OTHER_HALF + LIGHT_POINT: 2, OTHER_HALF + BSDF_DIRECTION: 2},
        {PIXEL: 2, LENS_POINT: 2, OTHER_HALF + BSDF_CHOICE: 1, OTHER_HALF + BSDF_DIRECTION: 2,
         OTHER_HALF + ROULETTE: 1},
    ],
)  # fmt: skip
def test_numbers_of_a_vertex_have_places_of_their_own(own):
    """Those of light tracing, of guides and of media, beside those that all paths have."""
    widths = {LIGHT_CHOICE: 1, LIGHT_POINT: 2, BSDF_CHOICE: 1, BSDF_DIRECTION: 2, ROULETTE: 1}
    taken = [place + k for place, n in (*widths.items(), *own.items()) for k in range(n)]
    assert len(set(taken)) == len(taken) == sum(widths.values()) + sum(own.values())
    assert max(taken) < VERTEX_DIMENSIONS


def test_numbers_of_shadows_on_the_ground_have_one_purpose_each():
    text = SURFACES.replace("  floor: {shape: plane", "  floor: {shape: rectangle")
    text = text.replace(
        "transform: {keyframes: [{time: 0}, {time: 1, translate: [0.3, 0, 0]}]}}", "}"
    )
    text = text[: text.index("  lamp:")] + text[text.index("  bulb:") : text.index("  window:")]
    flat = flatten(loads(text))
    scene = compile_scene(flat, structure="list", aovs=(SHADOW,))
    settings = make_settings(scene.integrator, seed=0, replicates=1)
    y, x = (a.ravel().astype(np.uint32) for a in np.mgrid[:6, :6])
    with recorded() as recorder, pytest.MonkeyPatch.context() as patch:
        patch.setattr(shadow_catcher, "add_layer", kernel(lambda *_: None))
        patch.setattr(walk, "mask_bits", lambda mask: 0)
        first, catch = (
            np.errstate(all="ignore")(instantiate(root, scene.program, compiled=False))
            for root in (begin, specialised(_write_catch))
        )
        recorder.active = np.ones(x.size, bool)
        path = first(scene.tables, settings, x, y, 0 * x, 0 * x)
        catch(scene.tables, ShadowFilm((), (), (), scene.ground), path, x == x)
    vertex = vertex_dimension(1)
    wanted = {vertex + k for k in (LIGHT_CHOICE, *range(LIGHT_POINT, LIGHT_POINT + 2))}
    wanted |= {vertex + BSDF_DIRECTION, vertex + BSDF_DIRECTION + 1}
    assert wanted == {d for d in check(recorder) if d >= CAMERA_DIMENSIONS}
