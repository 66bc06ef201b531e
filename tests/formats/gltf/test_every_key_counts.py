"""Every key of materials and lights of glTF, by double entry (decision 38).

`KEYS` is what the specification and its extensions say of each number, written down a second time:
its default, and of its texture the channel and the encoding. Said, the default changes nothing;
another number changes the scene or brings a remark; and a texture that is the same everywhere is
its number.
"""

from typing import Any, NamedTuple

import numpy as np
import pytest

from alight.core.fields import Model
from alight.core.spec import Spec, Texture
from alight.formats.gltf.keys import EXTENSIONS
from alight.formats.gltf.materials import TEXTURE_KEYS
from alight.formats.gltf.nodes import punctual
from alight.formats.gltf.scene import parse
from alight.formats.gltf.values import Item
from alight.formats.reading.report import Report
from alight.scene.build import Builder
from tests.formats.gltf.maker import Maker


class Key(NamedTuple):
    """A number of a material.

    owner: "" for the material, "pbr" for its core, or the end of an extension's name; needs: what
    else it must have to play a part; texture: key, channels, and whether it is sRGB-encoded.
    """

    owner: str
    name: str
    default: Any
    other: Any
    texture: tuple[str, str, bool] | None = None
    needs: Any = None


GLASS = {"transmission": {"transmissionFactor": 1.0}}
BODY = GLASS | {"volume": {"thicknessFactor": 1.0}}
FILM = {"iridescence": {"iridescenceFactor": 1.0}}
SHEEN = {"sheen": {"sheenColorFactor": [0.5, 0.4, 0.3]}}
COAT = {"clearcoat": {"clearcoatFactor": 0.5}}
TURNED = {"anisotropy": {"anisotropyStrength": 0.5}}
BLENDED = {"": {"alphaMode": "BLEND"}}
DIM = {"pbrSpecularGlossiness": {"specularFactor": [0.04, 0.04, 0.04]}}
METAL = {"pbrSpecularGlossiness": {"diffuseFactor": [0, 0, 0, 1]}}
CUT = {"": {"alphaMode": "MASK"}, "pbr": {"baseColorFactor": [1, 1, 1, 0.3]}}
GLOWING = {"": {"emissiveFactor": [1, 1, 1]}}
FAR = GLASS | {"volume": {"thicknessFactor": 1.0, "attenuationDistance": 2.0}}
GREEN = GLASS | {"volume": {"thicknessFactor": 1.0, "attenuationColor": [0.5, 0.9, 0.3]}}
KEYS = [
    Key(
        "pbr",
        "baseColorFactor",
        [1, 1, 1, 1],
        [0.3, 0.5, 0.7, 1],
        ("baseColorTexture", "rgb", True),
    ),
    Key(
        "pbr",
        "baseColorFactor",
        [1, 1, 1, 1],
        [1, 1, 1, 0.3],
        ("baseColorTexture", "a", False),
        BLENDED,
    ),
    Key("pbr", "metallicFactor", 1.0, 0.3, ("metallicRoughnessTexture", "b", False)),
    Key("pbr", "roughnessFactor", 1.0, 0.3, ("metallicRoughnessTexture", "g", False)),
    Key("", "emissiveFactor", [0, 0, 0], [0.3, 0.5, 0.7], ("emissiveTexture", "rgb", True)),
    Key("", "alphaCutoff", 0.5, 0.2, None, CUT),
    Key("emissive_strength", "emissiveStrength", 1.0, 3.0, None, GLOWING),
    Key("ior", "ior", 1.5, 1.3),
    Key("specular", "specularFactor", 1.0, 0.3, ("specularTexture", "a", False)),
    Key(
        "specular",
        "specularColorFactor",
        [1, 1, 1],
        [0.3, 0.5, 0.7],
        ("specularColorTexture", "rgb", True),
    ),
    Key("clearcoat", "clearcoatFactor", 0.0, 0.3, ("clearcoatTexture", "r", False)),
    Key(
        "clearcoat",
        "clearcoatRoughnessFactor",
        0.0,
        0.3,
        ("clearcoatRoughnessTexture", "g", False),
        COAT,
    ),
    Key(
        "sheen", "sheenColorFactor", [0, 0, 0], [0.3, 0.5, 0.7], ("sheenColorTexture", "rgb", True)
    ),
    Key("sheen", "sheenRoughnessFactor", 0.0, 0.3, ("sheenRoughnessTexture", "a", False), SHEEN),
    Key("transmission", "transmissionFactor", 0.0, 0.3, ("transmissionTexture", "r", False)),
    Key("volume", "thicknessFactor", 0.0, 0.3, None, GLASS),
    Key("volume", "attenuationColor", [1, 1, 1], [0.3, 0.5, 0.7], None, FAR),
    Key("volume", "attenuationDistance", None, 0.3, None, GREEN),
    Key("dispersion", "dispersion", 0.0, 0.3, None, BODY),
    Key("iridescence", "iridescenceFactor", 0.0, 0.3, ("iridescenceTexture", "r", False)),
    Key("iridescence", "iridescenceIor", 1.3, 1.6, None, FILM),
    Key("iridescence", "iridescenceThicknessMaximum", 400.0, 300.0, None, FILM),
    Key("anisotropy", "anisotropyStrength", 0.0, 0.3, ("anisotropyTexture", "b", False)),
    Key("anisotropy", "anisotropyRotation", 0.0, 0.3, None, TURNED),
    Key(
        "pbrSpecularGlossiness",
        "diffuseFactor",
        [1, 1, 1, 1],
        [0.3, 0.5, 0.7, 1],
        ("diffuseTexture", "rgb", True),
    ),
    Key(
        "pbrSpecularGlossiness",
        "diffuseFactor",
        [1, 1, 1, 1],
        [1, 1, 1, 0.3],
        ("diffuseTexture", "a", False),
        BLENDED,
    ),
    Key(
        "pbrSpecularGlossiness",
        "glossinessFactor",
        1.0,
        0.3,
        ("specularGlossinessTexture", "a", False),
        DIM,
    ),
    Key("pbrSpecularGlossiness", "specularFactor", [1, 1, 1], [0.3, 0.5, 0.7], None, METAL),
]

