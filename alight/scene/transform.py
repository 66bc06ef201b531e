r"""Affine transforms in float64: the value type of the scene graph.

Points are columns: p' = M p, and M = T R S moves a point by the scale first. Directions take the
3 x 3 part of M, normals its inverse transpose, because a normal n satisfies n . v = 0 for every
tangent v, and (M^-T n) . (M v) = n . v.

A `Transform` keeps the steps that it was made of, so that a scene file is written back as read.

Source: PBR4 section 3.9; Rodrigues' formula for rotations about any axis.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from alight.core.errors import Issue, SceneError

Matrix = NDArray[np.float64]

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}

# A matrix is singular where its columns' parallelepiped is this much flatter than their box: the
# inverse would keep fewer than 4 of float64's 16 digits.
FLATTEST = 1e-12


@dataclass(frozen=True)
class Step:
    """One operation as it is written in a scene file.

    Parameters
    ----------
    name : str
        ``translate``, ``rotate``, ``scale``, ``look_at`` or ``matrix``.
    value : object
        Its arguments as plain numbers, tuples and dictionaries.
    """

    name: str
    value: object


@dataclass(frozen=True, eq=False)
class Transform:
    """A 4 x 4 affine matrix.

    Parameters
    ----------
    matrix : (4, 4) float64
        Row-major, applied to column vectors; the last row is (0, 0, 0, 1).
    steps : tuple of Step
        The operations that gave the matrix, in the order in which they are applied.
    """

    matrix: Matrix = field(default_factory=lambda: np.eye(4))
    steps: tuple[Step, ...] = ()

    def __post_init__(self) -> None:
        """Freeze the matrix."""
        self.matrix.setflags(write=False)

    def __matmul__(self, first: Transform) -> Transform:
        """Compose: apply `first`, then this one."""
        return Transform(self.matrix @ first.matrix, first.steps + self.steps)

    def __eq__(self, other: object) -> bool:
        """Compare the matrices bit for bit."""
        return isinstance(other, Transform) and np.array_equal(self.matrix, other.matrix)

    def __hash__(self) -> int:
        """Hash the matrix (adding 0 makes -0 and 0 alike, as they are equal)."""
        return hash((self.matrix + 0.0).tobytes())

    def inverse(self) -> Transform:
        """Invert.

        Raises
        ------
        SceneError
            If the matrix is singular.
        """
        if self.is_singular:
            raise _error("matrix", "is singular: it flattens space, so it has no inverse")
        inverted = np.linalg.inv(self.matrix)
        return matrix(inverted)

    def apply_point(self, points: ArrayLike) -> Matrix:
        """Transform points, shape (..., 3)."""
        return np.asarray(points, np.float64) @ self.matrix[:3, :3].T + self.matrix[:3, 3]

    def apply_vector(self, vectors: ArrayLike) -> Matrix:
        """Transform directions, shape (..., 3); lengths are scaled too."""
        return np.asarray(vectors, np.float64) @ self.matrix[:3, :3].T

    def apply_normal(self, normals: ArrayLike) -> Matrix:
        """Transform normals by the inverse transpose, shape (..., 3); not normalised."""
        return np.asarray(normals, np.float64) @ np.linalg.inv(self.matrix[:3, :3])

    # Found out once: scenes that are made from one another share their transforms.
    @cached_property
    def is_singular(self) -> bool:
        """Whether volumes become (nearly) 0 compared with what lengths alone would give."""
        return is_singular(self.matrix)

    @cached_property
    def largest(self) -> float:
        """The largest number in the matrix, without its sign."""
        return float(np.abs(self.matrix).max())

    @property
    def flips_handedness(self) -> bool:
        """Whether it mirrors: a right-handed frame becomes a left-handed one."""
        return bool(np.linalg.det(self.matrix[:3, :3]) < 0.0)


IDENTITY = Transform()


def is_singular(to_world: Matrix) -> bool:
    """Whether a 4 x 4 matrix has no inverse that float64 can hold; see `FLATTEST`."""
    # In numbers of Python: each call of NumPy takes as long as all of this.
    rows = to_world.tolist()
    if not math.isfinite(sum(map(sum, rows))):
        return True
    columns = []
    for axis in range(3):
        column = rows[0][axis], rows[1][axis], rows[2][axis]
        length = math.hypot(*column)
        if length * length == 0.0:
            return True
        columns.append([number / length for number in column])
    (a, b, c), (d, e, f), (g, h, i) = columns
    return abs(a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)) < FLATTEST


def translate(x: float, y: float, z: float) -> Transform:
    """Move by (x, y, z) metres."""
    result = np.eye(4)
    result[:3, 3] = x, y, z
    return Transform(result, (Step("translate", (float(x), float(y), float(z))),))


def rotate(axis: Sequence[float] | str, angle: float) -> Transform:
    """Rotate about an axis through the origin.

    Parameters
    ----------
    axis : (3,) float or {"x", "y", "z"}
        Any length but 0.
    angle : float, degrees
        Counter-clockwise seen against the axis (right-hand rule).

    Raises
    ------
    SceneError
        If the axis has length 0.
    """
    x, y, z = AXES[axis] if isinstance(axis, str) else (float(a) for a in axis)
    length = math.hypot(x, y, z)
    if length == 0.0:
        raise _error("rotate", "axis must not have length 0, got (0, 0, 0)")
    unit = np.array([x, y, z]) / length
    cosine, sine = _exact_cosine_sine(angle)
    cross = np.array([[0.0, -unit[2], unit[1]], [unit[2], 0.0, -unit[0]], [-unit[1], unit[0], 0.0]])
    result = np.eye(4)
    # Rodrigues: R = cos I + sin [a]x + (1 - cos) a a^T
    result[:3, :3] = cosine * np.eye(3) + sine * cross + (1.0 - cosine) * np.outer(unit, unit)
    return Transform(result, (Step("rotate", {"axis": (x, y, z), "angle": float(angle)}),))


def _exact_cosine_sine(angle: float) -> tuple[float, float]:
    """Cosine and sine of an angle in degrees, exact for multiples of 90."""
    turns, rest = divmod(float(angle), 90.0)
    cosine, sine = math.cos(math.radians(rest)), math.sin(math.radians(rest))
    quarter = ((cosine, sine), (-sine, cosine), (-cosine, -sine), (sine, -cosine))
    return quarter[int(turns) % 4]


def scale(x: float, y: float | None = None, z: float | None = None) -> Transform:
    """Scale by one factor, or by one per axis; negative factors mirror."""
    uniform = y is None or z is None
    factors = (x, x, x) if y is None or z is None else (x, y, z)
    value = float(x) if uniform else tuple(float(f) for f in factors)
    return Transform(np.diag([*map(float, factors), 1.0]), (Step("scale", value),))


def look_at(
    origin: Sequence[float], target: Sequence[float], up: Sequence[float] = (0.0, 1.0, 0.0)
) -> Transform:
    """Stand at `origin` and look along the local -z axis towards `target`.

    Parameters
    ----------
    origin, target : (3,) float, metres
        Two different points.
    up : (3,) float, default +y
        Direction that appears upright; not parallel to the view.

    Raises
    ------
    SceneError
        If `target` is `origin`, or if the view is parallel to `up`.
    """
    origin, target, up = (tuple(float(x) for x in v) for v in (origin, target, up))
    back = np.subtract(origin, target)
    distance, up_length = float(np.linalg.norm(back)), float(np.linalg.norm(up))
    if distance == 0.0:
        raise _error("look_at", f"target must differ from origin, got {target} for both")
    if up_length == 0.0:
        raise _error("look_at", "up must not have length 0, got (0, 0, 0)")
    w = back / distance
    right = np.cross(np.array(up) / up_length, w)
    # The sine of the angle between view and up; below this the picture's roll is arbitrary.
    sine = float(np.linalg.norm(right))
    if sine < 1e-9:
        raise _error(
            "look_at", f"up {up} must not be parallel to the view {tuple((-back).tolist())}"
        )
    u = right / sine
    result = np.eye(4)
    result[:3, 0], result[:3, 1], result[:3, 2], result[:3, 3] = u, np.cross(w, u), w, origin
    value = {"origin": origin, "target": target, "up": up}
    return Transform(result, (Step("look_at", value),))


def matrix(rows: ArrayLike) -> Transform:
    """Use a 4 x 4 matrix as it is, row-major, for column vectors.

    Raises
    ------
    SceneError
        If the shape is not (4, 4), a number is not finite or the last row not (0, 0, 0, 1).
    """
    result = np.array(rows, np.float64)
    if result.shape != (4, 4):
        raise _error("matrix", f"must have shape (4, 4), got {result.shape}")
    if not np.isfinite(result).all():
        raise _error("matrix", "must be finite")
    if not np.array_equal(result[3], [0.0, 0.0, 0.0, 1.0]):
        raise _error("matrix", f"last row must be (0, 0, 0, 1), got {tuple(result[3].tolist())}")
    value = tuple(tuple(row) for row in result.tolist())
    return Transform(result, (Step("matrix", value),))


def _error(path: str, message: str) -> SceneError:
    return SceneError([Issue(path, message)])
