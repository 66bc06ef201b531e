"""Portals of pbrt's infinite lights: windows through which their light is looked for.

Their corners are points of the world: the transform of their light turns its picture alone.

Source: pbrt-v4, the lights' creation from a file.
"""

from __future__ import annotations

import numpy as np

from alight.formats.pbrt.context import Data
from alight.formats.pbrt.parameters import Parameters
from alight.formats.pbrt.transforms import steps

#: How far the corners of a portal may be from a rectangle's, of its size.
SKEW = 1e-3


def portal(p: Parameters) -> Data | None:
    """The node of an infinite light's portal: four corners in the world, one after another."""
    corners = p.table("portal", "point")
    if corners is None:
        return None
    if corners.shape[0] != 4:
        p.report.error(p.named["portal"], f"must have 4 corners, got {corners.shape[0]}")
        return None
    a, b, c, d = corners
    x, y = 0.5 * (b - a), 0.5 * (d - a)
    size = max(float(np.linalg.norm(x)), float(np.linalg.norm(y)))
    flat = np.linalg.norm(a + c - b - d) <= SKEW * size and abs(x @ y) <= SKEW * size * size
    normal = np.cross(x, y)
    if not flat or not np.linalg.norm(normal) > 0.0:
        p.report.error(p.named["portal"], "must be a rectangle, corner after corner")
        return None
    made = np.eye(4)
    made[:3, 0], made[:3, 1], made[:3, 2] = x, y, normal / np.linalg.norm(normal) * size
    made[:3, 3] = 0.25 * (a + b + c + d)
    text = "light that does not come through its portal counts, too"
    p.report.warn(p.directive, text)
    return {"light": {"type": "portal"}, "transform": steps(made)}
