"""Splitting groups of lights in two, as the light tree is built.

The lights of each group are counted into bins along the three axes, and split where the sum over
both sides of intensity times squared diagonal times solid angle of the directions is smallest (the
surface area heuristic of Conty Estevez and Kulla 2018, equations 1 and 2, with the diagonal that
our bounding spheres have). The spread of directions in a bin is known from the length of the sum of
their axes, which adds up over bins.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

BINS = 12


class Leaves(NamedTuple):
    """Lights with a place, a row each.

    Attributes
    ----------
    low, high : (n, 3) float64, metres
        Bounds.
    axis : (n, 3) float64
        Unit vector in the middle of the directions that it faces.
    spread, dark : (n,) float64, radians
        It faces directions up to `spread` from the axis, and is dark from `dark` beyond them.
    behind : (n,) float64, metres
        How far against the directions it faces its points lie from the middle of the bounds.
    intensity : (n,) float64, W/sr
        Along the directions that it faces; above 0.
    row, prim : (n,) uint32
        Of the light, and of the triangle.
    """

    low: NDArray[np.float64]
    high: NDArray[np.float64]
    axis: NDArray[np.float64]
    spread: NDArray[np.float64]
    dark: NDArray[np.float64]
    behind: NDArray[np.float64]
    intensity: NDArray[np.float64]
    row: NDArray[np.uint32]
    prim: NDArray[np.uint32]


def split(
    leaves: Leaves, items: np.ndarray, sizes: np.ndarray, levels_left: int
) -> tuple[np.ndarray, np.ndarray]:
    """Divide each group in two: the items in their new order, and the sizes of all halves."""
    groups = len(sizes)
    group = np.repeat(np.arange(groups), sizes)
    starts = np.cumsum(sizes) - sizes
    center = 0.5 * (leaves.low + leaves.high)[items]
    low, high = np.minimum.reduceat(center, starts), np.maximum.reduceat(center, starts)
    extent = high - low
    best = np.full(groups, np.inf)
    axis, at = np.argmax(extent, axis=1), np.zeros(groups, int)
    bins = np.zeros((3, len(items)), np.int64)
    for k in range(3):
        scale = BINS / np.where(extent[:, k] > 0.0, extent[:, k], 1.0)
        bins[k] = np.minimum((center[:, k] - low[group, k]) * scale[group], BINS - 1)
        costs = _costs(leaves, items, group * BINS + bins[k], groups)
        # Thin slices of long groups are no gain: the other extents stay as they are.
        flat = extent[:, k] <= 0.0
        longer = extent.max(axis=1) / np.where(flat, 1.0, extent[:, k])
        costs *= np.where(flat, 1.0, longer)[:, None]
        costs[flat] = np.inf
        found = np.argmin(costs, axis=1)
        cost = costs[np.arange(groups), found]
        better = cost < best
        best, axis = np.where(better, cost, best), np.where(better, k, axis)
        at = np.where(better, found, at)
    side = bins[axis[group], np.arange(len(items))] > at[group]
    # Where all centres agree, or the way grows too long: halves.
    deep = np.ceil(np.log2(sizes)) >= levels_left
    halve = deep | ~np.isfinite(best)
    if halve.any():
        along = center[np.arange(len(items)), axis[group]]
        rank = np.zeros(len(items), np.int64)
        rank[np.lexsort((along, group))] = np.arange(len(items)) - starts[group]
        side = np.where(halve[group], rank >= (sizes // 2)[group], side)
    halves = np.bincount(2 * group + side, minlength=2 * groups)
    return items[np.argsort(2 * group + side, kind="stable")], halves


def _costs(leaves: Leaves, items: np.ndarray, cell: np.ndarray, groups: int) -> np.ndarray:
    """Cost of the splits behind each bin of each group; (groups, BINS), the last is infinite."""
    cells = groups * BINS
    ones = np.bincount(cell, minlength=cells).reshape(groups, BINS)
    low, high = np.full((cells, 3), np.inf), np.full((cells, 3), -np.inf)
    sums = np.zeros((cells, 6))
    weights = (*leaves.axis.T, leaves.intensity, leaves.spread, leaves.dark)
    for k in range(3):
        np.minimum.at(low[:, k], cell, leaves.low[items, k])
        np.maximum.at(high[:, k], cell, leaves.high[items, k])
    for k, weight in enumerate(weights):
        sums[:, k] = np.bincount(cell, weight[items], minlength=cells)
    low, high = low.reshape(groups, BINS, 3), high.reshape(groups, BINS, 3)
    sums = sums.reshape(groups, BINS, 6)
    before = _cost_of(
        np.cumsum(ones, 1),
        np.minimum.accumulate(low, 1),
        np.maximum.accumulate(high, 1),
        np.cumsum(sums, 1),
    )
    back = slice(None, None, -1)
    after = _cost_of(
        np.cumsum(ones[:, back], 1),
        np.minimum.accumulate(low[:, back], 1),
        np.maximum.accumulate(high[:, back], 1),
        np.cumsum(sums[:, back], 1),
    )[:, back]
    total = np.full((groups, BINS), np.inf)
    total[:, :-1] = before[:, :-1] + after[:, 1:]
    return total


def _cost_of(
    count: np.ndarray, low: np.ndarray, high: np.ndarray, sums: np.ndarray
) -> NDArray[np.float64]:
    """Intensity times squared diagonal times solid angle; infinite for nothing."""
    there = count > 0
    number = np.where(there, count, 1)
    diagonal = np.where(there[..., None], high - low, 0.0)
    # Directions spread evenly over a cap have a mean of length (1 + cos) / 2.
    length = np.linalg.norm(sums[..., :3], axis=-1) / number
    spread = np.arccos(np.clip(2.0 * length - 1.0, -1.0, 1.0)) + sums[..., 4] / number
    spread = np.minimum(spread, np.pi)
    angle = _solid_angle(spread, sums[..., 5] / number)
    cost = sums[..., 3] * np.sum(diagonal * diagonal, axis=-1) * angle
    return np.where(there, cost, np.inf)


def _solid_angle(spread: np.ndarray, dark: np.ndarray) -> NDArray[np.float64]:
    """Conty Estevez and Kulla's measure of a cone of directions that fades by the cosine."""
    end = np.minimum(spread + dark, np.pi)
    cap = 2.0 * np.pi * (1.0 - np.cos(spread))
    rim = 2.0 * end * np.sin(spread) - np.cos(spread - 2.0 * end)
    return cap + 0.5 * np.pi * (rim - 2.0 * spread * np.sin(spread) + np.cos(spread))
