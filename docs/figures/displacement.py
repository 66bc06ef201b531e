"""The figure of docs/displacement.md: a ball as it is, with a bump map, and displaced.

Usage: python docs/figures/displacement.py [SPP]
"""

import sys

import numpy as np
from pictures import icosphere, save_beside

import alight
from alight.core.srgb import decode_srgb
from alight.outputs.display import Display

HEIGHT = 0.35

SCENE = {
    "alight": 1,
    "film": {"size": [230, 230]},
    "camera": {
        "fov": 30,
        "transform": {"look_at": {"origin": [0, 1.4, 6], "target": [0, 0.05, 0]}},
    },
    "integrator": {"type": "path", "max_depth": 6},
    "environment": {"type": "constant", "radiance": [0.18, 0.2, 0.24]},
    "textures": {
        "rock": {"type": "noise", "pattern": "turbulence", "scale": 0.9, "octaves": 6},
    },
    "bsdfs": {
        "stone": {"type": "diffuse", "reflectance": [0.5, 0.42, 0.36]},
        "bumpy": {"type": "bump_map", "texture": "rock", "scale": HEIGHT, "bsdf": "stone"},
    },
}


def scene(bsdf: str, **keys: object) -> alight.Scene:
    """A ball on a floor, in low light."""
    vertices, faces = icosphere(5)
    ball = {"type": "mesh", "vertices": vertices, "faces": faces, "normals": vertices, **keys}
    sun = {"shape": {"type": "rectangle", "flip_normals": True},
           "light": {"type": "area", "radiance": 30},
           "transform": [{"look_at": {"origin": [-5, 3, 2.5], "target": [0, 0, 0]}}]}  # fmt: skip
    floor = {"shape": "rectangle", "bsdf": {"type": "diffuse", "reflectance": 0.5},
             "transform": [{"scale": 20}, {"rotate": {"axis": "x", "angle": -90}},
                           {"translate": [0, -1.15, 0]}]}  # fmt: skip
    nodes = {"ball": {"shape": ball, "bsdf": bsdf}, "sun": sun, "floor": floor}
    return alight.load({**SCENE, "nodes": nodes})


def main(spp: int) -> None:
    """Render the three of them."""
    rocks = {"displacement": "rock", "displacement_scale": HEIGHT, "displacement_edge": 0.01}
    scenes = (scene("stone"), scene("bumpy"), scene("stone", **rocks))
    films = [alight.render(one, spp=spp) for one in scenes]
    print(films[-1].stats["accelerator"]["displaced"])
    shown = [Display(0.6, "agx").apply(film.image) for film in films]
    save_beside("displacement", *map(decode_srgb, map(np.asarray, shown)))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 256)
