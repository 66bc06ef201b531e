"""A scene at rest, as it is when the shutter opens."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from alight.scene.flatten import FlatScene


def at_opening(flat: FlatScene) -> FlatScene:
    """The scene as it is when the shutter opens: nothing moves."""

    def held(placed: Any) -> Any:
        if placed.motion is None:
            return placed
        return placed._replace(to_world=placed.motion.at(0.0) @ placed.to_world, motion=None)

    return replace(
        flat,
        shapes=[held(placed) for placed in flat.shapes],
        lights=[held(placed) for placed in flat.lights],
        camera=held(flat.camera),
    )
