"""One ray against all boxes of a node, or all triangles of a block: the steps of a traversal.

Nothing is culled wrongly: the boxes are larger than their triangles by more than the triangle test
errs near them (`references.MARGIN`), and the far ends of the box test are stretched by a few units
of 2^-24, which covers all its rounding since every step is relative (Ize 2013, Robust BVH Ray
Traversal, JCGT 2(2)).

Nothing hangs: rays that are not finite, or that have no direction, meet nothing. Components of a
direction below 1e-37 count as 1e-37.
"""

from __future__ import annotations

from collections import namedtuple

from alight.accel.layout import BLOCK, CHILDREN, CORNERS, IDS, LEAF, NODE, UPPER, WIDTH
from alight.core.vec import Vec3
from alight.shapes.triangle import Shear, component, edge_functions, shear_of, sheared, where_met
from lanewise.jit import kernel
from lanewise.simd import (
    absolute,
    as_int,
    copysign,
    float_bits,
    mask_bits,
    maximum,
    minimum,
    permuted,
    trailing_zeros,
    where,
)
from lanewise.wide import lane, load_wide, prefetch, wide

#: Found by one ray: t; index of the primitive in the tree (NONE: nothing up to t); face: triangle
#: of an instance's mesh, else 0; u, v: barycentrics or local coordinates.
SingleHit = namedtuple("SingleHit", "t index face u v")

#: What the box test needs: origin and reciprocal direction in every lane, and for each axis the row
#: of the bound that the ray meets first (lower or upper).
BoxRay = namedtuple("BoxRay", "o r near_x near_y near_z")

#: What the triangle test needs: the origin in every lane, in the order of the shear's axes.
TriangleRay = namedtuple("TriangleRay", "o shear row_x row_y row_z")

#: 1 + 8 2^-24, relative rounding of the box test: two subtractions, two reciprocals, two products,
#: and the product with this.
STRETCH = 1.0 + 2.0**-20
SHRINK = 1.0 - 2.0**-20

#: Index of a hit that loses every tie.
NONE = 0x7FFFFFFF


@kernel(strict=True)
def is_traceable(o, d, t_max):
    """True for a ray that is finite and has a direction; t_max may be infinite."""
    zero = (o.x * 0.0 + o.y * 0.0 + o.z * 0.0) + (d.x * 0.0 + d.y * 0.0 + d.z * 0.0)
    some = maximum(absolute(d.x), maximum(absolute(d.y), absolute(d.z)))
    return (zero == 0.0) & (some > 0.0) & (t_max > 0.0)


@kernel(strict=True)
def safe_reciprocal(x):
    """1 / x, and a huge finite number where that would overflow: 0 times it is 0, not NaN."""
    return 1.0 / where(absolute(x) > 1e-37, x, copysign(1e-37, x))


@kernel(strict=True)
def box_ray(o, d):
    """The `BoxRay` of a ray (scalars)."""
    r = Vec3(safe_reciprocal(d.x), safe_reciprocal(d.y), safe_reciprocal(d.z))
    return BoxRay(
        Vec3(wide(CHILDREN, o.x), wide(CHILDREN, o.y), wide(CHILDREN, o.z)),
        Vec3(wide(CHILDREN, r.x), wide(CHILDREN, r.y), wide(CHILDREN, r.z)),
        0 if r.x >= 0.0 else UPPER,
        CHILDREN if r.y >= 0.0 else CHILDREN + UPPER,
        2 * CHILDREN if r.z >= 0.0 else 2 * CHILDREN + UPPER,
    )


@kernel(strict=True)
def triangle_ray(o, d):
    """The `TriangleRay` of a ray (scalars)."""
    s = shear_of(d)
    return TriangleRay(
        Vec3(
            wide(WIDTH, component(o, s.kx)),
            wide(WIDTH, component(o, s.ky)),
            wide(WIDTH, component(o, s.kz)),
        ),
        Shear(s.kx, s.ky, s.kz, wide(WIDTH, s.sx), wide(WIDTH, s.sy), wide(WIDTH, s.sz)),
        s.kx * WIDTH,
        s.ky * WIDTH,
        s.kz * WIDTH,
    )


@kernel(strict=True)
def meet_boxes(nodes, at, ray, t):
    """The boxes of the node that starts at `at`: entry distances, and which are met before t."""
    x0 = (load_wide(CHILDREN, nodes, at + ray.near_x) - ray.o.x) * ray.r.x
    y0 = (load_wide(CHILDREN, nodes, at + ray.near_y) - ray.o.y) * ray.r.y
    z0 = (load_wide(CHILDREN, nodes, at + ray.near_z) - ray.o.z) * ray.r.z
    x1 = (load_wide(CHILDREN, nodes, at + UPPER - ray.near_x) - ray.o.x) * ray.r.x
    y1 = (load_wide(CHILDREN, nodes, at + 5 * CHILDREN - ray.near_y) - ray.o.y) * ray.r.y
    z1 = (load_wide(CHILDREN, nodes, at + 7 * CHILDREN - ray.near_z) - ray.o.z) * ray.r.z
    enter = maximum(maximum(x0, y0), maximum(z0, 0.0))
    leave = minimum(minimum(x1, y1), minimum(z1, t))
    return enter, enter <= leave * STRETCH


@kernel(strict=True)
def meet_triangles(blocks, at, ray, t):
    """The triangles of the block that starts at `at`: t, u, v, and which are hit up to t."""
    x = load_wide(WIDTH, blocks, at + ray.row_x) - ray.o.x
    y = load_wide(WIDTH, blocks, at + ray.row_y) - ray.o.y
    z = load_wide(WIDTH, blocks, at + ray.row_z) - ray.o.z
    x, y = sheared(Vec3(x, y, z), ray.shear)
    corners = float_bits(load_wide(WIDTH, blocks, at + CORNERS))
    a, b, c = corners & 15, (corners >> 4) & 15, (corners >> 8) & 15
    az, bz, cz = permuted(z, a), permuted(z, b), permuted(z, c)
    w, inside = edge_functions(
        (permuted(x, a), permuted(y, a)),
        (permuted(x, b), permuted(y, b)),
        (permuted(x, c), permuted(y, c)),
    )
    found, u, v = where_met(w, az, bz - az, cz - az, ray.shear)
    return found, u, v, inside & (found > 0.0) & (found <= t)


@kernel(strict=True)
def closest_of_block(blocks, at, ray, best):
    """The nearer one of `best` and the hits in a block; of equals the one with the lower index."""
    found, u, v, hit = meet_triangles(blocks, at, ray, best.t)
    bits = mask_bits(hit)
    while bits != 0:
        i = trailing_zeros(bits)
        bits &= bits - 1
        t, index = lane(found, i), as_int(float_bits(blocks[at + IDS + i]))
        if (t < best.t) | ((t == best.t) & (index < best.index)):
            best = SingleHit(t, index, best.face, lane(u, i), lane(v, i))
    return best


@kernel(strict=True)
def fetch_ahead(tree, code):
    """Bring a child's cache lines in while others are looked at; rays wait mostly for memory."""
    if code < LEAF:
        for line in range(0, NODE, 16):
            prefetch(tree.nodes, NODE * code + line)
    else:
        at = BLOCK * ((code & (LEAF - 1)) >> 4)
        for line in range(0, BLOCK, 16):
            prefetch(tree.blocks, at + line)
