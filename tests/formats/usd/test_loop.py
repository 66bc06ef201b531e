"""OpenUSD: subdivision surfaces by Loop's scheme."""

import numpy as np
import pytest

from alight.meshes.loop import subdivide
from tests.formats.usd.stage import shapes, usd_loader

pytest.importorskip("pxr")

#: An octahedron; its corners and a colour of each.
POINTS = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
FACES = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
COLORS = [tuple(0.5 + 0.5 * c for c in p) for p in POINTS]
MESH = """def Mesh "m" {{
    int[] faceVertexCounts = {counts}
    int[] faceVertexIndices = {corners}
    point3f[] points = {points}
    uniform token subdivisionScheme = "loop"
    {more}
}}
"""


@pytest.fixture
def load(tmp_path):
    return usd_loader(tmp_path)


def mesh_text(more="", faces=FACES):
    corners = [int(corner) for face in faces for corner in face]
    return MESH.format(counts=[len(f) for f in faces], corners=corners, points=POINTS, more=more)


def test_a_mesh_lies_on_the_limit_surface_of_loop(load):
    colors = f'color3f[] primvars:displayColor = {COLORS} ( interpolation = "vertex" )'
    (node,) = shapes(load(mesh_text(colors))).values()
    points, normals, faces = subdivide(np.array(POINTS, float), np.array(FACES), 2)
    mesh = node.shape
    np.testing.assert_allclose(mesh.vertices[mesh.faces], points[faces], atol=1e-6)
    unit = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    np.testing.assert_allclose(mesh.normals[mesh.faces], unit[faces], atol=1e-6)
    # Colours are interpolated within the faces of the file, as the control points are there.
    flat, level = np.array(POINTS, float)[FACES], 2
    for _ in range(level):
        a, b, c = flat.transpose(1, 0, 2)
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        parts = [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        flat = np.stack([np.stack(p, 1) for p in parts], 1).reshape(-1, 3, 3)
    np.testing.assert_allclose(mesh.colors[mesh.faces], 0.5 + 0.5 * flat, atol=1e-6)


@pytest.mark.parametrize(
    ("more", "faces", "word"),
    [
        ("", [*FACES[:6], (1, 3, 0, 5)], "no triangles"),
        ("int[] cornerIndices = [0]\n float[] cornerSharpnesses = [10]", FACES, "corners"),
        ("", [*FACES, FACES[0]], "at most two triangles"),
    ],
)
def test_what_loop_cannot_smooth_is_shown_as_it_is(load, more, faces, word):
    scene = load(mesh_text(more, faces))
    assert any(word in text and "control mesh" in text for text in scene.warnings)
    (node,) = shapes(scene).values()
    assert len(node.shape.vertices) == 6


def test_parts_of_a_smooth_mesh_keep_their_materials(load):
    part = """def GeomSubset "top" { uniform token elementType = "face"
    uniform token familyName = "materialBind"
    int[] indices = [0, 1, 2, 3] }"""
    sizes = sorted(len(n.shape.faces) for n in shapes(load(mesh_text(part))).values())
    assert sizes == [64, 64]
