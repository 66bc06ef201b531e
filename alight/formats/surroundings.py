r"""What a model needs to be seen, where its file has none: light around it, and a camera.

The camera looks at the model from the front (glTF's and most programs' front is +z, up is +y), 30
degrees to the right and 20 above, and stands so near that the model fills the picture but for a
margin. With the camera's axes u, v, w (w backwards) and :math:`t_x, t_y`, the tangents of half the
opening angles within the margin, a vertex p is in the picture if

.. math:: |p_u - c_u| \le t_x (c_w - p_w), \qquad |p_v - c_v| \le t_y (c_w - p_w)

so the nearest camera c follows from four largest values over all vertices: for one side,
:math:`A_\pm = \max(\pm p_u + t_x p_w)`, :math:`c_w = (A_+ + A_-) / (2 t_x)` and
:math:`c_u = (A_+ - A_-) / 2`. Of both sides the one that asks for more distance wins. The light is
the picture ``builtin:studio``, turned such that it is the same as seen from any camera.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from alight.cameras.basis import perspective_half_extents
from alight.formats.report import Report

STUDIO = "builtin:studio"
NO_LIGHT = "the file has no light: a soft studio stands around it (environment)"
FAINT_LIGHT = (
    "what shines in the file is too faint to see it by: a soft studio stands around it "
    "(environment)"
)
NO_CAMERA = "the file has no camera: one was placed that sees all of it (camera)"
SIZE = (800, 600)
FOV, TO_THE_RIGHT, ABOVE = 40.0, 30.0, 20.0  # degrees
#: Of both sides, so that wide and high pictures are not distorted at their ends.
FOV_AXIS = "larger"
#: Part of the picture's sides that is left free on each edge.
MARGIN = 0.05
#: Least depth of a vertex, in radii of the sphere around the box: from nearer, a rod that points at
#: the camera would be all tip.
NEAREST = 0.5


@dataclass
class Bounds:
    """The points that an automatic camera must see, and the axis-aligned box around them.

    Attributes
    ----------
    low, high : (3,) float64, metres
    parts : list of ((n, 3) array, (4, 4) float64)
        Points as they were added, and the matrix to the world.
    """

    low: NDArray[np.float64] = field(default_factory=lambda: np.full(3, np.inf))
    high: NDArray[np.float64] = field(default_factory=lambda: np.full(3, -np.inf))
    parts: list[tuple[ArrayLike, NDArray[np.float64]]] = field(default_factory=list)

    def add(self, points: ArrayLike, to_world: NDArray[np.float64]) -> None:
        """Enclose points (n, 3) after a (4, 4) matrix."""
        self.parts.append((points, to_world))
        low, high = self._extremes(points, to_world, np.eye(3))
        self.low, self.high = np.minimum(self.low, low), np.maximum(self.high, high)

    @property
    def sphere(self) -> tuple[NDArray[np.float64], float]:
        """Centre and radius of the sphere through the corners; a unit one around nothing."""
        if not (np.isfinite(self.low).all() and np.isfinite(self.high).all()):
            return np.zeros(3), 1.0
        radius = 0.5 * float(np.linalg.norm(self.high - self.low))
        return 0.5 * (self.low + self.high), radius if radius > 0.0 else 1.0

    def viewpoint(self, size: tuple[int, int]) -> tuple[list[float], list[float]]:
        """Origin and target of the camera that shows everything in a picture of this size."""
        center, radius = self.sphere
        axes = _axes()
        tangents = np.array(perspective_half_extents(FOV, FOV_AXIS, *size)) * (1.0 - 2.0 * MARGIN)
        # Largest values of p_u + t_x p_w, -p_u + t_x p_w, the same of v, and of p_w.
        sides = np.array([axes[0], -axes[0], axes[1], -axes[1], axes[2]])
        sides[:4] += np.repeat(tangents, 2)[:, None] * axes[2]
        largest = np.full(5, -np.inf)
        for points, to_world in self.parts:
            largest = np.maximum(largest, self._extremes(points, to_world, sides)[1])
        if not np.isfinite(largest).all() or not (self.low < self.high).any():
            # A unit sphere, where there is nothing or a point.
            largest = sides @ center + np.linalg.norm(sides, axis=1)
        plus, minus = largest[:4:2], largest[1:4:2]
        nearest = largest[4] + NEAREST * radius
        distance = max(nearest, *((plus + minus) / (2.0 * tangents)))
        origin = np.array([*(0.5 * (plus - minus)), distance]) @ axes
        target = origin - (distance - center @ axes[2]) * axes[2]
        return origin.tolist(), target.tolist()

    @staticmethod
    def _extremes(
        points: ArrayLike, to_world: NDArray[np.float64], directions: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Least and largest values of world points along directions (m, 3)."""
        # Directions are taken to the points' space, not a million points to the world's.
        with np.errstate(over="ignore", invalid="ignore"):
            along = np.asarray(points) @ (directions @ to_world[:3, :3]).T
            shift = directions @ to_world[:3, 3]
            return along.min(axis=0) + shift, along.max(axis=0) + shift


def _axes() -> NDArray[np.float64]:
    """Rows u, v, w of the automatic camera."""
    right, above = math.radians(TO_THE_RIGHT), math.radians(ABOVE)
    w = np.array(
        [math.sin(right) * math.cos(above), math.sin(above), math.cos(right) * math.cos(above)]
    )
    u = np.array([math.cos(right), 0.0, -math.sin(right)])
    return np.array([u, np.cross(w, u), w])


def add_light(
    data: dict[str, Any],
    report: Report,
    *,
    shines: bool,
    view: NDArray[np.float64] | None = None,
) -> None:
    """Put the studio around a scene.

    Parameters
    ----------
    shines : bool
        Whether anything in the scene shines, too faintly (`glow`).
    view : (4, 4) float64, optional
        Camera to world of the file's own camera: the studio's front is then turned to it.
    """
    data["environment"] = {"type": "environment", "file": STUDIO}
    if view is not None and (rotation := studio_rotation(view)) != 0.0:
        data["environment"]["rotate"] = rotation
    report.assume("environment.file", FAINT_LIGHT if shines else NO_LIGHT)


def studio_rotation(view: NDArray[np.float64]) -> float:
    """Degrees by which the studio is turned for a camera (4, 4); 0 if it looks up or down."""
    if np.hypot(view[0, 2], view[2, 2]) <= 1e-3 * np.linalg.norm(view[:3, 2]):
        return 0.0
    return math.degrees(math.atan2(view[0, 2], view[2, 2])) - TO_THE_RIGHT


def say_if_empty(report: Report, bounds: Bounds) -> None:
    """Say that a file shows nothing, which its picture would not explain."""
    if not bounds.parts:
        report.approximate("the file holds no surface: there is nothing to see but light")


def add_camera(data: dict[str, Any], report: Report, bounds: Bounds) -> None:
    """Place a camera that sees all of a scene."""
    origin, target = bounds.viewpoint(SIZE)
    data["camera"] = {
        "type": "pinhole",
        "fov": FOV,
        "fov_axis": FOV_AXIS,
        "transform": {"look_at": {"origin": origin, "target": target}},
    }
    data.setdefault("film", {})["size"] = list(SIZE)
    report.assume("camera.transform", NO_CAMERA)


def use_first_camera(data: dict[str, Any], report: Report, paths: Sequence[str]) -> None:
    """Show what the first camera of a file sees, and say so if there are others."""
    data["camera"] = paths[0]
    if len(paths) > 1:
        report.assume(
            "camera",
            f"the picture is that of the first camera, {paths[0]}; others: {', '.join(paths[1:])} "
            "(choose with --camera)",
        )
