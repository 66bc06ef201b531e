"""What nobody sees changes no sample, though kernels are written for all that a scene has.

A scene is drawn alone, and with one thing of every kind in a closed black box behind the camera:
each part of the program that was left out for want of use must not have been of use. Its floor is
brushed: without such a surface directions are chosen in other frames, and samples would differ.
"""

import numpy as np
import pytest

from alight.bsdfs.disney import principled
from alight.core.registry import modules
from alight.formats import loads
from alight.integrators.path import Path
from alight.integrators.volpath import VolPath
from tests.portion import portion
from tests.rendering.many_paths import prepared, samples_of

STAGE = """
alight: 1
camera: {type: pinhole, fov: 30, transform: {look_at: {origin: [0, 1, 4], target: [0, 0.7, 0]}}}
film: {size: [8, 8]}
sampler: independent
nodes:
  floor: {shape: rectangle, transform: [{rotate: {axis: x, angle: -90}}, {scale: 2}],
          bsdf: {type: rough_conductor, alpha_u: 0.5, alpha_v: 0.4}}
  ball: {shape: sphere, transform: [{scale: [0.5, 0.7, 0.6]}, {rotate: {axis: z, angle: 30}},
                                    {translate: [-0.6, 0.7, 0]}]}
  tube: {shape: cylinder, transform: [{scale: [0.4, 0.4, 1.2]}, {rotate: {axis: x, angle: -90}},
                                      {translate: [0.6, 0, 0]}]}
  lid: {shape: disk, transform: [{scale: [0.4, 0.4, 1]}, {rotate: {axis: x, angle: -90}},
                                 {translate: [0.6, 1.2, 0]}]}
  lamp: {shape: disk, light: {type: area, radiance: 9},
         transform: [{rotate: {axis: x, angle: 90}}, {scale: 0.7}, {translate: [0, 3, 1]}]}
"""
#: Beside all materials: motion, media, further texture coordinates, colours, instances, holes.
ZOO = """
alight: 1
camera: {type: pinhole, shutter: [0, 1]}
media:
  fog: {type: homogeneous, sigma_t: [0.1, 0.2, 0.3], albedo: 0.8}
  grid: {type: grid, values: [[[0.1, 1.0], [0.7, 0.3]], [[0.4, 0.0], [1.0, 0.2]]], sigma_t: 2}
nodes:
  zoo:
    transform: {translate: [0, 0, 60]}
    children:
      box: {shape: {type: cube, flip_normals: true}, bsdf: {type: two_sided, bsdf: {type: diffuse,
            reflectance: 0}}, transform: {scale: 20}}
      inside:
        children:
          plate: {shape: disk}
          tube: {shape: cylinder}
          flat: {shape: rectangle, interior: fog, bsdf: {type: "null"}}
          cloud: {shape: cube, interior: grid, bsdf: {type: "null"}}
          runner: {shape: sphere, transform: {keyframes: [{time: 0}, {time: 1, scale: [2, 1, 1]}]}}
          leaf: {shape: {type: mesh, vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]],
                         faces: [[0, 1, 2]], uvs: [[0, 0], [1, 0], [0, 1]],
                         more_uvs: [[[0, 0], [0, 1], [1, 0]]], normals: [[0, 0, 1], [1, 0, 1],
                         [0, 1, 1]], colors: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]},
                 bsdf: {type: diffuse, reflectance: {type: checkerboard, uv_set: 1}}}
"""
MODELS = modules("bsdfs")


SEEN = {
    f"{spec.type_name()}-{i}": spec for model in MODELS for i, spec in enumerate(model.EXAMPLES)
}
#: One of each kind is seen in every run, and all of the one whose parts are compiled alone.
ALWAYS = [name for name in SEEN if name.endswith("-0") or name.startswith("principled-")]
OTHERS = [name for name in SEEN if name not in ALWAYS]
#: Another one of each, and all parts of the one that has parts.
UNSEEN = [model.EXAMPLES[-1] for model in MODELS] + list(principled.EXAMPLES)
PATH, VOLPATH = Path(max_depth=4, rr_depth=2, heuristic="balance"), VolPath(max_depth=4, rr_depth=2)


def stage(bsdf, integrator):
    """A ball and a closed tube of a material, on a floor, under a lamp.

    A lid closes the tube: in a white body without an end, a single walk takes minutes.
    """
    scene = loads(STAGE, "stage")
    nodes = dict(scene.nodes)
    for name in ("ball", "tube", "lid"):
        nodes[name] = nodes[name].replaced(bsdf=bsdf)
    return scene.replaced(nodes=nodes, integrator=integrator)


def with_neighbours(scene):
    """The scene, and the zoo behind the camera."""
    other = loads(ZOO, "zoo", check=False)
    zoo, media = other.nodes["zoo"], other.media
    cage = dict(zoo.children["inside"].children)
    if not scene.integrator.sees_media:
        media = {}
        del cage["flat"], cage["cloud"]
    plate = cage["plate"]
    cage |= {f"one{i}": plate.replaced(bsdf=bsdf) for i, bsdf in enumerate(UNSEEN)}
    inside = zoo.children["inside"].replaced(children=cage)
    zoo = zoo.replaced(children={**zoo.children, "inside": inside})
    camera = scene.camera.replaced(camera=scene.camera.camera.replaced(shutter=(0.0, 1.0)))
    return scene.replaced(nodes={**scene.nodes, "zoo": zoo}, camera=camera, media=media)


def assert_no_sample_changes(bsdf, integrator):
    scene = stage(bsdf, integrator)
    alone = samples_of(prepared(scene), 2)
    beside = samples_of(prepared(with_neighbours(scene)), 2)
    assert (alone.max(axis=-1) > 0.0).mean() > 0.04
    same = np.isclose(beside, alone, rtol=2e-3, atol=1e-4).all(axis=-1)
    assert same.mean() > 0.99, (integrator.type, same.mean())


@pytest.mark.parametrize("name", ALWAYS)
def test_what_nobody_sees_changes_no_sample(name):
    for integrator in (PATH, VOLPATH):
        assert_no_sample_changes(SEEN[name], integrator)


@pytest.mark.proofs
@pytest.mark.parametrize("name", portion(OTHERS))
def test_what_nobody_sees_changes_no_sample_of_other_examples(name):
    # What the integrators do with a kind, its first example shows.
    assert_no_sample_changes(SEEN[name], (PATH, VOLPATH)[OTHERS.index(name) // 4 % 2])
