"""Skins at rest, and materials by specular colour and glossiness."""

import json

import numpy as np
import pytest

from alight.core.errors import SceneError
from alight.formats.materials.surfaces import BRIGHTEST
from tests.formats.gltf.maker import POINTS, Maker
from tests.formats.gltf.reading import core, material_of, parsed

#: Joint 0 holds the vertices at x = 0, joint 1 those at x = 1.
JOINTS = np.array([[0, 0, 0, 0], [1, 0, 0, 0], [1, 0, 0, 0], [0, 0, 0, 0]], "u1")
WEIGHTS = np.array([[1, 0, 0, 0]] * 4, "<f4")


def with_skin(joints=JOINTS, weights=WEIGHTS, bind=None, more=None):
    """A square in a moved node, with two joints elsewhere; `more` are attributes."""
    m = Maker()
    upright = np.tile(np.array([[0, 0, 1]], "<f4"), (4, 1))
    attributes = {"JOINTS_0": joints, "WEIGHTS_0": weights, "NORMAL": upright, **(more or {})}
    square = m.square(**{key: m.accessor(table) for key, table in attributes.items()})
    turn = [0.0, np.sqrt(0.5), 0.0, np.sqrt(0.5)]
    first = m.node(name="a", translation=[0, 0, 5])
    second = m.node(name="b", translation=[0, 0, 5], rotation=turn, scale=[2, 2, 2])
    m.node(name="skinned", mesh=square, skin=0, translation=[100, 0, 0], scale=[3, 3, 3])
    skin = {"joints": [first, second]}
    if bind is not None:
        skin["inverseBindMatrices"] = m.accessor(bind.astype("<f4"))
    m.json["skins"] = [skin]
    return m


def in_the_world(m):
    """Vertices and normals of the only mesh."""
    data = parsed(m).data["nodes"]["skinned"]
    shape = data["shape"]
    return 3.0 * shape.vertices + [100, 0, 0], shape.normals


def test_joints_hold_vertices_and_the_own_node_does_not():
    points, normals = in_the_world(with_skin())
    # Twice as large, and turned about y by 90 degrees: x becomes -z.
    at_one = [[0, 0, 5 - 2], [0, 2, 5 - 2]]
    np.testing.assert_allclose(points, [[0, 0, 5], *at_one, [0, 1, 5]], atol=2e-5)
    np.testing.assert_allclose(normals[:2], [[0, 0, 1], [1, 0, 0]], atol=1e-6)


def test_inverse_bind_matrices_come_first():
    shift = np.eye(4)
    shift[:3, 3] = 0, 10, 0
    # glTF writes columns one after the other.
    bind = np.stack([shift.T.ravel(), np.eye(4).ravel()])
    points, _ = in_the_world(with_skin(bind=bind))
    np.testing.assert_allclose(points[0], [0, 10, 5], atol=2e-5)
    np.testing.assert_allclose(points[1], [0, 0, 3], atol=2e-5)


@pytest.mark.parametrize("flat", ["itself", "parent"])
def test_a_node_without_size_shows_what_its_joints_hold(flat):
    m = with_skin()
    meant, _ = in_the_world(m)
    nodes = m.json["nodes"]
    if flat == "itself":
        nodes[2]["scale"] = [0, 0, 0]
    else:
        m.node(name="parent", scale=[0, 0, 0], children=[2])
    found = parsed(m)
    assert not any("flattens" in note for note in found.notes)
    assert "skinned" in found.data["nodes"]
    np.testing.assert_allclose(found.data["nodes"]["skinned"]["shape"].vertices, meant, atol=2e-5)


def test_weights_are_shares():
    half = np.array([[2, 2, 0, 0]] * 4, "<f4")
    joints = np.array([[0, 1, 0, 0]] * 4, "u1")
    points, _ = in_the_world(with_skin(joints, half))
    meant = 0.5 * np.add(POINTS, [0, 0, 5]) + 0.5 * (
        np.stack([2 * POINTS[:, 2], 2 * POINTS[:, 1], 5 - 2 * POINTS[:, 0]], 1)
    )
    np.testing.assert_allclose(points, meant, atol=2e-5)
    # The same by two sets: each joint in one of its own.
    first, second = np.zeros((2, 4, 4), "u1")
    second[:, 0] = 1
    more = {"JOINTS_1": second, "WEIGHTS_1": WEIGHTS}
    points, _ = in_the_world(with_skin(first, WEIGHTS, more=more))
    np.testing.assert_allclose(points, meant, atol=2e-5)


def test_joints_that_are_not_there():
    with pytest.raises(SceneError) as caught:
        parsed(with_skin(joints=JOINTS + np.uint8(5)))
    assert "below the number of joints, 2, got 6" in str(caught.value)
    assert "/meshes/0/primitives/0/attributes/JOINTS_0" in str(caught.value)
    with pytest.raises(SceneError) as caught:
        parsed(with_skin(bind=np.eye(4).reshape(1, 16)))
    assert "a matrix for each of 2 joints" in str(caught.value)


@pytest.mark.parametrize("wrong", [np.nan, 0.5])
def test_joints_are_whole_numbers(wrong):
    with pytest.raises(SceneError, match="attributes/JOINTS_0\n  must hold whole numbers"):
        parsed(with_skin(joints=JOINTS.astype("<f4") + np.float32(wrong)))


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf])
def test_weights_are_finite(wrong):
    with pytest.raises(SceneError, match="attributes/WEIGHTS_0\n  must hold finite numbers"):
        parsed(with_skin(weights=np.full_like(WEIGHTS, wrong)))


def glossy(**extension):
    return core(material_of(extensions={"KHR_materials_pbrSpecularGlossiness": extension}))


def test_specular_colours_are_what_is_reflected_straight_on():
    found = glossy(
        diffuseFactor=[0.1, 0.2, 0.3, 1], specularFactor=[0.2, 0.1, 0], glossinessFactor=0.7
    )
    assert found["base_color"] == [0.1, 0.2, 0.3]
    assert found["metallic"] == 0.0
    assert found["roughness"] == pytest.approx(0.3)
    straight_on = ((found["ior"] - 1) / (found["ior"] + 1)) ** 2
    np.testing.assert_allclose(straight_on * np.array(found["specular_color"]), [0.2, 0.1, 0])
    bright = glossy(specularFactor=[1, 0.8, 0.2])
    assert ((bright["ior"] - 1) / (bright["ior"] + 1)) ** 2 == pytest.approx(BRIGHTEST)
    np.testing.assert_allclose(bright["specular_color"], [1.0, 1.0, 0.2 / BRIGHTEST])


def test_glossiness_of_a_picture():
    found = glossy(diffuseTexture={"index": 0}, specularGlossinessTexture={"index": 0})
    assert found["base_color"]["type"] == "bitmap"
    assert found["specular_color"]["type"] == "clamp"
    # 1 - a, with a the picture's opacity.
    assert (found["roughness"]["a"], found["roughness"]["b"]) == (1.0, 0.0)
    assert found["roughness"]["weight"]["channel"] == "a"


def test_versions_written_as_numbers_are_versions():
    m = Maker()
    m.node(mesh=m.square())
    document = json.loads(m.gltf())
    document["asset"]["version"] = 1.0
    from alight.formats.gltf.scene import parse

    with pytest.raises(SceneError) as caught:
        parse(json.dumps(document).encode(), "a.gltf")
    assert 'must be 2.0, got "1"' in str(caught.value)
