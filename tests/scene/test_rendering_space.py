"""Scenes that lie far from the origin: the same pictures, places in the world, and what is told."""

from dataclasses import replace

import numpy as np
import pytest

import alight
from alight.cameras.table import ORIGIN
from alight.compiled.recompile import compiled_of
from alight.compiled.rendering_space import WORLD, shifted
from alight.compiled.scene import compile_scene
from alight.formats import loads
from alight.scene.description import Node
from alight.scene.flatten import PlacedShape, flatten
from alight.scene.keyframes import Parts, Track
from alight.scene.motion import Link, Motion
from alight.shapes.sphere import Sphere
from tests.extension.haze import Haze
from tests.twin import picture_of

AWAY = (1048576.0, -524288.0, 2097152.0)

SCENE = """
alight: 1
integrator: {type: %s, max_depth: 4}
camera: world/eye
film: {size: [8, 8], filter: box}
nodes:
  world:
    transform: {translate: [%r, %r, %r]}
    children:
      floor: {shape: rectangle, transform: [{scale: 4}, {rotate: {axis: x, angle: -90}}, {translate: [0, -1, 0]}]}
      glass: {shape: sphere, bsdf: {type: dielectric}, transform: [{scale: 0.5}, {translate: [1, 0, 0]}]}
      mesh:
        shape: {type: mesh, vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], faces: [[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]]}
        transform: {translate: [-1, -1, 1]}
      lamp: {light: {type: spot, intensity: 20, cutoff_angle: 40}, transform: {look_at: {origin: [0, 3, 1], target: [0, 0, 0]}}}
      panel: {shape: rectangle, light: {type: area, radiance: 2}, transform: [{rotate: {axis: x, angle: 90}}, {translate: [0, 3, 0]}]}
      eye:
        camera: {type: pinhole, fov: 50}
        transform: {look_at: {origin: [0.5, 1.5, 5], target: [0, 0, 0]}}
%s
"""  # noqa: E501
TURNING = """
      turning:
        shape: cube
        transform:
          keyframes:
            - {time: 0, scale: 0.25, translate: [-1, 0.5, 1]}
            - {time: 1, scale: 0.25, rotate: {axis: y, angle: 50}, translate: [-1, 1, 1]}
"""
CLOUD = """
      cloud:
        shape: cube
        bsdf: {type: "null"}
        interior: {type: grid, values: [[[0.2, 1], [0.5, 3]]], low: [%r, %r, %r], high: [%r, %r, %r]}
        transform: [{scale: 0.5}, {translate: [0, 0, 2]}]
"""  # noqa: E501


def scene(away, more="", integrator="path"):
    return loads(SCENE % (integrator, *away, more))


def cloud(away):
    low = [a + b for a, b in zip(away, (-0.5, -0.5, 1.5), strict=True)]
    return CLOUD % (*low, *(c + 1.0 for c in low))


@pytest.mark.parametrize(("kind", "integrator"), [("motion", "path"), ("cloud", "volpath")])
def test_pictures_are_those_at_the_origin(kind, integrator):
    films = []
    for away in (AWAY, (0.0, 0.0, 0.0)):
        more = {"motion": TURNING, "cloud": cloud(away)}[kind]
        films.append(
            alight.render(scene(away, more, integrator), spp=8, aovs=("position", "alpha"))
        )
    far, near = films
    assert near.image.max() > 0.0
    np.testing.assert_array_equal(far.sums, near.sums)
    # A layer is 0 where nothing is seen; a place has 24 bits in the world.
    covered = near.aov("alpha")
    assert covered.max() == 1.0
    shift = far.aov("position") - near.aov("position")
    np.testing.assert_allclose(shift, covered * AWAY, rtol=2e-7, atol=0.1)


def test_a_pattern_in_space_stays_where_it_is():
    """Near the origin, shifted by its own offset, noise is what it is far away."""
    away, scale = (4096.0, -2048.0, 8192.0), 2.0
    pictures = []
    for place, offset in ((away, (0.0,) * 3), ((0.0,) * 3, [scale * c for c in away])):
        paper = {"type": "noise", "scale": scale, "offset": offset, "octaves": 2}
        made = alight.changed(
            scene(place),
            {"nodes.world.children.floor.bsdf": {"type": "diffuse", "reflectance": paper}},
        )
        assert compile_scene(flatten(made), structure="list").origin.any() == (place is away)
        pictures.append(picture_of(made, spp=4))
    far, near = pictures
    assert near.max() > 0.05
    np.testing.assert_allclose(far, near, rtol=5e-3, atol=1e-3)


