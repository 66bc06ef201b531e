r"""Noise: a random pattern in space, smooth at its smallest scale, alike on every machine.

.. math::
    n(x) &= \sum_{c \in \{0, 1\}^3} \Bigl(\prod_i s_i\Bigr)\; g_{\lfloor x \rfloor + c} \cdot
            (x - \lfloor x \rfloor - c), \qquad s(t) = 6 t^5 - 15 t^4 + 10 t^3 \\
    f(x) &= \frac{\sum_{k < K} r^k\, n(2^k x)}{\sum_{k < K} r^k}, \qquad
    c = \text{mix}(\text{color}_0, \text{color}_1,\; \tfrac12 + \tfrac12 f)

with :math:`s_i` the fade s or 1 - s of the coordinate i, K octaves and r their `gain`. Gradients g
are the twelve directions from a cube's centre to the middles of its edges, chosen by a hash of
the corner's whole coordinates. |n| never exceeds 1.04; the weight is cut to [0, 1].
"turbulence" has \|n\| instead of n, and \|f\| as weight.

x is the place in the world (metres), or (u, v, 0), times `scale` plus `offset`. Beyond 2^20 cells
from the origin of rendering space float32 has no digits left to vary with. Whole cells between that
and the origin of the world are counted apart, modulo 2^32.

Source: Perlin, An image synthesizer, SIGGRAPH 1985, and Improving noise, SIGGRAPH 2002; Musgrave in
Ebert et al., Texturing and modeling, 3rd ed., chapter 16 for the sum; Jarzynski and Olano, Hash
functions for GPU rendering, JCGT 9(3), 2020, for the hash.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np

from alight.core.field_types import Reflectance, Triple, UnitInterval, Vector3
from alight.core.fields import Interval, Numbers
from alight.core.motion import point_at_opening
from alight.core.parameters import Slots, loader, slots_of
from alight.core.rng import pcg4d
from alight.core.spec import Texture
from alight.core.uv_sets import UvSet, set_features, uv_of_texture
from alight.core.vec import Vec3
from alight.textures.model import Flag, Number, Triplet
from lanewise.jit import kernel
from lanewise.simd import (
    absolute,
    any_lane,
    floor,
    lanes,
    lanes_u32,
    maximum,
    minimum,
    to_uint,
    where,
)

Octaves = Annotated[int, Interval(1, 16, integer=True)]
Scale3 = Annotated[Triple, Numbers(3, Interval(), spread=True)]


class Noise(Texture):
    """Random pattern in space.

    Parameters
    ----------
    color0, color1 : Reflectance, defaults 0 and 1
        Colours of the lowest and the highest values.
    pattern : {"fbm", "turbulence"}, default "fbm"
        Sum of waves, or of their sizes.
    space : {"world", "uv"}, default "world"
        Where the pattern lives.
    uv_set : int in [0, 7], default 0
        Which of a mesh's sets of (u, v): 0 its `uvs`, the others its `more_uvs`.
    scale : float or (3,) float, cells per metre (or per unit of u and v), default 1
        Of the largest waves.
    offset : (3,) float, cells, default 0
        Shift of the pattern.
    octaves : int in [1, 16], default 4
        Waves of 1, 1/2, 1/4, ... cells.
    gain : float in [0, 1], default 0.5
        Size of each octave relative to the one before.
    """

    type: Literal["noise"] = "noise"
    color0: Reflectance = (0.0, 0.0, 0.0)
    color1: Reflectance = (1.0, 1.0, 1.0)
    pattern: Literal["fbm", "turbulence"] = "fbm"
    space: Literal["world", "uv"] = "world"
    uv_set: UvSet = 0
    scale: Scale3 = (1.0, 1.0, 1.0)
    offset: Vector3 = (0.0, 0.0, 0.0)
    octaves: Octaves = 4
    gain: UnitInterval = 0.5

    def set_of_coordinates(self) -> int | None:
        """The one that it names; none where it fills space."""
        return self.uv_set if self.space == "uv" else None

    def maximum(self) -> Triple:
        """Largest value of each channel."""
        red, green, blue = (max(pair) for pair in zip(self.color0, self.color1, strict=True))
        return red, green, blue

    def mean(self) -> Triple:
        """Of fbm the mean of the pattern over all of space; of turbulence an estimate."""
        red, green, blue = (0.5 * sum(pair) for pair in zip(self.color0, self.color1, strict=True))
        return red, green, blue


EXAMPLES = (
    Noise(space="uv", scale=4.0),
    Noise(color0=(0.2, 0.1, 0.0), color1=(0.9, 0.8, 0.1), space="uv", octaves=1),
    Noise(pattern="turbulence", space="uv", scale=(3.0, -1.5, 1.0), offset=(7.0, 0.25, -3.0)),
    Noise(octaves=16, gain=1.0, color0=0.75, color1=0.25),
    Noise(scale=2.0),
)


class Params(NamedTuple):
    """A row of the table."""

    color0: Triplet
    color1: Triplet
    scale: Triplet
    offset: Triplet
    octaves: Number
    gain: Number
    turbulence: Flag
    in_uv: Flag
    high: Triplet
    low: Triplet
    uv: Annotated[Any, Slots(uv_of_texture, {"uv_set": 1})]


SLOTS = slots_of(Params)
_load = loader(Params)


def features(spec: Noise) -> tuple[str, ...]:
    """What kernels must be written for."""
    return set_features(spec.uv_set) if spec.space == "uv" else ()


_HALF_WORD = 2.0**16

#: Whole cells along each axis, u32, modulo 2^32.
Cells = namedtuple("Cells", "x y z")


def _apart(spec: Noise, origin: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The offset in rendering space, and whole cells from the world's origin to there (float64)."""
    offset = np.array(spec.offset)
    if spec.space == "uv" or not origin.any():
        return offset, np.zeros(3)
    offset = offset + np.array(spec.scale) * origin
    cells = np.floor(offset)
    return offset - cells, cells % _HALF_WORD**2


