"""A closed room with shining surfaces: soft shadows, and light from wall to wall."""

from __future__ import annotations

from alight.lab.random_scenes import enclosures, lamps
from alight.lab.random_scenes.draft import Draft


def build(draft: Draft) -> None:
    """Put a room, one to three lamps under its ceiling, and furniture."""
    chance = draft.chance.named("room")
    draft.closed, draft.found_by_chance, draft.edges = True, False, (3, 9)
    room = enclosures.any_measures(chance)
    enclosures.walls(draft, room)
    enclosures.look_in(draft, room)
    count = chance.choose((1, 1, 2, 3))
    for place in range(count):
        half = chance.within(0.15, 0.4)
        x = 0.0 if count == 1 else room.x * (-0.6 + 1.2 * place / (count - 1))
        at = (x, 0.98 * room.height, chance.within(-0.5, 0.3) * room.z)
        # So that what is below gets 2 to 6 W/m^2.
        radiance = chance.scaled(2.0, 6.0) / count * room.height**2 / (4.0 * half * half)
        light = lamps.glow(chance.named(place), radiance)
        draft.rectangle("lamp", at, (half, 0, 0), (0, 0, half), light=light)
    enclosures.furniture(draft, room, chance.whole(3, 6))
