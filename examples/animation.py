"""An animation by keyframes: a ball is thrown, with motion blur, as numbered pictures and a GIF.

Writes throw_0000.png ... and throw.gif. Run it twice: frames that are there are kept.
"""

import alight

#: Seconds, and where the ball is.
FLIGHT = {
    0: [-1.5, 0.3, 0],
    0.25: [-0.75, 1.2, 0],
    0.5: [0, 1.5, 0],
    0.75: [0.75, 1.2, 0],
    1: [1.5, 0.3, 0],
}

SCENE = {
    "camera": {
        "fov": 40,
        # The shutter counts in frames: open for half of each.
        "shutter": [0, 0.5],
        "transform": {"look_at": {"origin": [0, 0.9, 6], "target": [0, 0.9, 0]}},
    },
    "film": {"size": [96, 64]},
    "environment": {"type": "constant", "radiance": [0.7, 0.8, 1.0]},
    "nodes": {
        "floor": {"shape": "plane", "transform": {"rotate": {"axis": "x", "angle": -90}}},
        "ball": {
            "shape": {"type": "sphere", "radius": 0.3},
            "bsdf": {"type": "diffuse", "reflectance": [0.8, 0.3, 0.1]},
            "transform": {
                "keyframes": [{"time": time, "translate": place} for time, place in FLIGHT.items()]
            },
        },
    },
}

if __name__ == "__main__":
    files = alight.animate(
        SCENE, frames="0:8", fps=8, spp=16, output=["throw_####.png", "throw.gif"]
    )
    print("written:", *files)
