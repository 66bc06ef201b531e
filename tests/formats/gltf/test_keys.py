"""Keys and extensions that nobody reads are told of, with the nearest name."""

import json

import pytest

from alight.formats import load
from alight.formats.gltf import keys
from alight.formats.gltf.keys import EXTENSIONS, KINDS
from alight.formats.gltf.scene import COVERED
from tests.formats.gltf.maker import Maker, everything

MISSPELT = {
    "pbr": (["materials", 0, "pbrMetallicRoughness", "metalicFactor"], 'mean "metallicFactor"?'),
    "material": (["materials", 0, "alphaMod"], 'mean "alphaMode"?'),
    "node": (["nodes", 0, "translaton"], 'did you mean "translation"?'),
    "picture": (["materials", 0, "normalTexture", "texCord"], 'did you mean "texCoord"?'),
    "extension's key": (
        ["materials", 0, "extensions", "KHR_materials_clearcoat", "clearcoatFacter"],
        "/materials/0/extensions/KHR_materials_clearcoat: unknown key",
    ),
    "light": (
        ["extensions", "KHR_lights_punctual", "lights", 1, "intensty"],
        "/extensions/KHR_lights_punctual/lights/1: unknown key",
    ),
    "cone": (
        ["extensions", "KHR_lights_punctual", "lights", 0, "spot", "outerCone"],
        'did you mean "outerConeAngle"?',
    ),
    "skin": (["skins", 0, "inverseBindMatrix"], 'did you mean "inverseBindMatrices"?'),
    "extension": (["materials", 0, "extensions", "KHR_materials_clearcot"], '"KHR_materials_cl'),
    "extension of a node": (["nodes", 3, "extensions", "MSFT_lod"], "MSFT_lod is not"),
    "extension of a primitive": (
        ["meshes", 0, "primitives", 0, "extensions"],
        "EXT_mesh_features is not covered and was left out",
    ),
}


def warnings_of(document, tmp_path):
    (tmp_path / "a.gltf").write_text(json.dumps(document))
    return load(tmp_path / "a.gltf").source.remarks


@pytest.mark.parametrize("kind", MISSPELT)
def test_misspelt_keys_are_told_of(kind, tmp_path):
    document = json.loads(everything().gltf())
    document.setdefault("skins", [{"joints": [0]}])
    path, words = MISSPELT[kind]
    owner = document
    for key in path[:-1]:
        owner = owner[key]
    owner[path[-1]] = {"EXT_mesh_features": {}} if path[-1] == "extensions" else {}
    assert any(words in line for line in warnings_of(document, tmp_path).warnings)


def test_files_without_a_mistake_get_no_such_remark(tmp_path):
    document = json.loads(everything().gltf())
    found = warnings_of(document, tmp_path).warnings
    assert not any("unknown key" in line for line in found)
    assert sum("not covered" in line for line in found) == 2  # ACME_hats and ACME_glitter


def test_other_extensions_get_no_hint_to_those_that_are_read():
    assert keys.left_out("KHR_materials_glitter").endswith("left out")
    assert keys.left_out("KHR_materials_shen").endswith('did you mean "KHR_materials_sheen"?')


def test_a_volume_without_transmission_is_told_of(tmp_path):
    m = Maker()
    volume = {"KHR_materials_volume": {"thicknessFactor": 1.0, "attenuationColor": [1, 0, 0]}}
    m.node(mesh=m.square(m.material(extensions=volume)))
    notes = warnings_of(json.loads(m.gltf()), tmp_path).notes
    assert any("KHR_materials_volume: plays no part without" in line for line in notes)


def test_every_extension_that_is_read_has_its_keys_here():
    assert set(EXTENSIONS) == set(COVERED) - {"KHR_mesh_quantization"}
    kinds = [kind for keys in KINDS.values() for kind in keys.values() if kind]
    kinds += [
        k for owners in EXTENSIONS.values() for ks in owners.values() for k in ks.values() if k
    ]
    assert set(kinds) <= set(KINDS)
