"""Pictures of docs/gallery.md: the built-in scenes, in half a screen's width.

Usage: python docs/figures/gallery.py [NAME ...]
"""

import sys

from pictures import IMAGES

import alight
from alight.outputs import write_image

SCENES = (
    "blurred-foreground",
    "cloud",
    "clear-day",
    "coated-plastics",
    "depth-of-field",
    "door-ajar",
    "environment-map",
    "fog",
    "infinite-plane",
    "instances",
    "lambert-and-uniform-scatter",
    "lamp-profiles",
    "lamp-and-glass",
    "lamp-in-glass",
    "milk",
    "mirror-and-glass",
    "motion-blur",
    "phong-exponents",
    "prism",
    "rough-glass",
    "rough-metals",
    "soft-shadows",
    "transform-tree",
    "under-water",
    "uniform-and-cosine-sampling",
    "veach-plates",
)
WIDTH = 400
#: Samples per pixel, more for scenes with caustics and blurred highlights.
SPP = 96
MORE = {
    "cloud": 384,
    "door-ajar": 128,
    "environment-map": 256,
    "fog": 512,
    "lamp-and-glass": 256,
    "lamp-in-glass": 128,
    "milk": 512,
    "mirror-and-glass": 256,
    "motion-blur": 384,
    "prism": 512,
    "rough-glass": 256,
    "under-water": 128,
    "veach-plates": 192,
}
#: Its noise is what it shows: that of 16 samples in the scene's own size, four pixels as one.
FEW = {"uniform-and-cosine-sampling": 64}
#: Paths find their lamps so rarely that there would be little else to see than noise.
DENOISED = ("door-ajar", "lamp-in-glass", "under-water")
FEATURES = ("albedo_through", "normal_through")


def render(name: str) -> None:
    """Render one scene at the gallery's size."""
    width, height = alight.load(name).film.size
    scale = min(1.0, WIDTH / width)
    size = [round(width * scale), round(height * scale)]
    film = alight.render(
        alight.load(name, [f"film.size={size}"]),
        spp={**MORE, **FEW}.get(name, SPP),
        aovs=FEATURES if name in DENOISED else (),
    )
    picture = IMAGES / "gallery" / f"{name}.png"
    if name in DENOISED:
        write_image(picture, alight.denoise(film)[0])
    else:
        film.save(picture)


if __name__ == "__main__":
    (IMAGES / "gallery").mkdir(exist_ok=True)
    for scene_name in sys.argv[1:] or SCENES:
        print(scene_name)
        render(scene_name)
