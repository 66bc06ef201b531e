"""Prims stand where OpenUSD's own library says, whatever axis is up and in whatever unit."""

import numpy as np
import pytest

from tests.formats.usd.stage import SQUARE, shapes, usd_loader, world_points

Usd = pytest.importorskip("pxr.Usd")
UsdGeom = pytest.importorskip("pxr.UsdGeom")

#: From the stage's axes to ours.
ROOTS = {"Y": np.eye(3), "Z": np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])}


def triple(rng, low=-1.0, high=1.0):
    return "({:.4f}, {:.4f}, {:.4f})".format(*rng.uniform(low, high, 3))


def operations(rng):
    """Statements of a prim that is placed in general position."""
    rows = rng.uniform(-1.0, 1.0, (4, 4)) + 2.0 * np.eye(4)
    rows[:, 3] = 0.0, 0.0, 0.0, 1.0
    given = {
        "translate": f"double3 xformOp:translate = {triple(rng)}",
        "rotateZYX": f"float3 xformOp:rotateZYX = {triple(rng, -180, 180)}",
        "scale": f"float3 xformOp:scale = {triple(rng, 0.5, 2)}",
        "transform": "matrix4d xformOp:transform = "
        f"({', '.join(str(tuple(row)) for row in rows.round(4).tolist())})",
        "translate:pivot": f"double3 xformOp:translate:pivot = {triple(rng)}",
    }
    names = rng.permutation([name for name in given if name != "translate:pivot"])[:2].tolist()
    order = [f"xformOp:{name}" for name in names]
    order = ["xformOp:translate:pivot", *order, "!invert!xformOp:translate:pivot"]
    if rng.random() < 0.3:
        order.insert(0, "!resetXformStack!")
    lines = [given[name] for name in (*names, "translate:pivot")]
    listed = ", ".join(f'"{name}"' for name in order)
    return "\n".join([*lines, f"uniform token[] xformOpOrder = [{listed}]"])


@pytest.mark.parametrize("unit", [1, 0.01])
@pytest.mark.parametrize("up", ROOTS)
@pytest.mark.parametrize("seed", [1, 2])
def test_meshes_stand_where_the_library_says(seed, up, unit, tmp_path):
    """Nested six deep, each with steps of its own, some of which undo those above."""
    rng = np.random.default_rng([109, seed])
    text = ""
    for deep in reversed(range(6)):
        mesh = f'def Mesh "m{deep}" {{ {SQUARE} \n{operations(rng)} }}'
        text = f'def Xform "x{deep}" {{ {operations(rng)}\n{mesh}\n{text}\n}}'
    scene = usd_loader(tmp_path)(text, up=up, unit=unit)
    stage = Usd.Stage.Open(str(tmp_path / "a.usda"))
    cache = UsdGeom.XformCache()
    wanted = {}
    for prim in stage.Traverse():
        if prim.IsA(UsdGeom.Mesh):
            place = np.array(cache.GetLocalToWorldTransform(prim))
            points = np.array(UsdGeom.Mesh(prim).GetPointsAttr().Get())
            points = points @ place[:3, :3] + place[3, :3]
            wanted[prim.GetName()] = unit * points @ ROOTS[up].T
    names = [path.split("/")[-1] for path in shapes(scene)]
    found = dict(zip(names, np.split(world_points(scene), len(names)), strict=True))
    assert found.keys() == wanted.keys()
    assert "!resetXformStack!" in (tmp_path / "a.usda").read_text()
    for name, points in wanted.items():
        # In whatever order.
        apart = np.abs(found[name][:, None] - points).max(axis=2)
        assert max(apart.min(axis=0).max(), apart.min(axis=1).max()) < 1e-5 * np.abs(points).max()
