"""Media on the ways of a pilot's rays: where these are scattered, and what is left of their light.

Light paths collide in media as paths from the camera do, and cross their borders by the same rule
(`alight.integrators.interiors.volume_walk`).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from alight.core.vec import Vec3
from alight.integrators.interiors.volume_walk import medium_beyond
from alight.media.sampling import cross, evaluate_phase, fly, sample_phase
from alight.media.tables import KEEP, Segment, Stream
from alight.shapes.hit import Surface

#: Borders of media on one way through them.
_MOST_BORDERS = 16


class Way(NamedTuple):
    """Rays between two surfaces: origins, directions, lengths, rows of their media, and times."""

    o: Vec3
    d: Vec3
    length: np.ndarray
    medium: np.ndarray
    times: np.ndarray


class Flown(NamedTuple):
    """What rays did on their way to a surface.

    Attributes
    ----------
    scattered : (n,) bool
    t : (n,) float32
        Distance of that, or to the surface.
    weight : (n, 3) float64
        Of what has passed, or collided.
    albedo : (n, 3) float64
        What is left after a collision.
    """

    scattered: np.ndarray
    t: np.ndarray
    weight: np.ndarray
    albedo: np.ndarray


def in_no_medium(n: int) -> np.ndarray:
    """Row of empty space for n rays."""
    return np.zeros(n, np.uint32)


def medium_of_camera(pilot: Any, n: int) -> np.ndarray:
    """Row of the medium in which n rays of the camera start."""
    if not pilot.program.media:
        return in_no_medium(n)
    return np.full(n, pilot.tables.media.start.array[0], np.uint32)


def medium_around(pilot: Any, o: Vec3, d: Vec3, times: np.ndarray) -> np.ndarray:
    """Rows of the media in which rays start: the near side of the first border ahead tells.

    What meets none is in the camera's medium.
    """
    n = len(times)
    found = medium_of_camera(pilot, n)
    if not pilot.program.media:
        return found
    unknown = np.full(n, KEEP, np.uint32)
    looking = np.full(n, True)
    for _ in range(_MOST_BORDERS):
        hit = pilot.hits(o, d, times)
        looking &= np.isfinite(hit.t)
        if not looking.any():
            break
        surface, _ = pilot.surface(hit, o, d, times, looking)
        back = Vec3(-d.x, -d.y, -d.z)
        near = beyond(pilot, surface, back, unknown, times)
        known = looking & (near != KEEP)
        found = np.where(known, near, found)
        looking &= ~known
        p = pilot.leave(surface, d)
        ways = (p.x, o.x), (p.y, o.y), (p.z, o.z)
        o = Vec3(*(np.where(looking, ahead, before) for ahead, before in ways))
    return found


def beyond(
    pilot: Any, surface: Surface, d: Vec3, medium: np.ndarray, times: np.ndarray
) -> np.ndarray:
    """Rows of the media behind surfaces that rays leave along d."""
    if not pilot.program.media:
        return medium
    rows = pilot.twin(medium_beyond)(pilot.at(times), surface, d, medium)
    return np.broadcast_to(rows, len(medium)).astype(np.uint32)


def flown(pilot: Any, way: Way) -> Flown:
    """Fly as paths do: collide, or pass."""
    n = len(way.length)
    within = way.medium != 0
    if not within.any():
        return Flown(np.zeros(n, bool), way.length, np.ones((n, 3)), np.ones((n, 3)))
    u = pilot.random.random(n).astype(np.float32)
    flight = pilot.twin(fly)(pilot.at(way.times), _segment(pilot, way), u, within)
    scattered = within & np.broadcast_to(flight.scattered, n)
    factor = _rows(flight.factor, n)
    # Three channels, one of which has chosen the distance: the balance heuristic.
    weight = factor / np.maximum(factor.mean(axis=1, keepdims=True), 1e-30)
    albedo = np.where(scattered[:, None], _rows(flight.albedo, n), 1.0)
    t = np.where(scattered, np.broadcast_to(flight.t, n), way.length).astype(np.float32)
    return Flown(scattered, t, np.where(within[:, None], np.nan_to_num(weight), 1.0), albedo)


def transmittance(pilot: Any, way: Way) -> np.ndarray:
    """What media leave of light on a way, (n, 3) float64."""
    n = len(way.length)
    within = way.medium != 0
    if not within.any():
        return np.ones((n, 3))
    crossing = pilot.twin(cross)(pilot.at(way.times), _segment(pilot, way), within)
    chosen = _rows(crossing.light, n).mean(axis=1, keepdims=True)
    left = _rows(crossing.passed, n) * np.broadcast_to(crossing.weight, n)[:, None]
    return np.where(within[:, None], np.nan_to_num(left / np.maximum(chosen, 1e-30)), 1.0)


def turned_by_media(
    pilot: Any, medium: np.ndarray, d: Vec3, times: np.ndarray, there: np.ndarray
) -> tuple[Vec3, np.ndarray]:
    """Directions of the phase functions, and their densities, which are their values."""
    n = len(times)
    u2 = pilot.random.random((2, n)).astype(np.float32)
    wi, _ = pilot.twin(sample_phase)(pilot.at(times), medium, d, tuple(u2), there)
    density = pilot.twin(evaluate_phase)(pilot.at(times), medium, d, wi, there)
    wi = Vec3(*_rows(wi, n).astype(np.float32).T.copy())
    return wi, np.nan_to_num(np.broadcast_to(density, n).astype(np.float64))


def _segment(pilot: Any, way: Way) -> Segment:
    n, random = len(way.length), pilot.random
    words = random.integers(2**32, size=(2, n), dtype=np.uint32)
    stream = Stream(words[0], words[1], in_no_medium(n))
    channel = random.integers(3, size=n).astype(np.uint32)
    return Segment(way.o, way.d, way.length, way.medium, channel, stream)


def _rows(v: Vec3, n: int) -> np.ndarray:
    """A vector of arrays, or of numbers, as (n, 3) float64."""
    return np.stack([np.broadcast_to(c, n) for c in (v.x, v.y, v.z)], axis=1).astype(np.float64)
