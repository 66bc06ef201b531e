"""Colour maps: numbers on a surface -> colours, as a picture that the surface is looked up in.

A map is a strip of texels; a vertex has the place of its number along it. So numbers between the
vertices get the colours of the map, which interpolated colours would pass by.

Source: viridis is that of Matplotlib (van der Walt and Smith, CC0), here by 17 of its colours with
straight lines between, which are off by less than 0.01; other maps come from Matplotlib itself,
where it is installed.
"""

from __future__ import annotations

import importlib.util
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

TEXELS = 256

#: Maps that need no other package.
OWN = ("viridis", "grey")

#: Encoded as sRGB, evenly spaced.
_VIRIDIS = (
    "440154 48186a 472d7b 424086 3b528b 33638d 2c728e 26828e 21918c 1fa088 28ae80 3fbc73 5ec962 "
    "84d44b addc30 d8e219 fde725"
)
#: Of numbers that are none.
NO_NUMBER = (0.25, 0.25, 0.25)


@lru_cache(maxsize=1)
def names_of_maps() -> tuple[str, ...]:
    """The maps that there are: all of Matplotlib's where it is installed, else its default."""
    if importlib.util.find_spec("matplotlib") is None:
        return OWN
    from matplotlib import colormaps

    return tuple(dict.fromkeys((*OWN, *colormaps)))


@lru_cache(maxsize=8)
def color_map(name: str) -> NDArray[np.uint8]:
    """The colours of a map from its lowest number to its highest, sRGB, (256, 3)."""
    t = np.linspace(0.0, 1.0, TEXELS)
    if name == "grey":
        colors = np.repeat(t[:, None], 3, axis=1)
    elif name == "viridis":
        known = np.array([list(bytes.fromhex(word)) for word in _VIRIDIS.split()]) / 255.0
        places = np.linspace(0.0, 1.0, len(known))
        colors = np.stack([np.interp(t, places, known[:, i]) for i in range(3)], axis=1)
    else:
        from matplotlib import colormaps

        colors = colormaps[name](t)[:, :3]
    return np.rint(255.0 * colors).astype(np.uint8)


def strip(name: str) -> NDArray[np.uint8]:
    """The picture of a map, (4, 256, 3): the map above, the colour of no number below."""
    grey = np.rint(255.0 * np.array(NO_NUMBER)).astype(np.uint8)
    missing = np.broadcast_to(grey, (TEXELS, 3))
    upper = color_map(name)
    return np.stack([upper, upper, missing, missing])


def places_in(values: Any, limits: tuple[float, float]) -> NDArray[np.float32]:
    """Where numbers lie in the `strip`, (n, 2): outside of the limits at its ends."""
    numbers = np.asarray(values, np.float64)
    low, high = limits
    # Equal limits: all numbers are the middle.
    t = np.full(numbers.shape, 0.5)
    if high > low:
        # Halves: the difference of the largest numbers is none.
        t = np.clip((numbers / 2 - low / 2) / (high / 2 - low / 2), 0.0, 1.0)
    is_none = np.isnan(numbers)
    u = (0.5 + (TEXELS - 1) * np.where(is_none, 0.0, t)) / TEXELS
    # Centres of the outer rows of four, so that nothing is interpolated between the halves.
    v = np.where(is_none, 0.125, 0.875)
    return np.stack([u, v], axis=-1).astype(np.float32)


def limits_of(values: Any) -> tuple[float, float]:
    """The lowest and the highest finite number; (0, 1) if there is none."""
    numbers = np.asarray(values, np.float64)
    numbers = numbers[np.isfinite(numbers)]
    return (float(numbers.min()), float(numbers.max())) if numbers.size else (0.0, 1.0)
