"""glTF files made by the tests, read."""

import numpy as np

from alight.formats.gltf.scene import parse
from tests.formats.gltf.maker import Maker


def parsed(maker):
    found = parse(maker.gltf(), "model.gltf")
    assert not found.issues
    return found


def material_of(**material):
    """The description of one material of a square."""
    m = Maker()
    pixels = np.zeros((2, 2, 4), np.uint8)
    pixels[..., 1] = 128
    m.picture(pixels)
    m.node(mesh=m.square(m.material(name="it", **material)))
    return parsed(m).data["bsdfs"]["it"]


def core(bsdf):
    while "bsdf" in bsdf:
        bsdf = bsdf["bsdf"]
    return bsdf