#: One texel of four different bytes, and its numbers.
TEXEL = (130, 160, 190, 220)
LINEAR = dict(zip("rgba", (byte / 255.0 for byte in TEXEL), strict=True))


def decoded(value):
    """IEC 61966-2-1."""
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


def material_of(key, owners):
    """A material whose parts are given by their owners, with what `key` needs."""
    found = {}
    for owner, content in [*(key.needs or {}).items(), *owners.items()]:
        found.setdefault(owner, {}).update(content)
    material = {**found.pop("", {}), "pbrMetallicRoughness": found.pop("pbr", {})}
    return material | {"extensions": {f"KHR_materials_{n}": c for n, c in found.items()}}


def read(material):
    """(material, light, remarks) of a square."""
    m = Maker()
    m.picture(np.full((2, 2, 4), TEXEL, np.uint8))
    m.node(mesh=m.square(m.material(name="it", **material)))
    parsed = parse(m.gltf(), "model.gltf")
    assert not parsed.issues
    node = next(n for n in parsed.data["nodes"].values() if "shape" in n)
    return parsed.data["bsdfs"]["it"], node.get("light"), parsed.warnings, parsed.notes


def outcome(key, **more):
    return repr(read(material_of(key, {key.owner: more})))


def means(value):
    """A description, or a part of it, with textures as their means: all are even here."""
    if isinstance(value, Texture):
        return value.mean()
    if isinstance(value, Spec):
        return {name: means(item) for name, item in value}
    return value


def even(key, **more):
    """What a material has everywhere, numbers only: material and light."""
    bsdf, light, _, _ = read(material_of(key, {key.owner: more}))
    made = [means(Builder().model(Model("bsdf", "bsdfs"), bsdf, ""))]
    if light is not None:
        made.append(means(Builder().model(Model("light", "lights"), light, "")))
    return dict(flattened(made))


def flattened(value, path=""):
    """(path, numbers) of all parts; a number stands for three."""
    items = value.items() if isinstance(value, dict) else enumerate(value)
    for name, item in items:
        if isinstance(item, dict | list):
            yield from flattened(item, f"{path}.{name}")
        elif isinstance(item, bool | str) or item is None:
            yield f"{path}.{name}", item
        else:
            yield f"{path}.{name}", np.broadcast_to(np.asarray(item, float), 3)


def ident(key):
    return f"{key.owner}.{key.name}"


@pytest.mark.parametrize("key", KEYS, ids=ident)
def test_numbers_have_their_defaults_and_matter(key):
    silent = outcome(key)
    if key.default is not None:
        assert outcome(key, **{key.name: key.default}) == silent, "the default is another"
    assert outcome(key, **{key.name: key.other}) != silent, "without effect and remark"


@pytest.mark.parametrize("key", [key for key in KEYS if key.texture], ids=ident)
def test_a_texture_that_is_the_same_everywhere_is_its_number(key):
    """What a factor of 0.5 becomes that is multiplied by the texture, a smaller one becomes."""
    name, channels, is_color = key.texture
    values = [decoded(LINEAR[c]) if is_color else LINEAR[c] for c in channels]
    half, number = 0.5, 0.5 * values[0]
    if isinstance(key.default, list):
        rest = [1.0] * len(key.default)
        start = "rgba".index(channels[0])
        half, number = rest[:], rest[:]
        half[start : start + len(values)] = [0.5] * len(values)
        number[start : start + len(values)] = [0.5 * value for value in values]
    picture = {name: {"index": 0}}
    found, wanted = even(key, **picture, **{key.name: half}), even(key, **{key.name: number})
    # Other channels of the picture are other numbers' concern.
    changed = [
        path
        for path, value in even(key, **{key.name: half}).items()
        if not same(value, wanted[path])
    ]
    assert changed
    for path in changed:
        assert same(found[path], wanted[path], 1e-3), (path, found[path], wanted[path])


