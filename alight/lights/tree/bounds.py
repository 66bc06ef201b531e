r"""Bounds of a group of lights in a light tree, packed for kernels, and an estimate of its light.

A group is known by a sphere around its lights, a cone of the directions they face, how far they
reach behind its middle, and their intensity. To a point p, at the distance d from its middle c, it
sends in proportion to

.. math::
    \frac{I}{d^2} \Big(\cos(\theta_w - \theta_o)^+ + \frac h d\Big)
    \cdot \Big(\cos \theta_i + \frac r d\Big)

with :math:`\theta_w` from the cone's axis, :math:`\theta_o` the cone's half angle, r the radius of
the sphere, :math:`\theta_i` from the normal of the point; no bracket counts more than 1. Both are
bounds: over a sphere of radius r, :math:`n \cdot (x - p) \le n \cdot (c - p) + r`, and with h the
largest :math:`n_i \cdot (c - x_i)` of the group's lights,
:math:`n_i \cdot (p - x_i) \le d \cos(\theta_w - \theta_o)^+ + h`. So h is 0 for a flat panel,
negative for a ball that shines to the outside, and r for one that shines to the inside: a group is
dark behind the planes of its lights, not behind a sphere around them, and the bounds take one
square root.

Source: Conty Estevez and Kulla, Importance sampling of many lights with adaptive tree splitting,
Proc. ACM Comput. Graph. Interact. Tech. 1(2), 2018, whose measure this is, except for h and for
r / d instead of the sphere's angle.
"""

from __future__ import annotations

from collections import namedtuple
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from alight.core.vec import dot, gather_vec3, row_vec3
from lanewise.jit import kernel
from lanewise.simd import (
    absolute,
    bits_float,
    float_bits,
    gather,
    lanes,
    maximum,
    minimum,
    rsqrt,
    sqrt,
    to_float,
    where,
)
from lanewise.vec3 import Vec3

#: Words of a group: centre; radius and h (bfloat16 each); axis (10 bits a coordinate) and whether
#: far away only intensity counts; cosine and sine of the cone's half angle (15 bits each) and
#: whether only intensity counts anywhere; intensity (bfloat16) and cosine of the angle beyond the
#: cone where it is dark (16 bits). None of them is NaN as bits.
REACH, AXIS, CONE, STRENGTH, WORDS = 3, 4, 5, 6, 7

#: In AXIS and CONE: the group counts by intensity if it is far; wherever it is.
ALIKE = EVEN = FLAT = 0x80000000

#: What is far: squared distance over squared radius.
FAR_AWAY = 36.0

#: Within a sphere, its lights count as if at least this share of the squared radius away: what is
#: nearest gives most of the light, not what is in the mean. Measured (decision 19).
CLOSEST = 0.1

#: Rounding of bounds (mostly of the axis); a light must not be dark where it shines a little.
_GRAZING, _LEAST = 4e-3, 1e-3

_TENTH, _FIFTEENTH, _SIXTEENTH = 511, (1 << 15) - 1, (1 << 16) - 1


class Groups(NamedTuple):
    """Groups of lights, or single ones, a row each.

    Attributes
    ----------
    center : (n, 3) float32, metres
    radius, behind : (n,) float64, metres
        Of the sphere around the lights, and h: how far they lie behind the centre at most.
    axis : (n, 3) float64
        Unit vector.
    cosine, dark : (n,) float64
        Cosines of the cone's half angle, and of the angle beyond it where it is dark.
    intensity : (n,) float64
        As part of all lights'.
    flat : (n,) bool
        Each light faces one direction.
    alike : (n,) bool
        From afar only intensity counts: directions differ little.
    """

    center: NDArray[np.float32]
    radius: NDArray[np.float64]
    behind: NDArray[np.float64]
    axis: NDArray[np.float64]
    cosine: NDArray[np.float64]
    dark: NDArray[np.float64]
    intensity: NDArray[np.float64]
    flat: NDArray[np.bool_]
    alike: NDArray[np.bool_]


