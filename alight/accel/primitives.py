"""The primitives that an acceleration structure is made from, as the host describes them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np


class TriangleSet(NamedTuple):
    """Triangles in world space.

    Attributes
    ----------
    vertices : (V, 3) float32, metres
    faces : (F, 3) int32
    shape, prim : (F,) uint32
        What a hit reports. Not finite triangles are left out.
    """

    vertices: np.ndarray
    faces: np.ndarray
    shape: np.ndarray
    prim: np.ndarray


class Analytic(NamedTuple):
    """A shape with a formula: its kind, shape number, row in the data, bounds in metres."""

    kind: str
    shape: int
    row: int
    low: Sequence[float]
    high: Sequence[float]


class Many(NamedTuple):
    """A shape of many primitives with one formula, numbered from 0 on.

    Attributes
    ----------
    kind : str
    shape : int
        Shape number.
    row, stride : int
        Row of the first primitive in the data, and how far the next one is.
    low, high : (n, 3) float32, metres
        Bounds of each.
    """

    kind: str
    shape: int
    row: int
    stride: int
    low: np.ndarray
    high: np.ndarray

    @property
    def rows(self) -> np.ndarray:
        """Row of each primitive in the data, (n,) uint32."""
        return (self.row + self.stride * np.arange(len(self.low))).astype(np.uint32)


class Unbounded(NamedTuple):
    """A shape with a formula and without bounds: its kind, shape number, row in the data."""

    kind: str
    shape: int
    row: int


class Instance(NamedTuple):
    """A placed copy of a geometry: its number, shape number, and 3x4 maps to the world and back."""

    geometry: int
    shape: int
    to_world: np.ndarray
    to_object: np.ndarray


class Moving(NamedTuple):
    """What moves while the shutter is open.

    Attributes
    ----------
    kind : str
        `alight.accel.layout.TRIANGLES` or a kind of `Analytic`.
    shape : int
        Shape number.
    row : int
        Row in the data, or number of the geometry.
    motion : int
        Number of the motion.
    low, high : (3,) float, metres
        Bounds over all times.
    """

    kind: str
    shape: int
    row: int
    motion: int
    low: Sequence[float]
    high: Sequence[float]


def finite(triangles: TriangleSet) -> TriangleSet:
    """Without the triangles that have an infinite or undefined corner: no ray can meet them."""
    good = np.asarray(np.isfinite(triangles.vertices).all(axis=1))
    if good.all():
        return triangles
    vertices = np.where(good[:, None], triangles.vertices, np.float32(0.0))
    return chosen(triangles._replace(vertices=vertices), good[triangles.faces].all(axis=1))


def in_order(triangles: TriangleSet) -> TriangleSet:
    """Sorted by (shape, prim), so that an index tells which of two hits at the same t counts."""
    key = triangles.shape.astype(np.uint64) << np.uint64(32) | triangles.prim.astype(np.uint64)
    if (key[1:] >= key[:-1]).all():
        return triangles
    return chosen(triangles, np.argsort(key, kind="stable"))


def chosen(triangles: TriangleSet, which: np.ndarray) -> TriangleSet:
    """Those in a mask, or in the order of a list of rows; no copy if it is all of them."""
    if which.dtype == bool and which.all():
        return triangles
    return TriangleSet(
        triangles.vertices, triangles.faces[which], triangles.shape[which], triangles.prim[which]
    )


#: Cosine of the angle between neighbours that count as flat: rays that meet both are rare then.
FLAT = 0.99


def first_of_pairs(corners: np.ndarray, ids: np.ndarray) -> np.ndarray:
    """Which triangles a, b, c are followed by a triangle a, c, d in (nearly) the same plane.

    Parameters
    ----------
    corners : (n, 3, 3) float32
    ids : (n, 2) uint32
        Shape and prim, ascending.

    Returns
    -------
    (n,) bool
        No triangle belongs to two pairs.
    """
    a, b, c = np.moveaxis(corners.astype(np.float64), 1, 0)
    normal = np.cross(b - a, c - a)
    with np.errstate(invalid="ignore", divide="ignore"):
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        fits = np.einsum("ij,ij->i", normal[:-1], normal[1:]) > FLAT
    fits &= (ids[:-1, 0] == ids[1:, 0]) & (corners[:-1, 0] == corners[1:, 0]).all(axis=1)
    fits &= (corners[:-1, 2] == corners[1:, 1]).all(axis=1)
    first = np.zeros(len(corners), bool)
    for i in np.flatnonzero(fits).tolist():
        first[i] = not first[i - 1]
    return first
