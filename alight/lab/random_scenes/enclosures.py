"""Rooms: four walls, floor and ceiling that face inwards, the left wall with or without a hole."""

from __future__ import annotations

from typing import NamedTuple

from alight.lab.random_scenes.chance import Chance
from alight.lab.random_scenes.draft import Draft


class Measures(NamedTuple):
    """A room around the y axis with its floor at y = 0, in metres: half its width and depth."""

    x: float
    height: float
    z: float


class Hole(NamedTuple):
    """A part of the left wall: from y0 to y1, and from z0 to z1."""

    y0: float
    y1: float
    z0: float
    z1: float


def any_measures(chance: Chance) -> Measures:
    """A room of 2 to 6 metres."""
    return Measures(chance.within(1.2, 2.5), chance.within(2.0, 3.0), chance.within(1.5, 3.0))


def walls(draft: Draft, room: Measures, hole: Hole | None = None) -> None:
    """Put the six sides of a room."""
    x, h, z = room.x, room.height, room.z
    middle = 0.5 * h
    draft.rectangle("floor", (0, 0, 0), (x, 0, 0), (0, 0, -z))
    draft.rectangle("ceiling", (0, h, 0), (x, 0, 0), (0, 0, z))
    draft.rectangle("back", (0, middle, -z), (x, 0, 0), (0, middle, 0))
    draft.rectangle("front", (0, middle, z), (-x, 0, 0), (0, middle, 0))
    draft.rectangle("right", (x, middle, 0), (0, 0, z), (0, middle, 0))
    parts = [Hole(0.0, h, -z, z)]
    if hole is not None:
        parts = [
            Hole(0.0, hole.y0, -z, z),
            Hole(hole.y1, h, -z, z),
            Hole(hole.y0, hole.y1, -z, hole.z0),
            Hole(hole.y0, hole.y1, hole.z1, z),
        ]
    for part in parts:
        if part.y1 > part.y0 and part.z1 > part.z0:
            center = (-x, 0.5 * (part.y0 + part.y1), 0.5 * (part.z0 + part.z1))
            sides = (0.0, 0.0, 0.5 * (part.z0 - part.z1)), (0.0, 0.5 * (part.y1 - part.y0), 0.0)
            draft.rectangle("left", center, *sides)


def furniture(draft: Draft, room: Measures, count: int) -> None:
    """Put bodies on the floor, in the back two thirds of a room."""
    chance = draft.chance.named("furniture")
    for _ in range(count):
        radius = chance.within(0.15, 0.3) * room.x
        x = chance.within(-0.7, 0.7) * room.x
        z = chance.within(-0.75, 0.0) * room.z
        draft.thing("thing", (x, radius, z), radius)


def look_in(draft: Draft, room: Measures) -> None:
    """Look at the back of a room from its front."""
    chance = draft.chance.named("look")
    origin = (chance.within(-0.4, 0.4) * room.x, 0.5 * room.height, 0.95 * room.z)
    target = (0.0, chance.within(0.3, 0.5) * room.height, -0.5 * room.z)
    draft.look(origin, target, 0.7 * room.x, indoors=True)
