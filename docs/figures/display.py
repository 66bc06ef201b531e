"""Figures of docs/display.md: one picture through every tone curve, balanced, and denoised."""

import numpy as np
from pictures import save_beside

import alight
from alight.core.srgb import decode_srgb
from alight.films.denoising import FEATURES
from alight.outputs.display import Display
from alight.tone_curves.model import TONE_CURVES


def shown(image: np.ndarray, *display: Display) -> list[np.ndarray]:
    """What each display shows, as linear values that a plain PNG shows alike."""
    return [decode_srgb(one.apply(image)) for one in display]


def main() -> None:
    """Render two scenes, show them often."""
    scene = alight.load("rough-metals", ["film.size=[220, 140]"])
    image = alight.render(scene, spp=1024).image
    save_beside("display-curves", *shown(image, *(Display("auto", name) for name in TONE_CURVES)))
    whites = ("none", "3200K", "auto")
    agx = (Display("auto", "agx", white_balance=white) for white in whites)
    save_beside("display-white-balance", *shown(image, *agx))
    room = alight.load("mirror-and-glass", ["film.size=[240, 180]"])
    film = alight.render(room, spp=16, aovs=list(FEATURES.values()))
    clean = alight.render(room, spp=4096).image
    save_beside("display-denoised", film.image, alight.denoise(film)[0].image, clean)


if __name__ == "__main__":
    main()