def pack(groups: Groups) -> NDArray[np.uint32]:
    """Words for `bounds_at`; (n, WORDS). Whatever is rounded is rounded to the safe side."""
    words = np.zeros((len(groups.radius), WORDS), np.uint32)
    words[:, :REACH] = np.ascontiguousarray(groups.center).view(np.uint32)
    words[:, REACH] = _upwards(groups.radius) << 16 | _upwards(groups.behind)
    x, y, z = _rounded_axes(groups.axis).T + _TENTH
    words[:, AXIS] = x | y << 10 | z << 20 | np.where(groups.alike, ALIKE, 0)
    # Wider cones, and darkness only farther from them.
    cosine = np.floor((groups.cosine + 1.0) * (0.5 * _FIFTEENTH))
    sine = np.sqrt(np.maximum(1.0 - (cosine * (2.0 / _FIFTEENTH) - 1.0) ** 2, 0.0))
    words[:, CONE] = (cosine.astype(np.int64) << 15) | np.ceil(sine * _FIFTEENTH).astype(np.int64)
    dark = np.floor((groups.dark + 1.0) * (0.5 * _SIXTEENTH)).astype(np.int64)
    intensity = np.maximum(groups.intensity, 1e-30)
    words[:, STRENGTH] = (_upwards(intensity) << 16) | dark | np.where(groups.flat, FLAT, 0)
    return words


def _rounded_axes(axis: NDArray[np.float64]) -> NDArray[np.int64]:
    """Unit vectors in steps of 1 / _TENTH, none longer than 1.

    Behind a wide cone a longer one would feign an angle of 180 degrees where it is 177.
    """
    found, rows = np.rint(axis * _TENTH), np.arange(len(axis))
    for _ in range(3):
        # One coordinate after the other is rounded down, the one first that was most rounded up.
        long = np.sum(found * found, axis=1) > _TENTH**2
        most = np.argmax(np.abs(found) - np.abs(axis * _TENTH), axis=1)
        found[rows, most] -= np.where(long, np.sign(found[rows, most]), 0.0)
    return found.astype(np.int64)


def _upwards(x: NDArray[np.float64]) -> NDArray[np.int64]:
    """The least bfloat16 that is not below x, as a number of 16 bits."""
    limited = np.clip(x, -1e38, 1e38)
    single = limited.astype(np.float32)
    single = np.where(single < limited, np.nextafter(single, np.float32(np.inf)), single)
    bits = single.view(np.uint32).astype(np.int64)
    return np.where(single > 0.0, (bits + 0xFFFF) >> 16, bits >> 16)


def unpack(words: NDArray[np.uint32]) -> NDArray[np.float32]:
    """What `bounds_at` makes of the words, for `bounds_of_row`; (n, ROW)."""
    words = np.ascontiguousarray(words)
    halves = [(words[:, k] & np.uint32(0x7FFF0000)).view(np.float32) for k in (REACH, STRENGTH)]
    lower = (words[:, REACH] << np.uint32(16)).view(np.float32)
    word = words[:, AXIS].astype(np.int64)
    axis = [((word >> k & 1023) - _TENTH) / _TENTH for k in (0, 10, 20)]
    cone, strength = words[:, CONE].astype(np.int64), words[:, STRENGTH].astype(np.int64)
    cosine = (cone >> 15 & _FIFTEENTH) * (2.0 / _FIFTEENTH) - 1.0
    dark = (strength & _SIXTEENTH) * (2.0 / _SIXTEENTH) - 1.0
    far = np.where(word >= ALIKE, FAR_AWAY * halves[0].astype(float) ** 2, NEVER)
    far = np.where(cone >= EVEN, -1.0, np.minimum(far, NEVER))
    rows = np.zeros((len(words), ROW), np.float32)
    rows[:, :3] = words[:, :3].view(np.float32)
    columns = (halves[0], lower, *axis, cosine, (cone & _FIFTEENTH) / _FIFTEENTH, dark, halves[1])
    for k, column in enumerate((*columns, strength >= FLAT, far), 3):
        rows[:, k] = column
    return rows


#: What kernels know of a group; far: squared distance from which only intensity counts.
Bounds = namedtuple("Bounds", "center radius behind axis cosine sine dark intensity flat far")

#: Numbers of a row of `unpack`: those of `Bounds`.
RADIUS, INTENSITY, FAR, ROW = 3, 11, 13, 14

#: In `Bounds.far`: nowhere; metres squared.
NEVER = 3e38