def pack(spec: Noise, packer) -> None:
    """Fill the row of one texture."""
    packer.color("color0", spec.color0)
    packer.color("color1", spec.color1)
    packer.numbers("scale", *spec.scale)
    offset, cells = _apart(spec, packer.origin)
    packer.numbers("offset", *offset)
    packer.numbers("high", *(cells // _HALF_WORD))
    packer.numbers("low", *(cells % _HALF_WORD))
    packer.numbers("octaves", float(spec.octaves))
    packer.numbers("gain", spec.gain)
    packer.numbers("turbulence", float(spec.pattern == "turbulence"))
    packer.numbers("in_uv", float(spec.space == "uv"))
    packer.numbers("uv_set", float(spec.uv_set))


#: Coordinates are kept in this range, in which whole numbers are exact.
FARTHEST = 2.0**22


@kernel
def _hash_word(x, y, z):
    word, _, _, _ = pcg4d(x, y, z, lanes_u32(0))
    return word


@kernel
def _slope(h, x, y, z):
    """The gradient that a hash chooses, times (x, y, z): a sum of two of them with signs."""
    # h in 0..11: of the three pairs of axes, each with four signs.
    pair, signs = h >> 2, h & 3
    a = where(pair == 2, y, x)
    b = where(pair == 0, y, z)
    return where((signs & 1) != 0, -a, a) + where((signs & 2) != 0, -b, b)


@kernel
def _fade(t):
    return t * t * t * (t * (6.0 * t - 15.0) + 10.0)


@kernel
def noise_at(x, y, z, cells):
    """Gradient noise at a point, about -1 to 1, 0 at whole coordinates.

    cells: whole numbers, modulo 2^32, that the coordinates are short of.
    """
    x0, y0, z0 = floor(x), floor(y), floor(z)
    fx, fy, fz = x - x0, y - y0, z - z0
    # Shifted to be positive: the hash wants whole numbers without sign.
    i = to_uint(x0 + FARTHEST) + cells.x
    j = to_uint(y0 + FARTHEST) + cells.y
    k = to_uint(z0 + FARTHEST) + cells.z
    sx, sy, sz = _fade(fx), _fade(fy), _fade(fz)
    value = lanes(0.0)
    corner = lanes_u32(0)
    while any_lane(corner < 8):
        one_x, one_y, one_z = (corner & 1) != 0, (corner & 2) != 0, (corner & 4) != 0
        word = _hash_word(i + (corner & 1), j + ((corner >> 1) & 1), k + (corner >> 2))
        # The high bits are the best; 12 * word / 2^32 without a division.
        chosen = ((word >> 16) * 12) >> 16
        slope = _slope(
            chosen,
            where(one_x, fx - 1.0, fx),
            where(one_y, fy - 1.0, fy),
            where(one_z, fz - 1.0, fz),
        )
        weight = where(one_x, sx, 1.0 - sx) * where(one_y, sy, 1.0 - sy)
        value = value + slope * weight * where(one_z, sz, 1.0 - sz)
        corner = corner + 1
    return value


@kernel
def _kept(x):
    """A coordinate in range; NaN becomes 0."""
    return minimum(maximum(x, -0.5 * FARTHEST), 0.5 * FARTHEST)


@kernel
def evaluate(scene, base, surface):
    """The pattern's colour at a point of a surface."""
    params = _load(scene, base, surface)
    p, (u, v) = point_at_opening(scene, surface), params.uv
    point = where(params.in_uv, Vec3(u, v, lanes(0.0)), p) * params.scale + params.offset
    x, y, z = point.x, point.y, point.z
    high, low = params.high, params.low
    cells = Cells(
        (to_uint(high.x) << 16) + to_uint(low.x),
        (to_uint(high.y) << 16) + to_uint(low.y),
        (to_uint(high.z) << 16) + to_uint(low.z),
    )
    octaves, turbulent = params.octaves, params.turbulence
    total, sizes, size, k = lanes(0.0), lanes(0.0), lanes(1.0), lanes(0.0)
    more = k < octaves
    while any_lane(more):
        wave = noise_at(_kept(x), _kept(y), _kept(z), cells)
        wave = where(turbulent, absolute(wave), wave)
        total = where(more, total + size * wave, total)
        sizes = where(more, sizes + size, sizes)
        x, y, z, size, k = x + x, y + y, z + z, size * params.gain, k + 1.0
        cells = Cells(cells.x + cells.x, cells.y + cells.y, cells.z + cells.z)
        more = k < octaves
    mean = total / where(sizes > 0.0, sizes, 1.0)
    weight = minimum(maximum(where(turbulent, mean, 0.5 + 0.5 * mean), 0.0), 1.0)
    return params.color0 * (1.0 - weight) + params.color1 * weight
