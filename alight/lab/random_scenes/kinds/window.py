"""A room into which daylight comes through a window: most directions to the sky are blocked."""

from __future__ import annotations

import math

from alight.lab.random_scenes import enclosures, lamps
from alight.lab.random_scenes.draft import Draft
from alight.lights.portal import Portal
from alight.scene.transform import rotate, scale, translate


def build(draft: Draft) -> None:
    """Put a room with a hole, surroundings, perhaps a portal in the hole, and furniture."""
    chance = draft.chance.named("window")
    draft.closed, draft.found_by_chance, draft.edges = True, False, (4, 10)
    room = enclosures.any_measures(chance)
    half_y, half_z = chance.within(0.2, 0.35) * room.height, chance.within(0.2, 0.5) * room.z
    y, z = chance.within(0.45, 0.6) * room.height, chance.within(-0.4, 0.1) * room.z
    hole = enclosures.Hole(y - half_y, y + half_y, z - half_z, z + half_z)
    enclosures.walls(draft, room, hole)
    enclosures.look_in(draft, room)
    share = half_y * half_z / (room.height * room.z)
    irradiance = chance.scaled(1.5, 4.0) / share
    # Bright from the left, where the hole is; the sun alone would leave the room to its patch.
    names = [name for name in lamps.models_at("environment") if name != "sun"]
    contrast = chance.choose((0.0, 0.0, 0.5))
    draft.environment = lamps.surround(chance, irradiance, contrast, names, turn=math.pi)
    if chance.happens(0.5):
        where = translate(-room.x, y, z) @ rotate("y", -90.0) @ scale(half_z, half_y, 1.0)
        draft.add("portal", light=Portal(), transform=where)
    enclosures.furniture(draft, room, chance.whole(3, 6))
