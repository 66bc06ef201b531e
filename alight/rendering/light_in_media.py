r"""Rare light that media scatter into the camera: smoke beside a mirror, fog around a bulb.

Where paths from the lamps cross a medium, a path from the camera that collides close by may be
scattered into their light. Edges of light paths that pass within :math:`\pi r^2` of a collision
bring the radiance :math:`p\, \Phi T / (\pi r^2)` there, p being the phase function and T what the
medium leaves on the edge, and are met with the probability :math:`p\, G T / (\pi r^2)`: as on
surfaces (`alight.rendering.arriving_light`), without a cosine. No density of the medium is needed.

Source: Jarosz, Zwicker and Jensen, The beam radiance estimate for volumetric photon mapping, 2008;
Jarosz, Nowrouzezahrai, Sadeghi and Jensen, A comprehensive theory of volumetric radiance estimation
using photon points and beams, 2011 (beams and a point, blurred in two dimensions).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from alight.core.vec import Vec3
from alight.media.sampling import evaluate_phase
from alight.rendering.arriving_light import NEAREST, by_size
from alight.rendering.pilot_media import Way, transmittance
from alight.rendering.pilot_rays import Collided, Pilot, columns_of, dots, joined, picked, wide

#: Most edges of light paths that are looked at; of more, each k-th stands for k of them.
_MOST = 2**13


class Beams(NamedTuple):
    """Edges of light paths in media.

    Attributes
    ----------
    o, d : Vec3
    length : (n,) float32
        To the next surface.
    radiance : (n, 3) float64
        Where they begin.
    share : (n,) float64
        Étendue, m^2 sr.
    medium : (n,) uint32
        Row of the medium.
    times : (n,) float32
    """

    o: Vec3
    d: Vec3
    length: np.ndarray
    radiance: np.ndarray
    share: np.ndarray
    medium: np.ndarray
    times: np.ndarray


def gather_in_media(pilot: Pilot, seen: Collided, found: Sequence[Beams]) -> np.ndarray:
    """Light at collisions that the camera sees, by the nearest edges of light paths.

    Returns
    -------
    (n, 7) float64
        Rows of `alight.rendering.light_behind_glass.light_behind_glass`.
    """
    if not found or not len(seen.point):
        return np.zeros((0, 7))
    beams = joined(found)
    step = -(-len(beams.share) // _MOST)
    beams = picked(beams, np.arange(0, len(beams.share), max(step, 1)))
    beams = beams._replace(share=beams.share * max(step, 1))
    if len(beams.share) < NEAREST:
        return np.zeros((0, 7))
    near, reach = _nearest(seen, beams)
    widest = reach.max(axis=1)
    # The farthest of them has chosen the circle, so it is not counted.
    rows, columns = np.nonzero((reach < widest[:, None]) & np.isfinite(widest)[:, None])
    area = np.pi * np.maximum(widest[rows], 1e-30)
    at, edge = seen.some(rows), picked(beams, near[rows, columns])
    along = dots(at.p - columns_of(edge.o), columns_of(edge.d)).astype(np.float32)
    left = transmittance(pilot, Way(edge.o, edge.d, along, edge.medium, edge.times))
    wi = Vec3(-edge.d.x, -edge.d.y, -edge.d.z)
    tables, there = pilot.at(at.times), np.full(len(rows), True)
    phase = pilot.twin(evaluate_phase)(tables, at.medium, at.d, wi, there)
    share = np.nan_to_num(wide(phase, len(rows)).astype(np.float64)) * edge.share / area
    radiance = at.weight * edge.radiance * left * share[:, None]
    q = share * left.mean(axis=1) * at.reached
    return by_size(at.point, at.cell, radiance, q)


def _nearest(seen: Collided, beams: Beams) -> tuple[np.ndarray, np.ndarray]:
    """The `NEAREST` edges around each collision, in its medium, and squares of their distances."""
    o, d = columns_of(beams.o), columns_of(beams.d)
    begins, length = dots(o, d), beams.length.astype(np.float64)
    near, reach = (np.zeros((len(seen.point), NEAREST), kind) for kind in (int, np.float64))
    for row, p in enumerate(seen.p):
        way = p - o
        along = dots(d, p) - begins
        square = np.maximum(dots(way, way) - along**2, 0.0)
        beside = (along <= 0.0) | (along >= length) | (beams.medium != seen.medium[row])
        square[beside | ~np.isfinite(square)] = np.inf
        least = np.sort(np.argpartition(square, NEAREST - 1)[:NEAREST])
        near[row], reach[row] = least, square[least]
    return near, reach
