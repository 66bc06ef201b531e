r"""Whether a light tree pays: the possible gain from choosing lights for each point they light.

Of n lights a point x is lit by :math:`c_i = I_i w_i(x)`, with the intensity I and what distance and
direction make of it, w. One light chosen by its power, :math:`p_i \propto I_i`, estimates the sum
with the second moment

.. math:: R(x) = \frac{\sum c_i^2 / p_i}{(\sum c_i)^2}
    = \frac{\operatorname{E}_p w^2}{(\operatorname{E}_p w)^2} \ge 1,

a choice by :math:`c_i` itself with 1. So R says by what factor a tree can lower the error at best,
shadows and cosines at x left aside. It is asked at points on the scene's surfaces.

The same holds for a group of lights in a tree: below it, a choice by power has :math:`R_g(x) - 1`
more variance than the best one, at the points that the group gives much of their light. Where that
is small in the mean, :math:`\operatorname E_x s_g (R_g - 1) / \operatorname E_x s_g` with the part
:math:`s_g = \sum_g c_i / \sum c_i` of the light, the group is not looked into.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from alight.compiled.shapes import CompiledShapes
from alight.lights.tree.split import Leaves

#: Points on surfaces, half of them by area and half by piece: what is small has more to see.
POINTS = 128

#: A point that gains more counts as if it gained so much: one of them does not speak for all.
MOST_GAIN = 10.0

#: Lights that represent all, sampled by intensity.
MOST_LIGHTS = 2048

#: A group of a tree is even if it could gain less: some of what can be gained is given for time.
LEAST_IN_GROUP = 0.03

#: A verdict on a group needs at least this many points, and this many lights that represent
#: others.
LEAST_POINTS, LEAST_LIGHTS = 16.0, 32

#: Triangles that represent all.
MOST_TRIANGLES = 1 << 14


def gain_of_tree(leaves: Leaves, shapes: CompiledShapes, shining: NDArray[np.bool_]) -> float:
    """Mean of R, counted to `MOST_GAIN`, over points on surfaces that do not shine.

    Parameters
    ----------
    leaves : Leaves
    shapes : CompiledShapes
    shining : (shapes,) bool
        Which shapes are lights.

    Returns
    -------
    float
        1 where nothing can be gained; `MOST_GAIN` where there are no surfaces to ask at.
    """
    points = points_on_surfaces(shapes, shining)
    if not len(points) or not len(leaves.row):
        return MOST_GAIN if len(leaves.row) else 1.0
    weights = _weights(leaves, _chosen(leaves), points)
    mean = weights.mean(axis=1)
    lit = mean > 0.0
    if not lit.any():
        return 1.0
    second = (weights[lit] / mean[lit, None]) ** 2
    return float(np.minimum(second.mean(axis=1), MOST_GAIN).mean())


def points_on_surfaces(shapes: CompiledShapes, shining: NDArray[np.bool_]) -> NDArray[np.float64]:
    """`POINTS` places, (n, 3) in metres, the same ones each time; none where all surfaces shine."""
    rng = np.random.default_rng(1)
    corner, edges, area = (
        np.concatenate(columns)
        for columns in zip(_triangles(shapes, ~shining, rng), _boxes(shapes, ~shining), strict=True)
    )
    if not len(area):
        return np.zeros((0, 3))
    half, total = POINTS // 2, np.cumsum(area)
    by_area = np.searchsorted(total, rng.random(half) * total[-1], side="right")
    by_piece = rng.integers(0, len(area), POINTS - half)
    chosen = np.append(np.minimum(by_area, len(area) - 1), by_piece)
    u = rng.random((POINTS, 3))
    # Triangles have two edges only, and of their square one half.
    fold = (u[:, :1] + u[:, 1:2] > 1.0) & ~edges[chosen, 2].any(axis=1, keepdims=True)
    return corner[chosen] + np.einsum("ij,ijk->ik", np.where(fold, 1.0 - u, u), edges[chosen])


def _triangles(
    shapes: CompiledShapes, asked: NDArray[np.bool_], rng: np.random.Generator
) -> tuple[np.ndarray, ...]:
    """Corner (n, 3), edges (n, 3, 3) and area (n,) of triangles in the world."""
    found = shapes.triangles
    dark = np.flatnonzero(asked[found.shape])
    if len(dark) > MOST_TRIANGLES:
        dark = dark[rng.integers(0, len(dark), MOST_TRIANGLES)]
    corners = found.vertices[found.faces[dark]].astype(float)
    edges = np.zeros((len(dark), 3, 3))
    edges[:, :2] = corners[:, 1:] - corners[:, :1]
    area = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    return corners[:, 0], edges, area


def _boxes(shapes: CompiledShapes, asked: NDArray[np.bool_]) -> tuple[np.ndarray, ...]:
    """The same of all other shapes, by the boxes around them."""
    corner, edges, area = [], [], []
    for index, low, high in shapes.boxes():
        if asked[index]:
            corner.append(low)
            edges.append(np.diag(high - low))
            area.append(float(shapes.rows[index].areas.sum()))
    bounds = [(v.min(axis=0), v.max(axis=0)) for v, _ in shapes.geometries]
    for number, _, forward, _ in shapes.instances:
        low, high = bounds[number]
        x, y, z = (forward[:, :3] * (high - low)).T.astype(float)
        corner.append(forward[:, :3] @ low + forward[:, 3])
        edges.append(np.stack([x, y, z]))
        area.append(
            sum(float(np.linalg.norm(np.cross(*pair))) for pair in ((x, y), (y, z), (z, x)))
        )
    n = len(area)
    return np.reshape(corner, (n, 3)), np.reshape(edges, (n, 3, 3)), np.array(area)


def even_groups(
    points: NDArray[np.float64],
    leaves: Leaves,
    begin: NDArray[np.integer],
    end: NDArray[np.integer],
) -> NDArray[np.bool_]:
    """Which groups of lights may be chosen from by intensity alone.

    Parameters
    ----------
    points : (n, 3) float64
        Of `points_on_surfaces`.
    leaves : Leaves
        In the order of the tree.
    begin, end : (groups,) int
        First leaf of each group, and the one behind its last.

    Returns
    -------
    (groups,) bool
    """
    count = len(leaves.row)
    if not len(points) or not count:
        return np.zeros(len(begin), bool)
    if count <= MOST_LIGHTS:
        chosen, intensity, least = np.arange(count), leaves.intensity, 2
    else:
        chosen, least = _chosen(leaves), LEAST_LIGHTS
        intensity = np.full(len(chosen), 1.0 / len(chosen))
    low, high = np.searchsorted(chosen, begin), np.searchsorted(chosen, end)
    weights = _weights(leaves, chosen, points)
    sums = [
        _sums(intensity[None], low, high),
        _sums(intensity * weights, low, high),
        _sums(intensity * weights**2, low, high),
    ]
    whole, first, second = sums
    light = (intensity * weights).sum(axis=1)
    lit = light > 0.0
    if not lit.any():
        return np.zeros(len(begin), bool)
    share = first[lit] / light[lit, None]
    # s (R - 1) with R = whole * second / first^2.
    ratio = np.where(first[lit] > 0.0, whole * second[lit] / np.maximum(first[lit], 1e-300), 0.0)
    excess = ratio / light[lit, None] - share
    sum_of_shares, squares = share.sum(axis=0), (share**2).sum(axis=0)
    told = (sum_of_shares**2 >= LEAST_POINTS * squares) & (sum_of_shares > 0.0)
    little = excess.sum(axis=0) < LEAST_IN_GROUP * sum_of_shares
    return told & little & (high - low >= least)


def _sums(numbers: NDArray[np.float64], low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Sums of the columns [low, high) of each row."""
    sums = np.concatenate([np.zeros((len(numbers), 1)), np.cumsum(numbers, axis=1)], axis=1)
    return sums[:, high] - sums[:, low]


