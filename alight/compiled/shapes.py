"""Placed shapes -> tables for kernels, and what the acceleration structure needs to know."""

from __future__ import annotations

from collections import Counter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from alight.accel.layout import TRIANGLES
from alight.accel.primitives import Many, Moving
from alight.compiled.instances import instance_in_place
from alight.compiled.kept import Kept
from alight.compiled.mesh_tables import (
    NO_FACES,
    MeshArrays,
    MeshRange,
    Triangles,
    joined,
    joined_if_any,
    joined_triangles,
    mesh_flags,
    triangle_areas,
    unit_normals,
)
from alight.compiled.motion import MotionTable
from alight.compiled.uv_sets import uv_shifts
from alight.core.errors import Issue, SceneError
from alight.scene.flatten import NO_GEOMETRY, FlatScene, PlacedShape
from alight.scene.motion import Motion
from alight.shapes.hit import FLIP, INFO, INSTANCED, PRIMITIVES, ShapeTables
from alight.shapes.model import MOST_NUMBERS, SHAPES
from lanewise.view import View

#: Copies of a shared mesh with at most this many triangles in all are stored one by one: a second
#: level of the hierarchy would cost more than the memory.
FEW_TRIANGLES = 64

#: Most shapes named in one message.
MOST_TOLD = 10


class CompiledShape(NamedTuple):
    """A row of the tables, as the compiler of lights needs it.

    Attributes
    ----------
    kind : str
    source : int
        Index into `FlatScene.shapes`; the six faces of a cube share one.
    areas : (n,) float64, m^2
        Of each triangle of a mesh that shines; of the shape itself otherwise; empty without bounds.
    """

    kind: str
    source: int
    areas: NDArray[np.float64]


class CompiledShapes(NamedTuple):
    """All shapes of a scene.

    Attributes
    ----------
    tables : ShapeTables
    triangles : Triangles
    analytic : list of (str, int, int, (3,) float32, (3,) float32)
        Kind, shape, offset of its row in the table, bounds in metres.
    unbounded : list of (str, int, int)
        Kind, shape and offset of shapes without bounds.
    moving : list of Moving
        What moves while the shutter is open, of all kinds.
    many : list of Many
        Shapes of many primitives.
    motions : list of int
        Of each shape the number of its motion + 1, 0 where it rests.
    instances : list of (int, int, (3, 4) float32, (3, 4) float32)
        Index into `geometries`, shape, object to world, world to object.
    geometries : list of ((V, 3) float32, (F, 3) int32)
        Shared meshes in object space.
    rows : list of CompiledShape
        One a shape of the tables.
    kinds : tuple of str
        Kinds that occur, for `Program.shapes`.
    center, radius : (3,) float64 and float, metres
        Sphere around all finite shapes; radius 1 around the origin if there are none.
    lowest : float or None, metres
        Height of their lowest point.
    extents : list of (int, (3,), (3,))
        Row and bounds, metres, of each shape that has bounds, wherever it moves.
    """

    tables: ShapeTables
    triangles: Triangles
    analytic: list[tuple[str, int, int, NDArray[np.float32], NDArray[np.float32]]]
    unbounded: list[tuple[str, int, int]]
    instances: list[tuple[int, int, NDArray[np.float32], NDArray[np.float32]]]
    geometries: list[tuple[NDArray[np.float32], NDArray[np.int32]]]
    rows: list[CompiledShape]
    kinds: tuple[str, ...]
    center: NDArray[np.float64]
    radius: float
    lowest: float | None
    moving: list[Moving]
    motions: list[int]
    many: list[Many]
    extents: list[tuple[int, NDArray[Any], NDArray[Any]]]

    def boxes(self) -> list[tuple[int, NDArray[np.float32], NDArray[np.float32]]]:
        """Number and bounds, metres, of each shape with a formula and bounds that rests."""
        alone = [(index, low, high) for _, index, _, low, high in self.analytic]
        return alone + [(m.shape, m.low.min(axis=0), m.high.max(axis=0)) for m in self.many]


