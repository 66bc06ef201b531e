"""Materials of glTF: what each of their keys and extensions becomes."""

import pytest

from alight.formats import load
from tests.formats.gltf.reading import core, material_of


@pytest.mark.parametrize("scale", [0.5, -0.5])
def test_textures_of_normals_are_numbers(scale):
    bsdf = material_of(normalTexture={"index": 0, "scale": scale})["bsdf"]
    assert (bsdf["type"], bsdf["scale"]) == ("normal_map", scale)
    assert bsdf["texture"]["color_space"] == "linear"
    load({"camera": {"type": "pinhole"}, "bsdfs": {"it": bsdf}})


def test_factors_multiply_channels():
    bsdf = core(
        material_of(
            pbrMetallicRoughness={
                "metallicRoughnessTexture": {"index": 0}, "roughnessFactor": 0.5,
                "baseColorFactor": [0.5, 1, 1, 1], "baseColorTexture": {"index": 0},
            }
        )
    )  # fmt: skip
    assert bsdf["roughness"]["type"] == "multiply"
    assert bsdf["roughness"]["a"] == 0.5
    assert bsdf["roughness"]["b"]["channel"] == "g"
    assert bsdf["roughness"]["b"]["texture"]["color_space"] == "linear"
    assert bsdf["metallic"]["channel"] == "b"
    assert bsdf["base_color"]["a"] == [0.5, 1.0, 1.0]
    assert "color_space" not in bsdf["base_color"]["b"]


def test_opacity_cuts_or_blends():
    pbr = {"baseColorTexture": {"index": 0}, "baseColorFactor": [1, 1, 1, 0.5]}
    cut = material_of(alphaMode="MASK", alphaCutoff=0.25, pbrMetallicRoughness=pbr)
    assert cut["type"] == "mask"
    assert cut["opacity"]["type"] == "threshold"
    assert cut["opacity"]["cutoff"] == 0.25
    assert cut["opacity"]["texture"]["a"] == 0.5
    assert cut["opacity"]["texture"]["b"]["channel"] == "a"
    faint = {"baseColorFactor": [1, 1, 1, 0.25]}
    # At the cutoff a surface is there.
    for cutoff, opacity in ((0.25, None), (0.26, 0.0)):
        edge = material_of(alphaMode="MASK", alphaCutoff=cutoff, pbrMetallicRoughness=faint)
        assert edge.get("opacity") == opacity
    blended = material_of(alphaMode="BLEND", pbrMetallicRoughness=faint)
    assert blended["opacity"] == 0.25
    assert material_of(pbrMetallicRoughness=pbr)["type"] == "two_sided"


@pytest.mark.parametrize(
    ("extension", "value", "wanted"),
    [
        ("ior", {"ior": 1.2}, {"ior": 1.2}),
        ("specular", {"specularFactor": 0.25, "specularColorFactor": [1, 0.5, 0]},
         {"specular": 0.25, "specular_color": [1.0, 0.5, 0.0]}),
        ("transmission", {"transmissionFactor": 0.5}, {"transmission": 0.5, "thin": True}),
        ("transmission", {"transmissionFactor": 0.0}, {}),
        ("dispersion", {"dispersion": 1.0}, {}),
        ("clearcoat", {"clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.25},
         {"clearcoat": 0.5, "clearcoat_roughness": 0.25}),
        ("sheen", {"sheenColorFactor": [0, 0, 1]},
         {"sheen_color": [0.0, 0.0, 1.0], "sheen_roughness": 0.0}),
        ("anisotropy", {"anisotropyStrength": 0.5, "anisotropyRotation": 1.5},
         {"anisotropy": 0.5, "anisotropy_rotation": 1.5}),
        ("iridescence", {"iridescenceFactor": 1, "iridescenceIor": 1.8},
         {"iridescence": 1.0, "iridescence_ior": 1.8, "iridescence_thickness": 400.0}),
    ],
)  # fmt: skip
def test_extensions_of_materials(extension, value, wanted):
    bsdf = core(material_of(extensions={f"KHR_materials_{extension}": value}))
    plain = core(material_of())
    assert {key: bsdf[key] for key in bsdf if key not in plain} == wanted


def test_a_reflection_of_more_than_the_index_has_becomes_a_larger_index():
    """F0 = 0.04 times 2, as some exporters write it; of what transmits light the index stays."""
    bright = {"KHR_materials_specular": {"specularColorFactor": [2, 1, 0.5]}}
    bsdf = core(material_of(extensions=bright))
    assert ((bsdf["ior"] - 1.0) / (bsdf["ior"] + 1.0)) ** 2 == pytest.approx(0.08)
    assert bsdf["specular_color"] == [1.0, 0.5, 0.25]
    glass = bright | {"KHR_materials_transmission": {"transmissionFactor": 1}}
    bsdf = core(material_of(extensions=glass))
    assert "ior" not in bsdf
    assert bsdf["specular_color"] == [1.0, 1.0, 0.5]
    mirror = {"KHR_materials_specular": {"specularColorFactor": [99, 99, 99]}}
    assert core(material_of(extensions=mirror))["ior"] == 5.0


def test_glass_has_a_volume_and_needs_no_second_side():
    extensions = {
        "KHR_materials_transmission": {"transmissionFactor": 1},
        "KHR_materials_volume": {"thicknessFactor": 0.1, "attenuationDistance": 3},
    }
    bsdf = material_of(extensions=extensions)
    assert bsdf["type"] == "principled"
    assert bsdf["attenuation_distance"] == 3.0
    assert "thin" not in bsdf


def test_dispersion_is_twenty_over_the_abbe_number_of_bodies():
    def glass(dispersion, **volume):
        return core(
            material_of(
                extensions={
                    "KHR_materials_transmission": {"transmissionFactor": 1.0},
                    "KHR_materials_volume": volume,
                    "KHR_materials_dispersion": {"dispersion": dispersion},
                }
            )
        )

    assert glass(0.5, thicknessFactor=1.0)["dispersion"] == 40.0
    # More than any index allows; none; and a sheet, in which nothing is bent.
    assert glass(50.0, thicknessFactor=1.0)["dispersion"] == 1.0
    assert "dispersion" not in glass(0.0, thicknessFactor=1.0)
    assert "dispersion" not in glass(0.5)
