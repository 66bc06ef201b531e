"""The node test: where a ray enters a box, and whether before t.

A single ray is tested against all children of a node at once, a packet against one child at a time.

Nothing is culled wrongly: the boxes are larger than their triangles by more than the triangle test
errs near them (`references.MARGIN`), and the far ends of the box test are stretched by a few units
of 2^-24, which covers all its rounding since every step is relative (Ize 2013, Robust BVH Ray
Traversal, JCGT 2(2)).

Nothing hangs: rays that are not finite, or that have no direction, meet nothing. Components of a
direction below 1e-37 count as 1e-37.
"""

from __future__ import annotations

from alight.accel.layout import CHILDREN, UPPER
from alight.core.vec import Vec3
from lanewise.jit import kernel
from lanewise.simd import absolute, copysign, maximum, minimum, where
from lanewise.wide import load_wide

#: 1 + 16 2^-24: more than the relative rounding of the box test, which is that of two subtractions,
#: two reciprocals, two products, and the product with this.
STRETCH = 1.0 + 2.0**-20
SHRINK = 1.0 - 2.0**-20


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
def reciprocal_of(d):
    """The `safe_reciprocal` of each component of a direction."""
    return Vec3(safe_reciprocal(d.x), safe_reciprocal(d.y), safe_reciprocal(d.z))


@kernel(strict=True)
def meet_slabs(near, far, t):
    """Where rays enter a box, and whether before t and before they leave it.

    near, far: where they enter and leave the slab of each axis.
    """
    enter = maximum(maximum(near.x, near.y), maximum(near.z, 0.0))
    leave = minimum(minimum(far.x, far.y), minimum(far.z, t))
    return enter, enter <= leave * STRETCH


@kernel(strict=True)
def meet_children(nodes, at, ray, t):
    """One ray (`BoxRay`) and all children of the node at `at`: (entries, met before t)."""
    near = Vec3(
        (load_wide(CHILDREN, nodes, at + ray.near_x) - ray.o.x) * ray.r.x,
        (load_wide(CHILDREN, nodes, at + ray.near_y) - ray.o.y) * ray.r.y,
        (load_wide(CHILDREN, nodes, at + ray.near_z) - ray.o.z) * ray.r.z,
    )
    far = Vec3(
        (load_wide(CHILDREN, nodes, at + UPPER - ray.near_x) - ray.o.x) * ray.r.x,
        (load_wide(CHILDREN, nodes, at + 5 * CHILDREN - ray.near_y) - ray.o.y) * ray.r.y,
        (load_wide(CHILDREN, nodes, at + 7 * CHILDREN - ray.near_z) - ray.o.z) * ray.r.z,
    )
    return meet_slabs(near, far, t)


@kernel(strict=True)
def meet_box(bounds, k, step, rays):
    """All rays of a packet (`BoxRays`) and one box: (entries, which meet it before t).

    The bounds lower x, y, z, upper x, y, z are `step` words apart, from word k on. The signs of the
    directions, and so which bound comes first, differ from lane to lane.
    """
    o, r = rays.o, rays.r
    # This way round the bound is an operand from memory.
    x0, x1 = (o.x - bounds[k]) * -r.x, (o.x - bounds[k + 3 * step]) * -r.x
    y0, y1 = (o.y - bounds[k + step]) * -r.y, (o.y - bounds[k + 4 * step]) * -r.y
    z0, z1 = (o.z - bounds[k + 2 * step]) * -r.z, (o.z - bounds[k + 5 * step]) * -r.z
    near = Vec3(minimum(x0, x1), minimum(y0, y1), minimum(z0, z1))
    far = Vec3(maximum(x0, x1), maximum(y0, y1), maximum(z0, z1))
    return meet_slabs(near, far, rays.t)
