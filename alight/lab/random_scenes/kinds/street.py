"""A street at night: spots, projectors and lamps with profiles, hard shadows, and darkness."""

from __future__ import annotations

from alight.lab.random_scenes import lamps
from alight.lab.random_scenes.draft import Draft
from alight.scene.transform import scale, translate
from alight.shapes.cube import Cube


def build(draft: Draft) -> None:
    """Put ground, houses, bodies between them, lamps without a size, and lit windows."""
    chance = draft.chance.named("street")
    draft.ground()
    for side in (-1.0, 1.0):
        for row in range(chance.whole(1, 3)):
            size = [0.8, chance.within(0.8, 2.5), chance.within(0.6, 1.0)]
            at = translate(side * chance.within(2.6, 3.2), size[1], -2.2 * row)
            where = at @ scale(*size)
            draft.add("house", shape=Cube(), bsdf=draft.material("wall"), transform=where)
    for number in range(chance.whole(2, 6)):
        own = chance.named(number)
        at = (own.within(-1.8, 1.8), own.within(1.5, 2.8), own.within(-3.0, 2.0))
        light = lamps.small_lamp(own, 2.0, own.scaled(3.0, 12.0))
        foot = (0.7 * at[0] + own.within(-0.5, 0.5), 0.0, at[2] + own.within(-0.5, 0.5))
        draft.add("lamp", light=light, transform=lamps.aimed(own, at, foot))
    for _ in range(chance.whole(0, 3)):
        side = chance.choose((-1.0, 1.0))
        at = (1.75 * side, chance.within(0.6, 1.6), chance.within(-4.0, 0.5))
        light = lamps.glow(chance, chance.scaled(1.0, 8.0), 0.5)
        draft.rectangle("shop", at, (0, 0, side * 0.4), (0, 0.3, 0), light=light)
    for _ in range(chance.whole(3, 7)):
        radius = chance.scaled(0.2, 0.5)
        draft.thing("thing", (chance.within(-1.2, 1.2), radius, chance.within(-2.5, 1.5)), radius)
    if chance.happens(0.5):
        draft.environment = lamps.surround(chance, chance.scaled(0.01, 0.1), 0.0, ["constant"])
    draft.look((chance.within(-0.8, 0.8), chance.within(1.0, 2.5), 6.5), (0.0, 0.6, 0.0), 2.0)
