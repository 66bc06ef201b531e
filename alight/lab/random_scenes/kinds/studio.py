"""Bodies in even surroundings, the easiest light there is: what is left is noise at edges."""

from __future__ import annotations

from alight.lab.random_scenes import lamps
from alight.lab.random_scenes.draft import Draft


def build(draft: Draft) -> None:
    """Put bodies of any material, mostly on ground, in surroundings without a bright spot."""
    chance = draft.chance.named("studio")
    names = [name for name in lamps.models_at("environment") if name not in ("sun", "sunsky")]
    draft.environment = lamps.surround(chance, chance.scaled(1.5, 3.5), 0.0, names)
    if chance.happens(0.8):
        draft.ground()
    for _ in range(chance.whole(4, 8)):
        radius = chance.scaled(0.3, 0.7)
        at = (chance.within(-1.4, 1.4), radius, chance.within(-1.4, 1.2))
        draft.thing("thing", at, radius)
    draft.look((chance.within(-2.0, 2.0), chance.within(0.8, 3.0), 5.0), (0.0, 0.5, 0.0), 1.7)
