"""Materials that scatter light inside, on closed meshes."""

import json

import numpy as np
import pytest

from alight.compiled.scene import compile_scene
from alight.meshes import volume
from alight.scene import flatten
from tests.formats.bare import load
from tests.formats.gltf.maker import Maker

BODY = {
    "KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 1},
    "KHR_materials_volume": {"attenuationColor": [0.5, 0.25, 0.125], "attenuationDistance": 0.1},
    "KHR_materials_volume_scatter": {"multiscatterColor": [0.9, 0.5, 0.2]},
    "KHR_materials_ior": {"ior": 1.3},
}
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], "<f4")
SIDES = np.array([0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2], "<u2")


def look(folder, faces=SIDES, without=(), extensions=None, **material):
    """The material of a tetrahedron, and what was said."""
    m = Maker()
    extensions = {name: value for name, value in BODY.items() if name not in without} | (
        extensions or {}
    )
    pbr = {"metallicFactor": 0, "roughnessFactor": 0.25, **material.pop("pbr", {})}
    number = m.material(extensions=extensions, pbrMetallicRoughness=pbr, **material)
    primitive = {
        "attributes": {"POSITION": m.accessor(CORNERS)},
        "indices": m.accessor(faces),
        "material": number,
    }
    m.json["meshes"].append({"primitives": [primitive]})
    m.node(mesh=0)
    document = json.loads(m.gltf())
    document["extensionsUsed"] = sorted(extensions)
    (folder / "a.gltf").write_text(json.dumps(document))
    scene = load(folder / "a.gltf")
    [node] = [node for _, _, node in scene.walk() if node.shape is not None]
    remarks = scene.source.remarks
    return scene.bsdfs[node.bsdf], "\n".join([*remarks.notes, *remarks.warnings])


def test_whether_a_body_is_closed_is_found_out_once(tmp_path, monkeypatch):
    """By the loader, and the compiler, which warns of bodies that are inside out."""
    asked, work_out = [], volume._volume

    def counted(vertices, faces):
        asked.append(len(faces))
        return work_out(vertices, faces)

    monkeypatch.setattr(volume, "_volume", counted)
    look(tmp_path)
    compile_scene(flatten(load(tmp_path / "a.gltf")))
    assert asked == [4, 4]


def test_all_light_that_enters_is_scattered_inside(tmp_path):
    found, said = look(tmp_path)
    assert found.type_name() == "subsurface"
    assert found.radius == pytest.approx(0.1 / np.log([2, 4, 8]))
    assert (found.color, found.ior, found.roughness) == ((0.9, 0.5, 0.2), 1.3, 0.25)
    for word in ("plays no part", "left out", "not covered"):
        assert word not in said


@pytest.mark.parametrize(
    "keys",
    [
        {"without": ["KHR_materials_volume"]},
        {"without": ["KHR_materials_diffuse_transmission"]},
        {"without": ["KHR_materials_volume_scatter"]},
        {"pbr": {"metallicFactor": 0.5}},
        {"alphaMode": "BLEND", "pbr": {"baseColorFactor": [1, 1, 1, 0.5]}},
        {"extensions": {"KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0.5}}},
        {"extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 0.5}}},
    ],
)
def test_what_is_more_than_a_body_is_none(keys, tmp_path):
    found, said = look(tmp_path, **keys)
    assert found.type_name() != "subsurface"
    assert "left out; light that enters a surface" in said


def test_open_meshes_have_no_inside(tmp_path):
    found, said = look(tmp_path, faces=SIDES[3:])
    assert found.type_name() == "two_sided"
    assert "is open or inside out, so no light is scattered below its surface" in said


def test_scattering_to_some_sides_is_told(tmp_path):
    scattering = {"multiscatterColor": [1, 1, 1], "scatterAnisotropy": 0.5}
    found, said = look(tmp_path, extensions={"KHR_materials_volume_scatter": scattering})
    assert found.color == (1.0, 1.0, 1.0)
    assert "scatterAnisotropy" in said


def test_a_volume_without_a_distance_is_clear_of_attenuation(tmp_path):
    """Its default is infinite: light comes as far as it likes."""
    found, _ = look(tmp_path, extensions={"KHR_materials_volume": {}})
    assert found.type_name() == "subsurface"
    assert min(found.radius) > 1e8


def test_a_mesh_that_faces_inwards_has_no_inside(tmp_path):
    """It would be black: files have no key to turn it over."""
    found, said = look(tmp_path, faces=SIDES[::-1].copy())
    assert found.type_name() != "subsurface"
    assert "is open or inside out" in said


def test_the_strength_of_the_reflection_is_in_the_index(tmp_path):
    found, said = look(tmp_path, extensions={"KHR_materials_specular": {"specularFactor": 0}})
    assert found.ior == pytest.approx(1.0, abs=1e-3)
    _, said = look(
        tmp_path,
        extensions={"KHR_materials_specular": {"specularColorFactor": [1, 0.5, 0]}},
    )
    assert "the colour of a body's reflection is left out" in said


@pytest.mark.parametrize(
    ("scatters", "missing", "is_body"), [(True, 0, True), (False, 0, False), (True, 1, False)]
)
def test_primitives_close_a_mesh_together(scatters, missing, is_body, tmp_path):
    m = Maker()
    body = m.material(extensions=BODY, pbrMetallicRoughness={"metallicFactor": 0})
    other = body if scatters else m.material()
    corners = m.accessor(CORNERS)
    primitives = [
        {"attributes": {"POSITION": corners}, "indices": m.accessor(faces), "material": material}
        for faces, material in ((SIDES[:6], body), (SIDES[6 : 12 - 3 * missing], other))
    ]
    m.json["meshes"].append({"primitives": primitives})
    m.node(mesh=0)
    document = json.loads(m.gltf())
    document["extensionsUsed"] = sorted(BODY)
    (tmp_path / "a.gltf").write_text(json.dumps(document))
    scene = load(tmp_path / "a.gltf")
    first, *_ = [node for _, _, node in scene.walk() if node.shape is not None]
    assert (scene.bsdfs[first.bsdf].type_name() == "subsurface") == is_body
    said = "\n".join(scene.source.remarks.warnings)
    assert ("is open or inside out" in said) == (not is_body)
