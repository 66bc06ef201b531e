"""One more scene for `mitsuba_scenes`: pictures on walls, balls and in roughnesses."""

from typing import Any

import numpy as np
from mitsuba_parts import SceneDict, ball, ceiling_light, rgb, room, scene

# 8 bits a channel, lower row first: Mitsuba's v runs down the rows.
COLORS = (
    ((0xE0, 0x30, 0x20), (0x30, 0x90, 0x40), (0xF0, 0xE0, 0xA0), (0x20, 0x20, 0x28)),
    ((0x40, 0x60, 0xC0), (0xF0, 0xF0, 0xF0), (0x80, 0x20, 0x70), (0x90, 0xA0, 0x30)),
    ((0x10, 0x80, 0x90), (0xC0, 0x70, 0x10), (0x50, 0x50, 0x50), (0xD0, 0xA0, 0xC0)),
)
ROUGHNESS = ((0.05, 0.5, 0.15), (0.4, 0.1, 0.6))


@scene
def bitmap_textures(mi: Any) -> SceneDict:
    """Show pictures of 8 bits by both filters, in all wrap modes; floats as roughness."""

    def picture(**options: Any) -> SceneDict:
        return {"type": "bitmap", "bitmap": mi.Bitmap(np.array(COLORS, np.uint8))} | options

    def wall(transform: Any, texture: SceneDict) -> SceneDict:
        bsdf = {"type": "diffuse", "reflectance": texture}
        return {"type": "rectangle", "to_world": transform, "bsdf": bsdf}

    place = mi.ScalarTransform4f
    turned = place().translate([0.3, 0.1, 0]).rotate([0, 0, 1], 30).scale([2.5, 1.5, 1])
    moved = place().translate([-0.6, -0.8, 0]).scale([2.2, 2.6, 1])
    alpha = {
        "type": "bitmap",
        "bitmap": mi.Bitmap(np.array(ROUGHNESS, np.float32)[..., None]),
        "raw": True,
        "to_uv": place().scale([2, 2, 1]),
    }
    gold = {"type": "roughconductor", "distribution": "ggx", "alpha": alpha}
    gold |= {"eta": rgb(0.143, 0.375, 1.442), "k": rgb(3.983, 2.386, 1.603)}
    satin = {"type": "roughplastic", "distribution": "ggx", "alpha": 0.2}
    satin["diffuse_reflectance"] = picture(filter_type="nearest")
    left = place().translate([-1, 0, 0]).rotate([0, 1, 0], 90)
    right = place().translate([1, 0, 0]).rotate([0, 1, 0], -90)
    floor = place().translate([0, -1, 0]).rotate([1, 0, 0], -90)
    return room(mi) | {
        "light": ceiling_light(mi, 0.6, 4, 4, 4),
        "back": wall(place().translate([0, 0, -1]), picture(to_uv=turned)),
        "left": wall(left, picture(filter_type="nearest", wrap_mode="mirror", to_uv=turned)),
        "right": wall(right, picture(wrap_mode="clamp", to_uv=moved)),
        "floor": wall(floor, picture(filter_type="nearest", wrap_mode="clamp", to_uv=moved)),
        "gold": ball(mi, (-0.45, -0.5, 0.1), 0.4, gold),
        "satin": ball(mi, (0.5, -0.55, 0.2), 0.35, satin),
    }
