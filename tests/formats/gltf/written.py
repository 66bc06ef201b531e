"""A square of one material, written to glTF and read again."""

import json

from alight.formats import load, loads
from alight.formats.gltf.write import write
from alight.scene import flatten

SQUARE = {
    "type": "mesh", "vertices": [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]],
    "faces": [[0, 1, 2], [0, 2, 3]], "uvs": [[0, 0], [1, 0], [1, 1], [0, 1]],
}  # fmt: skip
GREY = {"type": "bitmap", "color_space": "linear", "interpolation": "nearest",
        "pixels": ["40 80", "c0 ff"]}  # fmt: skip


def scene_of(bsdf, light=None, **shape):
    node = {"shape": SQUARE | shape, "bsdf": bsdf} | ({"light": light} if light else {})
    nodes = {"it": node, "lamp": {"light": "point", "transform": {"translate": [0, 0, 9]}}}
    camera = {"type": "orthographic", "height": 2, "transform": {"translate": [0, 0, 3]}}
    head = {"alight": 1, "camera": camera, "film": {"size": [8, 8]}, "nodes": nodes}
    return loads(json.dumps(head), "scene.json")


def again(bsdf, folder, light=None, **shape):
    """The material that comes back of a written file, the flat scene, and what was lost."""
    lost = write(flatten(scene_of(bsdf, light, **shape)), folder / "a.glb")
    flat = flatten(load(folder / "a.glb"))
    found = flat.bsdfs[flat.shapes[0].bsdf]
    while "bsdf" in dict(found):
        found = found.bsdf
    return found, flat, lost
