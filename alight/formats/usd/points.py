"""Points of UsdGeom -> one mesh of balls.

Source: the documentation of UsdGeomPoints: widths are diameters in the space of the prim.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from alight.core.fields import LARGEST
from alight.formats.objects.points import FINEST, MOST_TRIANGLES, ball, sensible_radius
from alight.formats.usd.modules import UsdGeom
from alight.formats.usd.placing import are_in_range
from alight.formats.usd.stage import Stage
from alight.meshes.polygons import Triangles

#: Of more points only some are shown.
MOST_POINTS = 250_000

Array = np.ndarray


def read_points(stage: Stage, prim: Any) -> Triangles | None:
    """Read points; None after a problem, or where there are none."""
    points = np.array(stage.value(UsdGeom.Points(prim).GetPointsAttr(), []), np.float64)
    points = points.reshape(-1, 3)
    if not len(points):
        stage.report.drop(f"{prim.GetPath()}: no points")
        return None
    if not are_in_range(stage, prim, points):
        return None
    radii = _radii(stage, prim, points)
    colors = _colors(stage, prim, len(points))
    seen = radii > 0.0
    step = -(-int(seen.sum()) // MOST_POINTS)
    if step > 1:
        text = f"of {len(points)} points one in {step} is shown"
        stage.report.approximate(f"{prim.GetPath()}: {text}")
    chosen = np.flatnonzero(seen)[:: max(step, 1)]
    if not len(chosen):
        stage.report.drop(f"{prim.GetPath()}: its points have no widths above 0")
        return None
    level, count = 0, len(chosen)
    while level < FINEST and 20 * 4 ** (level + 1) * count <= MOST_TRIANGLES:
        level += 1
    stage.report.approximate(f"{prim.GetPath()}: its points are balls of {20 * 4**level} triangles")
    normals, faces = ball(level)
    vertices = points[chosen, None, :] + radii[chosen, None, None] * normals
    values = {"normals": np.tile(normals, (count, 1))}
    if colors is not None:
        values["colors"] = np.repeat(colors[chosen], len(normals), axis=0)
    every = len(normals) * np.arange(count)[:, None, None]
    return Triangles(
        vertices=vertices.reshape(-1, 3),
        faces=(faces + every).reshape(-1, 3),
        values=values,
        origin=np.repeat(chosen, len(faces)),
    )


def _radii(stage: Stage, prim: Any, points: Array) -> Array:
    """The radius of each point."""
    n, schema = len(points), UsdGeom.Points(prim)
    # A primvar of this name counts more than the attribute.
    primvar = UsdGeom.PrimvarsAPI(prim).GetPrimvar("widths")
    found = stage.table(primvar) if primvar and primvar.HasValue() else None
    found = stage.value(schema.GetWidthsAttr(), []) if found is None else found
    widths = np.array(found, np.float64).reshape(-1)
    if not len(widths):
        stage.report.approximate(f"{prim.GetPath()}: without widths, its points nearly touch")
        return np.full(n, sensible_radius(points))
    if len(widths) not in (1, n):
        stage.problem(prim, f"its widths must be 1 or {n}, got {len(widths)}")
        return np.zeros(n)
    if not ((widths >= 0.0) & (widths <= LARGEST)).all():
        stage.problem(prim, f"its widths must be in [0, {LARGEST:g}]")
        return np.zeros(n)
    return 0.5 * np.broadcast_to(widths, n)


def _colors(stage: Stage, prim: Any, n: int) -> Array | None:
    """The colour of each point, where they differ."""
    primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance("displayColor")
    if not primvar or not primvar.HasValue():
        return None
    table = stage.table(primvar)
    if table is None or primvar.GetInterpolation() == UsdGeom.Tokens.constant:
        return None
    rows = np.array(table, np.float64)
    if rows.shape != (n, 3) or not np.isfinite(rows).all():
        text = f"displayColor has {len(table)} values, which do not fit"
        stage.report.approximate(f"{prim.GetPath()}: {text}: left out")
        return None
    return np.clip(rows, 0.0, 1.0)
