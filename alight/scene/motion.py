r"""How placed objects move while the shutter is open, from 0 to 1.

What hangs below moving nodes of the scene graph moves by a chain

.. math:: p(t) = B_1 K_1(t) \; B_2 K_2(t) \cdots p

of what moves, K, and what rests, B. A B that keeps all angles is taken into the keyframes behind
it, exactly: an even translation stays even, an even turn too, and a common scale goes through to
the end of the chain, as does a stretch that does not change. So nearly every chain is one K that
only shifts and turns.
"""

from __future__ import annotations

from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from alight.scene.keyframes import (
    SAME_STRETCH,
    Keyframes,
    Parts,
    Track,
    arc,
    between,
    product,
    take_apart,
    while_open,
)
from alight.scene.transform import Matrix, Transform

#: A box around a path is made from at most STEPS points on it, between two keyframes; from fewer
#: where the path bends between them by less than STRAIGHT times its object's size.
STEPS = 64
STRAIGHT = 1.0 / 512.0

#: A cone around a turning direction is made from directions at most so far apart, in radians, or
#: from `STEPS` of them.
WIDE = 0.05

#: It is enlarged by this part of the numbers that kernels add up: a bound of their rounding.
MARGIN = 2.0**-16

_IDENTITY = np.eye(4)


class Link(NamedTuple):
    """A part of the chain: (4, 4) matrix that rests, applied after what moves."""

    before: Matrix
    track: Track


class Motion:
    """A chain of links, from the world down.

    Parameters
    ----------
    links : tuple of Link
    """

    def __init__(self, links: tuple[Link, ...]) -> None:
        self.links = links

    def at(self, time: float) -> Matrix:
        """The (4, 4) matrix at a time in [0, 1]."""
        result = _IDENTITY
        for before, track in self.links:
            result = result @ before @ _parts_at(track, time).matrix
        return result

    @cached_property
    def times(self) -> tuple[float, ...]:
        """Times of all keyframes, ascending."""
        return tuple(sorted({time for link in self.links for time in link.track.times}))

    @cached_property
    def is_rigid(self) -> bool:
        """Whether all distances and angles stay as they are."""
        return all(
            np.array_equal(before, _IDENTITY)
            and all(np.array_equal(frame.stretch, np.eye(3)) for frame in track.frames)
            for before, track in self.links
        )

    @cached_property
    def content(self) -> bytes:
        """All numbers, to tell motions apart."""
        numbers = [np.array([len(self.links)], float)]
        for before, track in self.links:
            numbers += [before.ravel(), np.array(track.times)]
            numbers += [part.ravel() for frame in track.frames for part in frame]
        return b"".join((n + 0.0).tobytes() for n in numbers)

    def bounds(self, low: Matrix, high: Matrix) -> tuple[Matrix, Matrix]:
        """The box that a moving box stays in.

        Between two times h apart a point's way differs from the straight line by h^2 / 8 times its
        largest acceleration at most, in every coordinate, and so does the box around it.

        Parameters
        ----------
        low, high : (3,) float, metres
            Before the motion.

        Returns
        -------
        low, high : (3,) float64, metres
            While the shutter is open, with room for the rounding of kernels.
        """
        low, high = np.asarray(low, float), np.asarray(high, float)
        corners = np.array([[x, y, z] for x in (low[0], high[0])
                            for y in (low[1], high[1]) for z in (low[2], high[2])])  # fmt: skip
        least, most = self.swept(corners[None])
        return least[0], most[0]

    def swept(self, points: Matrix) -> tuple[Matrix, Matrix]:
        """The boxes that groups of points stay in, as `bounds` of each.

        Parameters
        ----------
        points : (n, k, 3) float, metres
            k points of each group, before the motion.

        Returns
        -------
        low, high : (n, 3) float64, metres
        """
        points = np.asarray(points, float)
        every = points.reshape(-1, 3)
        least, most = np.full((len(points), 3), np.inf), np.full((len(points), 3), -np.inf)
        reach = float(np.abs(every).max())
        extent = max(float(np.linalg.norm(every.max(axis=0) - every.min(axis=0))), 1e-30)
        for begin, end in pairwise(self.times):
            bend, numbers = self._bend(every, begin, end)
            steps = int(np.clip(np.ceil(np.sqrt(bend / (STRAIGHT * extent))), 1, STEPS))
            for time in np.linspace(begin, end, steps + 1):
                matrix = self.at(time)
                moved = points @ matrix[:3, :3].T + matrix[:3, 3]
                least = np.minimum(least, moved.min(axis=1) - bend / steps**2)
                most = np.maximum(most, moved.max(axis=1) + bend / steps**2)
            reach = max(reach, numbers)
        return least - MARGIN * reach, most + MARGIN * reach

    def turned(self, axes: Matrix) -> tuple[Matrix, Matrix]:
        """The cones of directions that turning axes stay in.

        Parameters
        ----------
        axes : (n, 3) float
            Unit vectors before the motion, which must be rigid.

        Returns
        -------
        (n, 3) float64
            Unit vectors in their middle; where there is none, any.
        (n,) float64, radians
            Half angles, pi at most.
        """
        seen, between_two = [], 0.0
        for begin, end in pairwise(self.times):
            angle = sum(
                2.0 * arc(_parts_at(track, begin).turn, _parts_at(track, end).turn)[0]
                for _, track in self.links
            )
            steps = int(np.clip(np.ceil(angle / WIDE), 1, STEPS))
            between_two = max(between_two, 0.5 * angle / steps)
            seen += [axes @ self.at(t)[:3, :3].T for t in np.linspace(begin, end, steps + 1)]
        mean = np.mean(seen, axis=0)
        length = np.linalg.norm(mean, axis=1)
        middle = np.where((length > 1e-6)[:, None], mean, axes)
        middle /= np.linalg.norm(middle, axis=1, keepdims=True)
        least = np.min(np.sum(middle * np.array(seen), axis=2), axis=0)
        return middle, np.minimum(np.arccos(np.clip(least, -1.0, 1.0)) + between_two, np.pi)

    def _bend(self, points: Matrix, begin: float, end: float) -> tuple[float, float]:
        """How far paths bend at most between two neighbouring times, and the largest numbers, m.

        Bounds of |p|, |p'| and |p''| are taken from link to link by the product rule.
        """
        size = float(np.linalg.norm(points, axis=1).max())
        speed, bend, most = 0.0, 0.0, size
        for before, track in reversed(self.links):
            a, b = _parts_at(track, begin), _parts_at(track, end)
            span = end - begin
            angle, _ = arc(a.turn, b.turn)
            spin = 2.0 * angle / span
            stretch = max(_norm(a.stretch), _norm(b.stretch))
            change = _norm(b.stretch - a.stretch) / span
            shift = max(float(np.linalg.norm(a.shift)), float(np.linalg.norm(b.shift)))
            travel = float(np.linalg.norm(b.shift - a.shift)) / span
            # R S and its derivatives; |R'| = spin, |R''| = spin^2.
            first, second = spin * stretch + change, spin**2 * stretch + 2.0 * spin * change
            bend = second * size + 2.0 * first * speed + stretch * bend
            speed = travel + first * size + stretch * speed
            size = shift + stretch * size
            factor = _norm(before[:3, :3])
            size, speed, bend = factor * size, factor * speed, factor * bend
            size += float(np.linalg.norm(before[:3, 3]))
            most = max(most, size)
        return bend * (end - begin) ** 2 / 8.0, most


