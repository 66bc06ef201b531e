r"""Transforms that change in time: keyframes, and what they do while a shutter is open.

A matrix is taken apart into M = T R S: a translation, a rotation (a unit quaternion) and a
symmetric stretch. Between two keyframes T and S change evenly, and R turns evenly about one axis,
the shorter way around:

.. math::
    q(x) = q_0 \cos(x \theta) + q_\perp \sin(x \theta), \qquad \cos\theta = q_0 \cdot q_1

Before the first keyframe and after the last one nothing changes.

Sources: Shoemake and Duff, Matrix animation and polar decomposition (1992); PBR4 section 3.10.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from alight.core.errors import Issue, SceneError
from alight.scene.transform import Matrix, Transform, is_singular

#: Stretches that differ by less, relatively, are the same: rounding of the decomposition.
SAME_STRETCH = 1e-9

#: Keyframes that one node may have.
MOST_KEYFRAMES = 10_000


@dataclass(frozen=True, eq=False)
class Keyframes(Transform):
    """A transform given at two or more times; `matrix` is that of the first.

    Parameters
    ----------
    frames : tuple of (float, Transform)
        Times, ascending, in the unit of the camera's shutter, and what holds then. See
        `keyframes`, which checks them.
    """

    frames: tuple[tuple[float, Transform], ...] = ()

    def __matmul__(self, first: Transform) -> Transform:
        """Compose with a transform that rests: every keyframe is."""
        return keyframes([(time, frame @ first) for time, frame in self.frames])

    def __rmatmul__(self, last: Transform) -> Transform:
        """Apply one that rests afterwards."""
        return keyframes([(time, last @ frame) for time, frame in self.frames])

    def __eq__(self, other: object) -> bool:
        """Compare times and matrices bit for bit."""
        return isinstance(other, Keyframes) and self.frames == other.frames

    def __hash__(self) -> int:
        """Hash times and matrices."""
        return hash(self.frames)

    def inverse(self) -> Transform:
        """Invert every keyframe."""
        return keyframes([(time, frame.inverse()) for time, frame in self.frames])

    @cached_property
    def is_singular(self) -> bool:
        """Whether a keyframe flattens space."""
        return any(frame.is_singular for _, frame in self.frames)


def keyframes(
    frames: Mapping[float, Transform] | Sequence[tuple[float, Transform]],
) -> Transform:
    """Let a transform change in time.

    Parameters
    ----------
    frames : mapping of float to Transform, or sequence of pairs
        Times, ascending, in the unit of the camera's ``shutter``, and the transforms then.

    Raises
    ------
    SceneError
        If there are no keyframes, times do not increase, a transform is singular, or one mirrors
        and another one does not.
    """
    pairs = list(frames.items() if isinstance(frames, Mapping) else frames)
    issues = [Issue(f"keyframes{path}", text) for path, text in problems(pairs)]
    if issues:
        raise SceneError(issues)
    pairs = [(float(time), frame) for time, frame in pairs]
    return Keyframes(pairs[0][1].matrix, pairs[0][1].steps, tuple(pairs))


def problems(pairs: Sequence[tuple[float, Transform]]) -> list[tuple[str, str]]:
    """What is wrong with keyframes: (path behind ``keyframes``, message)."""
    if not 1 <= len(pairs) <= MOST_KEYFRAMES:
        return [("", f"must be a list of 1 to {MOST_KEYFRAMES} keyframes, got {len(pairs)}")]
    found = []
    mirrored = pairs[0][1].flips_handedness
    for i, (time, frame) in enumerate(pairs):
        if not np.isfinite(time):
            found.append((f"[{i}].time", f"must be finite, got {time}"))
        elif i > 0 and not time > pairs[i - 1][0]:
            text = f"must be later than the one before, {pairs[i - 1][0]:g}, got {time:g}"
            found.append((f"[{i}].time", text))
        if isinstance(frame, Keyframes):
            found.append((f"[{i}]", "must be a transform that rests, got keyframes"))
        elif is_singular(frame.matrix):
            found.append((f"[{i}]", "is singular: it flattens space"))
        elif frame.flips_handedness != mirrored:
            text = "does not mirror, and the first keyframe does"
            if not mirrored:
                text = "mirrors, and the first keyframe does not"
            found.append((f"[{i}]", f"{text}: in between it would flatten space"))
        elif i > 0 and (turned := _largest_turn(pairs[i - 1][1], frame)) >= 180.0:
            text = f"turns by {turned:g} degrees from the keyframe before; the way around is only "
            found.append((f"[{i}]", text + "clear below 180: add a keyframe in between"))
    return found


def _largest_turn(a: Transform, b: Transform) -> float:
    """By how many degrees the turns of two transforms differ that are written alike."""
    turns = [
        [step.value for step in t.steps if step.name == "rotate" and isinstance(step.value, dict)]
        for t in (a, b)
    ]
    # A turn that is not written is one by 0 degrees.
    one, other = (turns[i] or [{**v, "angle": 0.0} for v in turns[1 - i]] for i in (0, 1))
    if len(one) != len(other):
        return 0.0
    pairs = [(x, y) for x, y in zip(one, other, strict=True) if x["axis"] == y["axis"]]
    return max((abs(y["angle"] - x["angle"]) for x, y in pairs), default=0.0)


class Parts(NamedTuple):
    """M = T R S: (3,) metres, (4,) unit quaternion (w, x, y, z), (3, 3) symmetric."""

    shift: Matrix
    turn: Matrix
    stretch: Matrix

    @property
    def matrix(self) -> Matrix:
        """The (4, 4) matrix."""
        result = np.eye(4)
        result[:3, :3] = rotation(self.turn) @ self.stretch
        result[:3, 3] = self.shift
        return result


def take_apart(matrix: Matrix) -> Parts:
    """The polar decomposition of an affine matrix; one that mirrors has a negative stretch."""
    u, sizes, vt = np.linalg.svd(matrix[:3, :3])
    turn, stretch = u @ vt, vt.T @ np.diag(sizes) @ vt
    if np.linalg.det(turn) < 0.0:
        turn, stretch = -turn, -stretch
    return Parts(matrix[:3, 3].copy(), quaternion(turn), stretch)


def quaternion(turn: Matrix) -> Matrix:
    """The unit quaternion (w, x, y, z) of a 3 x 3 rotation, by its largest component."""
    xx, yy, zz = turn[0, 0], turn[1, 1], turn[2, 2]
    squares = np.array(
        [1.0 + xx + yy + zz, 1.0 + xx - yy - zz, 1.0 - xx + yy - zz, 1.0 - xx - yy + zz]
    )
    a, b, c = turn[2, 1], turn[0, 2], turn[1, 0]
    d, e, f = turn[1, 2], turn[2, 0], turn[0, 1]
    rows = np.array(
        [
            [squares[0], a - d, b - e, c - f],
            [a - d, squares[1], c + f, b + e],
            [b - e, c + f, squares[2], a + d],
            [c - f, b + e, a + d, squares[3]],
        ]
    )
    row = rows[int(np.argmax(squares))]
    return row / np.linalg.norm(row)


def rotation(turn: Matrix) -> Matrix:
    """The 3 x 3 matrix of a unit quaternion."""
    w, x, y, z = turn
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )


def product(a: Matrix, b: Matrix) -> Matrix:
    """The quaternion of b's rotation followed by a's."""
    return np.concatenate(
        [[a[0] * b[0] - a[1:] @ b[1:]], a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])]
    )


def between(a: Parts, b: Parts, x: float) -> Parts:
    """What holds at the part x of the way from a to b; ``a.turn @ b.turn`` must be >= 0."""
    angle, aside = arc(a.turn, b.turn)
    turn = a.turn * np.cos(x * angle) + aside * np.sin(x * angle)
    return Parts(a.shift + x * (b.shift - a.shift), turn, a.stretch + x * (b.stretch - a.stretch))


def arc(a: Matrix, b: Matrix) -> tuple[float, Matrix]:
    """The angle between two unit vectors, and the unit vector at right angles to a towards b."""
    aside = b - (a @ b) * a
    sine = float(np.linalg.norm(aside))
    angle = float(np.arctan2(sine, a @ b))
    return angle, aside / sine if sine > 0.0 else np.zeros(len(a))


class Track(NamedTuple):
    """What one node's keyframes do while the shutter is open, which is from 0 to 1.

    Attributes
    ----------
    times : tuple of float
        From 0 to 1.
    frames : tuple of Parts
        Neighbouring quaternions are less than a right angle apart.
    """

    times: tuple[float, ...]
    frames: tuple[Parts, ...]


def while_open(moving: Keyframes, shutter: tuple[float, float]) -> Track | Matrix:
    """What is seen of some keyframes; the (4, 4) matrix if nothing of it moves.

    Parameters
    ----------
    moving : Keyframes
    shutter : (float, float)
        Times at which it opens and closes.
    """
    begin, end = shutter
    times = np.array([time for time, _ in moving.frames])
    first = max(int(np.searchsorted(times, begin, "right")) - 1, 0)
    last = min(int(np.searchsorted(times, end, "left")), len(times) - 1)
    seen = [frame.matrix for _, frame in moving.frames[first : last + 1]]
    if all(np.array_equal(matrix, seen[0]) for matrix in seen):
        return seen[0]
    parts = _short_ways([take_apart(matrix) for matrix in seen])
    times = times[first : last + 1]
    if end == begin:
        return _at(times, parts, begin).matrix
    inside = [float(time) for time in times if begin < time < end]
    wanted = _with_halves(times, parts, [begin, *inside, end])
    frames = [_at(times, parts, time) for time in wanted]
    return Track(tuple((time - begin) / (end - begin) for time in wanted), tuple(frames))


def _short_ways(parts: list[Parts]) -> list[Parts]:
    """Of the two quaternions of each rotation the one that is nearer to the one before."""
    for i in range(1, len(parts)):
        if parts[i].turn @ parts[i - 1].turn < 0.0:
            parts[i] = parts[i]._replace(turn=-parts[i].turn)
    return parts


def _at(times: np.ndarray, parts: list[Parts], time: float) -> Parts:
    i = int(np.clip(np.searchsorted(times, time, "right") - 1, 0, max(len(times) - 2, 0)))
    if len(parts) == 1 or time <= times[0]:
        return parts[0]
    x = min((time - times[i]) / (times[i + 1] - times[i]), 1.0)
    return between(parts[i], parts[i + 1], float(x))


def _with_halves(times: np.ndarray, parts: list[Parts], wanted: list[float]) -> list[float]:
    """Times, with one in the middle where more than a quarter turn lies between two of them.

    Kernels know sine and cosine up to pi / 4 only (`alight.core.motion`).
    """
    result = wanted[:1]
    for a, b in pairwise(wanted):
        angle, _ = arc(_at(times, parts, a).turn, _at(times, parts, b).turn)
        result += [0.5 * (a + b), b] if angle > 0.249 * np.pi else [b]
    return result
