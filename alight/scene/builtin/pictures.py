r"""Pictures that need no file: computed when a scene that names one is loaded.

``file: builtin:sky`` means a map of latitude and longitude, as the light ``environment`` takes
it: a clear sky with some high cloud, a sun and a dull ground. With the angle gamma from the sun and
the height :math:`\mu = \omega_y` the radiance of the sky is

.. math:: L = \left( L_\text{zenith} + (L_\text{horizon} - L_\text{zenith})\, e^{-4 \mu} \right)
    (1 + 0.4 \cos^2\gamma) + L_\text{glow}\, (0.75 e^{-7 \gamma} + 3 e^{-40 \gamma})

plus clouds, which are octaves of smooth random numbers on a plane overhead. The sun is a disk of
radius 0.6 degrees with a soft edge, twice as large as the real one, so that a texel is smaller
than it. Its irradiance is about three times that of the sky.

``builtin:studio`` and ``builtin:studio-floor`` are a photographer's table for a single object:
`alight.scene.builtin.studio`.

``builtin:zone-plate`` is a test picture of rings that grow finer with the distance from a corner.

Source: the sky's shape (gradient to the horizon, circumsolar glow, Rayleigh's 1 + cos^2) is that of
the standard general sky of the CIE, S 011 (2003), with numbers of our own; for the noise Perlin,
An image synthesizer, SIGGRAPH 1985.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from alight.core.errors import unknown_name
from alight.scene.builtin.studio import smoothstep, studio, studio_floor

Array = NDArray[np.float64]

#: Prefix of the names of such pictures, given instead of a file's name.
PREFIX = "builtin:"

WIDTH, HEIGHT = 1024, 512
RINGS = 1024  # texels on the side of the zone plate
SUN_HEIGHT, SUN_AZIMUTH, SUN_RADIUS = 38.0, 140.0, 0.6  # degrees
SUN = (7600.0, 6500.0, 4900.0)  # W/(m^2 sr), as all that follow
ZENITH, HORIZON = (0.11, 0.24, 0.62), (0.62, 0.72, 0.86)
GLOW, CLOUD, GROUND = (1.0, 0.86, 0.66), (0.95, 0.93, 0.92), (0.17, 0.15, 0.13)


def sky() -> NDArray[np.float32]:
    """Radiance of the sky, linear sRGB, shape (512, 1024, 3), top row first."""
    azimuth = (np.arange(WIDTH) + 0.5) * (2.0 * np.pi / WIDTH)
    # The rows that reach above the horizon's soft edge; below there is only ground.
    rows = HEIGHT // 2 + 2
    theta = (np.arange(rows) * (np.pi / (HEIGHT - 1)))[:, None]
    x, y, z = np.sin(theta) * np.sin(azimuth), np.cos(theta), -np.sin(theta) * np.cos(azimuth)
    high, around = np.radians([SUN_HEIGHT, SUN_AZIMUTH])
    sun = (np.cos(high) * np.sin(around), np.sin(high), -np.cos(high) * np.cos(around))
    cos_gamma = np.clip(x * sun[0] + y * sun[1] + z * sun[2], -1.0, 1.0)
    gamma = np.arccos(cos_gamma)
    up = np.maximum(y, 0.0)
    clear = _mix(np.exp(-4.0 * up), ZENITH, HORIZON) * (1.0 + 0.4 * cos_gamma**2)[:, :, None]
    clear += _spread(0.75 * np.exp(-7.0 * gamma) + 3.0 * np.exp(-40.0 * gamma), GLOW)
    brighter = np.asarray(CLOUD) * (1.0 + 1.2 * np.exp(-3.0 * gamma))[:, :, None]
    cover = _clouds(x / (up + 0.12), z / (up + 0.12)) * (1.0 - np.exp(-9.0 * up))
    clear += cover[:, :, None] * (brighter - clear)
    # Three texels of soft edge keep the disk round.
    edge = np.radians(SUN_RADIUS) + (0.5 * np.pi / HEIGHT) * np.array([-1.0, 1.0])
    disk = 1.0 - smoothstep(gamma, *edge)
    clear += _spread(disk, SUN)
    picture = np.full((HEIGHT, WIDTH, 3), GROUND)
    above = smoothstep(y, -0.01, 0.005)[:, :, None]
    picture[:rows] += above * (clear - picture[:rows])
    return picture.astype(np.float32)


def zone_plate() -> NDArray[np.float32]:
    """Rings cos(256 pi r^2 / side^2) around a corner, a 256th of the side wide at its far edge."""
    side = np.arange(RINGS) + 0.5
    squared = (side[:, None] ** 2 + side**2) / RINGS**2
    return _spread(0.5 + 0.5 * np.cos(np.pi * 256.0 * squared), (1.0, 1.0, 1.0)).astype(np.float32)


def _spread(strength: Array, color: tuple[float, float, float]) -> Array:
    return strength[:, :, None] * np.asarray(color)


def _mix(part: Array, first: tuple[float, float, float], second: tuple[float, ...]) -> Array:
    return np.asarray(first) + part[:, :, None] * (np.asarray(second) - np.asarray(first))


def _clouds(x: Array, y: Array) -> Array:
    """Cover in [0, 1] over a plane: streaks of five octaves of noise."""
    lattice = np.random.Generator(np.random.PCG64(21)).random((64, 64))
    total = sum(
        0.55**octave * _noise(lattice, 2**octave * (0.55 * x + 17.3), 2**octave * (0.8 * y + 5.1))
        for octave in range(5)
    )
    return 0.75 * smoothstep(total / sum(0.55**octave for octave in range(5)), 0.48, 0.78)


def _noise(lattice: Array, x: Array, y: Array) -> Array:
    """Random numbers of a lattice that repeats, interpolated smoothly."""
    n = len(lattice)
    column, row = np.floor(x).astype(int), np.floor(y).astype(int)
    s, t = smoothstep(x - column, 0.0, 1.0), smoothstep(y - row, 0.0, 1.0)
    corners = [lattice[(row + i) % n, (column + j) % n] for i in (0, 1) for j in (0, 1)]
    upper = corners[0] + s * (corners[1] - corners[0])
    lower = corners[2] + s * (corners[3] - corners[2])
    return upper + t * (lower - upper)


PICTURES: dict[str, Callable[[], NDArray[np.float32]]] = {
    "sky": sky,
    "studio": studio,
    "studio-floor": studio_floor,
    "zone-plate": zone_plate,
}


def is_builtin(name: str) -> bool:
    """Whether a name given instead of a file's is one of these pictures."""
    return name.startswith(PREFIX)


@lru_cache(maxsize=4)
def builtin_texels(name: str) -> NDArray[np.float32]:
    """Compute a picture.

    Parameters
    ----------
    name : str
        With the prefix, as in ``builtin:sky``.

    Raises
    ------
    ValueError
        If there is none of that name.
    """
    plain = name.removeprefix(PREFIX)
    if plain not in PICTURES:
        raise ValueError(unknown_name("built-in picture", plain, PICTURES))
    texels = PICTURES[plain]()
    texels.setflags(write=False)
    return texels
