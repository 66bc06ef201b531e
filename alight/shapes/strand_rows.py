"""Strands as rows of primitives: tubes along cubics, and balls at the joints of straight lines.

What the numbers of a row mean says `alight.shapes.curves`.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from alight.core.constants import TWO_PI
from alight.shapes.strands import Segments, StrandShape, halved, segments
from alight.shapes.tube import BEYOND, PIECES

STRIDE = 24

SLACK, IS_BALL, TEXTURE, SPAN, AXIS = 16, 17, 18, 19, 20

#: Of balls: the directions of the segments before and after; 0 where there is none.
BEFORE, AFTER = 8, 12

#: What is longer than this many radii is halved, up to `HALVINGS` times, as long as there are at
#: most `MOST_HALVED` segments: short ones have small boxes.
SLENDER, HALVINGS, MOST_HALVED = 12.0, 2, 1 << 20

#: Coefficients of 1, u, u^2, u^3 from Bezier's control points.
_TO_POWERS = np.array([[1, 0, 0, 0], [-3, 3, 0, 0], [3, -6, 3, 0], [-1, 3, -3, 1]], float)

_FROM_POWERS = np.linalg.inv(_TO_POWERS)

#: Rows that are looked at together, to save memory.
_CHUNK = 1 << 16

#: Places and weights of Gauss's quadrature on [-1, 1].
_GAUSS = np.polynomial.legendre.leggauss(8)


def rows_of(spec: StrandShape, matrix: np.ndarray) -> np.ndarray:
    """The rows of the table, (n, STRIDE), from the (4, 4) float64 matrix, object to world."""
    parts = segments(spec, np.asarray(matrix, np.float64))
    axes = _axes(parts)
    if spec.basis == "linear":
        return np.concatenate([_tubes(parts, axes), _balls(parts, axes)])
    for _ in range(HALVINGS):
        if len(parts.points) <= MOST_HALVED:
            parts = halved(parts, _is_slender(parts))
    return _tubes(parts, axes)


def _is_slender(parts: Segments) -> np.ndarray:
    lengths = np.linalg.norm(parts.points[:, 3, :3] - parts.points[:, 0, :3], axis=1)
    return lengths > SLENDER * parts.points[:, :, 3].max(axis=1)


def _tubes(parts: Segments, axes: np.ndarray) -> np.ndarray:
    rows = np.zeros((len(parts.points), STRIDE), np.float32)
    powers = _TO_POWERS @ parts.points
    rows[:, :16] = powers.reshape(-1, 16)
    bends = np.maximum(np.abs(powers[:, 2]), np.abs(powers[:, 2] + 3.0 * powers[:, 3]))
    away = np.linalg.norm(bends[:, :3], axis=1) + bends[:, 3]
    size = np.abs(powers).sum(axis=(1, 2))
    rows[:, SLACK] = 1.01 * away * 0.25 / PIECES**2 + 2.0**-20 * size
    rows[:, TEXTURE], rows[:, SPAN] = parts.first, parts.span
    rows[:, AXIS : AXIS + 3] = axes[parts.strand]
    return rows


def _balls(parts: Segments, axes: np.ndarray) -> np.ndarray:
    """At both ends of straight segments; neighbours share one, of which the gap between is seen."""
    ends = np.append(parts.strand[1:] != parts.strand[:-1], True)
    starts = np.append(True, ends[:-1])
    points = np.concatenate([parts.points[:, 0], parts.points[ends, 3]])
    along = parts.points[:, 3, :3] - parts.points[:, 0, :3]
    lengths = np.maximum(np.linalg.norm(along, axis=1), 1e-30)
    along, rate = along / lengths[:, None], parts.span / lengths
    before = np.where(starts[:, None], 0.0, np.roll(along, 1, axis=0))
    rows = np.zeros((len(points), STRIDE), np.float32)
    rows[:, :4], rows[:, IS_BALL] = points, 1.0
    rows[:, 4:7] = np.concatenate([along, along[ends]])
    rows[:, BEFORE : BEFORE + 3] = np.concatenate([before, along[ends]])
    rows[:, AFTER : AFTER + 3] = np.concatenate([along, np.zeros((ends.sum(), 3))])
    rows[:, TEXTURE] = np.concatenate([parts.first, (parts.first + parts.span)[ends]])
    rows[:, SPAN] = points[:, 3] * np.concatenate([rate, rate[ends]])
    rows[:, AXIS : AXIS + 3] = axes[np.concatenate([parts.strand, parts.strand[ends]])]
    return rows


def _wedges(rows: np.ndarray) -> np.ndarray:
    """The part of each ball that is seen between the tubes that end there."""
    before, after = (rows[:, i : i + 3].astype(np.float64) for i in (BEFORE, AFTER))
    across = np.linalg.norm(np.cross(before, after), axis=1)
    inner = before.any(axis=1) & after.any(axis=1)
    turn = np.arctan2(across, np.sum(before * after, axis=1))
    return np.where(inner, turn / TWO_PI, 0.5)


def _axes(parts: Segments) -> np.ndarray:
    """For each strand the direction that is nearest to a right angle with all of it."""
    along = np.diff(parts.points[:, :, :3], axis=1)
    lengths = np.linalg.norm(along, axis=2, keepdims=True)
    along = along / np.where(lengths > 0.0, lengths, 1.0)
    squares = np.einsum("nki,nkj->nij", along, along)
    starts = np.flatnonzero(np.append(True, parts.strand[1:] != parts.strand[:-1]))
    return np.linalg.eigh(np.add.reduceat(squares, starts, axis=0))[1][:, :, 0]


def _powers(rows: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Coefficients (n, 4, 4) of some rows at a time, those of balls constant, and the rows."""
    for start in range(0, len(rows), _CHUNK):
        part = rows[start : start + _CHUNK].astype(np.float64)
        powers = part[:, :16].reshape(-1, 4, 4).copy()
        powers[part[:, IS_BALL] > 0.0, 1:] = 0.0
        yield powers, part