#: unoriented, importance: what a group may send, without and with the cosine at the point; apart:
#: mask, only intensity counts below it.
GroupImportance = namedtuple("GroupImportance", "unoriented importance apart")


@kernel
def bounds_at(cdf, k):
    """The group that is packed at the offset k of each lane."""
    reach, turn = float_bits(gather(cdf, k + REACH)), float_bits(gather(cdf, k + AXIS))
    cone, strength = float_bits(gather(cdf, k + CONE)), float_bits(gather(cdf, k + STRENGTH))
    radius = bits_float(reach & 0xFFFF0000)
    axis = Vec3(
        to_float(turn & 1023) * (1.0 / 511.0) - 1.0,
        to_float((turn >> 10) & 1023) * (1.0 / 511.0) - 1.0,
        to_float((turn >> 20) & 1023) * (1.0 / 511.0) - 1.0,
    )
    far = where(turn >= ALIKE, FAR_AWAY * radius * radius, NEVER)
    return Bounds(
        center=gather_vec3(cdf, k),
        radius=radius,
        behind=bits_float(reach << 16),
        axis=axis,
        cosine=to_float((cone >> 15) & 32767) * (2.0 / 32767.0) - 1.0,
        sine=to_float(cone & 32767) * (1.0 / 32767.0),
        dark=to_float(strength & 65535) * (2.0 / 65535.0) - 1.0,
        intensity=bits_float(strength & 0x7FFF0000),
        flat=where(strength >= FLAT, 1.0, 0.0),
        far=where(cone >= EVEN, -1.0, far),
    )


@kernel
def bounds_of_row(cdf, k):
    """The group in the row of `unpack` at the uniform offset k: scalars, the same for all lanes."""
    return Bounds(
        center=row_vec3(cdf, k),
        radius=cdf[k + 3],
        behind=cdf[k + 4],
        axis=row_vec3(cdf, k + 5),
        cosine=cdf[k + 8],
        sine=cdf[k + 9],
        dark=cdf[k + 10],
        intensity=cdf[k + 11],
        flat=cdf[k + 12],
        far=cdf[k + 13],
    )


@kernel
def group_importance(group, p, n, everywhere, behind):
    """What a group may send to a point.

    Parameters
    ----------
    group : Bounds
    p, n : Vec3
        The point, and its unit normal on the side that is lit.
    everywhere : mask
        The point has no normal.
    behind : float
        Least cosine at the point.

    Returns
    -------
    GroupImportance
    """
    to_center = group.center - p
    far = maximum(dot(to_center, to_center), 1e-30)
    inverse = rsqrt(far)
    sine = group.radius * inverse
    # At the lights: the angle from the axis, less that of the cone.
    cos_w = maximum(minimum(-dot(group.axis, to_center) * inverse, 1.0), -1.0)
    sin_w = sqrt(1.0 - cos_w * cos_w)
    within = cos_w >= group.cosine
    towards = where(within, 1.0, cos_w * group.cosine + sin_w * group.sine)
    towards += group.behind * inverse
    shines = towards > group.dark - absolute(lanes(group.dark)) * sine - _GRAZING
    # The mean of what is lit, if the lights' cosines are spread evenly from here to there.
    opposite = cos_w <= -group.cosine
    away = where(opposite, -1.0, cos_w * group.cosine - sin_w * group.sine)
    away = away + group.behind * inverse
    towards = maximum(minimum(towards, 1.0), _LEAST)
    away = minimum(where(group.flat > 0.0, away, towards), towards)
    span = rsqrt(towards - minimum(away, 0.0))
    mean = 0.5 * (towards + maximum(away, 0.0)) * towards * (span * span)
    nearness = rsqrt(maximum(far, CLOSEST * (group.radius * group.radius)))
    unoriented = group.intensity * mean * (nearness * nearness)
    unoriented = where(shines, unoriented, 0.0)
    # At the lit point likewise.
    facing = where(everywhere, 1.0, dot(n, to_center) * inverse + sine)
    cosine = where(facing > -_GRAZING, maximum(minimum(facing, 1.0), _LEAST), 0.0)
    return GroupImportance(unoriented, unoriented * maximum(cosine, behind), far > group.far)
