r"""Maps of textured area lights: how their light is spread over their shapes.

The texture is looked up, as renders do, at points on a regular grid in the unit square of a shape
or of each triangle (`alight.lights.area_map`). The grid is so fine that cells are no larger than
half a texel, and every texel is met, up to `MOST_CELLS` and `MOST_POINTS`. Finer details make noise
and no bias: every cell can be drawn.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from alight.compiled.materials import MaterialTables
from alight.compiled.program import Program
from alight.compiled.shapes import CompiledShapes
from alight.core.distributions import UNIT, cumulative_grid
from alight.core.field_types import Triple
from alight.core.registry import versions
from alight.core.spec import Texture
from alight.core.vec import Vec3, luminance
from alight.core.warps import square_to_triangle
from alight.lights.area_map import HEAD
from alight.shapes.hit import INFO, Hit, ShapeTables
from alight.shapes.model import SHAPES, ShapeModel
from alight.shapes.surfaces import surface_at_rest
from alight.textures.fetch import texture_value
from alight.textures.nesting import Composed
from lanewise.jit import instantiate, kernel
from lanewise.view import View

#: Cells along a side of the square for each texel, which is smooth within one, and most of them.
CELLS_PER_DETAIL, MOST_CELLS = 2, 512

#: Least and most points along a side, and most on all triangles of a mesh together.
LEAST_POINTS, MOST_POINTS, MOST_ON_MESH = 128, 1024, 1 << 20

#: Least gain in the mean square of a sample: the time that a map costs where nearly all of it goes
#: to the lamp.
LEAST_GAIN = 1.5

#: Where a texture does not say how fine it is: details per unit of (u, v).
_DETAILS = 64.0

#: Points at which the grid's fineness is found, along a side; points looked up at a time.
_COARSE, _BAND = 16, 1 << 16


class Textures(NamedTuple):
    """The textures of a compiled scene, for those who look them up while others are compiled.

    Attributes
    ----------
    tables : MaterialTables
    names : tuple of str
        For `Program.textures`.
    """

    tables: MaterialTables
    names: tuple[str, ...]


class AreaMap(NamedTuple):
    """How the light of one lamp is spread over its shape.

    Attributes
    ----------
    mean : triple
        Mean radiance over the surface.
    brightness : (n,) float64
        Mean luminance of each triangle, or of the whole shape.
    parts : list of ((m,) float32 or None)
        The map of each; None where it shines evenly.
    """

    mean: Triple
    brightness: NDArray[np.float64]
    parts: list[NDArray[np.float32] | None]

    def table(self, is_mesh: bool, at: int) -> NDArray[np.float32]:
        """What stands in `LightTables.cdf` from number `at` on: on meshes the list comes first."""
        if not is_mesh:
            assert self.parts[0] is not None
            return self.parts[0]
        starts, end = np.zeros(len(self.parts), np.uint32), at + len(self.parts)
        for i, part in enumerate(self.parts):
            if part is not None:
                starts[i], end = end, end + part.size
        found = [part for part in self.parts if part is not None]
        return np.concatenate([starts.view(np.float32), *found])


class _Scene(NamedTuple):
    """What textures and surfaces are given of a scene."""

    shapes: ShapeTables
    materials: MaterialTables


class _Points(NamedTuple):
    """Points of a shape.

    Attributes
    ----------
    radiance, p : (n, 3) float64
    density : (n,) float64
        Of uniform points of the square, per square metre.
    uv : (n, 2) float64
        Texture coordinates.
    """

    radiance: NDArray[np.float64]
    p: NDArray[np.float64]
    density: NDArray[np.float64]
    uv: NDArray[np.float64]


def area_map(
    spec: Texture, number: int, shapes: CompiledShapes, index: int, textures: Textures
) -> AreaMap | None:
    """The map of a lamp; None where its shape has no place in the unit square for each point.

    Parameters
    ----------
    spec : Texture
        Its radiance.
    number : int
        Index of the texture + 1 in the tables.
    shapes : CompiledShapes
    index : int
        Row of its shape.
    textures : Textures
    """
    lamp = _Lamp(spec, number, shapes, index, textures)
    if lamp.model.square is None:
        return None
    return lamp.of_formula() if lamp.model.has_formula else lamp.of_triangles()


def details(texture: Texture) -> NDArray[np.float64]:
    """How many texels, or details of that kind, a texture has per unit of u and of v."""
    if isinstance(texture, Composed):
        parts = [details(part) for part in texture.parts if isinstance(part, Texture)]
        return np.max([np.zeros(2), *parts], axis=0)
    matrix = texture.lookup()
    if matrix is None:
        return np.full(2, _DETAILS * float(texture.varies))
    pixels = getattr(texture, "pixels", None)
    size = _DETAILS * np.ones(2) if pixels is None else np.array([pixels.width, pixels.height])
    return np.max(np.abs(matrix[:, :2]) * size[:, None], axis=0)


@kernel
def _looked_up(scene, number, hit, o):
    """(radiance, surface) at a hit that starts where it ends."""
    d = o * 0.0 + Vec3(1.0, 1.0, 1.0)
    surface = surface_at_rest(scene, hit, o, d, hit.t == 0.0)
    return texture_value(scene, number, surface, o * 0.0), surface


class _Lamp:
    """One textured lamp and the kernels that look it up; the NumPy twin runs them."""

    def __init__(
        self, spec: Texture, number: int, shapes: CompiledShapes, index: int, textures: Textures
    ) -> None:
        kind = shapes.rows[index].kind
        self.model: ShapeModel = SHAPES[kind]
        self._index, self._number, self._areas = index, number, shapes.rows[index].areas
        self._details, self._facing = details(spec), np.pi
        self._scene = _Scene(shapes.tables, textures.tables)
        program = Program(
            shapes=(kind,), light_shapes=(kind,), textures=textures.names,
            registered=versions([spec]),
        )  # fmt: skip
        self._look = instantiate(_looked_up, program, compiled=False)
        self._triangle = instantiate(square_to_triangle, program, compiled=False)
        if self.model.has_formula:
            self._sample = instantiate(self.model.sample_area, program, compiled=False)
            at = int(shapes.tables.info.array[index * INFO + 3])
            self._facing = self.model.facing(shapes.tables.data.array[at:])[1]

    def points(self, prim: np.ndarray, x: np.ndarray, y: np.ndarray) -> _Points:
        """What is at the points (x, y) of the squares of some triangles; all (n,)."""
        bands = range(0, len(x), _BAND)
        with np.errstate(all="ignore"):
            found = [self._points(*(a[i : i + _BAND] for a in (prim, x, y))) for i in bands]
        return _Points(*(np.concatenate(columns) for columns in zip(*found, strict=True)))

    def _points(self, prim: np.ndarray, x: np.ndarray, y: np.ndarray) -> _Points:
        n, u2 = len(x), (x.astype(np.float32), y.astype(np.float32))
        zero, shape = np.zeros(n, np.float32), np.full(n, self._index, np.uint32)
        prim, p = prim.astype(np.uint32), Vec3(zero, zero, zero)
        if self.model.has_formula:
            s = self._sample(self._scene.shapes, View(zero), np.uint32(0), shape, zero, u2)
            u, v, p, density = s.u, s.v, s.p, s.pdf
        else:
            u, v = self._triangle(u2)
            density = 1.0 / self._areas[prim]
        hit = Hit(zero, u + zero, v + zero, shape, prim)
        color, surface = self._look(self._scene, shape * 0 + np.uint32(self._number), hit, p)
        here = surface.p
        found = color.x, color.y, color.z, here.x, here.y, here.z, surface.u, surface.v, density
        table = np.stack([np.broadcast_to(a, n).astype(np.float64) for a in found], axis=1)
        return _Points(table[:, :3], table[:, 3:6], table[:, 8], table[:, 6:8])

    def _fineness(self, prim: np.ndarray, side: int) -> NDArray[np.float64]:
        """Details along x and y of the square of each triangle: (n, 2)."""
        y, x = (np.mgrid[:side, :side] + 0.5) / side
        count, n = len(prim), side * side
        found = self.points(
            np.repeat(prim, n), np.tile(x.ravel(), count), np.tile(y.ravel(), count)
        )
        uv = found.uv.reshape(count, side, side, 2)
        across, up = np.abs(np.diff(uv, axis=2)), np.abs(np.diff(uv, axis=1))
        each = [(a @ self._details).reshape(count, -1) for a in (across, up)]
        # Seams of (u, v) are few.
        return np.stack([np.quantile(a, 0.9, axis=1) for a in each], axis=1) * side

    def of_formula(self) -> AreaMap:
        """Of a shape without triangles."""
        (columns, per_column), (rows, per_row) = map(
            _cells, self._fineness(np.zeros(1, int), _COARSE)[0]
        )
        m, n = columns * per_column, rows * per_row
        y, x = np.mgrid[:n, :m] + 0.5
        found = self.points(np.zeros(m * n, int), x.ravel() / m, y.ravel() / n)
        size = rows, per_row, columns, per_column
        weights, even, mean = _means(found, size)
        head = np.zeros(HEAD)
        middle = found.p.mean(axis=0)
        head[:2], head[4:] = (columns, rows), middle
        if self.model.KNOWS_VIEW:
            flat = self._facing == 0.0
            reach = np.max(np.sum((found.p - middle) ** 2, axis=1)) if flat else np.inf
            head[2:4] = min(_excess(weights, even), 0.5), reach
        else:
            head[2] = 1.0
        part = None if _is_even(weights, even) else _with_grid(head, weights, even)
        return AreaMap(mean, np.array([_brightness(mean)]), [part])

    def of_triangles(self) -> AreaMap:
        """Of a mesh."""
        prims = np.arange(len(self._areas))
        fine = self._fineness(prims, 2).max(axis=1)
        fine = np.clip(CELLS_PER_DETAIL * fine, 1.0, MOST_CELLS)
        sides = 2 ** np.ceil(np.log2(fine) - 1e-3).astype(int)
        while np.sum(4 * sides**2) > MOST_ON_MESH and sides.max() > 1:
            sides = np.minimum(sides, sides.max() // 2)
        brightness, means = np.zeros(len(prims)), np.zeros((len(prims), 3))
        parts: list[NDArray[np.float32] | None] = [None] * len(prims)
        for side in np.unique(sides):
            mine, per_cell = prims[sides == side], 4 if side == 1 else 2
            m = side * per_cell
            y, x = (np.mgrid[:m, :m] + 0.5) / m
            at = (
                np.repeat(mine, m * m),
                np.tile(x.ravel(), len(mine)),
                np.tile(y.ravel(), len(mine)),
            )
            found = self.points(*at)
            for k, prim in enumerate(mine):
                own = _Points(*(a[k * m * m : (k + 1) * m * m] for a in found))
                weights, even, means[prim] = _means(own, (side, per_cell, side, per_cell))
                brightness[prim] = _brightness(means[prim])
                if side > 1 and not _is_even(weights, even):
                    head = np.array([side, side, 1.0, 0.0, 0.0, 0.0, 0.0])
                    parts[prim] = _with_grid(head, weights, even)
        total = self._areas.sum()
        mean = tuple(self._areas @ means / total) if total > 0.0 else (0.0, 0.0, 0.0)
        # Dark triangles may have details that nobody has met.
        brightness = np.maximum(brightness, UNIT * _brightness(mean))
        return AreaMap(mean, brightness, parts)


def _cells(fineness: float) -> tuple[int, int]:
    """How many cells a side is cut into, and how many points each has along it."""
    wanted = max(1, int(np.ceil(CELLS_PER_DETAIL * fineness - 1e-2)))
    cells = -(-wanted // -(-wanted // MOST_CELLS))
    # A point for each texel.
    each = int(np.ceil((fineness - 1e-2) / cells))
    return cells, min(max(2, each, -(-LEAST_POINTS // cells)), MOST_POINTS // cells)


def _brightness(mean) -> float:
    return float(luminance(Vec3(*mean)))


def _means(found: _Points, size: tuple[int, int, int, int]):
    """Light of each cell, (rows, columns), that of an even lamp, and the mean radiance."""
    # A point stands for so much area.
    area = np.where(found.density > 0.0, 1.0 / np.where(found.density > 0.0, found.density, 1.0), 0)
    light = found.radiance * area[:, None]
    mean = light.sum(axis=0) / max(area.sum(), np.finfo(float).tiny)
    weights = np.asarray(luminance(Vec3(*light.T))).reshape(size).mean(axis=(1, 3))
    even = area.reshape(size).mean(axis=(1, 3)) * _brightness(mean)
    return weights, even, (float(mean[0]), float(mean[1]), float(mean[2]))


def _excess(weights: np.ndarray, even: np.ndarray) -> float:
    """Share of the light that exceeds that of an even lamp."""
    return float(np.maximum(weights - even, 0.0).sum() / max(even.sum(), np.finfo(float).tiny))


def _is_even(weights: np.ndarray, even: np.ndarray) -> bool:
    """Whether a map is not worth its time: it shines nearly evenly, or not at all.

    Even points make the mean square of a sample larger by Σ w² / e, over Σ w and with e of the same
    sum, for cells with the light w that would have e of an even lamp.
    """
    if weights.sum() <= 0.0:
        return True
    shining = even > 0.0
    squares = np.sum(weights[shining] ** 2 / even[shining])
    return bool(squares * even.sum() < LEAST_GAIN * weights.sum() ** 2)


def _with_grid(head: np.ndarray, weights: np.ndarray, even: np.ndarray) -> NDArray[np.float32]:
    # Every cell can be drawn: it may have details that nobody has met.
    tables = cumulative_grid(np.maximum(weights, UNIT * even))
    return np.concatenate([head, tables]).astype(np.float32)
