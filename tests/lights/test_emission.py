"""Light paths start as light sampling finds light: whole scenes, trees, motion; and refusals.

Single lights and shapes obey `alight.laws.emission`.
"""

from dataclasses import replace
from types import SimpleNamespace
from typing import Literal

import numpy as np
import pytest

import alight
from alight.compiled.scene import compile_scene
from alight.core.errors import SceneError
from alight.core.field_types import Color
from alight.core.registration import unregister
from alight.core.spec import Light
from alight.core.vec import Vec3, luminance
from alight.formats import loads
from alight.laws.emission import RECEIVERS, N, declared_power, rays_of, same_by_both
from alight.lights import point
from alight.lights.tables import CHOICE
from alight.scene import flatten
from tests.motion.test_kernels import seen
from tests.sampling.statistics import LARGEST_Z, z_of_mean

HEAD = """
alight: 1
film: {size: [8, 8]}
integrator: {type: path, max_depth: 2, light_sampling: %s, light_choice: %s}
camera: {type: pinhole, transform: {translate: [0, 0, 5]}}
"""
#: A textured panel, a mesh, a ball in two instances, points, a beam, a sun at infinity.
LAMPS = """
nodes:
  panel:
    shape: rectangle
    light: {type: area, radiance: {type: checkerboard, color0: 0.1, color1: [1, 0.8, 0.5]}}
    transform: [{scale: [1, 0.4, 1]}, {rotate: {axis: x, angle: 130}}, {translate: [0, 2, 0]}]
  shard:
    shape: {type: mesh, vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 2]],
            faces: [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]}
    light: {type: area, radiance: 2}
    transform: {translate: [-2, -1, 0]}
  ball: {shape: {type: sphere, radius: 0.3, center: [2, 0, 1]}, light: {type: area, radiance: 6}}
  other: {shape: {type: sphere, radius: 0.2, center: [2, 2, 1]}, light: {type: area, radiance: 9}}
  bulb: {light: {type: point, intensity: [2, 3, 4]}, transform: {translate: [0, 0, 2]}}
  beam: {light: {type: spot, intensity: 30}, transform: {translate: [0, 0, -2]}}
  far: {light: {type: directional, irradiance: 1}, transform: {rotate: {axis: x, angle: 60}}}
"""
SKY = """
environment: {type: sky, sun_direction: [0.2, 1, 0.4], scale: 0.02}
"""
WINDOWS = """
  sun: {light: {type: sun, sun_direction: [1, 1, 0], scale: 0.00002}}
  window: {light: portal, transform: [{scale: [0.7, 0.5, 1]}, {translate: [0, 0, 1]}]}
  hatch: {light: portal, transform: [{rotate: {axis: x, angle: 80}}, {translate: [0, 1, 0]}]}
"""
SCENES = {
    "lamps": LAMPS,
    "lamps below a sky": LAMPS + SKY,
    "windows among lamps": LAMPS + WINDOWS + SKY,
}
MOVING = """
nodes:
  rest: {shape: {type: sphere, center: [0, 0, -2]}}
  train:
    transform:
      keyframes:
        - {time: 0, rotate: {axis: y, angle: 20}, translate: [-2, 1, 1]}
        - {time: 1, rotate: {axis: z, angle: 160}, translate: [2, 0, 1]}
    children:
      panel: {shape: rectangle, light: {type: area, radiance: 3}}
      beam: {light: {type: spot, intensity: 40, cutoff_angle: 50}}
      far: {light: {type: directional, irradiance: 2}}
"""


class Bulb(Light):
    """A user's lamp that knows nothing of emission."""

    type: Literal["bulb"] = "bulb"
    intensity: Color = (1.0, 1.0, 1.0)


def described(text, sampling="emitter", choice="power"):
    return loads(HEAD % (sampling, choice) + text, "scene.yaml")


def compiled(text, sampling="emitter", choice="power"):
    flat = flatten(described(text, sampling, choice))
    return compile_scene(flat, structure="list", emits=True)


@pytest.mark.parametrize("name", SCENES)
def test_rays_of_several_lights_carry_the_power_of_all(name):
    found = luminance(Vec3(*rays_of(compiled(SCENES[name], "mis")).flux)).astype(float)
    declared = declared_power(described(SCENES[name]))
    assert abs(z_of_mean(found, declared, 5e-3 * declared)) < LARGEST_Z


@pytest.mark.parametrize("name", SCENES)
def test_what_arrives_of_several_lights_is_what_light_sampling_finds(name):
    same_by_both(rays_of(compiled(SCENES[name], "mis")), compiled(SCENES[name]), RECEIVERS)


def test_a_light_tree_leaves_the_rays_as_they_are():
    by_tree, by_power = (rays_of(compiled(LAMPS, choice=way)) for way in ("tree", "power"))
    assert by_tree.scene.program.light_tree and not by_power.scene.program.light_tree
    for found, wanted in zip(by_tree[1:], by_power[1:], strict=True):
        np.testing.assert_array_equal(found, wanted)


def test_lights_are_chosen_by_their_power():
    rays = rays_of(compiled(LAMPS))
    lights = rays.scene.tables.lights
    chances = np.diff(lights.emission.array[CHOICE : CHOICE + lights.info.size // 4 + 1])
    counts = np.bincount(rays.light, minlength=len(chances))
    error = np.sqrt(N * chances * (1.0 - chances))
    assert np.all(np.abs(counts - N * chances) < LARGEST_Z * error)


@pytest.mark.parametrize("time", [0.0, 0.4, 0.97])
def test_moving_lights_emit_where_they_are(time):
    scene = compiled(MOVING)
    # One time for all lanes, however many are traced.
    scene = replace(scene, tables=seen(scene, np.full(1, time)))
    same_by_both(rays_of(scene), scene, RECEIVERS)


def test_scenes_whose_lights_emit_nothing_have_no_tables_for_it():
    flat = flatten(described(LAMPS))
    assert not hasattr(compile_scene(flat, structure="list").tables.lights, "emission")


def test_a_dark_scene_emits_nothing():
    flux = rays_of(compiled("nodes: {lamp: {light: {type: point, intensity: 0}}}")).flux
    assert not flux.any()


def test_a_light_that_cannot_emit_is_refused():
    parts = {name: getattr(point, name) for name in ("DELTA", "place", "power", "sample")}
    bulb = alight.register(SimpleNamespace(EXAMPLES=(Bulb(),), **parts))
    try:
        assert alight.check_laws(bulb, compiled=False)
        with pytest.raises(SceneError, match="no light path can start at a light of type bulb"):
            compiled("nodes: {lamp: {light: bulb}}")
    finally:
        unregister("lights", "bulb")
