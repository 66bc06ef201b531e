"""The scene graph flattened: composition, inheritance, instances, lights, cameras."""

import numpy as np
import pytest

from alight.bsdfs.adapters.two_sided import TwoSided
from alight.bsdfs.conductors.mirror import Mirror
from alight.bsdfs.matte.diffuse import Diffuse
from alight.cameras.pinhole import Pinhole
from alight.core.errors import SceneError
from alight.formats import load
from alight.formats.loading import changed
from alight.integrators.ambient_occlusion import AmbientOcclusion
from alight.lights.area import Area
from alight.lights.constant import Constant
from alight.lights.directional import Directional
from alight.lights.point import Point
from alight.scene import Node, Scene, SceneManager, dump, flatten, look_at, rotate, scale, translate
from alight.scene.flatten import NO_GEOMETRY
from alight.shapes.cube import Cube
from alight.shapes.mesh import Mesh
from alight.shapes.sphere import Sphere
from alight.textures.checkerboard import Checkerboard

CAMERA = Node(camera=Pinhole(), transform=translate(0, 0, 5))
TRIANGLE = Mesh(vertices=[[0, 0, 0], [1, 0, 0], [0, 1, 0]], faces=[[0, 1, 2]])


def test_transforms_compose_down_the_graph():
    t, r, s = translate(1, 2, 3), rotate("y", 30), scale(1, 2, -3)
    leaf = Node(shape=Cube(), transform=s)
    scene = Scene(camera=CAMERA, nodes={
        "a": Node(transform=t, children={"b": Node(transform=r, children={"c": leaf})}),
    })  # fmt: skip
    (shape,) = flatten(scene).shapes
    assert shape.name == "a/b/c"
    np.testing.assert_array_equal(shape.to_world, t.matrix @ r.matrix @ s.matrix)


def test_transforms_apply_to_lights_and_cameras():
    rig = Node(
        transform=translate(1, 2, 3),
        children={
            "lamp": Node(light=Point(), transform=translate(0, 0, 1)),
            "sun": Node(light=Directional(), transform=rotate("x", 90)),
            "eye": Node(camera=Pinhole(fov=30), transform=rotate("y", 90)),
        },
    )
    flat = flatten(Scene(camera="rig/eye", nodes={"rig": rig}))
    assert [light.name for light in flat.lights] == ["rig/lamp", "rig/sun"]
    np.testing.assert_array_equal(flat.lights[0].to_world[:3, 3], (1, 2, 4))
    # Light travels along local +z, which a quarter turn about x points to -y.
    np.testing.assert_array_equal(flat.lights[1].to_world[:3, 2], (0, -1, 0))
    assert flat.camera.camera.fov == 30
    np.testing.assert_array_equal(flat.camera.to_world[:3, 3], (1, 2, 3))
    np.testing.assert_array_equal(-flat.camera.to_world[:3, 2], (-1, 0, 0))


def test_steps_in_a_file_are_applied_from_left_to_right(tmp_path):
    (tmp_path / "s.yaml").write_text(
        "alight: 1\ncamera: {}\nenvironment: constant\nnodes:\n  a:\n    shape: cube\n"
        "    transform: [{scale: 2}, {rotate: {axis: z, angle: 90}}, {translate: [10, 0, 0]}]\n"
    )
    (shape,) = flatten(load(tmp_path / "s.yaml")).shapes
    np.testing.assert_array_equal(shape.to_world @ [1, 0, 0, 1], [10, 2, 0, 1])


def test_materials_are_inherited_named_resolved_and_shared():
    scene = Scene(
        camera=CAMERA,
        textures={"checks": Checkerboard()},
        bsdfs={
            "checked": Diffuse(reflectance="checks"),
            "both": TwoSided(bsdf="checked"),
            "same": Diffuse(reflectance=Checkerboard()),
        },
        nodes={
            "a": Node(bsdf="checked", shape=Cube(), children={
                "inherits": Node(shape=Cube()),
                "own": Node(shape=Cube(), bsdf=Mirror()),
            }),
            "default": Node(shape=Cube()),
            "both": Node(shape=Cube(), bsdf="both"),
            "same": Node(shape=Cube(), bsdf="same"),
        },
    )  # fmt: skip
    flat = flatten(scene)
    found = {shape.name: flat.bsdfs[shape.bsdf] for shape in flat.shapes}
    checked = Diffuse(reflectance=Checkerboard())
    assert found["a"] == found["a/inherits"] == found["same"] == checked
    assert found["a/own"] == Mirror()
    assert found["default"] == Diffuse()
    assert found["both"] == TwoSided(bsdf=checked)
    assert len(flat.bsdfs) == 4