def test_a_picture_of_a_films_thickness_runs_from_its_minimum_to_its_maximum():
    film = Key("iridescence", "iridescenceThicknessMaximum", 400.0, 300.0, None, FILM)
    picture = {"iridescenceThicknessTexture": {"index": 0}}
    path = ".0.bsdf.iridescence_thickness"
    for ends, low, high in (
        ({}, 100.0, 400.0),
        ({"iridescenceThicknessMinimum": 200.0}, 200.0, 400.0),
        ({"iridescenceThicknessMaximum": 900.0}, 100.0, 900.0),
    ):
        wanted = low + LINEAR["g"] * (high - low)
        assert same(even(film, **picture, **ends)[path], wanted, 1e-3)
        # Without a picture it is as thick as it can be.
        assert same(even(film, **ends)[path], high)


def test_the_colour_of_a_glossy_metal_is_encoded_and_its_gloss_is_not():
    metal = KEYS[-1]
    found = even(metal, specularGlossinessTexture={"index": 0})
    assert same(found[".0.bsdf.base_color"], [decoded(LINEAR[c]) for c in "rgb"], 1e-3)
    assert same(found[".0.bsdf.roughness"], 1.0 - LINEAR["a"], 1e-3)


def test_normals_are_numbers_of_a_picture_and_have_the_scale_one():
    found = []
    for scale in ({}, {"scale": 1.0}, {"scale": 0.5}):
        bsdf, *_ = read({"normalTexture": {"index": 0, **scale}})
        found.append(bsdf["bsdf"])
    assert repr(found[0]) == repr(found[1]) != repr(found[2])
    made = means(Builder().model(Model("bsdf", "bsdfs"), found[0], ""))
    assert same(made["texture"], [LINEAR[c] for c in "rgb"], 1e-3)


@pytest.mark.parametrize("sampler", [{"wrapS": 10497}, {"wrapT": 10497}, {"magFilter": 9729}])
def test_samplers_repeat_and_are_linear_by_default(sampler):
    def seen(**sampler):
        m = Maker()
        number = m.picture(np.full((2, 2, 4), TEXEL, np.uint8), name="s", **sampler)
        core = {"baseColorTexture": {"index": number}}
        m.node(mesh=m.square(m.material(name="it", pbrMetallicRoughness=core)))
        color = parse(m.gltf(), "model.gltf").data["bsdfs"]["it"]["bsdf"]["base_color"]
        return {name: value for name, value in color.items() if name != "pixels"}

    assert seen() == seen(**sampler)
    for other in ({"wrapS": 33071}, {"wrapT": 33071}, {"magFilter": 9728}):
        assert seen(**other) != seen()


#: Numbers of lights: default and another one.
LIGHTS = {"color": ([1, 1, 1], [0.3, 0.5, 0.7]), "intensity": (1.0, 0.3)}
CONE = {"outerConeAngle": (np.pi / 4.0, 0.4), "innerConeAngle": (0.0, 0.2)}


@pytest.mark.parametrize("kind", ["point", "spot", "directional"])
def test_numbers_of_lights_have_their_defaults_and_matter(kind):
    def seen(cone, **light):
        item = {"type": kind, **light} | ({"spot": cone} if kind == "spot" else {})
        return repr(punctual(Item(item, "/lights/0", "model.gltf", Report())))

    silent = seen({})
    for name, (default, other) in LIGHTS.items():
        assert seen({}, **{name: default}) == silent != seen({}, **{name: other})
    for name, (default, other) in CONE.items() if kind == "spot" else ():
        assert seen({name: default}) == silent != seen({name: other})


#: Read by `alight.formats.gltf.bodies`, and what is left out as a whole.
ELSEWHERE = {"diffuse_transmission", "volume_scatter", "unlit"}
OF_PICTURES = {"iridescenceThicknessMinimum"}


def test_every_number_and_texture_that_is_read_is_here():
    known = {(key.owner, key.name) for key in KEYS}
    for extension, kinds in EXTENSIONS.items():
        owner = extension.removeprefix("KHR_materials_")
        if owner == extension or owner in ELSEWHERE:
            continue
        plain = {name for name, kind in kinds.get("material", {}).items() if not kind}
        missing = plain - {name for of, name in known if of == owner} - OF_PICTURES
        assert not missing, owner
    textures = {key.texture[0] for key in KEYS if key.texture}
    textures |= {"normalTexture", "clearcoatNormalTexture", "iridescenceThicknessTexture"}
    assert textures == {name for _, names in TEXTURE_KEYS for name in names}


def same(a, b, tolerance=1e-9):
    if a is None or b is None or isinstance(a, bool | str):
        return a == b
    return np.allclose(a, b, rtol=tolerance, atol=0.0, equal_nan=True)
