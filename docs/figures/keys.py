"""Small pictures of what scene keys do, for the page of scene keys.

Usage: python docs/figures/keys.py [NAME ...]

Without names only the pictures that are not there are rendered.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from key_scenes import OWN, STRIPS, Strip
from PIL import Image

import alight
from alight.formats import loads
from alight.outputs.display import Display
from alight.scene import Scene

IMAGES = Path(__file__).resolve().parents[1] / "images" / "keys"

#: Pixels of one picture, and between two.
WIDTH, HEIGHT, GAP = 112, 84, 4

#: Colours of a strip's palette.
COLOURS = 96


def scene_of(strip: Strip, value: str) -> Scene:
    """The scene of one picture."""
    sides = [WIDTH // strip.coarse, HEIGHT // strip.coarse]
    changes = [f"film.size={sides}", *strip.further, strip.change.format(value)]
    if strip.scene in OWN:
        return alight.changed(loads(OWN[strip.scene]), changes)
    return alight.load(strip.scene, changes)


def picture(strip: Strip, value: str) -> np.ndarray:
    """One picture of a strip: uint8, shape (HEIGHT, WIDTH, 3)."""
    film = alight.render(scene_of(strip, value), spp=strip.spp)
    shown = Image.fromarray(
        np.rint(255.0 * Display(strip.exposure).apply(film.image)).astype(np.uint8)
    )
    return np.asarray(shown.resize((WIDTH, HEIGHT), Image.Resampling.NEAREST))


def write(name: str) -> Path:
    """Render a strip."""
    strip = STRIPS[name]
    gap = np.full((HEIGHT, GAP, 3), 255, np.uint8)
    parts = [part for value in strip.values for part in (gap, picture(strip, value))][1:]
    row = Image.fromarray(np.concatenate(parts, axis=1))
    path = IMAGES / f"{name}.png"
    row.quantize(COLOURS, dither=Image.Dither.NONE).save(path, optimize=True)
    return path


if __name__ == "__main__":
    IMAGES.mkdir(parents=True, exist_ok=True)
    for old in IMAGES.glob("*.png"):
        if old.stem not in STRIPS:
            old.unlink()
    for name in sys.argv[1:] or [n for n in STRIPS if not (IMAGES / f"{n}.png").exists()]:
        sys.stdout.write(f"{write(name)}\n")
