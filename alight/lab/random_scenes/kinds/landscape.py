"""Hills or a plain under a sky with a sun: some texels hold most of the light."""

from __future__ import annotations

from alight.lab.random_scenes import lamps, meshes
from alight.lab.random_scenes.draft import Draft


def build(draft: Draft) -> None:
    """Put ground, bodies on it, and a sky; the sun is in its picture, or a light of its own."""
    chance = draft.chance.named("landscape")
    draft.found_by_chance = False
    if chance.happens(0.5):
        shape = meshes.hills(chance, 24.0, chance.within(0.5, 3.0))
        draft.add("ground", shape=shape, bsdf=draft.material("wall"))
    else:
        draft.ground()
    irradiance = chance.scaled(1.5, 4.0)
    if chance.happens(0.25):
        draft.environment = lamps.surround(chance, 0.3 * irradiance, 0.0, ["sky", "constant"])
        draft.add("sun", light=lamps.surround(chance.named("sun"), irradiance, 0.0, ["sun"]))
    else:
        contrast = chance.scaled(1.0, 10.0)
        names = ["environment", "environment", "sunsky"]
        draft.environment = lamps.surround(chance, irradiance, contrast, names)
    for _ in range(chance.whole(4, 9)):
        radius = chance.scaled(0.3, 0.9)
        at = (chance.within(-2.0, 2.0), radius, chance.within(-2.5, 1.5))
        draft.thing("thing", at, radius)
    draft.look((chance.within(-2.0, 2.0), chance.within(1.0, 3.0), 7.0), (0.0, 0.5, 0.0), 2.2)
