"""Things, lamps and the camera in motion while the shutter is open: edges become ramps."""

from __future__ import annotations

from alight.lab.random_scenes import lamps
from alight.lab.random_scenes.draft import Draft
from alight.scene.keyframes import keyframes
from alight.scene.transform import translate


def build(draft: Draft) -> None:
    """Put ground, mostly moving bodies, a lamp that may move, and light from all sides."""
    chance = draft.chance.named("moving")
    draft.moving = 0.8
    draft.ground()
    for _ in range(chance.whole(3, 7)):
        radius = chance.scaled(0.3, 0.6)
        at = (chance.within(-1.4, 1.4), 1.2 * radius, chance.within(-1.4, 1.0))
        draft.thing("thing", at, radius)
    half = chance.within(0.2, 0.6)
    radiance = chance.scaled(2.0, 6.0) * 9.0 / (4.0 * half * half)
    at = (chance.within(-1.5, 1.5), 3.0, chance.within(-1.0, 1.0))
    light = lamps.glow(chance, radiance)
    draft.rectangle("lamp", at, (half, 0, 0), (0, 0, half), light=light)
    if chance.happens(0.5):
        way = translate(chance.within(-1.5, 1.5), 0.0, chance.within(-1.0, 1.0))
        lamp = draft.nodes["lamp"]
        moved = keyframes({0.0: lamp.transform, 1.0: way @ lamp.transform})
        draft.nodes["lamp"] = lamp.replaced(transform=moved)
    draft.environment = lamps.surround(chance, chance.scaled(0.3, 2.0), 0.0)
    draft.look((chance.within(-2.0, 2.0), chance.within(1.0, 3.0), 5.5), (0.0, 0.6, 0.0), 1.9)
    shutter = {"shutter": (0.0, chance.within(0.3, 1.0))}
    assert draft.camera is not None
    assert draft.camera.camera is not None
    seen = draft.camera.camera.replaced(**shutter)
    draft.camera = draft.camera.replaced(camera=seen)
    if chance.happens(0.3):
        way = translate(chance.within(-0.3, 0.3), 0.0, chance.within(-0.3, 0.3))
        view = draft.camera.transform
        draft.camera = draft.camera.replaced(transform=keyframes({0.0: view, 1.0: way @ view}))
