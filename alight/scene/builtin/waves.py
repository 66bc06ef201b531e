r"""Water that needs no file: a mesh that is computed when a scene names ``builtin:waves``.

The square :math:`[-1, 1]^2` of x and z with ripples along y, a sum of plane waves at one instant:

.. math:: y(x, z) = \sum_i a_i \cos(\pi\, (m_i x + n_i z) + \varphi_i)

with whole numbers m and n, so that squares side by side continue each other, and no two waves
alike. Their lengths are spread evenly over octaves from 1/10 to 2/3 of the unit, most of them along
one diagonal; the slopes :math:`a_i k_i` fall with the root of the wave number :math:`k_i`, and that
of the water has the root mean square 0.12. In water two thirds of the unit deep the sun's caustics
on the ground are sharp. Vertex normals are those of the formula; they point up, to +y.

Source: Tessendorf, Simulating ocean water, SIGGRAPH 2001 course notes, for the sum; all numbers
are our own.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from alight.core.errors import unknown_name
from alight.meshes.triangles import MeshArrays
from alight.scene.builtin.pictures import PREFIX

Array = NDArray[np.float64]

#: Squares along a side: the shortest wave spans eight.
CELLS = 160
WAVES = 40
#: Range of the length of (m, n), the number of crests along a side of length 2.
FEWEST, MOST = 3.0, 20.0
SLOPE = 0.12  # root mean square of the length of the gradient
DIAGONAL, SPREAD = 0.6, 0.5  # radians; share of the waves that lie in any direction


@lru_cache(maxsize=1)
def builtin_mesh(name: str) -> MeshArrays:
    """Compute a mesh: 25 921 vertices with normals, 51 200 triangles.

    Raises
    ------
    ValueError
        If there is none of that name.
    """
    plain = name.removeprefix(PREFIX)
    if plain != "waves":
        raise ValueError(unknown_name("built-in mesh", plain, ("waves",)))
    side = np.linspace(-1.0, 1.0, CELLS + 1)
    z, x = np.meshgrid(side, side, indexing="ij")
    y, slope_x, slope_z = height(x, z)
    normals = np.stack([-slope_x, np.ones_like(x), -slope_z], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    number = np.arange((CELLS + 1) ** 2).reshape(CELLS + 1, CELLS + 1)
    # Corners of each square: near the origin, along x, along z, and opposite.
    a, b = number[:-1, :-1].ravel(), number[:-1, 1:].ravel()
    c, d = number[1:, :-1].ravel(), number[1:, 1:].ravel()
    faces = np.concatenate([np.stack([a, c, b], axis=1), np.stack([b, c, d], axis=1)])
    return MeshArrays(
        vertices=np.stack([x, y, z], axis=-1).reshape(-1, 3).astype(np.float32),
        faces=faces.astype(np.int32),
        normals=normals.reshape(-1, 3).astype(np.float32),
    )


def height(x: Array, z: Array) -> tuple[Array, Array, Array]:
    """Height of the water and its slopes along x and z, each of the shape of x and z."""
    waves = _waves()
    phase = np.multiply.outer(x, waves.kx) + np.multiply.outer(z, waves.kz) + waves.phase
    slope = -waves.amplitude * np.sin(phase)
    return np.cos(phase) @ waves.amplitude, slope @ waves.kx, slope @ waves.kz


class Waves(NamedTuple):
    """Plane waves, each array (WAVES,): wave vectors, amplitudes and phases (radians)."""

    kx: Array
    kz: Array
    amplitude: Array
    phase: Array


@lru_cache(maxsize=1)
def _waves() -> Waves:
    random = np.random.Generator(np.random.PCG64(3))
    found: dict[tuple[int, int], None] = {}
    while len(found) < WAVES:
        crests = FEWEST * (MOST / FEWEST) ** random.random()
        angle = 2.0 * np.pi * random.random()
        m, n = round(crests * np.cos(angle)), round(crests * np.sin(angle))
        kept = random.random() < SPREAD + (1.0 - SPREAD) * np.cos(angle - DIAGONAL) ** 2
        # (-m, -n) is the same wave.
        if kept and (-m, -n) not in found:
            found[m, n] = None
    kx, kz = np.pi * np.array(list(found)).T
    k = np.hypot(kx, kz)
    slope = k**-0.5
    slope *= SLOPE / np.sqrt(0.5 * np.sum(slope**2))
    return Waves(kx, kz, slope / k, 2.0 * np.pi * random.random(WAVES))
