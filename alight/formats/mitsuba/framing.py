"""A camera and light for files of Mitsuba that hold shapes alone."""

from __future__ import annotations

from typing import Any

from alight.core.spec import Camera
from alight.formats.geometry.bounds import Bounds
from alight.formats.mitsuba.context import Context, Data
from alight.formats.scenes.surroundings import add_camera, add_floor, add_light
from alight.scene.motion import NOWHERE, Placement
from alight.scene.steps import parse_transform

MOST_LEVELS = 16


def surround(context: Context, data: Data, nodes: dict[str, Any]) -> Bounds:
    """Place a camera that sees all shapes, and a studio around them if nothing shines.

    Returns
    -------
    Bounds
        What the camera sees.
    """
    bounds = Bounds()
    _add(context, bounds, nodes, NOWHERE)
    add_camera(data, context.report, bounds)
    shines = any("light" in node for node in nodes.values())
    if not shines and "environment" not in data:
        add_light(data, context.report, shines=False)
        add_floor(nodes, bounds)
    return bounds


def _add(
    context: Context, bounds: Bounds, nodes: dict[str, Any], above: Placement, level: int = 0
) -> None:
    for node in nodes.values():
        # Building the scene reports what is wrong with it.
        transform = parse_transform(node.get("transform", []), lambda issue: None)
        here = above.then(transform, Camera().shutter)
        if node.get("shape") is not None:
            bounds.add(node["shape"], here.matrix, here.motion)
        prototype = context.tables["prototypes"].get(node.get("instance"), {})
        if prototype and level < MOST_LEVELS:
            _add(context, bounds, prototype["children"], here, level + 1)
