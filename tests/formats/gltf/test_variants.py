"""KHR_materials_variants: other materials for the same meshes, by name."""

import pytest

import alight
from alight.core.errors import SceneError
from alight.formats.gltf.scene import parse
from alight.formats.reading.shown import Shown
from tests.formats.gltf.maker import Maker
from tests.formats.gltf.reading import core

NAME = "KHR_materials_variants"
COLORS = {"red": [1.0, 0.0, 0.0], "green": [0.0, 1.0, 0.0], "blue": [0.0, 0.0, 1.0]}


def shoe():
    """Red by itself and at noon, green by day, blue by night."""
    m = Maker()
    for name, color in COLORS.items():
        m.material(name=name, pbrMetallicRoughness={"baseColorFactor": [*color, 1]})
    index = m.square(0)
    m.json["extensionsUsed"] = [NAME]
    m.json["extensions"] = {NAME: {"variants": [{"name": n} for n in ("night", "day", "noon")]}}
    mappings = [{"material": 1, "variants": [1]}, {"material": 2, "variants": [0]}]
    m.json["meshes"][index]["primitives"][0]["extensions"] = {NAME: {"mappings": mappings}}
    m.node(mesh=index)
    return m


def color(variant):
    found = parse(shoe().gltf(), "a.gltf", None, Shown(variant))
    assert not any(NAME in line for line in found.warnings)
    name = found.data["nodes"]["node 0"]["bsdf"]
    assert core(found.data["bsdfs"][name])["base_color"] == COLORS[name]
    return name


@pytest.mark.parametrize(
    ("variant", "shown"), [(None, "red"), ("night", "blue"), ("day", "green"), ("noon", "red")]
)
def test_a_variant_shows_its_materials(variant, shown):
    assert color(variant) == shown


def test_names_that_could_be_asked_for_are_told():
    [line] = [n for n in parse(shoe().gltf(), "a.gltf").notes if "variants" in n]
    assert line == 'variants of materials ("night", "day", "noon"): --variant shows one of them'


def test_a_variant_that_is_not_there_is_one_message(tmp_path):
    with pytest.raises(SceneError, match=r'--variant\n.*did you mean "night"'):
        parse(shoe().gltf(), "a.gltf", None, Shown("nigth"))
    m = Maker()
    m.node(mesh=m.square())
    (tmp_path / "a.gltf").write_bytes(m.gltf())
    with pytest.raises(SceneError, match="the file has no variants of materials"):
        alight.load(tmp_path / "a.gltf", variant="day")
    with pytest.raises(
        SceneError, match="only glTF and MaterialX files have materials to choose from"
    ):
        alight.load("cornell-box", variant="day")


def test_a_loaded_scene_remembers_its_variant(tmp_path):
    (tmp_path / "a.gltf").write_bytes(shoe().gltf())
    scene = alight.load(tmp_path / "a.gltf", variant="day")
    assert list(scene.bsdfs) == ["green"]
    assert scene.source.recipe.variant == "day"
