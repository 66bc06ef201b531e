"""OpenUSD: characters with joints, bindings and shapes in general position, as it bakes them."""

import numpy as np
import pytest

from tests.formats.bare import load
from tests.formats.usd.stage import HEAD, world_points

Usd = pytest.importorskip("pxr.Usd")
UsdGeom = pytest.importorskip("pxr.UsdGeom")
UsdSkel = pytest.importorskip("pxr.UsdSkel")

POINTS = 9


def matrix(rng):
    rows = np.eye(4)
    rows[:3, :3] = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    rows[:3, :3] *= np.linalg.det(rows[:3, :3]) * rng.uniform(0.8, 1.2, 3)[:, None]
    rows[3, :3] = rng.uniform(-1.0, 1.0, 3)
    return rows


def written(table):
    """Rows, or matrices of rows, as the text of a stage."""
    return "({})".format(", ".join(map(written, table))) if np.ndim(table) else f"{table:.6g}"


def array(table):
    return "[{}]".format(", ".join(map(written, table)))


def character(rng):
    bound, rests = (array([matrix(rng) for _ in range(3)]) for _ in range(2))
    turns = rng.normal(size=(3, 4))
    turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    weights = rng.random((POINTS, 2))
    weights /= weights.sum(axis=1, keepdims=True)
    shared = 'elementSize = 2\n            interpolation = "vertex"'
    shapes = "\n".join(
        f"""        def BlendShape "{name}"
        {{
            uniform vector3f[] offsets = {array(rng.normal(size=(4, 3)))}
            uniform int[] pointIndices = {chosen}
        }}"""
        for name, chosen in (("one", [0, 2, 3, 5]), ("other", [5, 3, 8, 1]))
    )
    return f"""{HEAD.format(up="Y", unit=1)}
def SkelRoot "r"
{{
    matrix4d xformOp:transform = {written(matrix(rng))}
    uniform token[] xformOpOrder = ["xformOp:transform"]
    def Mesh "m" (prepend apiSchemas = ["SkelBindingAPI"])
    {{
        matrix4d xformOp:transform = {written(matrix(rng))}
        uniform token[] xformOpOrder = ["xformOp:transform"]
        int[] faceVertexCounts = [3, 3, 3]
        int[] faceVertexIndices = [0, 1, 2, 3, 4, 5, 6, 7, 8]
        point3f[] points = {array(rng.normal(size=(POINTS, 3)))}
        uniform token subdivisionScheme = "none"
        matrix4d primvars:skel:geomBindTransform = {written(matrix(rng))}
        uniform token[] skel:joints = ["a/b", "c", "a"]
        int[] primvars:skel:jointIndices = {rng.integers(0, 3, 2 * POINTS).tolist()} (
            {shared}
        )
        float[] primvars:skel:jointWeights = {array(weights.ravel())} (
            {shared}
        )
        rel skel:skeleton = </r/s>
        uniform token[] skel:blendShapes = ["other", "one"]
        rel skel:blendShapeTargets = [</r/m/other>, </r/m/one>]
{shapes}
    }}
    def Skeleton "s" (prepend apiSchemas = ["SkelBindingAPI"])
    {{
        matrix4d xformOp:transform = {written(matrix(rng))}
        uniform token[] xformOpOrder = ["xformOp:transform"]
        uniform token[] joints = ["a", "a/b", "c"]
        uniform matrix4d[] bindTransforms = {bound}
        uniform matrix4d[] restTransforms = {rests}
        rel skel:animationSource = </r/moves>
    }}
    def SkelAnimation "moves"
    {{
        uniform token[] joints = ["a/b", "a"]
        uniform token[] blendShapes = ["one", "other"]
        float3[] translations = {array(rng.normal(size=(2, 3)))}
        quatf[] rotations = {array(turns[:2])}
        half3[] scales = {array(rng.uniform(0.8, 1.2, (2, 3)))}
        float[] blendShapeWeights = [0.75, -0.5]
    }}
}}
"""


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_points_are_where_openusd_bakes_them(seed, tmp_path):
    """Two shapes move one point; joints of mesh, skeleton and animation are in other orders."""
    path = tmp_path / "a.usda"
    path.write_text(character(np.random.default_rng([109, seed])))
    found = world_points(load(path))
    stage = Usd.Stage.Open(str(path))
    assert UsdSkel.BakeSkinning(UsdSkel.Root(stage.GetPrimAtPath("/r")))
    prim = stage.GetPrimAtPath("/r/m")
    points = np.array(UsdGeom.Mesh(prim).GetPointsAttr().Get(0.0))
    place = np.array(UsdGeom.XformCache(0.0).GetLocalToWorldTransform(prim))
    wanted = points @ place[:3, :3] + place[3, :3]
    # In whatever order.
    apart = np.abs(found[:, None] - wanted).max(axis=2)
    assert len(found) == POINTS
    assert max(apart.min(axis=0).max(), apart.min(axis=1).max()) < 1e-3
