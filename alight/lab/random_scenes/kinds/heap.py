"""A heap of instances of some prototypes: small parts, edges everywhere, and deep trees."""

from __future__ import annotations

from alight.lab.random_scenes import bodies, lamps
from alight.lab.random_scenes.draft import Draft
from alight.scene.description import Node


def build(draft: Draft) -> None:
    """Put ground, 20 to 80 instances in the shape of a heap, a lamp, and light from all sides."""
    chance = draft.chance.named("heap")
    draft.ground()
    names = [f"part-{number}" for number in range(chance.whole(1, 3))]
    for name in names:
        draft.prototypes[name] = _prototype(draft, name)
    for number in range(round(chance.scaled(20.0, 80.0))):
        own = chance.named(number)
        height = own.number() ** 1.5
        reach = 1.5 * (1.0 - height) + 0.2
        at = (own.within(-reach, reach), 0.15 + 1.6 * height, own.within(-reach, reach))
        where = draft.placed(own, at, own.scaled(0.12, 0.35))
        draft.add("piece", instance=own.choose(names), transform=where)
    half = chance.within(0.2, 0.7)
    radiance = chance.scaled(2.0, 5.0) * 12.0 / (4.0 * half * half)
    at = (chance.within(-2.0, 2.0), 4.0, chance.within(0.0, 1.5))
    draft.rectangle("lamp", at, (half, 0, 0), (0, 0, half), light=lamps.glow(chance, radiance))
    draft.environment = lamps.surround(chance, chance.scaled(0.3, 2.0), chance.choose((0.0, 1.0)))
    draft.look((chance.within(-2.0, 2.0), chance.within(1.5, 3.5), 6.0), (0.0, 0.8, 0.0), 2.0)


def _prototype(draft: Draft, name: str) -> Node:
    """One or two bodies side by side, in the unit ball."""
    chance = draft.chance.named(name)
    children = {}
    for number in range(chance.whole(1, 2)):
        shape, fitted = bodies.any_body(chance.named(number))
        bsdf = draft.material("any_material")
        children[f"body-{number}"] = Node(shape=shape, bsdf=bsdf, transform=fitted)
    return Node(children=children)
