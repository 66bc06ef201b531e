"""Texture coordinates and their sets, as files have them and as meshes of ours do."""

import numpy as np

from tests.formats.gltf.maker import FACES, UVS, Maker
from tests.formats.gltf.reading import core, material_of, parsed


def test_texture_coordinates_are_turned_over():
    m = Maker()
    m.node(mesh=m.square())
    node = parsed(m).data["nodes"]["node 0"]
    np.testing.assert_array_equal(node["shape"].uvs, UVS * [1, -1] + [0, 1])
    np.testing.assert_array_equal(node["shape"].faces, FACES.reshape(-1, 3))


def test_the_example_of_texture_transforms_shows_the_lower_left_quarter():
    """Of KHR_texture_transform's text: offset (0, 1), rotation 90 degrees, scale 1/2."""
    change = {"offset": [0, 1], "rotation": np.pi / 2, "scale": [0.5, 0.5]}
    info = {"index": 0, "extensions": {"KHR_texture_transform": change}}
    bsdf = core(material_of(pbrMetallicRoughness={"baseColorTexture": info}))
    matrix = np.array(bsdf["base_color"]["to_uv"]["matrix"])
    corners = np.array([[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]) @ matrix.T
    assert np.allclose(corners.min(axis=0), [0, 0], atol=1e-12)
    assert np.allclose(corners.max(axis=0), [0.5, 0.5], atol=1e-12)


def test_texture_transforms_are_seen_from_above():
    """Half the height, from the top: v runs upwards here."""
    change = {"offset": [0.25, 0], "scale": [1, 0.5], "texCoord": 1}
    info = {"index": 0, "texCoord": 0, "extensions": {"KHR_texture_transform": change}}
    bsdf = core(material_of(pbrMetallicRoughness={"baseColorTexture": info}))
    assert bsdf["base_color"]["to_uv"]["matrix"] == [[1.0, 0.0, 0.25], [0.0, 0.5, 0.5]]
    m = Maker()
    m.picture(np.zeros((2, 2, 3), np.uint8))
    material = m.material(pbrMetallicRoughness={"baseColorTexture": info})
    other = np.full((4, 2), 0.25, "<f4")
    m.node(mesh=m.square(material, TEXCOORD_1=m.accessor(other)))
    uvs = parsed(m).data["nodes"]["node 0"]["shape"].uvs
    np.testing.assert_array_equal(uvs, [[0.25, 0.75]] * 4)


SECOND = np.array([[0.25, 0.5], [0.5, 0.5], [0.5, 0.25], [0.25, 0.25]], "<f4")


def square_with_two_sets(**material):
    """A node of the square with two sets of coordinates and a picture 0; and what was said."""
    m = Maker()
    m.picture(np.zeros((2, 2, 3), np.uint8))
    m.node(mesh=m.square(m.material(**material), TEXCOORD_1=m.accessor(SECOND)))
    found = parsed(m)
    (bsdf,) = found.data["bsdfs"].values()
    return found.data["nodes"]["node 0"], core(bsdf), found


def test_textures_name_their_sets_of_coordinates():
    second = {"index": 0, "texCoord": 1}
    pbr = {"baseColorTexture": {"index": 0}, "metallicRoughnessTexture": second}
    node, bsdf, found = square_with_two_sets(pbrMetallicRoughness=pbr, emissiveTexture=second,
                                             emissiveFactor=[1, 1, 1])  # fmt: skip
    np.testing.assert_array_equal(node["shape"].uvs, UVS * [1, -1] + [0, 1])
    np.testing.assert_array_equal(node["shape"].more_uvs, [SECOND * [1, -1] + [0, 1]])
    assert "uv_set" not in bsdf["base_color"]
    assert bsdf["roughness"]["texture"]["uv_set"] == 1
    assert node["light"]["radiance"]["uv_set"] == 1
    assert not [line for line in (*found.warnings, *found.notes) if "TEXCOORD" in line]


def test_normals_are_bent_along_the_own_coordinates_of_a_mesh():
    """Tangents follow from those: the set of the picture of normals becomes the own one."""
    pbr = {"baseColorTexture": {"index": 0}}
    bent = {"index": 0, "extensions": {"KHR_texture_transform": {"texCoord": 1}}}
    node, bsdf, _ = square_with_two_sets(pbrMetallicRoughness=pbr, normalTexture=bent)
    np.testing.assert_array_equal(node["shape"].uvs, SECOND * [1, -1] + [0, 1])
    np.testing.assert_array_equal(node["shape"].more_uvs, [UVS * [1, -1] + [0, 1]])
    assert bsdf["base_color"]["uv_set"] == 1


def test_sets_that_nothing_seen_uses_are_dropped():
    """Of occlusion nothing is seen; one set for all textures is the own one."""
    pbr = {"baseColorTexture": {"index": 0}}
    second = {"index": 0, "texCoord": 1}
    node, _, found = square_with_two_sets(pbrMetallicRoughness=pbr, occlusionTexture=second)
    assert node["shape"].more_uvs is None
    assert "TEXCOORD_1: not used by the material" in found.notes
    pbr = {"baseColorTexture": second, "metallicRoughnessTexture": second}
    node, bsdf, found = square_with_two_sets(pbrMetallicRoughness=pbr)
    np.testing.assert_array_equal(node["shape"].uvs, SECOND * [1, -1] + [0, 1])
    assert node["shape"].more_uvs is None
    assert "uv_set" not in bsdf["base_color"]
    assert "TEXCOORD_0: not used by the material" in found.notes


def test_a_mesh_that_lacks_a_set_is_told_of():
    third = {"index": 0, "texCoord": 2}
    pbr = {"baseColorTexture": {"index": 0}, "metallicRoughnessTexture": third}
    node, _, found = square_with_two_sets(pbrMetallicRoughness=pbr)
    np.testing.assert_array_equal(node["shape"].more_uvs, [node["shape"].uvs])
    lacks = "it lacks TEXCOORD_2, which its material asks for"
    (said,) = [line for line in found.warnings if "TEXCOORD" in line]
    assert said == f"/meshes/0/primitives/0: {lacks}; other coordinates of the mesh are taken"
