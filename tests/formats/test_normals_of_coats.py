"""Normals of coats: smooth where a file says nothing, whatever bends the base; else their own."""

import numpy as np
import pytest

from alight.formats import load
from tests.formats.gltf.maker import Maker
from tests.formats.gltf.reading import core, parsed
from tests.formats.gltf.written import again

FLAT = [0.5, 0.5, 1.0]
PIXELS = np.full((2, 2, 3), (128, 90, 230), np.uint8)


def coat_of(normal=None, coat_normal=None, strength=0.5):
    m = Maker()
    m.picture(PIXELS)
    m.picture(PIXELS[:1])
    coat = {"clearcoatFactor": strength}
    coat |= {"clearcoatNormalTexture": coat_normal} if coat_normal else {}
    own = {"normalTexture": normal} if normal else {}
    material = m.material(name="it", extensions={"KHR_materials_clearcoat": coat}, **own)
    m.node(mesh=m.square(material, TEXCOORD_1=m.accessor(np.zeros((4, 2), "<f4"))))
    found = parsed(m)
    assert not any("clearcoat" in text for text in found.warnings)
    return core(found.data["bsdfs"]["it"])


def test_coats_of_gltf_are_smooth_without_a_texture_of_their_own():
    assert "clearcoat_normal" not in coat_of()
    assert coat_of(normal={"index": 0}).get("clearcoat_normal") == FLAT
    assert "clearcoat_normal" not in coat_of(normal={"index": 0}, strength=0.0)


def test_coats_of_gltf_have_the_normals_of_their_texture():
    texture = {"index": 1, "scale": 0.5, "texCoord": 1}
    for normal in (None, {"index": 0}):
        found = coat_of(normal, texture)
        assert found["clearcoat_normal"]["type"] == "bitmap"
        assert found["clearcoat_normal"]["color_space"] == "linear"
        assert found["clearcoat_normal_scale"] == 0.5
        assert found["clearcoat_normal"].get("uv_set", 0) == (1 if normal else 0)


def test_coats_of_gltf_follow_the_base_where_both_textures_are_the_same():
    assert "clearcoat_normal" not in coat_of({"index": 0, "scale": 2}, {"index": 0, "scale": 2})
    assert "clearcoat_normal" in coat_of({"index": 0, "scale": 2}, {"index": 0})


@pytest.fixture
def material(tmp_path):
    """A function that reads a shader of MaterialX, with the normal map N of a picture."""
    from PIL import Image

    Image.fromarray(PIXELS).save(tmp_path / "p.png")
    head = """<?xml version="1.0"?><materialx version="1.39">
<image name="I" type="color3"><input name="file" type="filename" value="p.png"/></image>
<normalmap name="N" type="vector3"><input name="in" type="vector3" nodename="I"/>
  <input name="scale" type="float" value="0.5"/></normalmap>
<surfacematerial name="M" type="material">
  <input name="surfaceshader" type="surfaceshader" nodename="S"/></surfacematerial>"""

    def read(kind, weight, *names):
        inputs = "".join(f'<input name="{n}" type="vector3" nodename="N"/>' for n in names)
        coat = f'<input name="{weight}" type="float" value="1"/>'
        shader = f'<{kind} name="S" type="surfaceshader">{coat}{inputs}</{kind}>'
        (tmp_path / "m.mtlx").write_text(f"{head}{shader}</materialx>")
        scene = load(tmp_path / "m.mtlx")
        assert not any("normal" in text for text in scene.warnings)
        bsdf = scene.bsdfs["M"]
        while hasattr(bsdf, "bsdf"):
            bsdf = bsdf.bsdf
        return bsdf

    return read


@pytest.mark.parametrize(
    ("kind", "weight", "base", "coat"),
    [
        ("standard_surface", "coat", "normal", "coat_normal"),
        ("open_pbr_surface", "coat_weight", "geometry_normal", "geometry_coat_normal"),
        ("gltf_pbr", "clearcoat", "normal", "clearcoat_normal"),
    ],
)
def test_coats_of_materialx(kind, weight, base, coat, material):
    assert material(kind, weight).clearcoat_normal is None
    assert material(kind, weight, base).clearcoat_normal == tuple(FLAT)
    assert material(kind, weight, base, coat).clearcoat_normal is None
    own = material(kind, weight, coat)
    assert own.clearcoat_normal.type_name() == "bitmap"
    assert own.clearcoat_normal_scale == 0.5


GREEN = {"type": "bitmap", "color_space": "linear", "pixels": [[[0.6, 0.4, 0.9], [0.5, 0.5, 1.0]]]}
BLUE = {"type": "bitmap", "color_space": "linear", "pixels": [[[0.4, 0.5, 0.9], [0.5, 0.6, 1.0]]]}


@pytest.mark.parametrize("keys", [{}, {"clearcoat_normal": FLAT}], ids=["follows", "flat"])
def test_coats_over_bent_normals_come_back(keys, tmp_path):
    coat = {"type": "principled", "clearcoat": 0.7, **keys}
    found, _, _ = again({"type": "normal_map", "texture": GREEN, "bsdf": coat}, tmp_path)
    assert found.clearcoat_normal == (tuple(FLAT) if keys else None)


@pytest.mark.parametrize("is_bent", [False, True])
def test_pictures_of_normals_of_coats_come_back(is_bent, tmp_path):
    bsdf = {"type": "principled", "clearcoat": 0.7, "clearcoat_normal": BLUE}
    bsdf |= {"clearcoat_normal_scale": 0.25}
    if is_bent:
        bsdf = {"type": "normal_map", "texture": GREEN, "bsdf": bsdf}
    found, _, _ = again(bsdf, tmp_path)
    assert found.clearcoat_normal_scale == 0.25
    texels = found.clearcoat_normal.pixels.texels
    np.testing.assert_allclose(
        texels.reshape(-1, 3) / 255.0, np.reshape(BLUE["pixels"], (-1, 3)), atol=2e-3
    )
