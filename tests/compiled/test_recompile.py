"""What is known of a scene is used again, and gives the bits that a fresh one would."""

import copy
import pickle

import numpy as np
import pytest

import alight
from alight.accel import kept as kept_trees
from alight.compiled import recompile, shapes
from alight.compiled.scene import compile_scene
from alight.formats import loads
from alight.scene import content_hash, flatten
from lanewise.view import View

SCENE = """
alight: 1
camera: {fov: 40, transform: {look_at: {origin: [0, 1, 5], target: [0, 0, 0]}}}
film: {size: [8, 8]}
environment: {type: constant}
bsdfs:
  ball: {type: principled, roughness: 0.5}
  other: {type: diffuse, reflectance: 0.5}
prototypes:
  water: {shape: {type: mesh, file: "builtin:waves"}, bsdf: ball}
nodes:
  one: {instance: water}
  two: {instance: water, transform: {translate: [0, 1, 0]}}
"""


def look_at(*origin):
    return {"look_at": {"origin": list(origin), "target": [0, 0, 0]}}


def compiled(scene, threads=1):
    return recompile.compiled_of(scene, (), threads).compiled


@pytest.fixture
def counted(monkeypatch):
    """How often a scene and a mesh are built."""
    count = {"scenes": 0, "meshes": 0}
    build, make = kept_trees.build_bvh, compile_scene

    def tree(*args, **words):
        count["meshes"] += 1
        return build(*args, **words)

    def whole(*args, **words):
        count["scenes"] += 1
        return make(*args, **words)

    monkeypatch.setattr(kept_trees, "_TREES", {})
    monkeypatch.setattr(kept_trees, "build_bvh", tree)
    monkeypatch.setattr(recompile, "compile_scene", whole)
    return count


def test_another_camera_takes_what_is_known_and_has_the_hash_of_a_fresh_scene(counted):
    scene = loads(SCENE)
    first = compiled(scene)
    moved = alight.changed(scene, {"camera.transform": look_at(3, 1, 4), "camera.fov": 30})
    second = compiled(moved)
    assert counted["scenes"] == 1
    assert second.tables.accel is first.tables.accel
    fresh = flatten(loads(SCENE.replace("[0, 1, 5]", "[3, 1, 4]").replace("fov: 40", "fov: 30")))
    wanted = compile_scene(fresh, content_hash(fresh))
    assert second.content_hash == wanted.content_hash != first.content_hash
    assert np.array_equal(second.tables.camera.array, wanted.tables.camera.array)


def bits(tables):
    """All arrays of a scene's tables."""
    if isinstance(tables, View):
        return [tables.array.tobytes()]
    return [found for table in tables for found in bits(table)] if tables else []


@pytest.mark.parametrize(
    ("changes", "keeps_tree"),
    [
        ({"bsdfs.ball.roughness": 0.2}, True),
        ({"film.size": (16, 8)}, True),
        ({"nodes.two.transform": {"translate": [0, 2, 0]}}, False),
        ({"nodes.one.bsdf": "other", "nodes.two.transform": []}, False),
        ({"prototypes.water.bsdf": "other"}, True),
        ({"bsdfs.other.reflectance": 0.1, "bsdfs.ball": {"type": "diffuse"}}, True),
        ({"environment.radiance": 2.0}, True),
        ({"camera.type": "orthographic"}, True),
        ({"camera.shutter": (0.0, 0.5)}, True),
        ({"sampler.type": "independent"}, True),
    ],
    ids=str,
)
def test_whatever_else_changes_is_compiled_to_the_bits_of_a_fresh_scene(
    changes, keeps_tree, counted
):
    scene = loads(SCENE)
    first = compiled(scene)
    found = alight.changed(scene, changes)
    second = compiled(found)
    assert counted == {"scenes": 2, "meshes": 1}
    assert (second.tables.accel is first.tables.accel) == keeps_tree
    fresh = compile_scene(flatten(copy.deepcopy(found)), content_hash(found))
    assert second.content_hash == fresh.content_hash
    assert bits(second.tables) == bits(fresh.tables)