def test_instances_share_geometry_and_compose_transforms():
    scene = Scene(
        camera=CAMERA,
        prototypes={
            "leaf": Node(shape=TRIANGLE, transform=scale(2)),
            "twig": Node(children={
                "l": Node(instance="leaf", transform=translate(-1, 0, 0)),
                "r": Node(instance="leaf", transform=translate(1, 0, 0)),
            }),
        },
        nodes={f"t{i}": Node(instance="twig", transform=translate(0, i, 0)) for i in range(500)},
    )  # fmt: skip
    flat = flatten(scene)
    assert len(flat.shapes) == 1000
    assert len(flat.geometries) == 1
    assert {shape.geometry for shape in flat.shapes} == {0}
    assert flat.shapes[7].name == "t3/twig/r/leaf"
    expected = translate(1, 3, 0) @ scale(2)
    np.testing.assert_array_equal(flat.shapes[7].to_world, expected.matrix)


def test_equal_meshes_share_geometry_but_shading_separates_them():
    normals = {"normals": [[0, 0, 1]] * 3}
    same = Mesh(vertices=TRIANGLE.vertices.copy(), faces=TRIANGLE.faces.copy())
    smooth = TRIANGLE.replaced(**normals)
    flat = flatten(Scene(camera=CAMERA, nodes={
        "a": Node(shape=TRIANGLE), "b": Node(shape=same), "c": Node(shape=smooth),
        "d": Node(shape=smooth.replaced(face_normals=True)), "e": Node(shape=Sphere()),
    }))  # fmt: skip
    assert [shape.geometry for shape in flat.shapes] == [0, 0, 1, 0, NO_GEOMETRY]
    assert flat.geometries[0].normals is None
    assert flat.geometries[1].vertices.dtype == np.float32
    assert flat.geometries[1].faces.dtype == np.int32


def test_area_lights_stay_with_their_shapes():
    flat = flatten(Scene(camera=CAMERA, nodes={"a": Node(shape=Cube(), light=Area(radiance=2))}))
    assert flat.lights == []
    assert flat.shapes[0].light == Area(radiance=2)


@pytest.mark.parametrize(
    ("changes", "dark"),
    [
        ({}, True),
        ({"environment": Constant()}, False),
        ({"environment": Constant(radiance=0)}, True),
        ({"integrator": AmbientOcclusion()}, False),
        ({"nodes": {"a": Node(light=Point())}}, False),
        ({"nodes": {"a": Node(light=Point(intensity=0))}}, True),
        ({"nodes": {"a": Node(children={"b": Node(shape=Cube(), light=Area())})}}, False),
        ({"prototypes": {"p": Node(shape=Cube(), light=Area())}}, True),
        (
            {
                "prototypes": {"p": Node(shape=Cube(), light=Area()), "q": Node(instance="p")},
                "nodes": {"a": Node(instance="q")},
            },
            False,
        ),
    ],
)
def test_a_scene_without_light_says_so(changes, dark):
    flat = flatten(Scene(camera=CAMERA, **changes))
    text = "the scene has no light: the picture will be black"
    assert flat.warnings == ([text] if dark else [])


def test_problems_of_scenes_made_in_python_have_key_paths():
    scene = Scene(nodes={"a": Node(shape=Cube(), bsdf="wood", transform=scale(0))})
    with pytest.raises(SceneError) as caught:
        flatten(scene)
    assert str(caught.value) == (
        'nodes.a.bsdf\n  unknown bsdf "wood"  (valid: none)\n'
        "nodes.a.transform\n  is singular: it flattens space\n"
        "camera\n  is missing: a scene needs a camera"
    )
    with pytest.raises(SceneError) as caught:
        Diffuse(reflectance=(1.2, 0, 0), sampling="cosin")
    assert str(caught.value) == (
        "diffuse.reflectance[0]\n  must be in [0, 1], got 1.2\n"
        'diffuse.sampling\n  must be one of cosine, uniform, got "cosin"; did you mean "cosine"?'
    )


def test_trees_deeper_than_a_file_can_hold_are_refused():
    node = Node(shape=Cube())
    for _ in range(30):
        node = Node(children={"n": node})
    with pytest.raises(SceneError, match="nested deeper than 24 levels"):
        flatten(Scene(camera=CAMERA, nodes={"n": node}))


def test_manager_adds_finds_moves_and_removes():
    manager = SceneManager(Scene(camera=CAMERA))
    manager.add("boxes", Node()).add("boxes/small", Node(shape=Cube())).add("other", Node())
    assert [path for path, _ in manager.nodes()] == ["boxes", "boxes/small", "other"]
    manager.move("boxes/small", "other/tiny")
    assert [path for path, _ in manager.nodes()] == ["boxes", "other", "other/tiny"]
    manager.replace("other/tiny", Node(shape=Sphere()))
    assert manager.get("other/tiny").shape == Sphere()
    manager.remove("other")
    assert [path for path, _ in manager.nodes()] == ["boxes"]
    manager.add_bsdf("m", Mirror()).add_texture("t", Checkerboard()).add_prototype("p", Node())
    manager.set(environment=Constant())
    assert manager.scene.environment == Constant()


