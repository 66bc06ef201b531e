r"""Densities on a square, read between texels and between the viewer's directions.

A table holds (h, w) texels whose first and last lie on the edges of the square; between four of
them the density is bilinear. There is one for each measured direction of the viewer, and in between
their densities are mixed. All integrals are mixed with them, hence sampling is exact: the row by
the integral over rows M, the place in it by the integral along it, C:

.. math:: u_y = M(y) = \int_0^y \int_0^1 p, \qquad
    u_x = \frac{C(x, y)}{C(1, y)} = \frac{\int_0^x p(x', y)\, dx'}{\int_0^1 p(x', y)\, dx'}

Within a texel both are quadratic.

Source: Dupuy and Jakob 2018, section 4; PBR4 section A.5 for the inversion of a linear density.
"""

from __future__ import annotations

from collections import namedtuple

import numpy as np
from numpy.typing import NDArray

from alight.core.constants import ONE_MINUS_EPSILON
from alight.core.vec import Vec3, lerp
from lanewise.jit import kernel
from lanewise.simd import (
    any_lane,
    gather,
    lanes,
    lanes_u32,
    maximum,
    minimum,
    sqrt,
    to_float,
    to_uint,
    where,
)

#: The measured directions around the viewer's. first: number of the one before; elevation,
#: azimuth: distance of the next one, 0 if there is none; of_elevation, of_azimuth: part of that.
Viewed = namedtuple("Viewed", "first elevation azimuth of_elevation of_azimuth")
#: A table in `curves`: where the first one starts, distance of the next, texels of a side (floats).
Warp = namedtuple("Warp", "curves start size height width")
#: A place in a table: number of the texel before it, and part of the next one.
Place = namedtuple("Place", "index part")


# ---------------------------------------------------------------- on the host


def warp_tables(density: NDArray[np.float32]) -> NDArray[np.float64]:
    """Tables with their integrals.

    Parameters
    ----------
    density : (p, t, h, w)
        Not negative; what is 0 everywhere becomes the same everywhere.

    Returns
    -------
    (p, t, 2 h w + 2 h) float64
        Texels; integrals C up to each; integrals of the rows; integrals M up to each.
    """
    p, t, h, w = density.shape
    dark = density.max(axis=(2, 3), keepdims=True) <= 0.0
    values = np.where(dark, 1.0, density.astype(np.float64))
    along = np.zeros_like(values)
    along[..., 1:] = np.cumsum(0.5 * (values[..., 1:] + values[..., :-1]), axis=3) / (w - 1)
    rows = along[..., -1]
    up = np.zeros_like(rows)
    up[..., 1:] = np.cumsum(0.5 * (rows[..., 1:] + rows[..., :-1]), axis=2) / (h - 1)
    whole = up[..., -1:]
    parts = (values.reshape(p, t, -1), along.reshape(p, t, -1), rows, up)
    return np.concatenate(parts, axis=2) / whole


# ---------------------------------------------------------------- numbers between tables


@kernel
def interval_of(curves, at, count, x):
    """(number of the interval, part of it) of x among ascending numbers, clamped; 0 for one."""
    low, high = lanes_u32(0), count - 1
    while any_lane(high > low + 1):
        middle = (low + high) >> 1
        below = gather(curves, at + middle) <= x
        low, high = where(below, middle, low), where(below, high, middle)
    has_next = high > low
    a = gather(curves, at + low)
    b = gather(curves, at + where(has_next, low + 1, low))
    part = minimum(maximum((x - a) / where(has_next & (b > a), b - a, 1.0), 0.0), 1.0)
    return low, where(has_next, part, 0.0)


@kernel
def _read(warp, viewed, i):
    """Number i of the tables, mixed between the measured directions of the viewer."""
    value = _between_elevations(warp, viewed, i)
    # Of most materials there is one azimuth only.
    if any_lane(viewed.of_azimuth > 0.0):
        there = _between_elevations(warp, viewed, i + viewed.azimuth * warp.size)
        value = value + viewed.of_azimuth * (there - value)
    return value


@kernel
def _between_elevations(warp, viewed, i):
    at = warp.start + viewed.first * warp.size + i
    a, b = gather(warp.curves, at), gather(warp.curves, at + viewed.elevation * warp.size)
    return a + viewed.of_elevation * (b - a)


@kernel
def place_of(u, texels):
    """The `Place` of a coordinate in [0, 1] among so many texels (a float)."""
    x = minimum(maximum(u, 0.0), 1.0) * (texels - 1.0)
    i = to_uint(minimum(x, texels - 2.0))
    return Place(i, x - to_float(i))


@kernel
def read_texels(curves, start, height, width, u):
    """A table without viewers, between its texels at u."""
    x, y = place_of(u[0], width), place_of(u[1], height)
    columns = to_uint(width)
    at = start + y.index * columns + x.index
    below = lerp(x.part, gather(curves, at), gather(curves, at + 1))
    above = lerp(x.part, gather(curves, at + columns), gather(curves, at + columns + 1))
    return lerp(y.part, below, above)


