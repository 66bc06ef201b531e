"""Picture at the head of README.md: a scene next to the standard error of its pixels."""

import numpy as np
from pictures import IMAGES
from PIL import Image

import alight
from alight.core.srgb import encode_srgb
from alight.lab.panels import heat

SIZE, SPP = (480, 360), 512
GAP = 6
#: The standard error, relative to the mean of the picture, that gets the brightest colour.
BRIGHTEST = 0.2


if __name__ == "__main__":
    film = alight.render(alight.load("mirror-and-glass", [f"film.size={list(SIZE)}"]), spp=SPP)
    picture = 255.0 * encode_srgb(np.clip(film.image, 0.0, 1.0))
    error = np.nanmean(film.standard_error, axis=2) / film.image.mean()
    gap = np.full((SIZE[1], GAP, 3), 255.0)
    row = np.concatenate([picture, gap, heat(error**2, BRIGHTEST)], axis=1)
    Image.fromarray(row.round().astype(np.uint8)).save(IMAGES / "readme.jpg", quality=90)