def compile_shapes(
    flat: FlatScene, paths: MotionTable | None = None, *, uv_sets: bool = False,
    kept: Kept | None = None,
) -> CompiledShapes:  # fmt: skip
    """Make the tables of all shapes; the light of a shape is entered by `compile_lights`.

    Parameters
    ----------
    flat : FlatScene
    paths : MotionTable, optional
        Numbers the motions.
    uv_sets : bool
        Whether textures name further sets of coordinates; else these are not kept.
    kept : Kept, optional
        Of the compilation before.

    Raises
    ------
    SceneError
        For shapes that are too small, too large or too flat for float32.
    """
    compiler = _Compiler(flat, paths or MotionTable(), kept or Kept())
    issues = []
    for source, placed in enumerate(flat.shapes):
        try:
            with np.errstate(over="raise", divide="raise", invalid="raise"):
                compiler.place(source, placed)
        except (FloatingPointError, np.linalg.LinAlgError):
            issues.append(Issue(placed.name, _out_of_range(placed)))
            if len(issues) == MOST_TOLD:
                break
    if issues:
        raise SceneError(issues)
    return compiler.finish(uv_sets)


def _out_of_range(placed: PlacedShape) -> str:
    scales = np.linalg.svd(placed.to_world[:3, :3], compute_uv=False)
    return (
        "is too small, too large or too flat for numbers of float32: keep sizes between 1e-12 m "
        f"and 1e12 m; its transforms scale by {scales.min():.3g} to {scales.max():.3g}"
    )


