"""A layer as colours of a display: developed, or by a scale from dark to light."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from alight.outputs.display import Display

#: A scale whose lightness rises evenly: sRGB from black over violet and orange to light yellow.
_SCALE = np.array(
    [[0, 0, 4], [43, 16, 80], [112, 31, 105], [181, 52, 84], [231, 98, 48], [249, 166, 62],
     [252, 246, 190]], np.float64
)  # fmt: skip

#: Layers of three channels that hold directions, reflectances and places; others hold radiance.
_DIRECTIONS = ("normal", "geometric_normal", "normal_through")
_REFLECTANCES = ("albedo", "albedo_through")
_PLACES = ("position", "uv", "id")


class Shaded(NamedTuple):
    """A layer ready to be shown.

    Attributes
    ----------
    rgba : ndarray of uint8, shape (h, w, 4)
    low, high : float or None
        Ends of the scale, for its legend; None of what has no scale.
    """

    rgba: np.ndarray
    low: float | None = None
    high: float | None = None


def shaded(name: str, plane: np.ndarray, display: Display) -> Shaded:
    """Colour a layer, shape (h, w, c); only radiance is developed by the display."""
    if name in _DIRECTIONS:
        return Shaded(_bytes(np.clip(0.5 + 0.5 * np.nan_to_num(plane[..., :3]), 0.0, 1.0)))
    if name in _PLACES:
        return _spread(plane)
    if plane.shape[2] < 3:
        return _scaled(plane[..., 0])
    chosen = Display() if name in _REFLECTANCES else display
    return Shaded(_bytes(chosen.apply(plane[..., :3])))


def _scaled(plane: np.ndarray) -> Shaded:
    """By the scale, from the least to the 99.5th percentile; black where nothing is known."""
    plane = plane.astype(np.float64)
    known = np.isfinite(plane)
    if not known.any():
        return Shaded(_bytes(np.zeros((*plane.shape, 3))), 0.0, 0.0)
    low, high = float(plane[known].min()), float(np.percentile(plane[known], 99.5))
    share = (plane - low) / (high - low) if high > low else np.full_like(plane, 0.5)
    place = np.clip(np.nan_to_num(share), 0.0, 1.0) * (len(_SCALE) - 1)
    below = np.minimum(place.astype(int), len(_SCALE) - 2)
    part = (place - below)[..., None]
    colours = _SCALE[below] * (1.0 - part) + _SCALE[below + 1] * part
    return Shaded(_bytes(np.where(known[..., None], colours / 255.0, 0.0)), low, high)


def _spread(plane: np.ndarray) -> Shaded:
    """Each channel from its least to its largest value."""
    plane = np.nan_to_num(plane.astype(np.float64))
    low, high = plane.min(axis=(0, 1)), plane.max(axis=(0, 1))
    share = (plane - low) / np.where(high > low, high - low, 1.0)
    if share.shape[2] == 2:
        share = np.concatenate([share, np.zeros_like(share[..., :1])], axis=2)
    return Shaded(_bytes(share))


def _bytes(rgb: np.ndarray) -> np.ndarray:
    """Encode values in [0, 1] as opaque RGBA."""
    rgba = np.full((*rgb.shape[:2], 4), 255, np.uint8)
    rgba[..., :3] = np.rint(rgb * 255.0)
    return rgba
