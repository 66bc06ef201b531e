"""BasisCurves of UsdGeom -> round strands.

Source: the documentation of UsdGeomBasisCurves, for bases, wrapping and the sizes of primvars.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from alight.core.errors import unknown_name
from alight.core.fields import LARGEST
from alight.formats.materials.surfaces import Surface
from alight.formats.usd.modules import UsdGeom
from alight.formats.usd.placing import are_in_range
from alight.formats.usd.stage import Stage
from alight.shapes.curves import Curves
from alight.shapes.strands import TO_BEZIER

Array = np.ndarray
#: Their bases -> ours, and by how many points the segments of each follow one another.
BASES = {"bezier": ("bezier", 3), "bspline": ("b_spline", 1), "catmullRom": ("catmull_rom", 1)}
#: Bases whose curves do not pass their first and last points.
SMOOTH = ("b_spline", "catmull_rom")
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
    if counts.sum() != len(points) or bad.any():
        text = f"curveVertexCounts must fit its points, and {basis} curves ({wrap})"
        stage.problem(prim, f"{text}, got {int(counts[bad.argmax()])} of {len(points)}")
        return None
    if not are_in_range(stage, prim, points):
        return None
    if len(stage.value(curves.GetNormalsAttr(), [])):
        stage.report.approximate(f"{prim.GetPath()}: ribbons with normals are shown round")
    widths, at_ends = _widths(stage, curves, points, counts, (basis, step, wrap))
    radii = 0.5 * np.maximum(widths, 0.0)
    starts = np.cumsum(counts)[:-1]
    if basis in SMOOTH and (at_ends is not None or wrap == "pinned"):
        # Bezier's have the widths of the file at their ends, whatever lies beyond.
        of_each = np.split(radii, starts if at_ends is None else np.cumsum(at_ends)[:-1])
        pairs = zip(np.split(points, starts), of_each, strict=True)
        parts = [_as_bezier(part, r, basis, wrap, at_ends is not None) for part, r in pairs]
        basis = "bezier"
    else:
        if at_ends is not None:
            radii = _from_ends(radii, counts, at_ends, step, wrap)
        rows = np.concatenate([points, radii[:, None]], axis=1)
        parts = [_wrapped(part, basis, wrap) for part in np.split(rows, starts)]
    whole = np.concatenate(parts)
    return Curves(
        points=whole[:, :3],
        radii=np.maximum(whole[:, 3], 0.0),
        counts=[len(part) for part in parts],
        basis=basis,
    )


def _as_bezier(points: Array, radii: Array, basis: str, wrap: str, at_ends: bool) -> Array:
    """The rows of one curve as Bezier's; radii: at its points, or at the ends of its segments."""
    rows = points if at_ends else np.concatenate([points, radii[:, None]], axis=1)
    rows = _wrapped(rows, basis, wrap)
    taken = rows[np.arange(len(rows) - 3)[:, None] + np.arange(4)]
    cubics = TO_BEZIER[basis] @ taken
    if at_ends:
        closed = np.append(radii, radii[0]) if wrap == "periodic" else radii
        t = np.arange(4) / 3.0
        linear = closed[:-1, None] + t * (closed[1:] - closed[:-1])[:, None]
        cubics = np.concatenate([cubics, linear[:, :, None]], axis=2)
    return np.concatenate([cubics[:, :3].reshape(-1, 4), cubics[-1:, 3]])


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
) -> tuple[Array, Array | None]:
    """A width at each control point, and None; or at the ends of segments, and how many of each."""
    path, n = curves.GetPrim().GetPath(), len(points)
    attribute, how = curves.GetWidthsAttr(), str(curves.GetWidthsInterpolation())
    # A primvar of this name counts more than the attribute.
    primvar = UsdGeom.PrimvarsAPI(curves.GetPrim()).GetPrimvar("widths")
    if primvar and primvar.HasValue():
        found, how = stage.table(primvar), str(primvar.GetInterpolation())
        found = [] if found is None else found
    else:
        found = stage.value(attribute, [])
    widths = np.array(found, np.float64).reshape(-1)
    if not len(widths):
        size = float(np.linalg.norm(np.ptp(points, axis=0)))
        stage.report.approximate(f"{path}: without widths, its curves are thin")
        return np.full(n, 2.0 * THIN * size), None
    if not ((widths >= 0.0) & (widths <= LARGEST)).all():
        stage.problem(curves.GetPrim(), f"its widths must be in [0, {LARGEST:g}]")
        return np.zeros(n), None
    if len(widths) == 1:
        return np.full(n, widths[0]), None
    ends = _ends(counts, kind)
    if how == "vertex" and len(widths) == n:
        return widths, None
    if how == "uniform" and len(widths) == len(counts):
        return np.repeat(widths, counts), None
    if how in ("varying", "vertex") and len(widths) == ends.sum():
        return widths, ends
    text = f"its widths ({how}) must be 1, {len(counts)}, {int(ends.sum())} or {n}"
    stage.problem(curves.GetPrim(), f"{text}, got {len(widths)}")
    return np.zeros(n), None


def _ends(counts: Array, kind: tuple[str, int, str]) -> Array:
    """How many ends of segments each curve has."""
    basis, step, wrap = kind
    if basis == "linear" or (wrap == "pinned" and basis != "bezier"):
        return counts
    return counts // step if wrap == "periodic" else (counts - 4) // step + 2


def _from_ends(values: Array, counts: Array, ends: Array, step: int, wrap: str) -> Array:
    """Values at the ends of straight or Bezier's segments -> values at control points."""
    found = []
    for part, count in zip(np.split(values, np.cumsum(ends)[:-1]), counts, strict=True):
        closed = np.append(part, part[0]) if wrap == "periodic" else part
        found.append(np.interp(np.arange(count) / step, np.arange(len(closed)), closed))
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
