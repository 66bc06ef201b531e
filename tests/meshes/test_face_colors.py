"""PLY files that colour their faces."""

import numpy as np
import pytest

from alight.core.srgb import decode_srgb
from alight.meshes import ply

HEAD = """ply
format ascii 1.0
element vertex 6
property float x
property float y
property float z
element face 3
property list uchar int vertex_indices
property {kind} red
property {kind} green
property {kind} blue
end_header
0 0 0
1 0 0
1 1 0
0 1 0
2 0 0
2 1 0
"""
#: A square of one colour, then two triangles of which the second is like the square.
FACES = "4 0 1 2 3 {a}\n3 1 4 2 {b}\n3 4 5 2 {a}\n"


@pytest.mark.parametrize(("kind", "a", "b"), [("uchar", "255 0 51", "0 102 0"),
                                              ("float", "1 0 0.2", "0 0.4 0")])  # fmt: skip
def test_faces_keep_their_colours_and_those_of_one_colour_share_vertices(kind, a, b):
    mesh = ply.read((HEAD.format(kind=kind) + FACES.format(a=a, b=b)).encode())
    given = [np.array(text.split(), float) for text in (a, a, b, a)]
    wanted = [decode_srgb(c / 255.0) if kind == "uchar" else c for c in given]
    assert mesh.faces.shape == (4, 3)
    for triangle, color in zip(mesh.faces, wanted, strict=True):
        np.testing.assert_allclose(mesh.colors[triangle], [color] * 3, atol=1e-6)
    places = mesh.vertices[mesh.faces][:, :, :2]
    assert places[2].tolist() == [[1, 0], [2, 0], [1, 1]]
    assert np.unique(places[:2].reshape(-1, 2), axis=0).shape == (4, 2)
    # Six of the first colour (one place is met by two of its faces), three of the other.
    assert len(mesh.vertices) == 9
