"""Shapes that only pbrt 3 has, as fine meshes.

Source: pbrt-v3, documentation of the file format, "Shapes"; PBR3 section 3.5; Piegl and Tiller, The
NURBS book, 2nd ed., algorithms A2.2 and A4.3.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from alight.formats.pbrt.parameters import Parameters
from alight.formats.pbrt.placed import Placed, angle_of, cut, mesh_of
from alight.meshes import surfaces
from alight.shapes.mesh import Mesh

Array = np.ndarray
#: Cells of a surface without a formula for its curvature, along u and along v.
DICE = 30
_STEP = 1e-4
MOST_SIDE = 4096


def _bent(formula: Callable[[Array, Array], Array], columns: int, rows: int) -> dict[str, Array]:
    """A mesh of a surface, with the normals that its derivatives give."""

    def with_normals(u: Array, v: Array) -> tuple[Array, Array]:
        low, high = np.clip(u - _STEP, 0.0, 1.0), np.clip(u + _STEP, 0.0, 1.0)
        # At a tip all of u is one point: the normals are those just beside it.
        inside = np.clip(v, _STEP, 1.0 - _STEP)
        along_u = formula(high, inside) - formula(low, inside)
        low, high = np.clip(v - _STEP, 0.0, 1.0), np.clip(v + _STEP, 0.0, 1.0)
        across = np.cross(along_u, formula(u, high) - formula(u, low))
        lengths = np.linalg.norm(across, axis=1, keepdims=True)
        return formula(u, v), across / np.where(lengths > 0.0, lengths, 1.0)

    return surfaces.grid(with_normals, columns, rows)


def _turned(radius: Array, height: Array, angle: Array) -> Array:
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=1)


def _cone(placed: Placed) -> Mesh | None:
    p = placed.p
    radius, height, phi = p.positive("radius", 1.0), p.positive("height", 1.0), angle_of(p)
    p.find("alpha")

    def formula(u: Array, v: Array) -> Array:
        return _turned((1.0 - v) * radius, v * height, u * phi)

    return cut(placed, _bent(formula, surfaces.AROUND, 1), "is a cone")


def _paraboloid(placed: Placed) -> Mesh | None:
    p = placed.p
    radius, phi = p.positive("radius", 1.0), angle_of(p)
    low, high = sorted([p.number("zmin", 0.0), p.number("zmax", 1.0)])
    p.find("alpha")
    if not 0.0 <= low < high:
        placed.fail(f"zmin and zmax must differ and be >= 0, got {low:g} and {high:g}")
        return None

    def formula(u: Array, v: Array) -> Array:
        z = low + v * (high - low)
        return _turned(radius * np.sqrt(z / high), z, u * phi)

    return cut(placed, _bent(formula, surfaces.AROUND, 64), "is a paraboloid")


def _hyperboloid(placed: Placed) -> Mesh | None:
    p = placed.p
    begin, end = p.triple("p1", (0.0, 0.0, 0.0)), p.triple("p2", (1.0, 1.0, 1.0))
    phi = angle_of(p)
    p.find("alpha")

    def formula(u: Array, v: Array) -> Array:
        x, y, z = ((1.0 - v[:, None]) * begin + v[:, None] * end).T
        return _turned(np.hypot(x, y), z, u * phi + np.arctan2(y, x))

    return cut(placed, _bent(formula, surfaces.AROUND, 64), "is a hyperboloid")


def _height_field(placed: Placed) -> Mesh | None:
    p = placed.p
    columns, rows = p.integer("nu", 0), p.integer("nv", 0)
    heights = p.values("Pz", "float")
    p.find("alpha")
    if min(columns, rows) < 2 or max(columns, rows) > MOST_SIDE or heights is None:
        text = f'needs nu and nv from 2 to {MOST_SIDE} and "float Pz"'
        placed.fail(f"{text}, got {columns} and {rows}")
        return None
    if len(heights.values) != columns * rows:
        wanted = f"must hold nu * nv = {columns * rows} heights, got {len(heights.values)}"
        p.report.error(heights, wanted)
        return None
    u, v = np.meshgrid(np.linspace(0, 1, columns), np.linspace(0, 1, rows))
    points = np.stack([u.ravel(), v.ravel(), np.asarray(heights.values)], axis=1)
    first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    right, up = first + 1, first + columns
    lower, upper = np.stack([first, right, up + 1], 1), np.stack([first, up + 1, up], 1)
    keys = {"vertices": points, "faces": np.concatenate([lower, upper]), "uvs": points[:, :2]}
    return mesh_of(placed, keys, placed.reverse)


def _nurbs(placed: Placed) -> Mesh | None:
    p = placed.p
    axes = [_axis(p, name) for name in "uv"]
    name, width = ("Pw", 4) if p.has("Pw") else ("P", 3)
    found = p.values(name, "float", "point")
    p.find("alpha")
    if found is None or axes[0] is None or axes[1] is None:
        text = "needs nu, uorder, uknots (nu + uorder of them, ascending), the same of v"
        placed.fail(f'{text}, and "point3 P" or "float Pw"')
        return None
    (nu, at_u), (nv, at_v) = axes[0], axes[1]
    if len(found.values) != nu * nv * width:
        wanted = f"must hold nu * nv * {width} = {nu * nv * width} numbers"
        p.report.error(found, f"{wanted}, got {len(found.values)}")
        return None
    net = np.asarray(found.values, np.float64).reshape(nv, nu, width)
    if width == 3:
        net = np.concatenate([net, np.ones((nv, nu, 1))], axis=2)

    def formula(u: Array, v: Array) -> Array:
        whole = np.einsum("ni,nj,jik->nk", at_u(u), at_v(v), net)
        return whole[:, :3] / np.where(whole[:, 3:] == 0.0, 1.0, whole[:, 3:])

    p.report.warn(p.directive, f"becomes {2 * DICE * DICE} triangles")
    return mesh_of(placed, _bent(formula, DICE, DICE), placed.reverse)


def _axis(p: Parameters, axis: str) -> tuple[int, Callable[[Array], Array]] | None:
    """Number of control points along u or v, and what gives their weights in [0, 1]."""
    count, order = p.integer(f"n{axis}", 0), p.integer(f"{axis}order", 0)
    found = p.values(f"{axis}knots", "float")
    if found is None or not 2 <= order <= count <= MOST_SIDE:
        return None
    knots = np.asarray(found.values, np.float64)
    if len(knots) != count + order or (np.diff(knots) < 0.0).any():
        return None
    begin = p.number(f"{axis}0", float(knots[order - 1]))
    end = p.number(f"{axis}1", float(knots[count]))

    def weights(t: Array) -> Array:
        return _basis(knots, order, count, begin + t * (end - begin))

    return count, weights


def _basis(knots: Array, order: int, count: int, t: Array) -> Array:
    """Weights of the control points at parameters t, shape (n, count), by Cox and de Boor."""
    t = np.clip(t, knots[order - 1], knots[count])
    span = np.clip(np.searchsorted(knots, t, side="right") - 1, order - 1, count - 1)
    n = np.zeros((len(t), len(knots) - 1))
    n[np.arange(len(t)), span] = 1.0
    for k in range(2, order + 1):
        width = len(knots) - k
        left, right = knots[k - 1 : k - 1 + width] - knots[:width], knots[k:] - knots[1 : width + 1]
        a = (t[:, None] - knots[:width]) / np.where(left > 0.0, left, np.inf)
        b = (knots[k:] - t[:, None]) / np.where(right > 0.0, right, np.inf)
        n = a * n[:, :width] + b * n[:, 1 : width + 1]
    return n[:, :count]


OF_3: dict[str, Callable[[Placed], Mesh | None]] = {
    "cone": _cone,
    "heightfield": _height_field,
    "hyperboloid": _hyperboloid,
    "nurbs": _nurbs,
    "paraboloid": _paraboloid,
}