@kernel
def read_color(warp, viewed, u):
    """A table of colours at u: 3 planes of texels a viewer."""
    return Vec3(
        _read_plane(warp, viewed, u, 0),
        _read_plane(warp, viewed, u, 1),
        _read_plane(warp, viewed, u, 2),
    )


@kernel
def _read_plane(warp, viewed, u, plane):
    x, y = place_of(u[0], warp.width), place_of(u[1], warp.height)
    columns = to_uint(warp.width)
    at = plane * columns * to_uint(warp.height) + y.index * columns + x.index
    below = lerp(x.part, _read(warp, viewed, at), _read(warp, viewed, at + 1))
    next_row = at + columns
    above = lerp(x.part, _read(warp, viewed, next_row), _read(warp, viewed, next_row + 1))
    return lerp(y.part, below, above)


# ---------------------------------------------------------------- densities


@kernel
def _solve(rest, a, b):
    """t with a t + (b - a) t^2 / 2 = rest, for a density from a to b along [0, 1]."""
    # The form without a division by b - a, which may be 0.
    root = sqrt(maximum(a * a + 2.0 * (b - a) * rest, 0.0))
    below = a + root
    t = 2.0 * rest / where(below > 0.0, below, 1.0)
    return minimum(maximum(t, 0.0), 1.0)


@kernel
def _texel_columns(warp):
    return to_uint(warp.width), to_uint(warp.height)


@kernel
def sample_warp(warp, viewed, u2):
    """((x, y), density) of a point of the square."""
    columns, rows = _texel_columns(warp)
    masses, sums = 2 * columns * rows, 2 * columns * rows + rows
    # The row: the last one whose integral is at most u_y.
    low, high = lanes_u32(0), rows - 1
    while any_lane(high > low + 1):
        middle = (low + high) >> 1
        below = _read(warp, viewed, sums + middle) <= u2[1]
        low, high = where(below, middle, low), where(below, high, middle)
    row = low
    a, b = _read(warp, viewed, masses + row), _read(warp, viewed, masses + row + 1)
    rest = (u2[1] - _read(warp, viewed, sums + row)) * (warp.height - 1.0)
    t = _solve(rest, a, b)
    # The place in it, where both rows around it are mixed.
    begin = row * columns
    along = columns * rows + begin
    wanted = u2[0] * lerp(t, a, b)
    low, high = lanes_u32(0), columns - 1
    while any_lane(high > low + 1):
        middle = (low + high) >> 1
        before = _mixed(warp, viewed, along + middle, columns, t)
        below = before <= wanted
        low, high = where(below, middle, low), where(below, high, middle)
    a = _mixed(warp, viewed, begin + low, columns, t)
    b = _mixed(warp, viewed, begin + low + 1, columns, t)
    before = _mixed(warp, viewed, along + low, columns, t)
    s = _solve((wanted - before) * (warp.width - 1.0), a, b)
    x = (to_float(low) + s) / (warp.width - 1.0)
    y = (to_float(row) + t) / (warp.height - 1.0)
    return (x, y), lerp(s, a, b)


@kernel
def _mixed(warp, viewed, i, columns, t):
    return lerp(t, _read(warp, viewed, i), _read(warp, viewed, i + columns))


@kernel
def density_at(warp, viewed, u):
    """Density at a point of the square."""
    return _read_plane(warp, viewed, u, 0)


@kernel
def invert_warp(warp, viewed, u):
    """((u_x, u_y), density): what `sample_warp` makes a point of."""
    columns, rows = _texel_columns(warp)
    x, y = place_of(u[0], warp.width), place_of(u[1], warp.height)
    masses, sums = 2 * columns * rows, 2 * columns * rows + rows
    a, b = _read(warp, viewed, masses + y.index), _read(warp, viewed, masses + y.index + 1)
    u_y = _read(warp, viewed, sums + y.index)
    u_y = u_y + y.part * (a + 0.5 * y.part * (b - a)) / (warp.height - 1.0)
    mass = lerp(y.part, a, b)
    at = y.index * columns + x.index
    a = _mixed(warp, viewed, at, columns, y.part)
    b = _mixed(warp, viewed, at + 1, columns, y.part)
    before = _mixed(warp, viewed, columns * rows + at, columns, y.part)
    before = before + x.part * (a + 0.5 * x.part * (b - a)) / (warp.width - 1.0)
    u_x = where(mass > 0.0, before / where(mass > 0.0, mass, 1.0), lanes(0.5))
    found = minimum(u_x, ONE_MINUS_EPSILON), minimum(u_y, ONE_MINUS_EPSILON)
    return found, lerp(x.part, a, b)
