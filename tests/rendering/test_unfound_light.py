"""The ledger tells of light that no path finds: where there is some, and nowhere else."""

import pytest

import alight
from alight.compiled.scene import compile_scene
from alight.rendering.unfound_light import unfound_light
from alight.scene.flatten import flatten

LAMP = {
    "shape": "sphere",
    "light": {"type": "area", "radiance": 9},
    "transform": {"translate": [0, 3, 0]},
}
POINT = {"light": {"type": "point", "intensity": 9}, "transform": {"translate": [0, 3, 0]}}
SUN = {"light": {"type": "directional", "irradiance": 1}}


def scene_of(integrator, light, bsdf, **keys):
    return alight.load({
        "camera": {"transform": {"look_at": {"origin": [0, 1, 4], "target": [0, 0, 0]}}},
        "film": {"size": [8, 8]},
        "integrator": {"type": integrator, **keys},
        "nodes": {
            "floor": {"shape": "rectangle", "transform": [{"rotate": {"axis": "x", "angle": -90}}]},
            "ball": {"shape": "sphere", "bsdf": bsdf, "transform": {"scale": 0.3}},
            "light": light,
        },
    })  # fmt: skip


def texts(integrator, light, bsdf, **keys):
    scene = compile_scene(flatten(scene_of(integrator, light, bsdf, **keys)))
    return [bias.text for bias in unfound_light(scene)]


@pytest.mark.parametrize("light", [POINT, SUN])
@pytest.mark.parametrize("bsdf", [{"type": "dielectric"}, {"type": "mirror"}])
@pytest.mark.parametrize(
    ("integrator", "keys", "words"),
    [
        ("path", {}, "no path finds them"),
        ("path", {"caustics": "manifold"}, "where walks do not cover them"),
        ("bidirectional", {}, "are missing where they are seen in mirrors"),
        ("light", {}, "what is seen in mirrors and through clear glass is missing"),
    ],
)
def test_caustics_of_lights_without_a_size_are_told(integrator, keys, words, bsdf, light):
    (text,) = texts(integrator, light, bsdf, **keys)
    assert words in text


@pytest.mark.parametrize(("light", "bsdf"), [
    (LAMP, {"type": "mirror"}), (POINT, {"type": "diffuse"}),
    (POINT, {"type": "rough_dielectric"}), (SUN, {"type": "null"}),
])  # fmt: skip
def test_nothing_is_told_where_nothing_is_missing(light, bsdf):
    assert texts("path", light, bsdf) == []


def test_a_picture_tells_it():
    film = alight.render(scene_of("path", POINT, {"type": "mirror"}, max_depth=4), spp=4)
    assert [bias.cause for bias in film.biases] == ["depth cap", "caustics"]
