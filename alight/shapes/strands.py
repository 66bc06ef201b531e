"""Shapes made of strands: their arrays as fields, and their cubics as Bezier segments."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, Literal, NamedTuple, Self

import numpy as np
from numpy.typing import DTypeLike, NDArray
from pydantic import model_validator
from pydantic_core import core_schema

from alight.core.fields import invalid
from alight.shapes.arrays import ArrayShape, Points

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Column:
    """A list of numbers of one kind; metadata of a field type.

    Parameters
    ----------
    dtype : dtype
    least : float
        The least number allowed.
    spread : bool
        Whether a number alone stands for a list of one.
    """

    dtype: DTypeLike
    least: float
    spread: bool = False

    def check(self, value: object) -> np.ndarray:
        """Return a read-only copy of shape (n,)."""
        try:
            column = np.asarray(value)
        except ValueError:  # a list of lists of different lengths
            column = np.zeros((), object)
        if column.dtype == np.float16:  # where the largest number allowed is infinite
            column = column.astype(np.float32)
        whole = np.issubdtype(self.dtype, np.integer)
        if self.spread and column.ndim == 0 and not isinstance(value, bool):
            column = column.reshape(1)
        if column.ndim != 1 or column.dtype.kind not in "iuf" or column.size == 0:
            noun = "whole numbers" if whole else "numbers"
            either = "a number or " if self.spread else ""
            is_array = column.ndim and not isinstance(value, str)
            found = f"shape {column.shape}" if is_array else type(value).__name__
            raise invalid(f"must be {either}a list of {noun}, got {found}")
        most = np.iinfo(self.dtype).max if whole else 1e15
        bad = ~((column >= self.least) & (column <= most))
        if whole:
            bad |= column != np.floor(column)
        if bad.any():
            place = int(bad.argmax())
            raise invalid(
                f"must be in [{self.least:g}, {most:g}], got {column[place]} at place {place}"
            )
        column = np.array(column, self.dtype)
        column.setflags(write=False)
        return column

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        """Use `check` alone."""
        return core_schema.no_info_plain_validator_function(self.check)


Radii = Annotated[NDArray[np.float32], Column(np.float32, 0.0, spread=True)]
Counts = Annotated[NDArray[np.int32], Column(np.int32, 2)]
Basis = Literal["linear", "bezier", "b_spline", "catmull_rom"]

#: Control points of a segment, and how many of them the next segment does not share.
DEGREE = {"linear": 1, "bezier": 3, "b_spline": 3, "catmull_rom": 3}
STEP = {"linear": 1, "bezier": 3, "b_spline": 1, "catmull_rom": 1}

#: From four control points in a row to those of Bezier's.
TO_BEZIER = {
    "bezier": np.eye(4),
    "b_spline": np.array([[1, 4, 1, 0], [0, 4, 2, 0], [0, 2, 4, 0], [0, 1, 4, 1]]) / 6.0,
    "catmull_rom": np.array([[0, 6, 0, 0], [-1, 6, 1, 0], [0, 1, 6, -1], [0, 0, 6, 0]]) / 6.0,
}

#: Bezier's from the two ends of a straight segment.
_STRAIGHT = np.array([[3, 0], [2, 1], [1, 2], [0, 3]]) / 3.0


class StrandShape(ArrayShape):
    """Base class of shapes made of strands, from arrays or a file."""

    file: str | None = None
    points: Points | None = None
    radii: Radii | None = None
    counts: Counts | None = None
    basis: Basis = "b_spline"

    @model_validator(mode="after")
    def _makes_strands(self) -> Self:
        if self.flip_normals:
            raise invalid("flip_normals must be false: strands are met from outside only")
        given = [name for name in ("points", "radii", "counts") if getattr(self, name) is not None]
        if self.file is not None:
            if given:
                raise invalid(f"takes either file or arrays, got file and {', '.join(given)}")
            return self
        if self.points is None or self.radii is None:
            raise invalid("needs a file, or points and radii")
        self._check_lengths(self.points, self.radii)
        return self

    def _check_lengths(self, points: np.ndarray, radii: np.ndarray) -> None:
        n = len(points)
        if len(radii) not in (1, n):
            raise invalid(f"radii must be one number or one a point ({n}), got {len(radii)}")
        counts = np.array([n]) if self.counts is None else self.counts.astype(np.int64)
        if counts.sum() != n:
            raise invalid(f"counts must sum up to the number of points, {n}, got {counts.sum()}")
        degree, step = DEGREE[self.basis], STEP[self.basis]
        bad = (counts <= degree) | ((counts - 1 - degree) % step != 0)
        if bad.any():
            place = int(bad.argmax())
            wanted = "4, 7, 10, ..." if step == 3 else f"at least {degree + 1}"
            text = f"strands of basis {self.basis} have {wanted} points"
            raise invalid(f"{text}, got {counts[place]} in strand {place}")


class Segments(NamedTuple):
    """Strands in pieces.

    Attributes
    ----------
    points : (n, 4, 4) float64
        Control points of Bezier's, and their radii, metres.
    first, span : (n,) float64
        Where each begins on its strand, as a part of that, and how much of it it is.
    strand : (n,) int64
        Ascending.
    """

    points: Array
    first: Array
    span: Array
    strand: NDArray[np.int64]


def segments(spec: StrandShape, matrix: np.ndarray) -> Segments:
    """The cubics of strands in the world; radii grow as the third root of the volume does.

    Parameters
    ----------
    spec : StrandShape
        With arrays.
    matrix : (4, 4) float64
        Object to world.
    """
    assert spec.points is not None
    assert spec.radii is not None
    placed = spec.points.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
    growth = np.cbrt(abs(np.linalg.det(matrix[:3, :3])))
    radii = np.broadcast_to(spec.radii.astype(np.float64) * growth, len(placed))
    rows = np.concatenate([placed, radii[:, None]], axis=1)
    counts = np.array([len(rows)]) if spec.counts is None else spec.counts.astype(np.int64)
    degree, step = DEGREE[spec.basis], STEP[spec.basis]
    each = (counts - 1 - degree) // step + 1
    strand = np.repeat(np.arange(len(counts)), each)
    number = np.arange(len(strand)) - np.repeat(np.cumsum(each) - each, each)
    first = np.repeat(np.cumsum(counts) - counts, each) + step * number
    taken = rows[first[:, None] + np.arange(degree + 1)]
    to_bezier = _STRAIGHT if spec.basis == "linear" else TO_BEZIER[spec.basis]
    share = 1.0 / np.repeat(each, each)
    return Segments(to_bezier @ taken, number * share, share, strand)


def halved(parts: Segments, chosen: NDArray[np.bool_]) -> Segments:
    """The chosen segments in two each, by de Casteljau's construction."""
    p = parts.points[chosen]
    a, b, c = (0.5 * (p[:, i] + p[:, i + 1]) for i in range(3))
    d, e = 0.5 * (a + b), 0.5 * (b + c)
    middle = 0.5 * (d + e)
    times = np.where(chosen, 2, 1)
    left = (np.cumsum(times) - times)[chosen]
    points, first, span, strand = (np.repeat(column, times, axis=0) for column in parts)
    points[left] = np.stack([p[:, 0], a, d, middle], axis=1)
    points[left + 1] = np.stack([middle, e, c, p[:, 3]], axis=1)
    span[left] *= 0.5
    span[left + 1] *= 0.5
    first[left + 1] += span[left + 1]
    return Segments(points, first, span, strand)