@pytest.mark.parametrize(
    ("action", "message"),
    [
        (lambda m: m.get("boxs/small"), 'unknown node "boxs/small"; did you mean "boxes/small"?'),
        (lambda m: m.add("boxes", Node()), 'a node named "boxes" exists already'),
        (lambda m: m.add("none/x", Node()), 'unknown node "none"'),
        (lambda m: m.add("a.b", Node()), "names must not contain any of / . [ ] ="),
        (lambda m: m.remove("x"), 'unknown node "x"'),
        (lambda m: m.move("boxes", "boxes/small/x"), "cannot move below itself"),
        (lambda m: m.move("boxes", "nowhere/x"), 'unknown node "nowhere"'),
        (lambda m: m.set_value("film.size"), "must be path.to.key=value"),
        (lambda m: m.set_value("film.sise=[1, 1]"), 'did you mean "size"?'),
        (lambda m: m.set_value("film.size[2]=1"), "index must be in [0, 1], got 2"),
        (lambda m: m.set_value("film.size.x=1"), "film.size has an index"),
        (lambda m: m.set_value("camera.fov.x=1"), "camera.fov has no keys below it"),
        (lambda m: m.set_value("nodes.boxs.bsdf=x"), 'did you mean "boxes"?'),
        (lambda m: m.set_value("camera.fov={"), "is not YAML"),
        (lambda m: m.set_value("camera.fov=-1"), "must be in (0, 180), got -1"),
    ],
)
def test_manager_refuses_with_a_reason_and_keeps_the_scene(action, message):
    manager = SceneManager(Scene(camera=CAMERA)).add("boxes", Node(children={"small": Node()}))
    before = manager.scene
    with pytest.raises(SceneError) as caught:
        action(manager)
    assert message in str(caught.value)
    assert manager.scene == before


def test_set_value_changes_one_value():
    manager = SceneManager(load("cornell-box"))
    manager.set_value("bsdfs.white.reflectance[1]=0.25")
    assert manager.scene.bsdfs["white"].reflectance == (0.885809, 0.25, 0.666422)
    manager.set_value("integrator.type=direct")
    assert manager.scene.integrator.type == "direct"
    manager.set_value("sampler={type: stratified, strata: 3}")
    assert manager.scene.sampler.strata == 3
    manager.set_value("camera.transform={look_at: {origin: [0, 0, 4], target: [0, 0, 0]}}")
    assert manager.scene.camera.transform == look_at((0, 0, 4), (0, 0, 0))
    manager.set_value("integrator.heuristic=balance")
    manager.set_value("environment.type=constant")
    assert manager.scene.environment == Constant()


def test_instances_have_the_material_of_where_they_stand_unless_they_have_their_own():
    own, outer, inner = Diffuse(reflectance=0.1), Diffuse(reflectance=0.2), Diffuse(reflectance=0.3)
    ball = Node(shape=Sphere())
    both = Node(children={"bare": ball, "painted": ball.replaced(bsdf=own)})
    scene = Scene(
        camera=CAMERA,
        prototypes={"both": both},
        nodes={
            "plain": Node(instance="both"),
            "a": Node(bsdf=outer, children={"b": Node(instance="both")}),
            "c": Node(bsdf=outer, children={"d": Node(instance="both", bsdf=inner)}),
        },
    )
    flat = flatten(scene)
    found = {shape.name: flat.bsdfs[shape.bsdf].reflectance[0] for shape in flat.shapes}
    assert len(found) == 6
    assert {name: value for name, value in found.items() if name.endswith("painted")} == {
        f"{name}/both/painted": 0.1 for name in ("plain", "a/b", "c/d")
    }
    assert found["a/b/both/bare"] == 0.2
    assert found["c/d/both/bare"] == 0.3
    assert found["plain/both/bare"] not in (0.1, 0.2, 0.3)


def test_an_edit_looks_at_nothing_that_it_does_not_name(monkeypatch):
    scene = load("cornell-box")
    seen = []
    monkeypatch.setattr(dump, "holds_image", lambda value: bool(seen.append(value)))
    edited = changed(scene, {"bsdfs.white.reflectance": 0.5})
    assert len(seen) == 1
    assert seen[0] is scene.bsdfs["white"]
    assert all(edited.nodes[name] is node for name, node in scene.nodes.items())