def area(rows: np.ndarray) -> float:
    """Surface area in m^2: what a bend adds outside it takes away inside."""
    total, u, weights = 0.0, 0.5 + 0.5 * _GAUSS[0], 0.5 * _GAUSS[1]
    for powers, part in _powers(rows):
        at = np.stack([u**0, u, u**2, u**3], axis=1) @ powers
        rate = np.stack([0.0 * u, u**0, 2.0 * u, 3.0 * u**2], axis=1) @ powers
        tube = TWO_PI * ((np.maximum(at[:, :, 3], 0.0) * np.linalg.norm(rate, axis=2)) @ weights)
        balls = part[:, IS_BALL] > 0.0
        total += float(np.where(balls, 2.0 * TWO_PI * part[:, 3] ** 2 * _wedges(part), tube).sum())
    return total


def overlap(rows: np.ndarray) -> float:
    """About how much of the area lies where straight lines overlap at bends, in parts of it."""
    balls = rows[rows[:, IS_BALL] > 0.0]
    inner = balls[:, BEFORE : BEFORE + 3].any(axis=1) & balls[:, AFTER : AFTER + 3].any(axis=1)
    whole = area(rows)
    return area(balls[inner]) / whole if whole > 0.0 else 0.0


def extremes(rows: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least and largest values (n, m) of each primitive along directions (m, 3).

    Those of Bezier's control points, with what is met beyond the ends of a tube.
    """
    lows, highs = [], []
    lengths = np.linalg.norm(directions, axis=1)
    for powers, _ in _powers(rows):
        points = _FROM_POWERS @ powers
        values = points[:, :, :3] @ directions.T
        beyond = 2.0 * BEYOND * np.abs(powers[:, 1:]).sum(axis=(1, 2))
        reach = np.maximum(points[:, :, 3].max(axis=1), 0.0) * (1.0 + 1e-6) + beyond
        margin = reach[:, None] * lengths + 4e-7 * np.abs(values).max(axis=1)
        lows.append(values.min(axis=1) - margin)
        highs.append(values.max(axis=1) + margin)
    return np.concatenate(lows), np.concatenate(highs)


def bounds(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corners of the bounding box from packed rows."""
    low, high = extremes(rows, np.eye(3))
    return low.min(axis=0).astype(np.float32), high.max(axis=0).astype(np.float32)
