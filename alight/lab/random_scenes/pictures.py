"""Small pictures: patterns for surfaces, and surroundings from a smooth sky to one bright texel."""

from __future__ import annotations

import math

import numpy as np

from alight.lab.random_scenes.chance import Chance

#: Most texels a side of textures and slides.
MOST_TEXELS = 12


def pattern(chance: Chance) -> np.ndarray:
    """A picture of whole numbers or floats in [0, 1], grey or coloured.

    Returns
    -------
    (h, w) or (h, w, 3) uint8, uint16 or float32
    """
    height, width = chance.whole(1, MOST_TEXELS), chance.whole(1, MOST_TEXELS)
    texels = chance.numbers(height, width, 3)
    if chance.happens(0.5):
        texels = np.round(texels)  # strong contrasts
    if chance.happens(0.3):
        texels = texels[..., 0]
    kind = chance.choose(("float32", "uint8", "uint16"))
    return texels.astype(np.float32) if kind == "float32" else _whole(texels, kind)


def normals(chance: Chance) -> np.ndarray:
    """A map of normals that lean by up to some 40 degrees, (h, w, 3) uint8."""
    height, width = chance.whole(2, MOST_TEXELS), chance.whole(2, MOST_TEXELS)
    slopes = (chance.numbers(height, width, 2) - 0.5) * chance.within(0.2, 1.2)
    vectors = np.concatenate([slopes, np.ones((height, width, 1))], axis=2)
    vectors /= np.linalg.norm(vectors, axis=2, keepdims=True)
    return _whole(0.5 + 0.5 * vectors, "uint8")


def surroundings(chance: Chance, contrast: float, turn: float | None = None) -> np.ndarray:
    """A latitude-longitude map: a smooth sky over dark ground, with small bright texels in it.

    Parameters
    ----------
    chance : Chance
    contrast : float
        Light of the bright texels together, as a multiple of that of all others.
    turn : float, radians, optional
        About where they are, from +x towards +z; anywhere by default.

    Returns
    -------
    (h, w, 3) float32
        Radiances with a mean of 1 over the sphere.
    """
    height = chance.whole(4, 20)
    width = 2 * height
    rows = np.linspace(0.0, np.pi, height)
    # Rows count by the area of their part of the sphere; the first and last one are the poles.
    weight = np.broadcast_to(np.maximum(np.sin(rows), 0.02)[:, None], (height, width))
    zenith, horizon, ground = (np.array(chance.color(0.2, 1.0)) for _ in range(3))
    ground = ground * 0.3
    above = np.clip(np.cos(rows), 0.0, 1.0)[:, None, None]
    sky = horizon + (zenith - horizon) * above
    texels = np.where(np.cos(rows)[:, None, None] >= 0.0, sky, ground)
    texels = texels * (0.6 + 0.8 * chance.numbers(height, width, 1))
    texels /= np.average(texels.mean(axis=2), weights=weight)
    if contrast > 0.0:
        bright = np.zeros((height, width, 3))
        for _ in range(chance.choose((1, 1, 2, 5))):
            row = chance.whole(1, max(1, height // 2 - 1))
            column = chance.whole(0, width - 1) if turn is None else _column(chance, turn, width)
            bright[row, column] += chance.color(0.5, 1.0)
        texels += contrast * bright / np.average(bright.mean(axis=2), weights=weight)
    texels /= np.average(texels.mean(axis=2), weights=weight)
    return np.array([float(f"{value:.4g}") for value in texels.ravel()], np.float32).reshape(
        texels.shape
    )


def _column(chance: Chance, turn: float, width: int) -> int:
    """The column of a direction: +z is in the middle, -x to its right."""
    turn += chance.within(-0.5, 0.5)
    around = math.atan2(-math.cos(turn), math.sin(turn)) / (2.0 * math.pi)
    return int(width * (0.5 + around)) % width


def _whole(texels: np.ndarray, kind: str) -> np.ndarray:
    largest = np.iinfo(kind).max
    return np.round(texels * largest).astype(kind)
