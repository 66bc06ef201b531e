"""Textures on everything: noise that pixel filters are there for."""

from __future__ import annotations

from alight.lab.random_scenes import lamps
from alight.lab.random_scenes.draft import Draft


def build(draft: Draft) -> None:
    """Put textured ground and bodies, a lamp with a picture, and light from all sides."""
    chance = draft.chance.named("textures")
    draft.ground("textured")
    for _ in range(chance.whole(4, 8)):
        radius = chance.scaled(0.3, 0.7)
        at = (chance.within(-1.4, 1.4), radius, chance.within(-1.4, 1.0))
        role = chance.choose(("textured", "textured", "textured", "any_material"))
        draft.thing("thing", at, radius, role)
    half = chance.within(0.3, 0.8)
    radiance = chance.scaled(2.0, 5.0) * 9.0 / (4.0 * half * half)
    at = (chance.within(-1.5, 1.5), 3.0, chance.within(-1.0, 1.0))
    light = lamps.glow(chance, radiance, 0.8)
    draft.rectangle("lamp", at, (half, 0, 0), (0, 0, half), light=light)
    draft.environment = lamps.surround(chance, chance.scaled(0.5, 2.0), 0.0)
    draft.look((chance.within(-2.0, 2.0), chance.within(1.0, 3.0), 5.0), (0.0, 0.5, 0.0), 1.8)
