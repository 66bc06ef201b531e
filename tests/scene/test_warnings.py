"""Who asks what is suspicious of a scene sends no rays through it, however large it is."""

import alight
from alight.compiled.scene import compile_scene
from alight.compiled.warnings.scenes import warnings_of_scene
from alight.scene import flatten

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
