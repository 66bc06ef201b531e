"""More scenes for `mitsuba_scenes`: media around the camera, inside glass, and on a grid."""

from typing import Any

import numpy as np
from mitsuba_scenes import (
    SceneDict,
    area,
    ball,
    camera,
    ceiling_light,
    diffuse,
    rgb,
    room,
    scene,
)

#: Densities of the cloud, [z][y][x]: no two of them alike, so that no axis can be mistaken.
DENSITIES = np.array(
    [
        [[0.1, 0.9, 0.3], [1.0, 0.4, 0.0]],
        [[0.7, 0.2, 0.8], [0.05, 0.6, 0.5]],
    ],
    np.float32,
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


@scene
def milk_and_cloud(mi: Any) -> SceneDict:
    """Show milk in a glass ball, its channels extinguished differently, and a cloud on a grid."""
    place = mi.ScalarTransform4f
    glass = {"type": "dielectric", "int_ior": 1.4, "ext_ior": 1.0}
    milk = ball(mi, (-0.45, -0.5, 0.1), 0.45, glass)
    milk["interior"] = homogeneous(rgb(0.25, 0.5, 1), 8.0, rgb(0.99, 0.95, 0.8), 0.5)
    box = place().translate([0.1, -0.5, -0.6]).scale([0.8, 1.1, 0.9])
    cloud = {
        "type": "cube",
        "to_world": box @ place().translate([0.5, 0.5, 0.5]).scale(0.5),
        "bsdf": {"type": "null"},
        "interior": {
            "type": "heterogeneous",
            "sigma_t": {
                "type": "gridvolume",
                "grid": mi.VolumeGrid(DENSITIES),
                "to_world": box,
                "raw": True,
            },
            "albedo": {"type": "constvolume", "value": rgb(0.95, 0.7, 0.4)},
            "scale": 9.0,
            "phase": {"type": "isotropic"},
        },
    }
    return room(mi) | {
        "integrator": {"type": "volpathmis", "max_depth": 12, "rr_depth": 5},
        "lamp": ceiling_light(mi, 0.6, 5, 4, 3),
        "panel": ball(mi, (0.7, 0.5, 0.4), 0.2, diffuse(0.0)) | {"emitter": area(2, 3, 5)},
        "milk": milk,
        "cloud": cloud,
    }
