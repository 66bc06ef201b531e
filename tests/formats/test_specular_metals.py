"""A metal in a workflow of specular colours reflects that colour straight on, in every format."""

import numpy as np
import pytest

from alight.formats import load
from alight.laws.materials import Material, direction, random_numbers
from tests.formats.gltf.maker import Maker
from tests.formats.usd.stage import MATERIAL, SQUARE, stage_text

GOLD = (0.95, 0.75, 0.4)
SILVER = (0.97, 0.96, 0.92)


def usd(folder, color):
    pytest.importorskip("pxr")
    inputs = f"""int inputs:useSpecularWorkflow = 1
        color3f inputs:specularColor = {color}
        color3f inputs:diffuseColor = (0, 0, 0)
        float inputs:roughness = 0.1"""
    (folder / "a.usda").write_text(stage_text(MATERIAL % (inputs, SQUARE)))
    return load(folder / "a.usda")


def gltf(folder, **material):
    m = Maker()
    m.node(mesh=m.square(m.material(**material)))
    (folder / "a.gltf").write_bytes(m.gltf())
    return load(folder / "a.gltf")


def glossy(folder, color):
    shiny = {"specularFactor": color, "diffuseFactor": [0, 0, 0, 1], "glossinessFactor": 0.9}
    return gltf(folder, extensions={"KHR_materials_pbrSpecularGlossiness": shiny})


def of_index_0(folder, color):
    """KHR_materials_ior: an index of 0 stands for a specular workflow."""
    pbr = {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0, "roughnessFactor": 0.1}
    specular = {"specularColorFactor": color}
    more = {"KHR_materials_ior": {"ior": 0}, "KHR_materials_specular": specular}
    return gltf(folder, pbrMetallicRoughness=pbr, extensions=more)


@pytest.mark.parametrize("color", [GOLD, SILVER], ids=["gold", "silver"])
@pytest.mark.parametrize("read", [usd, glossy, of_index_0])
def test_it_reflects_its_colour_straight_on(tmp_path, read, color):
    scene = read(tmp_path, color)
    (bsdf,) = scene.bsdfs.values()
    _, weight, _, _ = Material(bsdf).sample(direction(1.0), random_numbers(20_000, 1))
    np.testing.assert_allclose(weight.mean(axis=1), color, rtol=0.01)
    assert not any("reflect" in line for line in scene.warnings)


@pytest.mark.parametrize("read", [usd, glossy])
def test_what_a_dielectric_may_reflect_stays_one(tmp_path, read):
    (bsdf,) = read(tmp_path, (0.3, 0.2, 0.1)).bsdfs.values()
    assert bsdf.bsdf.metallic == 0.0
