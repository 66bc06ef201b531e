"""Rays as the node and leaf tests need them: one alone, and those of a packet in memory."""

from __future__ import annotations

from collections import namedtuple

from alight.accel.layout import CHILDREN, UPPER, WIDTH
from alight.accel.node_test import reciprocal_of
from alight.core.vec import Vec3
from alight.shapes.triangle import Shear, rotated, shear_of
from lanewise.jit import kernel
from lanewise.simd import (
    as_int,
    lanes,
    lanes_u32,
    local_floats,
    local_uints,
    store_lanes,
    where,
)
from lanewise.wide import wide

#: What rays search and for what. tree: `Bvh`; data: rows of analytic shapes, or `moving.AtTimes`;
#: nearest: a constant, False where any hit will do. Then no order matters, and only t of a hit is
#: kept, which is -1.
Search = namedtuple("Search", "tree data nearest")

#: One ray: origin, direction, largest t that counts; lane: its number in the packet.
Ray = namedtuple("Ray", "o d t lane")

#: Found by one ray: t; index of the primitive in the tree (NONE: nothing up to t); face: triangle
#: of an instance's mesh, else 0; u, v: barycentrics or local coordinates. Where any hit will do: t
#: is -1 once there is one.
SingleHit = namedtuple("SingleHit", "t index face u v")

#: Index of a hit that loses every tie.
NONE = 0x7FFFFFFF

#: What the node test needs: origin and reciprocal direction in every lane, and for each axis the
#: row of the bound that the ray meets first (lower or upper).
BoxRay = namedtuple("BoxRay", "o r near_x near_y near_z")

#: What the node test needs of a whole packet: origins, reciprocal directions, largest t that count.
BoxRays = namedtuple("BoxRays", "o r t")

#: What the leaf test needs: the origin in every lane, in the order of the shear's axes, and the row
#: of each of these axes.
TriangleRay = namedtuple("TriangleRay", "o shear row_x row_y row_z")

#: Most lanes that a packet can have.
MOST = 16

#: What the tests need of each ray. numbers: local floats, rows of MOST: origin, direction, its
#: reciprocal, origin in the order of the shear's axes, shear; rows: local uints, rows of MOST: of
#: the near bounds, then of the shear's axes.
Rays = namedtuple("Rays", "numbers rows")
ORIGIN, DIRECTION, RECIPROCAL, ROTATED, SHEAR = (3 * MOST * i for i in range(5))
_NUMBERS = 15 * MOST
AXES = 3 * MOST
_ROWS = 6 * MOST

#: What the rays have found, local tables of MOST: t of the hit (before it: the largest that
#: counts), its barycentrics, index in the tree (`NONE` before it) and face, as of `SingleHit`.
Hits = namedtuple("Hits", "t u v index face")


@kernel(strict=True)
def box_ray(o, d):
    """The `BoxRay` of a ray (scalars)."""
    r = reciprocal_of(d)
    return BoxRay(
        _spread(CHILDREN, o),
        _spread(CHILDREN, r),
        0 if r.x >= 0.0 else UPPER,
        CHILDREN if r.y >= 0.0 else CHILDREN + UPPER,
        2 * CHILDREN if r.z >= 0.0 else 2 * CHILDREN + UPPER,
    )


@kernel(strict=True)
def triangle_ray(o, d):
    """The `TriangleRay` of a ray (scalars)."""
    s = shear_of(d)
    return TriangleRay(
        _spread(WIDTH, rotated(o, s)),
        Shear(s.kx, s.ky, s.kz, wide(WIDTH, s.sx), wide(WIDTH, s.sy), wide(WIDTH, s.sz)),
        s.kx * WIDTH,
        s.ky * WIDTH,
        s.kz * WIDTH,
    )


@kernel(strict=True)
def new_rays():
    """Room for the rays of a packet."""
    return Rays(local_floats(_NUMBERS), local_uints(_ROWS))


@kernel(strict=True)
def new_hits():
    """Room for the hits of a packet."""
    return Hits(
        local_floats(MOST), local_floats(MOST), local_floats(MOST),
        local_uints(MOST), local_uints(MOST),
    )  # fmt: skip


@kernel(strict=True)
def write_rays(rays, o, d):
    """Write down what the tests need of each ray of a packet."""
    r, shear = reciprocal_of(d), shear_of(d)
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
def write_no_hits(hits, t_max):
    """Nothing found yet, up to t_max in each lane."""
    store_lanes(hits.t, 0, t_max)
    store_lanes(hits.u, 0, lanes(0.0))
    store_lanes(hits.v, 0, lanes(0.0))
    store_lanes(hits.index, 0, lanes_u32(NONE))
    store_lanes(hits.face, 0, lanes_u32(0))


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
    """The `BoxRay` of ray i of a packet."""
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
    """The `TriangleRay` of ray i of a packet; its shear's axes are in the rows already."""
    rows, shear = rays.rows, _spread(WIDTH, vector_of(rays, SHEAR, i))
    return TriangleRay(
        _spread(WIDTH, vector_of(rays, ROTATED, i)),
        Shear(0, 0, 0, shear.x, shear.y, shear.z),
        as_int(rows[AXES + i]),
        as_int(rows[AXES + MOST + i]),
        as_int(rows[AXES + 2 * MOST + i]),
    )
