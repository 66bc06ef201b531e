"""The rays of a packet in memory, so that each can continue alone."""

from __future__ import annotations

from collections import namedtuple

from alight.accel.layout import CHILDREN, UPPER, WIDTH
from alight.accel.node_test import BoxRay, TriangleRay, safe_reciprocal
from alight.core.vec import Vec3
from alight.shapes.triangle import Shear, rotated, shear_of
from lanewise.jit import kernel
from lanewise.simd import as_int, lanes_u32, store_lanes, where
from lanewise.wide import wide

#: Most lanes that a packet can have.
MOST = 16

#: What the tests need of each ray. numbers: local floats, rows of MOST: origin, direction, its
#: reciprocal, origin in the order of the shear's axes, shear; rows: local uints, rows of MOST: of
#: the near bounds, then of the shear's axes.
Rays = namedtuple("Rays", "numbers rows")
ORIGIN, DIRECTION, RECIPROCAL, ROTATED, SHEAR = (3 * MOST * i for i in range(5))
NUMBERS = 15 * MOST
AXES = 3 * MOST
ROWS = 6 * MOST

#: What has been found, local tables of MOST: t of the hit (before it: the largest that counts), its
#: barycentrics, index in the tree (`NONE` before it) and face (`SingleHit`).
Hits = namedtuple("Hits", "t u v index face")


@kernel(strict=True)
def write_rays(rays, o, d):
    """Write down what the box and triangle tests need of each ray of a packet."""
    r = Vec3(safe_reciprocal(d.x), safe_reciprocal(d.y), safe_reciprocal(d.z))
    shear = shear_of(d)
    numbers, rows = rays.numbers, rays.rows
    _store(numbers, ORIGIN, o)
    _store(numbers, DIRECTION, d)
    _store(numbers, RECIPROCAL, r)
    _store(numbers, ROTATED, rotated(o, shear))
    _store(numbers, SHEAR, Vec3(shear.sx, shear.sy, shear.sz))
    zero = lanes_u32(0)
    store_lanes(rows, 0, where(r.x >= 0.0, zero, UPPER))
    store_lanes(rows, MOST, where(r.y >= 0.0, zero + CHILDREN, CHILDREN + UPPER))
    store_lanes(rows, 2 * MOST, where(r.z >= 0.0, zero + 2 * CHILDREN, 2 * CHILDREN + UPPER))
    store_lanes(rows, AXES, WIDTH * (zero + shear.kx))
    store_lanes(rows, AXES + MOST, WIDTH * (zero + shear.ky))
    store_lanes(rows, AXES + 2 * MOST, WIDTH * (zero + shear.kz))


@kernel(strict=True)
def _store(numbers, k, v):
    """Write the three components of a packet's vectors from numbers[k] on."""
    store_lanes(numbers, k, v.x)
    store_lanes(numbers, k + MOST, v.y)
    store_lanes(numbers, k + 2 * MOST, v.z)


@kernel(strict=True)
def vector_of(rays, k, i):
    """One vector of ray i, from row k on."""
    numbers = rays.numbers
    return Vec3(numbers[k + i], numbers[k + MOST + i], numbers[k + 2 * MOST + i])


@kernel(strict=True)
def _spread(n, v):
    """One vector in n lanes."""
    return Vec3(wide(n, v.x), wide(n, v.y), wide(n, v.z))


@kernel(strict=True)
def box_ray_of(rays, i):
    """The `BoxRay` of ray i."""
    rows = rays.rows
    return BoxRay(
        _spread(CHILDREN, vector_of(rays, ORIGIN, i)),
        _spread(CHILDREN, vector_of(rays, RECIPROCAL, i)),
        as_int(rows[i]),
        as_int(rows[MOST + i]),
        as_int(rows[2 * MOST + i]),
    )


@kernel(strict=True)
def triangle_ray_of(rays, i):
    """The `TriangleRay` of ray i; its shear's axes are in the rows already."""
    rows, shear = rays.rows, _spread(WIDTH, vector_of(rays, SHEAR, i))
    return TriangleRay(
        _spread(WIDTH, vector_of(rays, ROTATED, i)),
        Shear(0, 0, 0, shear.x, shear.y, shear.z),
        as_int(rows[AXES + i]),
        as_int(rows[AXES + MOST + i]),
        as_int(rows[AXES + 2 * MOST + i]),
    )
