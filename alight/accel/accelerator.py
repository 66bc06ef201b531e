"""The acceleration structure of a whole scene: which primitives go into lists, which into the tree.

A list costs every ray some time for every entry, but less than a nanosecond each, as a packet works
on all its lanes together. A tree costs a ray some fifty nanoseconds at least, and hardly more for a
million triangles. So a small scene is all lists; in a big one the few primitives that most rays
would meet anyway (walls, floor) are, and the rest is one tree.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from alight.accel.forest import Forest, placed, placed_boxes
from alight.accel.kept import own_box
from alight.accel.layout import LIST, MOVING_LIST, TRIANGLES, kinds_in_order, number_of
from alight.accel.lists import PAIRS, Accelerator
from alight.accel.moving import MOVING_ROW, MovingAccelerator
from alight.accel.primitives import (
    Analytic,
    Instance,
    Many,
    Moving,
    TriangleSet,
    Unbounded,
    chosen,
    finite,
    first_of_pairs,
    in_order,
)
from lanewise.view import View

#: Most primitives in lists altogether.
LIST_LIMIT = 64

#: Beside a tree a list takes only what covers this part of the scene's box surface or more.
BIG = 0.02


def build_accelerator(
    triangles: TriangleSet | None = None,
    analytic: Sequence = (),
    unbounded: Sequence = (),
    instances: Sequence = (),
    geometries: Sequence[tuple[np.ndarray, np.ndarray]] = (),
    moving: Sequence = (),
    many: Sequence = (),
    *,
    builder: str = "sah",
    structure: str = "auto",
    threads: int = 1,
) -> tuple[Accelerator | MovingAccelerator, tuple[str, ...], dict[str, Any]]:
    """Sort a scene's primitives into lists and a tree.

    Parameters
    ----------
    triangles : TriangleSet, optional
    analytic : sequence of Analytic
    unbounded : sequence of Unbounded
    instances : sequence of Instance
    geometries : sequence of (vertices (V, 3) float32, faces (F, 3) int32)
        Meshes in their own space.
    moving : sequence of Moving
    many : sequence of Many
    builder : {"sah", "median"}
        How the tree is divided.
    structure : {"auto", "list", "bvh", "none"}
        "list": every primitive is tested, instances are written out (the oracle of tests; runs in
        the NumPy twin). "bvh": everything with bounds goes into the tree. "none": nothing is met.
    threads : int
        For the build.

    Returns
    -------
    accelerator : Accelerator or MovingAccelerator
    plan : tuple of str
        What kernels specialise on (``Program.accel``).
    stats : dict
        ``triangles``, ``listed``, ``nodes``, ``blocks``, ``leaves``, ``depth``, ``sah_cost``,
        ``bytes``, ``seconds``.
    """
    begin = time.perf_counter()
    if structure == "none":
        triangles, analytic, unbounded, instances, geometries, moving, many = None, *[()] * 6
    sorter = _Sorter(triangles, analytic, unbounded, instances, geometries, moving, many)
    if structure == "list":
        sorter.list_everything()
    elif structure == "auto":
        sorter.list_the_big()
    elif structure not in ("bvh", "none"):
        text = f'structure must be "auto", "list", "bvh" or "none", got {structure!r}'
        raise ValueError(text)
    # What the oracle tests one by one stays so.
    accelerator, plan, stats = sorter.finish(builder, threads, in_pairs=structure == "auto")
    stats["seconds"] = time.perf_counter() - begin
    return accelerator, plan, stats


class _Sorter:
    """Primitives on their way into lists or the tree."""

    def __init__(self, triangles, analytic, unbounded, instances, geometries, moving, many=()):
        if triangles is None:
            triangles = TriangleSet(
                np.zeros((0, 3), np.float32),
                np.zeros((0, 3), np.int32),
                np.zeros(0, np.uint32),
                np.zeros(0, np.uint32),
            )
        self.triangles = in_order(finite(triangles))
        self.analytic = sorted((Analytic(*a) for a in analytic), key=lambda a: a.shape)
        self.unbounded = sorted((Unbounded(*u) for u in unbounded), key=lambda u: u.shape)
        self.instances = sorted((Instance(*i) for i in instances), key=lambda i: i.shape)
        self.geometries = [
            (np.ascontiguousarray(v, np.float32), np.ascontiguousarray(f, np.int32))
            for v, f in geometries
        ]
        self.moving = sorted((Moving(*m) for m in moving), key=lambda m: m.shape)
        self.many = sorted((Many(*m) for m in many), key=lambda m: m.shape)
        self.listed_many: list[Many] = []
        self.listed = np.zeros(len(self.triangles.faces), bool)
        self.listed_analytic = np.zeros(len(self.analytic), bool)
        self.listed_moving: list[Moving] = []
        self.flattened: list[TriangleSet] = []

    # ---- what goes into lists

    def list_everything(self) -> None:
        """Everything into lists, instances as triangles in world space."""
        self.listed[:] = True
        self.listed_analytic[:] = True
        for one in self.instances:
            vertices, faces = self.geometries[one.geometry]
            self.flattened.append(placed(one, vertices, faces))
        self.instances = []
        self._list_moving()
        self.listed_many, self.many = self.many, []

    def _list_moving(self) -> None:
        self.listed_moving, self.moving = self.moving, []

    def list_the_big(self) -> None:
        """Small scenes into lists; of big ones the few primitives that cover much of the scene."""
        total = len(self.triangles.faces) + len(self.analytic)
        total += sum(
            len(self.geometries[m.row][1]) if m.kind == TRIANGLES else 1 for m in self.moving
        )
        # A list tests what is one of many piece by piece: those are for trees.
        if total <= LIST_LIMIT and not self.instances and not self.many:
            self.listed[:] = True
            self.listed_analytic[:] = True
            self._list_moving()
            return
        room = LIST_LIMIT
        for area, count, is_mesh, first in sorted(self._candidates(), reverse=True):
            if area < BIG or count > room:
                continue
            room -= count
            if is_mesh:
                self.listed[first : first + count] = True
            else:
                self.listed_analytic[first] = True

    def _candidates(self) -> list[tuple[float, int, bool, int]]:
        """(part of the scene's surface, primitives, is it a mesh, first one) of small shapes."""
        boxes = [(np.asarray(a.low, float), np.asarray(a.high, float)) for a in self.analytic]
        entries = [(1, False, k) for k in range(len(boxes))]
        _, firsts, counts = np.unique(self.triangles.shape, return_index=True, return_counts=True)
        for first, count in zip(firsts.tolist(), counts.tolist(), strict=True):
            if count <= LIST_LIMIT:
                points = self.triangles.vertices[self.triangles.faces[first : first + count]]
                boxes.append((points.min(axis=(0, 1)), points.max(axis=(0, 1))))
                entries.append((count, True, first))
        whole = _half_area(*self._bounds())
        return [
            (_half_area(*box) / whole if whole > 0.0 else 0.0, *entry)
            for box, entry in zip(boxes, entries, strict=True)
        ]

    def _bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Box of everything that has one, metres."""
        parts = [np.asarray([a.low, a.high], float) for a in self.analytic]
        used = {i.geometry for i in self.instances if len(self.geometries[i.geometry][1])}
        boxes = {g: own_box(*self.geometries[g]) for g in used}
        shown = [i for i in self.instances if i.geometry in used]
        parts.append(placed_boxes(shown, boxes).reshape(-1, 3))
        parts += [np.asarray([m.low, m.high], float) for m in self.moving]
        parts += [np.array([m.low.min(axis=0), m.high.max(axis=0)], float) for m in self.many]
        if len(self.triangles.faces):
            vertices = self.triangles.vertices
            parts.append(np.asarray([vertices.min(axis=0), vertices.max(axis=0)], float))
        stacked = np.concatenate(parts)
        return stacked.min(axis=0), stacked.max(axis=0)

    # ---- the result

    def finish(self, builder: str, threads: int, in_pairs: bool):
        """The accelerator, its plan, and figures about it."""
        lists: dict[str, list[tuple[int, ...]]] = {}
        for a, listed in zip(self.analytic, self.listed_analytic, strict=True):
            if listed:
                lists.setdefault(a.kind, []).append((a.shape, a.row))
        for kind, shape, row in self.unbounded:
            lists.setdefault(kind, []).append((shape, row))
        for one in self.listed_many:
            rows = enumerate(one.rows.tolist())
            lists.setdefault(one.kind, []).extend((one.shape, row, prim) for prim, row in rows)
        plan = list(kinds_in_order(set(lists)))
        shapes = _joined([np.array(lists[kind], np.uint32).reshape(-1) for kind in plan])
        corners, ids = self._listed_triangles()
        first = first_of_pairs(corners, ids) if in_pairs else np.zeros(len(ids), bool)
        alone = ~first & ~np.roll(first, 1)
        second = np.roll(first, 1)
        plan += [PAIRS] if first.any() else []
        plan += [TRIANGLES] if alone.any() else []
        forest = Forest(
            chosen(self.triangles, ~self.listed),
            [
                a
                for a, listed in zip(self.analytic, self.listed_analytic, strict=True)
                if not listed
            ],
            self.instances,
            self.geometries,
            self.moving,
            self.many,
        )
        tree, box, tree_plan, stats = forest.build(builder, threads)
        count = len(ids) + sum(len(rows) for rows in lists.values())
        accelerator = Accelerator(
            shapes,
            triangles=_corner_table(corners[alone]),
            triangle_ids=View(ids[alone].reshape(-1)),
            pairs=_corner_table(np.hstack([corners[first], corners[second, 2:]])),
            pair_ids=View(np.hstack([ids[first], ids[second, 1:]]).reshape(-1)),
            tree=tree,
            box=box,
        )
        if self.moving or self.listed_moving:
            accelerator = MovingAccelerator(*accelerator, *self._moving_tables())
            kinds = {m.kind for m in self.listed_moving}
            moving_plan = (f"{MOVING_LIST} {kind}" for kind in kinds_in_order(kinds))
            tree_plan = (*moving_plan, *tree_plan)
        return (
            accelerator,
            (*(f"{LIST} {kind}" for kind in plan), *tree_plan),
            {"listed": count, "triangles": len(self.triangles.faces), **stats},
        )

    def _moving_tables(self) -> tuple[View, View]:
        """The list of what moves, and the corners of its meshes, each once."""
        firsts, corners = {}, []
        rows = np.zeros((len(self.listed_moving), MOVING_ROW), np.uint32)
        for row, one in zip(rows, self.listed_moving, strict=True):
            first, count = one.row, 0
            if one.kind == TRIANGLES:
                vertices, faces = self.geometries[one.row]
                if one.row not in firsts:
                    firsts[one.row] = sum(len(part) for part in corners)
                    corners.append(vertices[faces].reshape(-1, 9))
                first, count = firsts[one.row], len(faces)
            row[:] = number_of(one.kind), one.shape, one.motion, first, count
        joined = np.concatenate(corners or [np.zeros((0, 9), np.float32)]).astype(np.float32)
        return View(rows.reshape(-1)), _corner_table(joined)

    def _listed_triangles(self) -> tuple[np.ndarray, np.ndarray]:
        """Corners (n, 3, 3) float32, metres, and (shape, prim) of triangles in lists, in order."""
        listed = [chosen(self.triangles, self.listed), *self.flattened]
        corners = np.concatenate([t.vertices[t.faces] for t in listed]).astype(np.float32)
        ids = np.concatenate([np.stack([t.shape, t.prim], axis=1) for t in listed])
        order = np.lexsort((ids[:, 1], ids[:, 0]))
        return corners[order], ids[order].astype(np.uint32)


def _joined(lists: list[np.ndarray]) -> View:
    """Where each list starts and the last one ends, then the lists."""
    ends = np.cumsum([len(lists) + 1, *map(len, lists)]).astype(np.uint32)
    return View(np.concatenate([ends, *lists]))


def _corner_table(corners: np.ndarray) -> View:
    """Corners as kernels read them; one number more, as the last corner is read as four."""
    return View(np.append(corners.reshape(-1), np.float32(0.0)))


def _half_area(low: np.ndarray, high: np.ndarray) -> float:
    x, y, z = (float(e) for e in np.asarray(high, float) - np.asarray(low, float))
    return x * y + y * z + z * x
