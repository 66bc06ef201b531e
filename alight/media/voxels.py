"""Grids of values in the tables of media: interpolated between the centres of cells."""

from __future__ import annotations

from alight.core.vec import Vec3, gather_vec3
from alight.media.tables import DENSITIES, EMISSION, EMISSIONS, INFO, MATRIX, STRIDE
from lanewise.jit import kernel
from lanewise.simd import (
    any_lane,
    floor,
    gather,
    maximum,
    minimum,
    minimum_u32,
    to_float,
    to_uint,
    where,
)


@kernel
def into_cube(scene, medium, p, w):
    """p . rows + w . last column: a point (w = 1) or direction (w = 0) in the unit cube."""
    m, k = scene.media.data, medium * STRIDE + MATRIX
    return Vec3(
        gather(m, k) * p.x + gather(m, k + 1) * p.y + gather(m, k + 2) * p.z + w * gather(m, k + 3),
        gather(m, k + 4) * p.x
        + gather(m, k + 5) * p.y
        + gather(m, k + 6) * p.z
        + w * gather(m, k + 7),
        gather(m, k + 8) * p.x
        + gather(m, k + 9) * p.y
        + gather(m, k + 10) * p.z
        + w * gather(m, k + 11),
    )


@kernel
def _place(x, count):
    """(first cell, its neighbour, how far between both) of a coordinate in [0, 1]."""
    last = to_float(count - 1)
    # In this order: a lane that is not a number becomes 0.
    at = minimum(maximum(x * to_float(count) - 0.5, 0.0), last)
    whole = floor(at)
    first = to_uint(whole)
    return first, minimum_u32(first + 1, count - 1), at - whole


@kernel
def _corners(scene, medium, word, p):
    """Where the eight neighbours of a point stand in a grid: rows of x, and the fractions."""
    info, k = scene.media.info, medium * INFO + word
    nx, ny = gather(info, k + 1), gather(info, k + 2)
    x0, x1, fx = _place(p.x, nx)
    y0, y1, fy = _place(p.y, ny)
    z0, z1, fz = _place(p.z, gather(info, k + 3))
    return (
        (z0 * ny + y0) * nx,
        (z0 * ny + y1) * nx,
        (z1 * ny + y0) * nx,
        (z1 * ny + y1) * nx,
        x0,
        x1,
        fx,
        fy,
        fz,
    )


@kernel
def _blended(voxels, start, stride, corners):
    """The value between the neighbours."""
    r00, r01, r10, r11, x0, x1, fx, fy, fz = corners
    a0, a1 = (
        gather(voxels, start + (r00 + x0) * stride),
        gather(voxels, start + (r00 + x1) * stride),
    )
    b0, b1 = (
        gather(voxels, start + (r01 + x0) * stride),
        gather(voxels, start + (r01 + x1) * stride),
    )
    c0, c1 = (
        gather(voxels, start + (r10 + x0) * stride),
        gather(voxels, start + (r10 + x1) * stride),
    )
    e0, e1 = (
        gather(voxels, start + (r11 + x0) * stride),
        gather(voxels, start + (r11 + x1) * stride),
    )
    a, b = a0 + fx * (a1 - a0), b0 + fx * (b1 - b0)
    c, e = c0 + fx * (c1 - c0), e0 + fx * (e1 - e0)
    low, high = a + fy * (b - a), c + fy * (e - c)
    return low + fz * (high - low)


@kernel
def density(scene, medium, p):
    """Density at a point of the unit cube."""
    corners = _corners(scene, medium, DENSITIES, p)
    start = gather(scene.media.info, medium * INFO + DENSITIES)
    return _blended(scene.media.voxels, start, 1, corners)


@kernel
def color_at(scene, medium, constant, word, p):
    """Colour at a point of the unit cube: from the grid at a word of the table, or a constant."""
    value = gather_vec3(scene.media.data, medium * STRIDE + constant)
    found = gather(scene.media.info, medium * INFO + word)
    varies = found != 0
    if any_lane(varies):
        start = where(varies, found - 1, 0)
        corners = _corners(scene, where(varies, medium, 0), word, p)
        voxels = scene.media.voxels
        red = _blended(voxels, start, 3, corners)
        green = _blended(voxels, start + 1, 3, corners)
        value = where(varies, Vec3(red, green, _blended(voxels, start + 2, 3, corners)), value)
    return value


@kernel
def emission(scene, medium, p):
    """What a medium shines with at a point of the world."""
    return color_at(scene, medium, EMISSION, EMISSIONS, into_cube(scene, medium, p, 1.0))
