"""Who asks what is suspicious of a scene sends no rays through it, however large it is."""

from importlib import import_module

import pytest

import alight
from alight.compiled import scene as compiling
from alight.compiled.scene import compile_scene
from alight.compiled.warnings.scenes import warnings_of_scene
from alight.formats import loads
from alight.scene import flatten

#: The module, whose name its package gives to a function.
checking = import_module("alight.laws.scene.check")

AWAY = {"translate": [2, 0, 0]}
GLASS = {"type": "dielectric"}
SCENE = {
    "alight": 1,
    "camera": {},
    "integrator": {"type": "path", "caustics": "manifold"},
    "prototypes": {"wood": {"children": {
        "tree": {"shape": {"type": "mesh", "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]],
                           "faces": [[0, 1, 2]]}},
    }}},
    "nodes": {
        "a": {"instance": "wood"},
        "b": {"instance": "wood", "transform": AWAY},
        "lamp": {"shape": "sphere", "light": "area", "transform": {"translate": [0, 5, 0]}},
        "ball": {"shape": "sphere", "bsdf": GLASS,
                 "transform": {"keyframes": [{"time": 0}, {"time": 1, **AWAY}]}},
        "c": {"shape": "cube", "bsdf": GLASS, "transform": {"translate": [0, 0, -9]}},
        "d": {"shape": "cube", "bsdf": GLASS, "transform": {"translate": [2, 0, -9]}},
    },
}  # fmt: skip


def test_nothing_is_built_or_traced_and_all_is_told(monkeypatch):
    scene = alight.load(SCENE)
    with_rays = compile_scene(flatten(alight.changed(scene, {"integrator.caustics": "paths"})))
    monkeypatch.setattr("alight.compiled.scene.with_photons", None)
    assert warnings_of_scene(scene) == with_rays.warnings != ()
    assert compile_scene(flatten(scene), structure="none").program.accel == ()


FAR = """alight: 1
camera: {transform: {look_at: {origin: [1.0e+6, 0, 4], target: [1.0e+6, 0, 0]}}}
environment: {type: constant}
nodes:
  paper: {shape: rectangle, transform: {translate: [1.0e+6, 0, 0]},
          bsdf: {type: diffuse, reflectance: {type: noise, scale: 2}}}
"""


@pytest.mark.parametrize("way", ["info", "tree", "check"])
def test_who_compiles_a_scene_does_so_once(monkeypatch, way):
    """Its warnings come from there, and its materials are packed once wherever it lies."""
    calls = []

    def counted(module, name):
        make = getattr(module, name)

        def made(*arguments, **named):
            calls.append(name)
            return make(*arguments, **named)

        monkeypatch.setattr(module, name, made)

    counted(compiling, "PackedMaterials")
    counted(checking if way == "check" else compiling, "compile_scene")
    scene = loads(FAR, "far.yaml")
    if way == "check":
        found = checking.check_scene(scene, only=("numbers",)).warnings
    else:
        found = alight.info(scene, tree=way == "tree").warnings
    assert sorted(calls) == ["PackedMaterials", "compile_scene"]
    assert not found


@pytest.mark.parametrize("integrator", ["path", "volpath", "ambient_occlusion"])
@pytest.mark.parametrize("light", ["black picture", "grey picture", "none"])
def test_darkness_is_told_once_where_the_integrator_needs_light(integrator, light):
    """What only the picture of a lamp tells, and what the description says already."""
    level = 0.0 if light == "black picture" else 0.5
    shade = {"type": "checkerboard", "color0": level, "color1": level}
    lamp = {"shape": "rectangle", "light": {"type": "area", "radiance": shade}}
    nodes = {"ball": {"shape": "sphere"}} | ({} if light == "none" else {"lamp": lamp})
    scene = alight.load({"alight": 1, "camera": {}, "integrator": integrator, "nodes": nodes})
    told = [text for text in warnings_of_scene(scene) if "picture will be black" in text]
    dark = light != "grey picture" and integrator != "ambient_occlusion"
    assert len(told) == dark