def test_what_does_not_lie_far_away_stays():
    for away in ((0.0, 0.0, 0.0), (20.0, 0.0, 0.0)):
        assert compile_scene(flatten(scene(away)), structure="list").origin is WORLD


def test_a_camera_that_is_far_from_all_shapes_keeps_its_place():
    """The only finite shape may be a sun."""
    flat = flatten(scene(AWAY))
    assert compile_scene(flat, structure="list").origin.any()
    moved = replace(flat, camera=flat.camera._replace(to_world=np.eye(4)))
    assert compile_scene(moved, structure="list").origin is WORLD


def test_a_camera_that_comes_near_changes_the_space():
    """As a scene that is compiled from there."""
    there = scene(AWAY)
    from_afar = there.replaced(camera=Node(camera=there.nodes["world"].children["eye"].camera))
    made = compiled_of(from_afar, (), 1)
    near = compiled_of(there, (), 1)
    assert made.compiled.origin is WORLD
    seen = made.seen_from(near.flat.camera)
    np.testing.assert_array_equal(seen.compiled.origin, near.compiled.origin)
    assert seen.compiled.content_hash == near.compiled.content_hash
    tables = (s.compiled.tables.shapes.data.shaped for s in (seen, near))
    np.testing.assert_array_equal(*tables)


def test_a_medium_that_knows_its_place_keeps_the_world():
    flat = flatten(scene(AWAY))
    flat.media.append(Haze())
    compiled = compile_scene(flat, structure="list")
    assert compiled.origin is WORLD
    assert any("numbers of float32" in text for text in compiled.warnings)


def test_traces_are_told_in_the_world():
    far, near = (alight.trace(scene(away), (4, 4)) for away in (AWAY, (0.0, 0.0, 0.0)))
    assert len(far.vertices) == len(near.vertices) > 1
    for a, b in zip(far.vertices, near.vertices, strict=True):
        assert a.origin == pytest.approx(np.add(b.origin, AWAY), abs=1e-6)
        if b.position is not None:
            assert a.position == pytest.approx(np.add(b.position, AWAY), abs=1e-6)


def test_another_camera_sees_the_same_place():
    made = compiled_of(scene(AWAY), (), 1)
    seen = made.seen_from(made.flat.camera).compiled.tables.camera.shaped
    np.testing.assert_array_equal(seen, made.compiled.tables.camera.shaped)
    assert np.abs(seen[ORIGIN : ORIGIN + 3]).max() < 20.0


def matrix(shift):
    result = np.diag([2.0, 1.0, 0.5, 1.0])
    result[:3, 3] = shift
    return result


def motion(angle, shift, before):
    """From no turn at a shift to a turn about y and 1 m further."""
    turns = ([1.0, 0.0, 0.0, 0.0], [np.cos(0.5 * angle), 0.0, np.sin(0.5 * angle), 0.0])
    parts = [Parts(np.array(shift) + i, np.array(turns[i]), np.eye(3)) for i in (0, 1)]
    return Motion((Link(before, Track((0.0, 1.0), tuple(parts))),))


FAR, NEAR = np.array(AWAY), np.array([0.0, 1.0, 0.5])
MOTIONS = {
    "turns there": (motion(1.0, FAR, np.eye(4)), NEAR),
    "is there and shifts": (motion(0.0, NEAR, np.eye(4)), FAR),
    "is there and turns": (motion(1.0, NEAR, np.eye(4)), FAR),
    "below a stretch": (motion(1.0, NEAR, matrix(FAR)), NEAR),
}


@pytest.mark.parametrize("name", MOTIONS)
def test_what_moves_is_shifted_after_its_motion(name):
    moves, rest = MOTIONS[name]
    placed = PlacedShape("a", Sphere(), matrix(rest), 0, None, -1, motion=moves)
    back = shifted(placed, FAR)
    for time in (0.0, 0.3, 1.0):
        moved = back.motion.at(time) @ back.to_world
        expected = moves.at(time) @ placed.to_world
        expected[:3, 3] -= FAR
        np.testing.assert_allclose(moved, expected, atol=1e-8)
    assert back.motion.is_rigid == moves.is_rigid
    far_away = name == "is there and turns"
    assert (np.abs(back.to_world[:3, 3]).max() > 1e5) == far_away