class _Compiler:
    def __init__(self, flat: FlatScene, paths: MotionTable, kept: Kept):
        self.flat, self.paths, self.known = flat, paths, kept.each("instances in place")
        self.moving: list[Moving] = []
        self.many: list[Many] = []
        self.motions: list[int] = []
        self.info: list[list[int]] = []
        self.data: list[np.ndarray] = []
        self.offset = 0
        self.arrays = MeshArrays()
        self.rows: list[CompiledShape] = []
        self.triangles: list[tuple[np.ndarray, np.ndarray, int]] = []
        self.analytic: list[tuple[str, int, int, np.ndarray, np.ndarray]] = []
        self.unbounded: list[tuple[str, int, int]] = []
        self.instances: list[tuple[int, int, np.ndarray, np.ndarray]] = []
        self.geometries: list[tuple[np.ndarray, np.ndarray]] = []
        self.ranges: dict[int, tuple[int, MeshRange]] = {}
        self.moving_ranges: dict[tuple[int, bytes], tuple[int, MeshRange, np.ndarray]] = {}
        self.extents: list[tuple[int, np.ndarray, np.ndarray]] = []
        self.numbers: dict[str, int] = {}
        self.shared = self._find_shared()

    def _find_shared(self) -> set[int]:
        """Geometries that are kept once for several instances."""
        uses = Counter(s.geometry for s in self.flat.shapes if s.light is None and s.motion is None)
        return {
            index
            for index, count in uses.items()
            if index >= 0
            and count > 1
            and count * len(self.flat.geometries[index].faces) > FEW_TRIANGLES
        }

    def place(self, source: int, placed: PlacedShape) -> None:
        """Enter one shape."""
        if placed.geometry != NO_GEOMETRY:
            if placed.motion is not None:
                self._place_moving_mesh(source, placed)
            elif placed.geometry in self.shared and placed.light is None:
                self._place_instance(source, placed)
            else:
                self._place_mesh(source, placed)
            return
        parts = placed.shape.parts()
        for part, place in parts:
            self._place_analytic(source, placed, part, placed.to_world @ place)
        if not parts:
            self._place_analytic(source, placed, placed.shape, placed.to_world)

    def _enter(
        self,
        kind: str,
        source: int,
        placed: PlacedShape,
        row: np.ndarray,
        flags: int,
        areas: np.ndarray,
        place: MeshRange = NO_FACES,
    ) -> int:
        """Append a row to the tables and return its index."""
        index = len(self.rows)
        if kind not in self.numbers:
            self.numbers[kind] = SHAPES[kind].number
        self.info.append([self.numbers[kind], placed.bsdf, 0, self.offset, flags, *place])
        self.data.append(row)
        self.offset += row.size
        self.rows.append(CompiledShape(kind, source, areas))
        self.motions.append(self.paths.number(placed.motion))
        return index

    def _place_analytic(
        self, source: int, placed: PlacedShape, shape: Any, matrix: np.ndarray
    ) -> None:
        kind = shape.type_name()
        model, offset = SHAPES[kind], self.offset
        assert model.pack is not None
        row = model.pack(shape, matrix)
        if model.is_many:
            self._place_many(source, placed, row)
            return
        if row.size > MOST_NUMBERS:
            text = f"the row of a {kind} must hold at most {MOST_NUMBERS} numbers, got {row.size}"
            raise SceneError([Issue(placed.name, text)])
        flags = FLIP if shape.flip_normals else 0
        if model.area is None or model.bounds is None:
            index = self._enter(kind, source, placed, row, flags, np.zeros(0))
            self.unbounded.append((kind, index, offset))
            return
        index = self._enter(kind, source, placed, row, flags, np.array([model.area(row)]))
        low, high = model.bounds(row)
        if placed.motion is not None:
            self._move(kind, index, offset, placed.motion, low, high)
            return
        self._grow(low, high)
        self.analytic.append((kind, index, offset, low, high))

    def _place_many(self, source: int, placed: PlacedShape, rows: np.ndarray) -> None:
        """Enter a shape of many primitives, whose rows are known."""
        kind, offset, count = placed.shape.type_name(), self.offset, len(rows)
        model = SHAPES[kind]
        assert model.area is not None
        assert model.extremes is not None
        if count >= 1 << 24:
            text = f"must have fewer than {1 << 24} segments, got {count}: make several of it"
            raise SceneError([Issue(placed.name, text)])
        flags, areas = count << PRIMITIVES, np.array([model.area(rows)])
        index = self._enter(kind, source, placed, rows.ravel(), flags, areas)
        low, high = (side.astype(np.float32) for side in model.extremes(rows, np.eye(3)))
        self._grow(low.min(axis=0), high.max(axis=0))
        self.many.append(Many(kind, index, offset, rows.shape[1], low, high))

    def _move(
        self, kind: str, index: int, row: int, motion: Motion, low: np.ndarray, high: np.ndarray
    ) -> None:
        """Enter what moves: bounds before the motion."""
        low, high = motion.bounds(low, high)
        low, high = low.astype(np.float32), high.astype(np.float32)
        self._grow(low, high)
        self.moving.append(Moving(kind, index, row, self.paths.number(motion) - 1, low, high))

    def _add_mesh(self, placed: PlacedShape) -> tuple[np.ndarray, MeshRange]:
        """Append a mesh where it is placed: its vertices, and where they are."""
        mesh = self.flat.geometries[placed.geometry]
        matrix = placed.to_world[:3, :3]
        vertices = (mesh.vertices @ matrix.T + placed.to_world[:3, 3]).astype(np.float32)
        normals = unit_normals(mesh)
        if normals is not None:
            # By the inverse transpose. Kernels normalise after interpolation, as for instances;
            # the factor keeps numbers in range.
            inverse = np.linalg.inv(matrix) * np.cbrt(abs(np.linalg.det(matrix)))
            normals = (normals @ inverse).astype(np.float32)
        return vertices, self.arrays.add(vertices, normals, mesh)

    def _enter_mesh(
        self, source: int, placed: PlacedShape, vertices: np.ndarray, place: MeshRange
    ) -> int:
        """Append the row of such a mesh."""
        mesh = self.flat.geometries[placed.geometry]
        # A mirror image reverses the order of the vertices, not the outer side.
        mirrored = bool(np.linalg.det(placed.to_world[:3, :3]) < 0.0)
        flags = mesh_flags(mesh, placed.shape.flip_normals != mirrored)
        # Float64 corners of a big mesh would be the largest array of all.
        areas = np.zeros(0) if placed.light is None else triangle_areas(vertices, mesh.faces)
        index = self._enter(
            placed.shape.type_name(), source, placed, np.zeros(0, np.float32), flags, areas, place
        )
        self.info[index][3] = 0
        return index

    def _place_moving_mesh(self, source: int, placed: PlacedShape) -> None:
        """Enter a mesh with a tree of its own; those that begin alike share it."""
        assert placed.motion is not None
        key = placed.geometry, (placed.to_world + 0.0).tobytes()
        if key not in self.moving_ranges:
            vertices, place = self._add_mesh(placed)
            self.moving_ranges[key] = len(self.geometries), place, vertices
            self.geometries.append((vertices, self.flat.geometries[placed.geometry].faces))
        number, place, vertices = self.moving_ranges[key]
        index = self._enter_mesh(source, placed, vertices, place)
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        self._move(TRIANGLES, index, number, placed.motion, low, high)

    def _place_mesh(self, source: int, placed: PlacedShape) -> None:
        mesh = self.flat.geometries[placed.geometry]
        vertices, place = self._add_mesh(placed)
        index = self._enter_mesh(source, placed, vertices, place)
        self._grow(vertices.min(axis=0), vertices.max(axis=0))
        self.triangles.append((vertices, mesh.faces, index))

    def _place_instance(self, source: int, placed: PlacedShape) -> None:
        mesh = self.flat.geometries[placed.geometry]
        if placed.geometry not in self.ranges:
            place = self.arrays.add(mesh.vertices, unit_normals(mesh), mesh)
            self.ranges[placed.geometry] = len(self.geometries), place
            self.geometries.append((mesh.vertices, mesh.faces))
        number, place = self.ranges[placed.geometry]
        found = self.known(instance_in_place, mesh.vertices, placed.to_world)
        # Kernels turn the normals of object space by the inverse transpose, which keeps the side.
        flags = mesh_flags(mesh, placed.shape.flip_normals) | INSTANCED
        kind = placed.shape.type_name()
        index = self._enter(kind, source, placed, found.row, flags, np.zeros(0), place)
        self._grow(found.low, found.high)
        self.instances.append((number, index, found.forward, found.backward))

    def _grow(self, low: np.ndarray, high: np.ndarray) -> None:
        self.extents.append((len(self.rows) - 1, low, high))

    def finish(self, uv_sets: bool) -> CompiledShapes:
        """Join all parts."""
        arrays = self.arrays
        info = np.array(self.info or [[0] * INFO], np.uint32)
        shifts, further = np.zeros(1, np.uint32), []
        if uv_sets:
            shifts = uv_shifts(info, arrays.further, arrays.vertex_count)
            further = [table for sets in arrays.further.values() for table in sets]
        # Zeros after the last row: a lane that reads another kind of row stays inside the table.
        data = np.concatenate([*self.data, np.zeros(MOST_NUMBERS)]).astype(np.float32)
        tables = ShapeTables(
            info=View(info),
            data=View(data),
            faces=View(joined(arrays.faces, 3, np.uint32)),
            vertices=View(joined(arrays.vertices, 3, np.float32)),
            normals=View(joined_if_any(arrays.normals, 3)),
            uvs=View(joined_if_any([*arrays.uvs, *further], 2)),
            colors=View(joined_if_any(arrays.colors, 3)),
            uv_shifts=View(shifts),
        )
        kinds = {row.kind for row in self.rows}
        low = np.min([np.full(3, np.inf), *(low for _, low, _ in self.extents)], axis=0)
        high = np.max([np.full(3, -np.inf), *(high for _, _, high in self.extents)], axis=0)
        empty = not np.isfinite(low).all()
        lowest = None if empty else float(low[1])
        low, high = (np.zeros(3), np.zeros(3)) if empty else (low, high)
        radius = 0.5 * float(np.linalg.norm(high - low))
        return CompiledShapes(
            tables=tables,
            triangles=joined_triangles(self.triangles),
            analytic=self.analytic,
            unbounded=self.unbounded,
            instances=self.instances,
            geometries=self.geometries,
            rows=self.rows,
            kinds=tuple(name for name in SHAPES if name in kinds),
            center=0.5 * (low + high),
            radius=radius if radius > 0.0 else 1.0,
            lowest=lowest,
            moving=self.moving,
            motions=self.motions,
            many=self.many,
            extents=self.extents,
        )
