r"""Checkerboard over the surface parameters (u, v).

.. math::
    (s, t) = \text{scale} \cdot \text{to\_uv}(u, v) + \text{offset}, \qquad
    c = \text{color}_{(\lfloor s \rfloor + \lfloor t \rfloor) \bmod 2}

With scale 1 one square covers the unit square of (u, v). On an infinite plane (u, v) = (x, y)
in metres.

Source: PBR4 section 10.3 (without its filtering).
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from alight.core.field_types import Reflectance, Scale2, Triple, Vector2
from alight.core.parameters import loader, slots_of
from alight.core.spec import Texture
from alight.core.uv_sets import UvSet, set_features
from alight.textures.model import Triplet
from alight.textures.uv import IDENTITY, LookupPoint, ToUv
from lanewise.jit import kernel
from lanewise.simd import floor, where


class Checkerboard(Texture):
    """Squares of two colours.

    Parameters
    ----------
    color0, color1 : Reflectance, defaults 0.4 and 0.2
        Linear sRGB; `color0` holds the square next to the origin.
    scale : float or (2,) float, default 1
        Squares per unit of u and of v.
    offset : (2,) float, default 0
        Shift in squares.
    to_uv : step or list of steps, default none
        Applied to (u, v) first, see `alight.textures.uv`.
    uv_set : int in [0, 7], default 0
        Which of a mesh's sets of (u, v): 0 its `uvs`, the others its `more_uvs`.
    """

    type: Literal["checkerboard"] = "checkerboard"
    color0: Reflectance = (0.4, 0.4, 0.4)
    color1: Reflectance = (0.2, 0.2, 0.2)
    scale: Scale2 = (1.0, 1.0)
    offset: Vector2 = (0.0, 0.0)
    to_uv: ToUv = IDENTITY
    uv_set: UvSet = 0

    @property
    def matrix(self) -> np.ndarray:
        """From (u, v) to (s, t), shape (2, 3)."""
        scaled = np.array(self.scale)[:, None] * self.to_uv.matrix
        scaled[:, 2] += self.offset
        return scaled

    def set_of_coordinates(self) -> int:
        """The one that it names."""
        return self.uv_set

    def lookup(self) -> np.ndarray:
        """Its matrix."""
        return self.matrix

    def maximum(self) -> Triple:
        """Largest value of each channel."""
        red, green, blue = (max(pair) for pair in zip(self.color0, self.color1, strict=True))
        return red, green, blue

    def mean(self) -> Triple:
        """Mean of each channel."""
        red, green, blue = (0.5 * sum(pair) for pair in zip(self.color0, self.color1, strict=True))
        return red, green, blue

    @property
    def mean_is_exact(self) -> bool:
        """There are as many fields of either colour."""
        return True


EXAMPLES = (
    Checkerboard(),
    Checkerboard(color0=(1.0, 0.0, 0.0), color1=(0.0, 0.0, 1.0), scale=10.0),
    Checkerboard(color0=0.0, color1=1.0, scale=(3.0, -0.5), offset=(0.25, -7.0)),
    Checkerboard(scale=0.5, to_uv=[{"rotate": 45.0}, {"translate": [0.5, 0.0]}]),
)


class Params(NamedTuple):
    """A row of the table."""

    color0: Triplet
    color1: Triplet
    point: LookupPoint


SLOTS = slots_of(Params)
_load = loader(Params)


def features(spec: Checkerboard) -> tuple[str, ...]:
    """What kernels must be written for."""
    return set_features(spec.uv_set)


def pack(spec: Checkerboard, packer) -> None:
    """Fill the row of one texture."""
    packer.color("color0", spec.color0)
    packer.color("color1", spec.color1)
    packer.numbers("to_uv", *spec.matrix.ravel())
    packer.numbers("uv_set", float(spec.uv_set))


@kernel
def evaluate(scene, base, surface):
    """Colour of the square that (u, v) lies in."""
    params = _load(scene, base, surface)
    s, t = params.point
    # The fraction of half a whole number is 0 or 1/2, whatever its sign.
    half = 0.5 * (floor(s) + floor(t))
    return where(half == floor(half), params.color0, params.color1)
