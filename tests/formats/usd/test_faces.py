"""Faces of meshes by their numbers: holes, subsets and sides, among faces that are none."""

import numpy as np
import pytest

from tests.formats.usd.stage import shapes, usd_loader

pytest.importorskip("pxr")

MATERIALS = "".join(
    f"""
def Material "m{n}" {{ token outputs:surface.connect = </m{n}/s.outputs:surface>
    def Shader "s" {{ uniform token info:id = "UsdPreviewSurface"; token outputs:surface
        color3f inputs:diffuseColor = ({n / 8}, 0, 0) }} }}
"""
    for n in range(1, 4)
)


@pytest.mark.parametrize("orientation", ["rightHanded", "leftHanded"])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_faces_belong_to_the_first_subset_that_names_them(seed, orientation, tmp_path):
    """Each face stands by itself, at x = its number, and looks to +z as the file says."""
    rng = np.random.default_rng([109, seed])
    count = 12
    sizes = rng.permutation([0, 1, 2, *rng.integers(3, 6, count - 3)]).tolist()
    holes = rng.choice(count, 2, replace=False).tolist()
    subsets = [rng.choice(count, 5, replace=False).tolist() for _ in range(3)]
    points, corners, uvs = [], [], []
    for face, size in enumerate(sizes):
        turn = 2.0 * np.pi * np.arange(size) / max(size, 1)
        turn = turn if orientation == "rightHanded" else -turn
        corners += list(range(len(points), len(points) + size))
        points += [(face + 0.25 * np.cos(t), 0.25 * np.sin(t), 0.0) for t in turn]
    # Points in another order than their corners.
    order = rng.permutation(len(points))
    stored = [None] * len(points)
    for place, point in zip(order.tolist(), points, strict=True):
        stored[place] = point
    uvs = [(0.125 * x, 0.5 + y) for x, y, _ in points]
    parts = "".join(
        f"""
    def GeomSubset "part{n}" (prepend apiSchemas = ["MaterialBindingAPI"]) {{
        uniform token elementType = "face"; uniform token familyName = "materialBind"
        int[] indices = {faces}
        rel material:binding = </m{n}>
    }}"""
        for n, faces in enumerate(subsets, 1)
    )
    scene = usd_loader(tmp_path)(f"""{MATERIALS}
def Mesh "mesh" {{
    int[] faceVertexCounts = {sizes}
    int[] faceVertexIndices = {order[corners].tolist()}
    point3f[] points = [{", ".join(map(str, [tuple(map(float, p)) for p in stored]))}]
    int[] holeIndices = {holes}
    uniform token orientation = "{orientation}"
    uniform token subdivisionScheme = "none"
    texCoord2f[] primvars:st = [{", ".join(f"({u}, {v})" for u, v in uvs)}] (interpolation = "faceVarying")
{parts}
}}""")  # noqa: E501
    found, wanted = {}, {}
    for path, node in shapes(scene).items():
        mesh, name = node.shape, path.split("/")[-1]
        a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
        assert (np.cross(b - a, c - a)[:, 2] > 0.0).all()
        np.testing.assert_allclose(mesh.uvs[:, 0], 0.125 * mesh.vertices[:, 0], atol=1e-6)
        np.testing.assert_allclose(mesh.uvs[:, 1], 0.5 + mesh.vertices[:, 1], atol=1e-6)
        found[name] = sorted(np.rint((a + b + c)[:, 0] / 3.0).astype(int).tolist())
    for face, size in enumerate(sizes):
        owner = next((f"part{n}" for n, s in enumerate(subsets, 1) if face in s), "rest")
        if size >= 3 and face not in holes:
            wanted.setdefault(owner, []).extend([face] * (size - 2))
    assert found == wanted