def _chosen(leaves: Leaves) -> NDArray[np.integer]:
    """`MOST_LIGHTS` lights by their intensity, ascending; they may repeat."""
    sums = np.cumsum(leaves.intensity)
    wanted = (np.arange(MOST_LIGHTS) + 0.5) / MOST_LIGHTS * sums[-1]
    return np.minimum(np.searchsorted(sums, wanted), len(sums) - 1)


def _weights(
    leaves: Leaves, chosen: NDArray[np.integer], points: NDArray[np.float64]
) -> NDArray[np.float64]:
    """w, (points, lights), of some lights."""
    low, high = leaves.low[chosen], leaves.high[chosen]
    to_light = 0.5 * (low + high) - points[:, None]
    squared = np.sum(to_light * to_light, axis=2)
    size = 0.25 * np.sum((high - low) ** 2, axis=1)
    distance = np.sqrt(np.maximum(squared, 1e-30))
    cosine = -np.einsum("ijk,jk->ij", to_light, leaves.axis[chosen]) / distance
    beyond = np.arccos(np.clip(cosine, -1.0, 1.0)) - leaves.spread[chosen]
    shines = np.cos(np.maximum(beyond, 0.0)) * (beyond < leaves.dark[chosen])
    return np.maximum(shines, 0.0) / np.maximum(squared, np.maximum(size, 1e-30))
