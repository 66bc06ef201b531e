"""KHR_texture_transform turns and mirrors what a picture of normals says, not only its texels."""

import numpy as np
import pytest

from tests.formats.bare import load
from tests.formats.gltf.maker import Maker
from tests.formats.leaning import normals_of

#: Texels of 8 bits: the normal leans to the right of the picture, and less to its top.
TEXEL = np.uint8([[[179, 166, 230]]])
LEAN, RISE, HEIGHT = 2.0 * TEXEL[0, 0] / 255.0 - 1.0
QUARTER = np.pi / 2
#: A transform, and where in the world the right and the top of the picture then are.
CASES = {
    "none": ({}, (1, 0), (0, 1)),
    "quarter turn": ({"rotation": QUARTER}, (0, -1), (1, 0)),
    "half turn": ({"rotation": np.pi}, (-1, 0), (0, -1)),
    "mirrored": ({"scale": [-1, 1]}, (-1, 0), (0, 1)),
    "upside down": ({"scale": [1, -1]}, (1, 0), (0, -1)),
    "both": ({"scale": [-1, -1]}, (-1, 0), (0, -1)),
    "turned and mirrored": ({"rotation": QUARTER, "scale": [-1, 1]}, (0, -1), (-1, 0)),
    "moved and larger": ({"offset": [0.3, 0.1], "scale": [2, 3]}, (1, 0), (0, 1)),
}


@pytest.mark.parametrize("case", CASES)
def test_the_normals_of_a_transformed_picture_lean_as_it_lies(tmp_path, case):
    """(u', v') = T R S (u, v) with v downwards: where u' and -v' grow on a square seen head-on."""
    change, right, above = CASES[case]
    m = Maker()
    m.picture(TEXEL)
    info = {"index": 0, "extensions": {"KHR_texture_transform": change}}
    m.node(mesh=m.square(m.material(normalTexture=info)))
    (tmp_path / "a.gltf").write_bytes(m.gltf())
    scene = load(tmp_path / "a.gltf")
    (bsdf,) = scene.bsdfs.values()
    (shape,) = (node.shape for _, _, node in scene.walk() if node.shape is not None)
    normals = normals_of(shape, bsdf.bsdf.texture)
    expected = LEAN * np.array([*right, 0.0]) + RISE * np.array([*above, 0.0]) + [0, 0, HEIGHT]
    expected /= np.linalg.norm(expected)
    np.testing.assert_allclose(normals, np.tile(expected, (len(normals), 1)), atol=1e-4)
