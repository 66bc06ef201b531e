"""Materials with pictures in their slots, written to glTF and read again."""

import math

import numpy as np
import pytest

from alight.formats import load
from alight.formats.gltf.write import write
from alight.scene import flatten
from alight.textures.checkerboard import Checkerboard
from tests.formats.gltf.maker import Maker
from tests.formats.gltf.written import GREY, SQUARE, again
from tests.textures.lookup import look_up

RNG = np.random.default_rng(11)


def in_every_slot():
    """A file with a material with pictures wherever there can be one, in two sets."""
    m = Maker()

    def info(channels=3, texture_coordinates=0, **place):
        index = m.picture(RNG.integers(1, 256, (4, 6, channels)).astype(np.uint8), wrapT=33071)
        made = {"index": index, "texCoord": texture_coordinates}
        return made | ({"extensions": {"KHR_texture_transform": place}} if place else {})

    extensions = {
        "KHR_materials_ior": {"ior": 1.4},
        "KHR_materials_specular": {
            "specularFactor": 0.5, "specularTexture": info(4),
            "specularColorFactor": [1, 0.5, 0.25], "specularColorTexture": info(),
        },
        "KHR_materials_transmission": {"transmissionFactor": 0.5, "transmissionTexture": info()},
        "KHR_materials_clearcoat": {
            "clearcoatFactor": 0.75, "clearcoatTexture": info(texture_coordinates=1),
            "clearcoatRoughnessFactor": 0.5, "clearcoatRoughnessTexture": info(),
        },
        "KHR_materials_sheen": {
            "sheenColorFactor": [0.5, 0.25, 1], "sheenColorTexture": info(),
            "sheenRoughnessFactor": 0.5, "sheenRoughnessTexture": info(4),
        },
        "KHR_materials_iridescence": {
            "iridescenceFactor": 0.5, "iridescenceTexture": info(), "iridescenceIor": 1.5,
            "iridescenceThicknessMinimum": 50.0, "iridescenceThicknessTexture": info(),
        },
        "KHR_materials_anisotropy": {"anisotropyStrength": 0.5, "anisotropyRotation": 1.0},
        "KHR_materials_emissive_strength": {"emissiveStrength": 4.0},
    }  # fmt: skip
    material = m.material(
        pbrMetallicRoughness={
            "baseColorFactor": [1, 0.5, 0.25, 0.5],
            "baseColorTexture": info(4, offset=[0.25, 0.5], rotation=0.5, scale=[2.0, -1.0]),
            "metallicFactor": 0.5, "roughnessFactor": 0.75,
            "metallicRoughnessTexture": info(texture_coordinates=1),
        },
        normalTexture={**info(), "scale": 0.5},
        emissiveFactor=[1, 0.5, 0],
        emissiveTexture=info(texture_coordinates=1, scale=[0.5, 3.0]),
        alphaMode="MASK", alphaCutoff=0.25, extensions=extensions,
    )  # fmt: skip
    second = RNG.random((4, 2)).astype("<f4")
    m.node(mesh=m.square(material, TEXCOORD_1=m.accessor(second)))
    m.json["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "point"}]}}
    m.node(extensions={"KHR_lights_punctual": {"light": 0}})
    return m


def test_pictures_of_every_slot_come_back(tmp_path):
    """To the last bit: materials with all texels, places on surfaces and sets; meshes; light."""
    (tmp_path / "a.glb").write_bytes(in_every_slot().glb())
    first = flatten(load(tmp_path / "a.glb"))
    assert write(first, tmp_path / "b.glb") == []
    second = flatten(load(tmp_path / "b.glb"))
    assert rounded(first.bsdfs) == rounded(second.bsdfs)
    assert rounded([first.shapes[0].light]) == rounded([second.shapes[0].light])
    for one, other in zip(first.geometries, second.geometries, strict=True):
        np.testing.assert_array_equal(one.uvs, other.uvs)
        np.testing.assert_array_equal(one.more_uvs, other.more_uvs)


def rounded(specs):
    """Descriptions as text, numbers to ten digits: places of pictures are multiplied out."""

    def plain(value):
        if isinstance(value, float):
            return float(f"{value + 0.0:.10g}") + 0.0
        if hasattr(value, "to_uv") or hasattr(type(value), "model_fields"):
            return {name: plain(item) for name, item in value}
        if hasattr(value, "matrix"):
            return value.matrix.round(10).tolist()
        return [plain(item) for item in value] if isinstance(value, tuple | list) else repr(value)

    return plain(list(specs))


def test_colours_in_floats_are_encoded(tmp_path):
    """They were linear; a lamp may be brighter than 1."""
    texels = RNG.uniform(0.0, 1.0, (3, 4, 3)).round(3)
    texture = {"type": "bitmap", "pixels": texels.tolist()}
    bright = {"type": "bitmap", "pixels": (30.0 * texels).tolist()}
    found, flat, lost = again({"type": "diffuse", "reflectance": texture}, tmp_path,
                              {"type": "area", "radiance": bright})  # fmt: skip
    # One step of 8 bits is 1 % of 1 and 0.03 % near 0.
    np.testing.assert_allclose(found.base_color.pixels.linear(), texels, atol=0.005)
    radiance = flat.shapes[0].light.radiance
    strength, picture = (
        (radiance.a, radiance.b) if isinstance(radiance.a, tuple) else (radiance.b, radiance.a)
    )
    shown = np.array(strength) * picture.pixels.linear()
    np.testing.assert_allclose(shown, 30.0 * texels, atol=0.15)
    assert lost == ["pictures of 16 bits and floats: became 8 bits"]


OTHER = GREY | {"pixels": ["10 20", "30 40"]}


def channels_of(value):
    """Values of a number: the factor times the channel of its picture."""
    if isinstance(value, float):
        return np.full((2, 2), value)
    parts = [value.a, value.b] if value.type == "multiply" else [value]
    factor = math.prod(np.mean(part) for part in parts if isinstance(part, tuple))
    (part,) = [part for part in parts if not isinstance(part, tuple)]
    return factor * part.texture.pixels.linear("linear")[..., "rgb".index(part.channel)]


def test_numbers_in_grey_pictures_share_one_with_two_channels(tmp_path):
    """As pbrt, Mitsuba and OBJ have them: each in a picture of its own."""
    half = {"type": "multiply", "a": 0.5, "b": OTHER}
    bsdf = {"type": "principled", "metallic": half, "roughness": GREY}
    found, _, lost = again(bsdf, tmp_path)
    np.testing.assert_allclose(
        channels_of(found.roughness), np.array([[64, 128], [192, 255]]) / 255
    )
    np.testing.assert_allclose(channels_of(found.metallic), np.array([[16, 32], [48, 64]]) / 510)
    assert lost == []
    # A number beside a picture stays a number: the picture's other channel is white.
    found, _, lost = again(bsdf | {"metallic": 0.25}, tmp_path)
    np.testing.assert_allclose(channels_of(found.metallic), np.full((2, 2), 0.25))
    np.testing.assert_allclose(
        channels_of(found.roughness), np.array([[64, 128], [192, 255]]) / 255
    )
    # Pictures that lie differently cannot share one.
    found, _, lost = again(bsdf | {"metallic": OTHER | {"uv_set": 1}}, tmp_path)
    np.testing.assert_allclose(channels_of(found.metallic), np.full((2, 2), 40 / 255))
    assert lost == ["a number that varies otherwise than a picture: became its mean"]


@pytest.mark.parametrize("metallic", [0.0, 0.25])
def test_a_channel_of_a_picture_leaves_the_other_number_alone(metallic, tmp_path):
    """The picture may stay as it is only where the other number is 0."""
    three = GREY | {"pixels": ["804020 0840ff", "ffff00 102030"]}
    tinted = {"type": "multiply", "a": [0.125, 0.5, 0.25], "b": three}
    roughness = {"type": "channel", "texture": tinted, "channel": "g"}
    bsdf = {"type": "principled", "metallic": metallic, "roughness": roughness}
    found, _, lost = again(bsdf, tmp_path)
    assert lost == []
    np.testing.assert_allclose(channels_of(found.metallic), np.full((2, 2), metallic))
    expected = np.array([[0x40, 0x40], [0xFF, 0x20]]) / 510
    np.testing.assert_allclose(channels_of(found.roughness), expected)


def test_roughness_of_alpha_in_a_picture_is_its_root(tmp_path):
    bsdf = {"type": "rough_plastic", "alpha": GREY, "diffuse_reflectance": 0.25}
    found, _, _ = again(bsdf, tmp_path)
    expected = np.sqrt(np.array([[64, 128], [192, 255]]) / 255)
    np.testing.assert_allclose(channels_of(found.roughness), expected, atol=0.5 / 255)


@pytest.mark.parametrize("mode", ["blend", "mask"])
def test_opacity_lies_in_the_picture_of_the_colour(mode, tmp_path):
    opacity = {"type": "channel", "texture": GREY, "channel": "r"}
    if mode == "mask":
        opacity = {"type": "threshold", "texture": opacity, "cutoff": 0.6}
    bsdf = {"type": "mask", "opacity": opacity, "bsdf": {"type": "principled", "base_color": 0.25}}
    _, flat, lost = again(bsdf, tmp_path)
    found = flat.bsdfs[flat.shapes[0].bsdf].opacity
    if mode == "mask":
        assert (found.type, found.cutoff) == ("threshold", 0.6)
        found = found.texture
    assert found.channel == "a"
    np.testing.assert_allclose(
        found.texture.pixels.alpha / 255, np.array([[64, 128], [192, 255]]) / 255
    )
    assert lost == []


def test_places_that_shear_and_bumps_are_told_of(tmp_path):
    sheared = GREY | {"to_uv": {"matrix": [[1, 0.5, 0], [0, 1, 0]]}}
    bsdf = {
        "type": "bump_map",
        "texture": GREY,
        "bsdf": {"type": "diffuse", "reflectance": sheared},
    }
    lost = "\n".join(again(bsdf, tmp_path)[2])
    assert "bump_map: what it does to a material" in lost
    assert "to_uv: places of pictures on surfaces that shear" in lost


def test_a_mesh_gets_the_sets_that_its_material_asks_for(tmp_path):
    """Where it has none of that number, its own is looked up: so it is in the file."""
    bsdf = {"type": "diffuse", "reflectance": GREY | {"uv_set": 2}}
    _, flat, lost = again(bsdf, tmp_path)
    np.testing.assert_allclose(flat.geometries[0].uvs, SQUARE["uvs"])
    assert lost == []


def test_colours_of_vertices_that_nothing_uses_are_left_out(tmp_path):
    """In glTF they would tint the surface."""
    colors = {"colors": [[1, 0, 0]] * 4}
    _, flat, _ = again({"type": "diffuse"}, tmp_path, **colors)
    assert flat.geometries[0].colors is None
    tinted = {"type": "diffuse", "reflectance": {"type": "vertex_color"}}
    _, flat, _ = again(tinted, tmp_path, **colors)
    np.testing.assert_array_equal(flat.geometries[0].colors, [[1, 0, 0]] * 4)


def test_vertices_tint_the_base_colour_alone(tmp_path):
    """What else has their colours would be tinted by none, and the base colour by them."""
    colors = {"colors": [[1, 0, 0]] * 4}
    vertex = {"type": "vertex_color"}
    mean = "vertex_color texture: became its mean colour"
    for bsdf, light in (
        ({"type": "diffuse"}, {"type": "area", "radiance": vertex}),
        ({"type": "principled", "specular_color": vertex}, None),
        ({"type": "principled", "sheen_color": vertex}, None),
    ):
        _, flat, lost = again(bsdf, tmp_path, light, **colors)
        assert flat.geometries[0].colors is None
        assert lost == [mean]


def test_meshes_without_colours_of_vertices_show_the_fallback(tmp_path):
    tinted = {"type": "vertex_color", "fallback": [0.5, 0.25, 1.0]}
    bsdf = {"type": "diffuse", "reflectance": {"type": "multiply", "a": 0.5, "b": tinted}}
    found, _, lost = again(bsdf, tmp_path)
    assert found.base_color == pytest.approx((0.25, 0.125, 0.5))
    assert lost == []


CLEAR = {"type": "bitmap", "pixels": ["ff804020 40ff80c0"]}


@pytest.mark.parametrize("opacity", [0.5, 1.0])
def test_the_alpha_of_a_colour_that_nothing_asked_for_plays_no_part(opacity, tmp_path):
    bsdf = {"type": "mask", "opacity": opacity, "bsdf": {"type": "diffuse", "reflectance": CLEAR}}
    _, flat, lost = again(bsdf, tmp_path)
    found = flat.bsdfs[flat.shapes[0].bsdf]
    assert lost == []
    assert opacity == (1.0 if found.type != "mask" else found.opacity.mean()[0])


def test_an_opacity_that_lies_otherwise_becomes_its_mean(tmp_path):
    other = {"type": "channel", "texture": GREY | {"wrap": "clamp"}, "channel": "r"}
    bsdf = {"type": "mask", "opacity": {"type": "multiply", "a": 0.5, "b": other},
            "bsdf": {"type": "diffuse", "reflectance": CLEAR}}  # fmt: skip
    _, flat, lost = again(bsdf, tmp_path)
    mean = 0.5 * (64 + 128 + 192 + 255) / 4 / 255
    assert flat.bsdfs[flat.shapes[0].bsdf].opacity.mean() == pytest.approx([mean] * 3)
    assert lost == ["opacity: its picture lies otherwise than that of the colour"]


HALF = {"type": "bitmap", "pixels": ["10 20", "30 40"], "color_space": "linear"}
TWICE = {"type": "multiply", "a": 2.0, "b": {"type": "channel", "texture": HALF, "channel": "r"}}


@pytest.mark.parametrize("name", ["metallic", "roughness", "clearcoat", "sheen_roughness"])
def test_factors_above_1_go_into_the_picture(name, tmp_path):
    """The file allows none."""
    sheen = {"sheen_color": 0.5} if name == "sheen_roughness" else {}
    found, _, lost = again({"type": "principled", name: TWICE, **sheen}, tmp_path)
    value = dict(found)[name]
    assert value.type == "channel"
    texels = value.texture.pixels.whole[..., "rgba".index(value.channel)]
    assert texels.tolist() == [[0x20, 0x40], [0x60, 0x80]]
    assert lost == []


def test_cuts_of_opacities_with_factors_above_1_stay_where_they_are(tmp_path):
    for kind in ("mask", "blend"):
        cut = {"type": "threshold", "texture": TWICE, "cutoff": 0.3}
        opacity = cut if kind == "mask" else TWICE
        bsdf = {"type": "mask", "opacity": opacity, "bsdf": {"type": "diffuse"}}
        _, flat, lost = again(bsdf, tmp_path)
        found = flat.bsdfs[flat.shapes[0].bsdf].opacity
        assert lost == []
        if kind == "mask":
            assert found.cutoff == pytest.approx(0.15)
            found = found.texture
        factor = 1 if kind == "mask" else 2
        texels = factor * np.array([[0x10, 0x20], [0x30, 0x40]])
        np.testing.assert_array_equal(found.texture.pixels.alpha, texels)


@pytest.mark.parametrize("weight", [0.25, HALF, {"type": "multiply", "a": 0.5, "b": HALF}])
def test_films_keep_their_thickness(weight, tmp_path):
    thickness = {"type": "mix", "a": 100.0, "b": 500.0, "weight": weight}
    bsdf = {"type": "principled", "iridescence": 1.0, "iridescence_thickness": thickness}
    found, _, lost = again(bsdf, tmp_path)
    value = found.iridescence_thickness
    if weight == 0.25:
        assert value == pytest.approx(200.0)
    else:
        assert (value.a[0], value.b[0]) == (100.0, 500.0 if weight is HALF else 300.0)
    assert lost == []


@pytest.mark.parametrize("place", [{}, {"scale": [3.0, 5.0], "offset": [0.25, -1.5]}])
def test_checkerboards_become_pictures_of_four_texels(place, tmp_path):
    board = {"type": "checkerboard", "color0": [1, 0.5, 0], "color1": 0.25, **place}
    bsdf = {"type": "principled", "base_color": board, "metallic": board}
    found, _, lost = again(bsdf, tmp_path)
    assert lost == ["pictures of 16 bits and floats: became 8 bits"]
    u, v = np.random.default_rng(1).random((2, 100))
    meant = look_up(Checkerboard(**board), u, v)
    np.testing.assert_allclose(look_up(found.base_color, u, v), meant, atol=0.004)
    meant = meant @ [0.2126, 0.7152, 0.0722]
    np.testing.assert_allclose(look_up(found.metallic, u, v)[:, 0], meant, atol=0.004)
