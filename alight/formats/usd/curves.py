"""BasisCurves of UsdGeom -> round strands.

Source: the documentation of UsdGeomBasisCurves, for bases, wrapping and the sizes of primvars.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from alight.core.errors import unknown_name
from alight.core.fields import LARGEST
from alight.formats.surfaces import Surface
from alight.formats.usd.modules import UsdGeom
from alight.formats.usd.stage import Stage
from alight.shapes.curves import Curves

Array = np.ndarray
#: Their bases -> ours, and by how many points the segments of each follow one another.
BASES = {"bezier": ("bezier", 3), "bspline": ("b_spline", 1), "catmullRom": ("catmull_rom", 1)}
WRAPS = ("nonperiodic", "periodic", "pinned")

#: Radius, in parts of the size of all, where a file names no widths.
THIN = 1e-3


def read_curves(stage: Stage, prim: Any) -> Curves | None:
    """Read curves; None after a problem, or where there are none."""
    curves = UsdGeom.BasisCurves(prim)
    points = np.array(stage.value(curves.GetPointsAttr(), []), np.float64).reshape(-1, 3)
    counts = np.array(stage.value(curves.GetCurveVertexCountsAttr(), []), np.int64)
    basis, step, wrap = _kind(stage, curves)
    if basis is None:
        return None
    if not len(counts) or not len(points):
        stage.report.drop(f"{prim.GetPath()}: curves without points")
        return None
    fewest = {"linear": 2, "bezier": 4}.get(basis, 2 if wrap == "pinned" else 4)
    fewest = {"linear": 3, "bezier": 3}.get(basis, 3) if wrap == "periodic" else fewest
    uneven = basis == "bezier" and ((counts % 3 != 0) if wrap == "periodic" else (counts % 3 != 1))
    bad = (counts < fewest) | uneven
    if counts.sum() != len(points) or bad.any() or not (np.abs(points) <= LARGEST).all():
        text = f"curveVertexCounts must fit its points, and {basis} curves ({wrap})"
        stage.problem(prim, f"{text}, got {int(counts[bad.argmax()])} of {len(points)}")
        return None
    if len(stage.value(curves.GetNormalsAttr(), [])):
        stage.report.approximate(f"{prim.GetPath()}: ribbons with normals are shown round")
    radii = 0.5 * _widths(stage, curves, points, counts, (basis, step, wrap))
    rows = np.concatenate([points, np.maximum(radii, 0.0)[:, None]], axis=1)
    parts = [_wrapped(part, basis, wrap) for part in np.split(rows, np.cumsum(counts)[:-1])]
    whole = np.concatenate(parts)
    return Curves(
        points=whole[:, :3],
        radii=np.maximum(whole[:, 3], 0.0),
        counts=[len(part) for part in parts],
        basis=basis,
    )


def _kind(stage: Stage, curves: Any) -> tuple[Any, int, str]:
    """Our basis (None after a problem), points from segment to segment, and the wrap."""
    wrap = str(stage.value(curves.GetWrapAttr(), "nonperiodic"))
    if wrap not in WRAPS:
        stage.problem(curves.GetPrim(), unknown_name("wrap", wrap, WRAPS, listed_as="wraps"))
        return None, 1, wrap
    if str(stage.value(curves.GetTypeAttr(), "cubic")) == "linear":
        return "linear", 1, wrap
    basis = str(stage.value(curves.GetBasisAttr(), "bezier"))
    if basis not in BASES:
        stage.problem(curves.GetPrim(), unknown_name("basis", basis, BASES, listed_as="bases"))
        return None, 1, wrap
    return *BASES[basis], wrap


def _wrapped(rows: Array, basis: str, wrap: str) -> Array:
    """The rows of one curve with those that close it, or pin its ends."""
    if wrap == "periodic":
        return np.concatenate([rows, rows[: 1 if basis in ("linear", "bezier") else 3]])
    if wrap == "pinned" and basis not in ("linear", "bezier"):
        return np.concatenate([2.0 * rows[:1] - rows[1:2], rows, 2.0 * rows[-1:] - rows[-2:-1]])
    return rows


def _widths(
    stage: Stage, curves: Any, points: Array, counts: Array, kind: tuple[str, int, str]
) -> Array:
    """A width at each control point."""
    path, n = curves.GetPrim().GetPath(), len(points)
    widths = np.array(stage.value(curves.GetWidthsAttr(), []), np.float64).reshape(-1)
    if not len(widths):
        size = float(np.linalg.norm(np.ptp(points, axis=0)))
        stage.report.approximate(f"{path}: without widths, its curves are thin")
        return np.full(n, 2.0 * THIN * size)
    if not ((widths >= 0.0) & (widths <= LARGEST)).all():
        stage.problem(curves.GetPrim(), f"its widths must be in [0, {LARGEST:g}]")
        return np.zeros(n)
    if len(widths) == 1:
        return np.full(n, widths[0])
    how = str(curves.GetWidthsInterpolation())
    ends = _ends(counts, kind)
    if how == "vertex" and len(widths) == n:
        return widths
    if how == "uniform" and len(widths) == len(counts):
        return np.repeat(widths, counts)
    if how in ("varying", "vertex") and len(widths) == ends.sum():
        return _from_ends(widths, counts, ends, kind)
    text = f"its widths ({how}) must be 1, {len(counts)}, {int(ends.sum())} or {n}"
    stage.problem(curves.GetPrim(), f"{text}, got {len(widths)}")
    return np.zeros(n)


def _ends(counts: Array, kind: tuple[str, int, str]) -> Array:
    """How many ends of segments each curve has."""
    basis, step, wrap = kind
    if basis == "linear" or (wrap == "pinned" and basis != "bezier"):
        return counts
    return counts // step if wrap == "periodic" else (counts - 4) // step + 2


def _from_ends(widths: Array, counts: Array, ends: Array, kind: tuple[str, int, str]) -> Array:
    """Values at the ends of segments -> values at control points."""
    basis, step, wrap = kind
    # Of these bases the first point lies before the first segment.
    before = 1 if basis in ("b_spline", "catmull_rom") and wrap == "nonperiodic" else 0
    found = []
    for part, count in zip(np.split(widths, np.cumsum(ends)[:-1]), counts, strict=True):
        closed = np.append(part, part[0]) if wrap == "periodic" else part
        place = (np.arange(count) - before) / step
        found.append(np.interp(place, np.arange(len(closed)), closed))
    return np.concatenate(found)


def with_mean_color(stage: Stage, prim: Any, surface: Surface) -> Surface | None:
    """A material with the mean displayColor, if it shows one that varies; else None."""
    primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance("displayColor")
    if not _shows_colors(surface.core) or not primvar or not primvar.HasValue():
        return None
    table = stage.table(primvar)
    if table is None or table.shape[1:] != (3,) or not len(table):
        return None
    stage.report.approximate(f"{prim.GetPath()}: its curves have the mean of their displayColor")
    color = np.clip(table.mean(axis=0), 0.0, 1.0).tolist()
    return replace(surface, core=_colored(surface.core, color))


def _shows_colors(value: Any) -> bool:
    if isinstance(value, dict):
        return value.get("type") == "vertex_color" or any(map(_shows_colors, value.values()))
    return isinstance(value, list) and any(map(_shows_colors, value))


def _colored(value: Any, color: list[float]) -> Any:
    """The same with a colour in the place of those of vertices."""
    if isinstance(value, dict):
        if value.get("type") == "vertex_color":
            return color
        return {key: _colored(item, color) for key, item in value.items()}
    return [_colored(item, color) for item in value] if isinstance(value, list) else value
