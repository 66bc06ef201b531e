"""Motion while the shutter is open -> tables for kernels (`alight.core.motion`)."""

from __future__ import annotations

import numpy as np

from alight.core.motion import (
    ANGLE,
    ASIDE,
    BEFORE,
    BEGIN,
    CHANGE,
    RATE,
    SEGMENT,
    SEGMENTS,
    SHIFT,
    STRETCH,
    TRAVEL,
    TURN,
    Motions,
)
from alight.scene.keyframes import Parts, Track, arc
from alight.scene.motion import Link, Motion
from lanewise.view import View

#: Part of the shutter's time below which float32 tells no two moments apart.
SHORTEST = 2.0**-24
#: The six numbers of a symmetric matrix.
_UPPER = np.triu_indices(3)

#: A link that moves nothing, for motions that are shorter than others.
_NOTHING = Link(
    np.eye(4),
    Track((0.0, 1.0), (Parts(np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]), np.eye(3)),) * 2),
)


class MotionTable:
    """Numbers the different motions of a scene."""

    def __init__(self) -> None:
        self.motions: list[Motion] = []
        self._numbers: dict[bytes, int] = {}

    def number(self, motion: Motion | None) -> int:
        """The number of a motion + 1; equal ones share it; 0 for none."""
        if motion is None:
            return 0
        number = self._numbers.setdefault(motion.content, len(self.motions) + 1)
        if number > len(self.motions):
            self.motions.append(motion)
        return number

    @property
    def is_rigid(self) -> bool:
        """Whether all motions only shift and turn, in one link each."""
        return all(motion.is_rigid and len(motion.links) == 1 for motion in self.motions)

    def tables(self, of_shape: list[int], of_light: list[int], camera: int) -> Motions:
        """Tables for kernels, from the numbers of all shapes, lights and the camera."""
        links = max(len(motion.links) for motion in self.motions)
        tracks = [link.track for motion in self.motions for link in motion.links]
        segments = max(len(track.times) - 1 for track in tracks)
        rows = np.zeros((len(self.motions), links, SEGMENTS + SEGMENT * segments))
        for row, motion in zip(rows, self.motions, strict=True):
            more = (_NOTHING,) * (links - len(motion.links))
            for place, link in zip(row, (*motion.links, *more), strict=True):
                _pack(link, place)
        return Motions(
            View(rows.astype(np.float32).reshape(-1)),
            View(np.array([links, segments], np.uint32)),
            View(np.array(of_shape or [0], np.uint32)),
            View(np.array(of_light or [0], np.uint32)),
            View(np.array([camera], np.uint32)),
        )


def _pack(link: Link, row: np.ndarray) -> None:
    """Fill the row of one link; segments that it does not have begin when all is over."""
    row[BEFORE : BEFORE + 12] = link.before[:3].ravel()
    times, frames = link.track
    segments = row[SEGMENTS:].reshape(-1, SEGMENT)
    segments[len(times) - 1 :, BEGIN] = 2.0
    for i, segment in enumerate(segments[: len(times) - 1]):
        a, b = frames[i], frames[i + 1]
        angle, aside = arc(a.turn, b.turn)
        segment[BEGIN] = times[i]
        segment[RATE] = 1.0 / max(times[i + 1] - times[i], SHORTEST)
        segment[ANGLE] = angle
        segment[SHIFT : SHIFT + 3], segment[TRAVEL : TRAVEL + 3] = a.shift, b.shift - a.shift
        segment[TURN : TURN + 4], segment[ASIDE : ASIDE + 4] = a.turn, aside
        segment[STRETCH : STRETCH + 6] = a.stretch[_UPPER]
        segment[CHANGE : CHANGE + 6] = (b.stretch - a.stretch)[_UPPER]
