"""KHR_texture_transform turns and mirrors what a picture of normals says, not only its texels."""

import numpy as np
import pytest

from alight.bsdfs.dispatch import evaluate_bsdf
from alight.bsdfs.normal_map import NormalMap
from alight.core.vec import Vec3
from alight.formats import load
from tests.formats.gltf.maker import Maker
from tests.physics.test_maps_on_charts import N, hit_surfaces
from tests.shapes.tracing import rows

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
    ((_, bsdf),) = scene.bsdfs.items()
    ((_, _, node),) = (part for part in scene.walk() if part[2].shape is not None)
    bent = bsdf.bsdf
    assert isinstance(bent, NormalMap)
    run, surface, found = hit_surfaces(node.shape, np.eye(4), bent.follow_uv, bent.texture)
    # What white matte stuff sends straight up is pi times the cosine between normal and light.
    n, every = rows(surface.ns), np.ones(N, bool)
    over = Vec3(*(np.float32([[0.0], [0.0], [1.0]]) * np.ones((3, N), np.float32)))
    lights = np.array([[0.6, 0.0, 0.8], [0.0, 0.6, 0.8], [0.0, 0.0, 1.0]])
    seen = []
    for wi in lights:
        local = [wi @ rows(axis) for axis in (surface.s, surface.t, surface.ns)]
        value, _ = run(evaluate_bsdf, surface, over, Vec3(*np.float32(local)), every)
        seen.append(np.pi * np.asarray(value.x, float)[found])
    assert found.sum() > 0.2 * N
    normal = np.linalg.solve(lights, seen)
    expected = LEAN * np.array([*right, 0.0]) + RISE * np.array([*above, 0.0]) + [0, 0, HEIGHT]
    expected /= np.linalg.norm(expected)
    np.testing.assert_allclose(normal.T, np.tile(expected, (found.sum(), 1)), atol=1e-4)
    np.testing.assert_allclose(n[2][found], 1.0)
