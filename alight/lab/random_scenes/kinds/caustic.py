"""Glass before a small lamp: its bright figures on the ground are found by chance only."""

from __future__ import annotations

from alight.lab.random_scenes import lamps
from alight.lab.random_scenes.draft import Draft


def build(draft: Draft) -> None:
    """Put ground, clear bodies and perhaps a solid one, and a lamp that paths can hit."""
    chance = draft.chance.named("caustic")
    draft.edges, draft.found_by_chance = (6, 16), False
    draft.ground(half=3.0)
    for _ in range(chance.whole(1, 3)):
        radius = chance.scaled(0.35, 0.8)
        at = (chance.within(-1.0, 1.0), radius, chance.within(-1.0, 0.7))
        shapes = ["sphere", "sphere", "cube", "mesh", "cylinder"]
        draft.thing("glass", at, radius, "clear", shapes=shapes)
    if chance.happens(0.5):
        draft.thing("thing", (chance.within(-1.5, 1.5), 0.4, -1.4), 0.4)
    half = chance.scaled(0.1, 0.6)
    radiance = chance.scaled(2.0, 5.0) * 12.0 / (4.0 * half * half)
    at = (chance.within(-1.5, 1.5), 3.5, chance.within(-1.0, 1.0))
    draft.rectangle("lamp", at, (half, 0, 0), (0, 0, half), light=lamps.glow(chance, radiance, 0.0))
    if chance.happens(0.6):
        irradiance = chance.scaled(0.1, 0.6)
        draft.environment = lamps.surround(chance, irradiance, 0.0, ["constant", "environment"])
    draft.look((chance.within(-2.0, 2.0), chance.within(2.0, 4.0), 5.0), (0.0, 0.4, 0.0), 1.8)
