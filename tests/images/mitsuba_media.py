"""More scenes for `mitsuba_scenes`: a medium around the camera."""

from typing import Any

from mitsuba_parts import (
    SceneDict,
    ball,
    camera,
    diffuse,
    rgb,
    room,
    scene,
)


def homogeneous(sigma_t: SceneDict, scale: float, albedo: SceneDict, g: float) -> SceneDict:
    """Make a medium that scatters by Henyey and Greenstein; its colours must lie in [0, 1]."""
    return {
        "type": "homogeneous",
        "sigma_t": sigma_t,
        "scale": scale,
        "albedo": albedo,
        "phase": {"type": "hg", "g": g},
    }


@scene
def fog(mi: Any) -> SceneDict:
    """Fill the room and all around it with grey fog, in which a spot draws a cone.

    A bubble of empty space around the spot keeps the noise of light from near it away.
    """
    place = mi.ScalarTransform4f
    side = place().look_at(origin=[-0.8, 0.7, 0.5], target=[0.6, -0.6, -0.3], up=[0, 1, 0])
    sensor = camera(mi, (0, 0, 3.9), (0, 0, 0))
    fog = homogeneous(rgb(0.4), 1.0, rgb(0.9, 0.8, 0.7), 0.6)
    sensor["medium"] = fog
    bubble = ball(mi, (-0.8, 0.7, 0.5), 0.45, {"type": "null"})
    return room(mi) | {
        "integrator": {"type": "volpath", "max_depth": 8, "rr_depth": 5},
        "sensor": sensor,
        "spot": {
            "type": "spot",
            "to_world": side,
            "intensity": rgb(9, 8, 7),
            "cutoff_angle": 25.0,
        },
        "bubble": bubble | {"exterior": fog},
        "ball": ball(mi, (0.4, -0.6, -0.2), 0.4, diffuse(0.3, 0.5, 0.7)),
    }
