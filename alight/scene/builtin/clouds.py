r"""A cloud that needs no file: densities that are computed when a scene names ``builtin:cloud``.

Overlapping balls give a cumulus its shape, flat below; octaves of smooth random numbers eat into
its edges. Values lie in [0, 1].

Source: the shape by soft balls follows the usual practice of implicit surfaces (Blinn, A
generalization of algebraic surface drawing, ACM TOG 1982); for the noise Perlin, An image
synthesizer, SIGGRAPH 1985; all numbers are our own.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from alight.core.errors import unknown_name
from alight.scene.builtin.pictures import PREFIX

#: Cells along x, y (up) and z.
SIZE = (96, 56, 72)
#: Centre in the unit cube, and radius over its width.
_BALLS = (
    (0.5, 0.38, 0.5, 0.27),
    (0.31, 0.3, 0.48, 0.22),
    (0.7, 0.32, 0.55, 0.23),
    (0.42, 0.58, 0.46, 0.2),
    (0.61, 0.6, 0.53, 0.18),
    (0.19, 0.22, 0.52, 0.15),
    (0.83, 0.23, 0.48, 0.15),
    (0.5, 0.3, 0.7, 0.2),
    (0.45, 0.28, 0.28, 0.2),
)


@lru_cache(maxsize=2)
def builtin_values(name: str) -> NDArray[np.float32]:
    """Compute a grid, shape (nz, ny, nx).

    Raises
    ------
    ValueError
        If there is none of that name.
    """
    plain = name.removeprefix(PREFIX)
    if plain != "cloud":
        raise ValueError(unknown_name("built-in grid", plain, ("cloud",)))
    nx, ny, nz = SIZE
    z, y, x = np.meshgrid(*((np.arange(n) + 0.5) / n for n in (nz, ny, nx)), indexing="ij")
    # Lengths in units of the width, whatever the sides of the box are.
    tall, deep = ny / nx, nz / nx
    soft = np.zeros(x.shape)
    for bx, by, bz, radius in _BALLS:
        squared = (x - bx) ** 2 + ((y - by) * tall) ** 2 + ((z - bz) * deep) ** 2
        soft = np.maximum(soft, 1.0 - np.sqrt(squared) / radius)
    rough = sum(0.5**k * _noise(7.0 * 2**k, x, tall * y, deep * z) for k in range(4)) / 1.875
    # The noise takes away from the balls only, so that nothing is left outside them.
    eaten = np.maximum(0.03, 0.25 + 1.1 * (rough - 0.5))
    edge = np.clip((soft - eaten) / 0.1, 0.0, 1.0)
    floor = np.clip((y - 0.1) / 0.06, 0.0, 1.0)
    return (edge * edge * (3.0 - 2.0 * edge) * floor).astype(np.float32)


def _noise(frequency: float, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Random numbers of a lattice, interpolated smoothly."""
    side = 64
    lattice = np.random.Generator(np.random.PCG64(7)).random((side, side, side))
    total = np.zeros(x.shape)
    parts = [np.divmod(frequency * axis, 1.0) for axis in (x, y, z)]
    fractions = [f * f * (3.0 - 2.0 * f) for _, f in parts]
    wholes = [w.astype(int) for w, _ in parts]
    for corner in np.ndindex(2, 2, 2):
        weight = np.ones(x.shape)
        index = []
        for whole, fraction, upper in zip(wholes, fractions, corner, strict=True):
            weight = weight * (fraction if upper else 1.0 - fraction)
            index.append((whole + upper) % side)
        total += weight * lattice[index[2], index[1], index[0]]
    return total
