"""What a model needs to be seen, where its file has none: light around it, and a camera.

The camera stands in front of the model (glTF's and most programs' front is +z, up is +y), 30
degrees to the right and 20 above, and sees the sphere around its bounding box. The light is the
picture ``builtin:studio``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from alight.scene.formats.report import Report

STUDIO = "builtin:studio"
NO_LIGHT = "the file has no light: a soft studio stands around it (environment)"
NO_CAMERA = "the file has no camera: one was placed that sees all of it (camera)"
SIZE = [800, 600]
FOV, TO_THE_RIGHT, ABOVE = 35.0, 30.0, 20.0  # degrees


@dataclass
class Bounds:
    """The axis-aligned box around points.

    Attributes
    ----------
    low, high : (3,) float64, metres
    """

    low: NDArray[np.float64] = field(default_factory=lambda: np.full(3, np.inf))
    high: NDArray[np.float64] = field(default_factory=lambda: np.full(3, -np.inf))

    def add(self, points: ArrayLike, to_world: NDArray[np.float64]) -> None:
        """Enclose points (n, 3) after a (4, 4) matrix."""
        linear, shift = to_world[:3, :3], to_world[:3, 3]
        with np.errstate(over="ignore", invalid="ignore"):
            moved = np.asarray(points, np.float64) @ linear.T + shift
        self.low = np.minimum(self.low, moved.min(axis=0))
        self.high = np.maximum(self.high, moved.max(axis=0))

    @property
    def sphere(self) -> tuple[NDArray[np.float64], float]:
        """Centre and radius of the sphere through the corners; a unit one around nothing."""
        if not (np.isfinite(self.low).all() and np.isfinite(self.high).all()):
            return np.zeros(3), 1.0
        radius = 0.5 * float(np.linalg.norm(self.high - self.low))
        return 0.5 * (self.low + self.high), radius if radius > 0.0 else 1.0


def add_light(data: dict[str, Any], report: Report) -> None:
    """Put the studio around a scene."""
    data["environment"] = {"type": "environment", "file": STUDIO}
    report.approximate(NO_LIGHT)


def add_camera(data: dict[str, Any], report: Report, bounds: Bounds) -> None:
    """Place a camera that sees all of a scene."""
    center, radius = bounds.sphere
    distance = radius / math.sin(math.radians(0.5 * FOV))
    right, above = math.radians(TO_THE_RIGHT), math.radians(ABOVE)
    direction = np.array(
        [math.sin(right) * math.cos(above), math.sin(above), math.cos(right) * math.cos(above)]
    )
    view = {"origin": (center + distance * direction).tolist(), "target": center.tolist()}
    data["camera"] = {
        "type": "pinhole",
        "fov": FOV,
        "fov_axis": "smaller",
        "transform": {"look_at": view},
    }
    data.setdefault("film", {})["size"] = list(SIZE)
    report.approximate(NO_CAMERA)
