"""What a model needs to be seen, where its file has none: light around it, and a camera.

The light is the picture ``builtin:studio``, turned such that it is the same as seen from any
camera; `alight.formats.bounds` tells where the camera stands.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from alight.formats.bounds import FOV, FOV_AXIS, TO_THE_RIGHT, Bounds
from alight.formats.report import Report

STUDIO = "builtin:studio"
NO_LIGHT = "the file has no light: a soft studio stands around it (environment)"
FAINT_LIGHT = (
    "what shines in the file is too faint to see it by: a soft studio stands around it "
    "(environment)"
)
NO_CAMERA = "the file has no camera: one was placed that sees all of it (camera)"
SIZE = (800, 600)


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