def _norm(matrix: Matrix) -> float:
    return float(np.linalg.norm(matrix, 2))


def _parts_at(track: Track, time: float) -> Parts:
    times = track.times
    i = int(np.clip(np.searchsorted(times, time, "right") - 1, 0, len(times) - 2))
    x = (time - times[i]) / (times[i + 1] - times[i])
    return between(track.frames[i], track.frames[i + 1], float(np.clip(x, 0.0, 1.0)))


def _constant_stretch(track: Track) -> Matrix | None:
    """The stretch of a track if it does not change."""
    first = track.frames[0].stretch
    near = SAME_STRETCH * np.abs(first).max()
    same = all(np.abs(frame.stretch - first).max() <= near for frame in track.frames)
    return first if same else None


class Placement(NamedTuple):
    """Where something is: links of a motion, then a (4, 4) matrix, which acts first."""

    links: tuple[Link, ...]
    matrix: Matrix

    def then(self, transform: Transform, shutter: tuple[float, float]) -> Placement:
        """Go down one node of the scene graph."""
        if not isinstance(transform, Keyframes):
            return Placement(self.links, self.matrix @ transform.matrix)
        seen = while_open(transform, shutter)
        if not isinstance(seen, Track):
            return Placement(self.links, self.matrix @ seen)
        link, rest = _simplified(self.matrix, seen)
        return Placement((*self.links, link), rest)

    @property
    def motion(self) -> Motion | None:
        """The moving part, None if there is none."""
        return Motion(self.links) if self.links else None


NOWHERE = Placement((), _IDENTITY)


def _simplified(before: Matrix, track: Track) -> tuple[Link, Matrix]:
    """A link, and what is left to do before it, that are together ``before`` after `track`."""
    outer = take_apart(before)
    scale = float(np.trace(outer.stretch)) / 3.0
    if np.abs(outer.stretch - scale * np.eye(3)).max() <= SAME_STRETCH * abs(scale):
        linear = before[:3, :3]
        frames = tuple(
            Parts(before[:3, 3] + linear @ f.shift, product(outer.turn, f.turn), scale * f.stretch)
            for f in track.frames
        )
        before, track = _IDENTITY, Track(track.times, frames)
    rest, stretch = _IDENTITY, _constant_stretch(track)
    if stretch is not None:
        rest = np.eye(4)
        rest[:3, :3] = stretch
        frames = tuple(frame._replace(stretch=np.eye(3)) for frame in track.frames)
        track = Track(track.times, frames)
    return Link(before, track), rest
