"""Many small lamps, each visible and lighting what is near: which one is sampled matters."""

from __future__ import annotations

from alight.lab.random_scenes import bodies, lamps
from alight.lab.random_scenes.draft import Draft
from alight.scene.transform import scale, translate


def build(draft: Draft) -> None:
    """Put ground, bodies, and 20 to 150 lamps above them, some without a size."""
    chance = draft.chance.named("many lamps")
    draft.found_by_chance = False
    draft.ground(half=4.0)
    count = round(chance.scaled(20.0, 150.0))
    radius = chance.scaled(0.01, 0.06)
    shapes = chance.among(_shining(), 2)
    sized = chance.choose((1.0, 1.0, 0.7, 0.0))
    names = chance.among(lamps.models_at("node"), 2)
    for number in range(count):
        own = chance.named(number)
        at = (own.within(-3.0, 3.0), own.within(0.3, 2.2), own.within(-3.0, 2.0))
        # Together they give some W/m^2 where each is about a metre away.
        irradiance = own.scaled(2.0, 20.0) / count
        if own.happens(sized):
            shape, fitted = bodies.any_body(own, shapes)
            where = translate(*at) @ scale(radius) @ fitted
            light = lamps.glow(own, irradiance / (3.0 * radius * radius), 0.0)
            draft.add("lamp", shape=shape, light=light, transform=where)
        else:
            light = lamps.small_lamp(own, 1.0, irradiance, names)
            draft.add("lamp", light=light, transform=lamps.aimed(own, at, (at[0], 0.0, at[2])))
    for _ in range(chance.whole(3, 7)):
        half = chance.scaled(0.3, 0.7)
        draft.thing("thing", (chance.within(-2.0, 2.0), half, chance.within(-2.0, 1.0)), half)
    draft.look((chance.within(-2.0, 2.0), chance.within(3.0, 5.0), 7.0), (0.0, 0.4, 0.0), 2.4)


def _shining() -> list[str]:
    """Shapes that are cheap to be lights: a light for each triangle would be too many."""
    return [name for name in bodies.finite_shapes() if name not in ("mesh", "cube")]
