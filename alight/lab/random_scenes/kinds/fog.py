"""Fog, smoke and clouds with lamps: light that turns somewhere between the surfaces."""

from __future__ import annotations

from alight.bsdfs.dielectrics.null import Null
from alight.lab.random_scenes import fogs, lamps
from alight.lab.random_scenes.draft import Draft
from alight.scene.transform import scale, translate
from alight.shapes.cube import Cube


def build(draft: Draft) -> None:
    """Put ground, bodies, fog everywhere or in a box, and lamps of both sorts."""
    chance = draft.chance.named("fog")
    draft.found_by_chance = False
    draft.ground(half=4.0)
    everywhere = chance.happens(0.5)
    if everywhere:
        draft.medium = fogs.any_medium(chance, chance.scaled(0.3, 2.0), 6.0)
    if not everywhere or chance.happens(0.3):
        _cloud(draft)
    for _ in range(chance.whole(2, 5)):
        radius = chance.scaled(0.3, 0.6)
        at = (chance.within(-1.8, 1.8), radius, chance.within(-2.0, 0.5))
        draft.thing("thing", at, radius)
    for number in range(chance.whole(1, 3)):
        own = chance.named(number)
        at = (own.within(-2.0, 2.0), own.within(2.0, 3.0), own.within(-1.5, 1.5))
        if own.happens(0.5):
            radius = own.scaled(0.05, 0.4)
            light = lamps.glow(own, own.scaled(4.0, 12.0) * 2.0 / (radius * radius), 0.0)
            draft.rectangle("lamp", at, (radius, 0, 0), (0, 0, radius), light=light)
        else:
            light = lamps.small_lamp(own, 2.5, own.scaled(2.0, 8.0))
            draft.add("lamp", light=light, transform=lamps.aimed(own, at, (0.0, 0.5, 0.0)))
    if chance.happens(0.5):
        draft.environment = lamps.surround(chance, chance.scaled(0.1, 0.8), 0.0)
    draft.look((chance.within(-1.0, 1.0), chance.within(0.8, 2.0), 5.5), (0.0, 0.8, 0.0), 1.8)


def _cloud(draft: Draft) -> None:
    """A box of any medium, without a surface of its own."""
    chance = draft.chance.named("cloud")
    half = [chance.within(0.4, 1.2) for _ in range(3)]
    at = [chance.within(-0.6, 0.6), half[1] + chance.within(0.05, 0.6), chance.within(-0.8, 0.4)]
    low, high = ((*(a + side * h for a, h in zip(at, half, strict=True)),) for side in (-1, 1))
    thickness = chance.scaled(0.5, 8.0)
    draft.media["cloud"] = fogs.boxed_medium(chance, thickness, low, high)
    draft.bsdfs["invisible"] = Null()
    # Objects in a box of fog do not refer to it.
    draft.walked = False
    where = translate(*at) @ scale(*half)
    draft.add("cloud", shape=Cube(), bsdf="invisible", interior="cloud", transform=where)
