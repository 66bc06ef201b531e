r"""Light that paths from the lamps bring to what the camera sees: how much, how often it is met.

Where light paths of flux :math:`\Phi = L G`, radiance and étendue, arrive within :math:`\pi r^2`
around a point, they add the radiance :math:`f \Phi / (\pi r^2)` (Jensen 1996), and a path from the
camera is scattered into their light with the probability
:math:`q = p_b\, G / (|\cos\theta|\, \pi r^2)`; see `alight.rendering.light_off_mirrors`.

Source: Jensen, Global illumination using photon maps, 1996.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from alight.bsdfs.dispatch import evaluate_bsdf
from alight.core.vec import Vec3
from alight.integrators.walk import to_local
from alight.rendering.pilot_rays import Pilot, Seen, columns_of, joined, lanes_of, wide

#: Light paths around a point whose flux is taken together.
NEAREST = 16


class Arrived(NamedTuple):
    """Light at surfaces.

    Attributes
    ----------
    p, n, towards : (n, 3) float64
        Places, normals, and directions that it comes from.
    radiance : (n, 3) float64
    share : (n,) float64
        Étendue, m^2 sr; its product with the radiance is the flux.
    """

    p: np.ndarray
    n: np.ndarray
    towards: np.ndarray
    radiance: np.ndarray
    share: np.ndarray


def all_of(found: Sequence[Arrived]) -> Arrived:
    """What has arrived at one surface after another, together."""
    none = np.zeros((0, 3))
    return joined(found) if found else Arrived(none, none, none, none, np.zeros(0))


def gather(pilot: Pilot, seen: Seen, arrived: Arrived) -> np.ndarray:
    """Light at the points of the picture, by its nearest light paths."""
    surface, wo = pilot.surface(seen.hit, seen.o, seen.d, seen.times)
    n = len(seen.point)
    p, normal = columns_of(lanes_of(surface.p, n)), columns_of(lanes_of(surface.ns, n))
    near, reach = _nearest(arrived, p, normal)
    widest = reach.max(axis=1)
    # The farthest of them has chosen the circle, so it is not counted.
    rows, columns = np.nonzero((reach < widest[:, None]) & np.isfinite(widest)[:, None])
    paths, area = near[rows, columns], np.pi * np.maximum(widest[rows], 1e-30)
    some = seen.some(rows)
    surface, wo = pilot.surface(some.hit, some.o, some.d, some.times)
    wi = pilot.twin(to_local)(surface, Vec3(*arrived.towards[paths].astype(np.float32).T))
    there = np.full(len(rows), True)
    f_cos, pdf = pilot.twin(evaluate_bsdf)(pilot.at(some.times), surface, wo, wi, there)
    cosine = np.maximum(np.abs(wide(wi.z, len(rows)).astype(np.float64)), 1e-6)
    share = arrived.share[paths] / (area * cosine)
    f_cos = np.nan_to_num(columns_of(lanes_of(f_cos, len(rows))))
    radiance = some.weight * f_cos * arrived.radiance[paths] * share[:, None]
    q = np.nan_to_num(wide(pdf, len(rows)).astype(np.float64)) * share * some.reached
    return by_size(some.point, some.cell, radiance, q)


def _nearest(arrived: Arrived, p: np.ndarray, normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The `NEAREST` light paths around each point, on surfaces that face as it does.

    Returns
    -------
    near : (n, NEAREST) int
        Rows of `arrived`, ascending.
    reach : (n, NEAREST) float64
        Squares of their distances, m^2; infinite where too few face as the point does.
    """
    order = np.argsort(arrived.p[:, 0], kind="stable")
    every = np.ascontiguousarray(np.column_stack([arrived.p, arrived.n])[order].T)
    few, x = np.ascontiguousarray(every[:, ::NEAREST]), every[0]

    def squares(paths: np.ndarray, row: int) -> np.ndarray:
        (px, py, pz), (u, v, w), (x, y, z, nx, ny, nz) = p[row], normal[row], paths
        found = (x - px) ** 2 + (y - py) ** 2 + (z - pz) ** 2
        found[np.abs(nx * u + ny * v + nz * w) < 0.5] = np.inf
        return found

    near, reach = np.zeros((len(p), NEAREST), int), np.zeros((len(p), NEAREST))
    for row in range(len(p)):
        # As many of every sixteenth as are wanted bound the distance: a slab holds the nearest.
        some, part = squares(few, row), slice(None)
        if len(some) >= NEAREST:
            # A little wider, as squares are rounded.
            side = 1.001 * np.sqrt(np.partition(some, NEAREST - 1)[NEAREST - 1])
            # A point that is not a number is near none, whose bound is none either.
            if np.isfinite(side):
                low, high = p[row, 0] - side, p[row, 0] + side
                part = slice(np.searchsorted(x, low), np.searchsorted(x, high, "right"))
        found, rows = squares(every[:, part], row), order[part]
        least = np.argpartition(found, NEAREST - 1)[:NEAREST]
        least = least[np.argsort(rows[least])]
        near[row], reach[row] = rows[least], found[least]
    return near, reach


def by_size(point: np.ndarray, cell: np.ndarray, radiance: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Rows of `light_behind_glass`: at each point, light of samples of about the same size."""
    total = radiance.sum(axis=1)
    some = (total > 0.0) & (q > 0.0)
    size = np.zeros(len(q), int)
    size[some] = np.floor(np.log2(total[some] / q[some])).astype(int)
    keys = np.column_stack([point, cell, size])[some]
    kinds, of_row = np.unique(keys, axis=0, return_inverse=True)
    sums = np.zeros((len(kinds), 4))
    np.add.at(sums, of_row.ravel(), np.column_stack([radiance, q])[some])
    sums[:, 3] = np.minimum(sums[:, 3], 1.0)
    return np.column_stack([kinds[:, :2], sums, sums[:, 3]])
