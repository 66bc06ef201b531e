"""The figure of docs/cryptomatte.md: a picture, its mattes in colours, and one mask.

Usage: python docs/figures/mattes.py [SPP]
"""

import sys

import numpy as np
from pictures import save_beside

import alight
from alight.core.srgb import decode_srgb
from alight.outputs.display import Display


def main(spp: int) -> None:
    """Render, and show what the film knows of its objects."""
    scene = alight.load("motion-blur", ["film.size=[230, 150]"])
    film = alight.render(scene, spp=spp, aovs="cryptomatte")
    picture = decode_srgb(Display("auto", "agx").apply(film.image))
    mask = np.repeat(film.mask("mill")[..., None], 3, axis=2)
    save_beside("cryptomatte", picture, film.aov("cryptomatte_object"), mask)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 512)
