"""More scenes for `mitsuba_scenes`: spot, environment map, textured area light."""

from typing import Any

import numpy as np
from mitsuba_parts import (
    AXIS,
    MESHES,
    WIDE,
    SceneDict,
    ball,
    base,
    camera,
    diffuse,
    ground,
    rgb,
    room,
    scene,
)


@scene
def spot_light(mi: Any) -> SceneDict:
    """Two spots in the room: one with the default beam, one that fades out from its axis."""
    place = mi.ScalarTransform4f
    down = place().look_at(origin=[0.3, 0.9, 0.5], target=[-0.2, -1, -0.2], up=[0, 0, 1])
    side = place().look_at(origin=[-0.8, 0.2, 0.8], target=[0.7, 0.3, -1], up=[0, 1, 0])
    return room(mi) | {
        "down": {
            "type": "spot",
            "to_world": down,
            "intensity": rgb(5, 4, 3),
            "cutoff_angle": 35.0,
        },
        "side": {
            "type": "spot",
            "to_world": side,
            "intensity": rgb(2, 3, 5),
            "cutoff_angle": 50.0,
            "beam_width": 5.0,
        },
        "ball": ball(mi, (-0.3, -0.5, -0.2), 0.4, diffuse(0.3, 0.5, 0.7)),
    }


@scene
def environment_map(mi: Any) -> SceneDict:
    """Show balls below a sunset of 32 x 16 texels that is turned about a slanting axis."""
    write_sky(mi)
    place = mi.ScalarTransform4f().rotate([0.48, 0.6, 0.64], 50).rotate([0, 1, 0], 130)
    sky = {"type": "envmap", "filename": str(MESHES / "sky.hdr"), "scale": 1.5, "to_world": place}
    return base() | {
        "sensor": camera(mi, (2, 2.6, 4), (0, 0.5, 0), 55, WIDE, fov_axis="y"),
        "sky": sky,
        "ground": ground(mi, 1.5, diffuse(0.5, 0.45, 0.4)),
        "ball": ball(mi, (-0.5, 0.7, 0), 0.7, diffuse(0.8, 0.4, 0.3)),
        "mirror": ball(mi, (0.8, 0.45, 0.6), 0.45, {"type": "conductor", "material": "none"}),
    }


@scene
def textured_light(mi: Any) -> SceneDict:
    """Show lamps with a picture: one below the ceiling, one stretched and turned."""
    colors = [[[6, 3, 1], [0, 0.5, 2], [4, 4, 4]], [[0, 0, 0], [8, 0, 0], [0, 5, 0]]]

    def lamp(to_world: Any, filter_type: str) -> SceneDict:
        picture = mi.Bitmap(np.array(colors, np.float32))
        texture = {"type": "bitmap", "bitmap": picture, "raw": True, "filter_type": filter_type}
        emitter = {"type": "area", "radiance": texture}
        return {"type": "rectangle", "to_world": to_world, "bsdf": diffuse(0.0), "emitter": emitter}

    place = mi.ScalarTransform4f
    ceiling = place().translate([0, 0.99, 0]).rotate([1, 0, 0], 90).scale(0.4)
    panel = place().translate([-0.5, -0.3, -0.6]).rotate(list(AXIS), 50).scale([0.5, 0.3, 1.0])
    return room(mi) | {
        "ceiling_lamp": lamp(ceiling, "bilinear"),
        "panel": lamp(panel, "nearest"),
        "ball": ball(mi, (0.35, -0.6, 0.2), 0.35, diffuse(0.6)),
    }


def write_sky(mi: Any) -> None:
    """Write a sunset of 32 x 16 texels: a gradient, a sun, dark ground; no two texels are alike."""
    height, width = 16, 32
    y, x = np.mgrid[:height, :width]
    glow = np.exp(-0.5 * (((x - 9) / 4.0) ** 2 + ((y - 6) / 2.0) ** 2))
    zenith = np.array([0.2, 0.35, 0.8]) * (1.0 - y / height)[..., None]
    texels = zenith + glow[..., None] * np.array([2.0, 0.9, 0.3])
    texels[8:] = 0.15
    texels *= np.random.default_rng(1).uniform(0.3, 1.0, (height, width, 1))
    texels[6, 9] = (40.0, 30.0, 18.0)
    texels[12, 27] = (3.0, 0.1, 0.1)
    mi.Bitmap(texels.astype(np.float32)).write(str(MESHES / "sky.hdr"))
