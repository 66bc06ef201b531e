"""Glossy things on a glossy table: highlights of lamps and of each other."""

from __future__ import annotations

from alight.lab.random_scenes import lamps
from alight.lab.random_scenes.draft import Draft


def build(draft: Draft) -> None:
    """Put a table, glossy bodies, a lamp above them, and some light from all sides."""
    chance = draft.chance.named("tabletop")
    draft.ground("glossy", half=2.5)
    for _ in range(chance.whole(4, 8)):
        radius = chance.scaled(0.25, 0.6)
        at = (chance.within(-1.3, 1.3), radius, chance.within(-1.3, 1.0))
        draft.thing("thing", at, radius, chance.choose(("glossy", "glossy", "any_material")))
    half = chance.within(0.3, 0.8)
    radiance = chance.scaled(2.0, 6.0) * 9.0 / (4.0 * half * half)
    at = (chance.within(-1.0, 1.0), 3.0, chance.within(-1.0, 1.0))
    draft.rectangle("lamp", at, (half, 0, 0), (0, 0, half), light=lamps.glow(chance, radiance))
    draft.environment = lamps.surround(chance, chance.scaled(0.2, 1.0), 0.0)
    draft.look((chance.within(-1.5, 1.5), chance.within(1.5, 3.0), 4.5), (0.0, 0.3, 0.0), 1.6)