def test_a_change_leaves_the_scene_and_shares_the_rest():
    scene = loads(SCENE)
    found = alight.changed(scene, {"bsdfs.ball.roughness": 0.2, "nodes.one.transform": []})
    assert (scene.bsdfs["ball"].roughness, found.bsdfs["ball"].roughness) == (0.5, 0.2)
    assert found.nodes["two"] is scene.nodes["two"]
    assert found.prototypes["water"] is scene.prototypes["water"]
    with pytest.raises(alight.SceneError, match=r"bsdfs\.ball\.roughnes\n.*did you mean"):
        alight.changed(scene, {"bsdfs.ball.roughnes": 0.2})
    with pytest.raises(alight.SceneError, match=r"did you mean \"ball\""):
        alight.changed(scene, {"bsdfs.bal.roughness": 0.2})


def test_what_is_frozen_names_the_way():
    scene = loads(SCENE)
    with pytest.raises(
        alight.SceneError, match=r"film\.size\n.*\.replaced\(size=\.\.\.\).*changed"
    ):
        scene.film.size = (4, 4)


def test_copies_and_other_processes_begin_with_nothing():
    scene = loads(SCENE)
    compiled(scene)
    assert scene.memory.held is not None
    for other in (copy.deepcopy(scene), pickle.loads(pickle.dumps(scene))):
        assert other == scene
        assert other.memory.held is None


def test_nodes_that_are_the_same_are_placed_once():
    scene = loads(SCENE)
    before = flatten(scene)
    moved = alight.changed(scene, {"nodes.two.transform": {"translate": [0, 2, 0]}})
    after = flatten(moved, before)
    assert after.shapes[0] is before.shapes[0]
    assert after.shapes[1].to_world[1, 3] == 2.0
    for one, fresh in zip(after.shapes, flatten(copy.deepcopy(moved)).shapes, strict=True):
        assert np.array_equal(one.to_world, fresh.to_world)
        assert one[3:] == fresh[3:]


def test_nodes_are_placed_anew_where_what_they_name_or_their_times_change():
    """Media end at bodies, keyframes are seen at the times of the shutter."""
    scene = loads(SCENE.replace("{instance: water}", "{instance: water, transform: {keyframes: ["
                                "{time: 0, translate: [0, 0, 0]}, {time: 1, translate: [1, 0, 0]}"
                                "]}}"))  # fmt: skip
    recompile.compiled_of(scene, (), 1)
    for changes in (
        {"prototypes.water.shape": {"type": "sphere"}},
        {"camera.shutter": (0.0, 0.5)},
        {"medium": {"type": "homogeneous"}, "integrator.type": "volpath"},
        {"bsdfs.ball": {"type": "subsurface"}},
    ):
        scene = alight.changed(scene, changes)
        found = recompile.compiled_of(scene, (), 1)
        assert found.compiled.content_hash == content_hash(copy.deepcopy(scene))


def test_only_the_instance_that_moves_is_put_into_its_place_anew(monkeypatch):
    asked, box = [], shapes.instance_in_place

    def counted(vertices, to_world):
        asked.append(tuple(to_world[:3, 3]))
        return box(vertices, to_world)

    monkeypatch.setattr(shapes, "instance_in_place", counted)
    scene = loads(SCENE)
    compiled(scene)
    assert asked == [(0.0, 0.0, 0.0), (0.0, 1.0, 0.0)]
    moved = alight.changed(scene, {"nodes.two.transform.translate": (0, 3, 0)})
    now = compiled(moved)
    assert asked[2:] == [(0.0, 3.0, 0.0)]
    fresh = compile_scene(flatten(copy.deepcopy(moved)), content_hash(moved))
    assert bits(now.tables) == bits(fresh.tables)


def test_the_box_of_a_mesh_is_found_once():
    vertices, faces = np.eye(3, dtype=np.float32), np.array([[0, 1, 0]], np.int32)
    # A vertex that no face uses is not in the box, nor is an array that may change kept.
    assert kept_trees.own_box(vertices, faces).tolist() == [[0, 0, 0], [1, 1, 0]]
    vertices[0] *= 2.0
    assert kept_trees.own_box(vertices, faces).tolist() == [[0, 0, 0], [2, 1, 0]]
    for array in (vertices, faces):
        array.flags.writeable = False
    assert kept_trees.own_box(vertices, faces) is kept_trees.own_box(vertices, faces)
