"""A world that is turned and shifted as a whole, camera and all, looks the same, sample by sample.

Random numbers choose directions in frames that do not turn along, so only what leaves nothing to
them is compared: what the camera sees, and light from a single direction or point.
"""

import numpy as np
import pytest

from alight.core.registry import modules, specs
from alight.formats import loads
from alight.scene import translate
from tests.rendering.many_paths import prepared, samples_of

TURNED = "[{rotate: {axis: [1, 2, 3], angle: 130}}, {translate: [1, -2, 0.5]}]"
WORLD = """
alight: 1
camera: world/eye
film: {size: [8, 8]}
sampler: independent
integrator: {type: path, max_depth: %d, rr_depth: 9}
bsdfs:
  tiles: {type: diffuse, reflectance: {type: checkerboard, color0: [0.9, 0.5, 0.1], color1: 0.3}}
  brushed: {type: principled, base_color: [0.9, 0.6, 0.3], metallic: 0.7, roughness: 0.4,
            anisotropy: 0.8, anisotropy_rotation: 0.7}
  bent: {type: normal_map, texture: [0.7, 0.4, 0.9], bsdf: {type: phong}}
nodes:
  world:
    transform: %s
    children:
      eye: {camera: {type: pinhole, fov: 70},
            transform: {look_at: {origin: [0, 1, 4], target: [0, 0.8, 0]}}}
      floor: {shape: rectangle, bsdf: tiles,
              transform: [{rotate: {axis: x, angle: -90}}, {scale: 3}]}
      ball: {shape: sphere, bsdf: brushed, transform: [{scale: [0.6, 0.8, 0.5]},
             {rotate: {axis: [1, 1, 0], angle: 30}}, {translate: [-1, 0.8, 0]}]}
      tube: {shape: cylinder, bsdf: brushed, transform: [{scale: [0.4, 0.5, 1]},
             {rotate: {axis: x, angle: -80}}, {translate: [0.3, 0.2, 0]}]}
      plate: {shape: disk, bsdf: bent, transform: [{scale: 0.5}, {rotate: {axis: y, angle: -30}},
              {translate: [1, 1.2, 0]}]}
      leaf: {shape: {type: mesh, vertices: [[0, 0, 0], [1, 0, 0.3], [0, 1, 0]], faces: [[0, 1, 2]],
                     uvs: [[0, 0], [0.2, 1], [1, 0.3]],
                     normals: [[0, 0, 1], [0.4, 0, 1], [0, 0.4, 1]]}, bsdf: bent,
             transform: {translate: [0.4, 0.1, 1]}}
      lamp: {light: {type: point, intensity: 9},
             transform: {look_at: {origin: [0.3, 3, 2], target: [0.6, 5.2, 4]}}}
"""
#: All but suns alone, which the camera does not see; `test_sun_of_any_size` turns them.
LIGHTS = {
    f"{spec.type_name()}-{i}": spec
    for model in modules("lights")
    for i, spec in enumerate(model.EXAMPLES)
    if not (
        spec.is_black or spec.type_name() == "sun" or getattr(spec, "sky_scale", 1) == (0, 0, 0)
    )
}


def with_lamp(text, light):
    """A scene with another lamp."""
    scene = loads(text, "world.yaml")
    world = scene.nodes["world"]
    lamp = world.children["lamp"].replaced(light=light)
    if light.placement == "shape":
        # In front of the camera.
        lamp = lamp.replaced(shape=specs("shapes")["rectangle"](), transform=translate(0.2, 2, 0))
    world = world.replaced(children={**world.children, "lamp": lamp})
    return scene.replaced(nodes={**scene.nodes, "world": world})


def drawn(placement, light, depth):
    return samples_of(prepared(with_lamp(WORLD % (depth, placement), light)))


def is_single(light):
    """Whether light sampling has no choice of the direction."""
    return light.placement == "node"


@pytest.mark.parametrize("name", LIGHTS)
def test_lights_turn_with_the_world(name):
    light = LIGHTS[name]
    # What has a size is looked at, the others light what is there.
    depth = 2 if is_single(light) else 1
    still = drawn("[]", light, depth)
    assert still.any()
    turned = drawn(TURNED, light, depth)
    same = np.isclose(turned, still, rtol=3e-3, atol=1e-4 * still.max()).all(axis=-1)
    # At the rims of things and of their patterns a rounding decides.
    assert same.mean() > 0.98, same.mean()
