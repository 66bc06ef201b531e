"""A dark room with a door ajar to one with a lamp: nearly all light comes the long way around."""

from __future__ import annotations

from alight.lab.random_scenes import enclosures, lamps
from alight.lab.random_scenes.draft import Draft


def build(draft: Draft) -> None:
    """Put a room with a gap, a box with a lamp beyond it, and furniture."""
    chance = draft.chance.named("door")
    draft.closed, draft.found_by_chance, draft.edges = True, False, (5, 12)
    room = enclosures.any_measures(chance)
    gap = chance.within(0.08, 0.35) * room.z
    z = chance.within(-0.4, 0.0) * room.z
    hole = enclosures.Hole(0.0, 0.8 * room.height, z, z + gap)
    enclosures.walls(draft, room, hole)
    enclosures.look_in(draft, room)
    x, h = -2.0 * room.x, room.height
    left, middle = x - room.x, 0.5 * h
    draft.rectangle("hall", (x, 0, 0), (room.x, 0, 0), (0, 0, -room.z))
    draft.rectangle("hall", (x, h, 0), (room.x, 0, 0), (0, 0, room.z))
    draft.rectangle("hall", (x, middle, -room.z), (room.x, 0, 0), (0, middle, 0))
    draft.rectangle("hall", (x, middle, room.z), (-room.x, 0, 0), (0, middle, 0))
    draft.rectangle("hall", (left, middle, 0), (0, 0, -room.z), (0, middle, 0))
    half = chance.within(0.1, 0.3)
    radiance = chance.scaled(20.0, 80.0) * room.height**2 / (4.0 * half * half)
    at = (x, 0.98 * h, chance.within(-0.3, 0.3) * room.z)
    light = lamps.glow(chance, radiance, 0.0)
    draft.rectangle("lamp", at, (half, 0, 0), (0, 0, half), light=light)
    enclosures.furniture(draft, room, chance.whole(3, 6))
