"""Questions about a place of the picture: one path through a pixel, and why a region is noisy."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from alight.cameras.basis import project_points
from alight.cameras.model import CAMERAS
from alight.lab.why import shares_of
from alight.lab.why.words import ranked, share_tables
from alight.rendering.tracing.trace import trace
from alight.rendering.tracing.traced_path import Vertex
from alight.view.live import LiveScene
from alight.view.pose import Pose

#: Pixels of the longer side of the small picture in which noise is divided up, and its samples.
WHY_SIZE, WHY_SPP = 192, 64

#: Share of the distance to the pivot at which lines are cut off that come towards the camera, and
#: the length of those that leave the scene.
_NEAR, _FAR = 1e-3, 100.0

Point = np.ndarray


def path_through(live: LiveScene, x: int, y: int, sample: int) -> dict[str, Any]:
    """Trace a sample of a pixel of the window, and project its path onto the picture.

    Returns
    -------
    dict
        ``value`` (what the film adds), ``lines`` (``kind`` path, light or shadow, and two points
        in pixels of the window each) and ``vertices`` (words and figures of each).

    Raises
    ------
    AlightError
        For scenes that plain Python cannot trace.
    """
    left, top, width, height = live.movable.window
    at = left + min(x, width - 1), top + min(y, height - 1)
    options, pose = live.movable.options, live.pose
    kept = {} if options.replicates is None else {"replicates": options.replicates}
    found = trace(live.scene, at, sample=sample, seed=options.seed, **kept)
    lines = []
    for vertex in found.vertices:
        origin = np.array(vertex.origin)
        end = vertex.position
        if end is None:
            end = origin + _FAR * pose.distance * np.array(vertex.direction)
        lines.append(_line(live, pose, "path", origin, np.array(end)))
        light = vertex.light
        if light is not None and vertex.position is not None and light.visible is not None:
            here = np.array(vertex.position)
            far = min(light.distance, _FAR * pose.distance)
            kind = "light" if light.visible else "shadow"
            lines.append(_line(live, pose, kind, here, here + far * np.array(light.wi)))
    return {
        "x": x, "y": y, "sample": sample, "number": live.wish.number,
        "value": _numbers(found.value), "lines": [line for line in lines if line],
        "vertices": [_told(vertex) for vertex in found.vertices],
    }  # fmt: skip


def why_noisy(live: LiveScene, x: int, y: int, width: int, height: int) -> dict[str, Any]:
    """Divide up the variance of a region of the window, in pixels.

    Returns
    -------
    dict
        ``error`` (relative, of a sample per pixel), ``parts`` (words, share and standard error, the
        largest first) and ``tables`` (title and rows of words).

    Raises
    ------
    AlightError
        For an integrator that does not say where its light comes from.
    """
    (left, top, _, _), (across, down) = live.movable.window, live.movable.size
    region = (left + x) / across, (top + y) / down, width / across, height / down
    shares = shares_of(live.scene, size=WHY_SIZE, spp=WHY_SPP, region=region)
    return {
        "error": float(np.sqrt(max(shares.relative_variance, 0.0))),
        "parts": [[str(part), *share] for part, share in ranked(shares).items()],
        "tables": [[title, rows] for title, rows in share_tables(shares)],
    }


def _line(live: LiveScene, pose: Pose, kind: str, a: Point, b: Point) -> dict[str, Any] | None:
    """A line of the scene on the window; None if all of it is behind the camera."""
    model, movable = CAMERAS[pose.camera.type_name()], live.movable
    if model.PERSPECTIVE:
        ahead = -pose.to_world[:3, 2] / np.linalg.norm(pose.to_world[:3, 2])
        near = _NEAR * pose.distance
        depths = [float((point - pose.origin) @ ahead) - near for point in (a, b)]
        if max(depths) <= 0.0:
            return None
        if min(depths) < 0.0:
            cut = a + (b - a) * (depths[0] / (depths[0] - depths[1]))
            a, b = (cut, b) if depths[0] < 0.0 else (a, cut)
    extents = model.half_extents(pose.camera, *movable.size)
    points = project_points(
        np.array([a, b]), extents, movable.size, pose.to_world, model.PERSPECTIVE
    )
    points = points[:, :2] - movable.window[:2]
    # The page draws with floats that hold no more.
    return {"kind": kind, "points": np.clip(points, -1e6, 1e6).round(3).tolist()}


def _told(vertex: Vertex) -> dict[str, Any]:
    """One row of the page's table."""
    if vertex.position is None:
        place = "leaves the scene"
    elif vertex.shape is None:
        place = "scattered in a medium"
    else:
        place = vertex.shape
    return {
        "depth": vertex.depth,
        "place": place,
        "bsdf": vertex.bsdf or "",
        "lobe": vertex.scattering.lobe if vertex.scattering else "",
        "contribution": _numbers(vertex.contribution),
    }


def _numbers(values: Iterable[float]) -> list[float | None]:
    """Plain JSON knows no NaN and no infinity."""
    return [value if math.isfinite(value) else None for value in values]
