"""What integrators call: packets of rays against a whole scene.

A packet first meets the flat lists, then the box of the tree; the lanes that enter it go down one
by one, each on 8 boxes at a time.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

from alight.accel.layout import KINDS
from alight.accel.lists import (
    NOTHING,
    closest_of_nothing,
    keep,
    occlude_by_nothing,
    write_lists,
)
from alight.accel.mixed import write_mixed
from alight.accel.single import NONE, STRETCH, is_traceable, safe_reciprocal
from alight.accel.traversal import any_triangle, closest_triangle
from alight.core.constants import INFINITY
from alight.core.jit import kernel, specialised
from alight.core.simd import (
    as_uint,
    gather,
    lanes,
    lanes_u32,
    load_lanes,
    local_floats,
    local_uints,
    mask_bits,
    maximum,
    minimum,
    store_lanes,
    trailing_zeros,
    where,
)
from alight.core.vec import Vec3
from alight.shapes.hit import Hit

#: Most lanes that a packet can have, and room for six numbers a lane.
_MOST = 16
_RAYS = 6 * _MOST


@kernel(strict=True)
def enters_box(box, o, d, t_max):
    """Lanes that meet the box (6 floats: lower, upper bounds) at 0 <= t <= t_max."""
    r = Vec3(safe_reciprocal(d.x), safe_reciprocal(d.y), safe_reciprocal(d.z))
    low = (Vec3(box[0], box[1], box[2]) - o) * r
    high = (Vec3(box[3], box[4], box[5]) - o) * r
    enter = maximum(
        maximum(minimum(low.x, high.x), minimum(low.y, high.y)),
        maximum(minimum(low.z, high.z), 0.0),
    )
    leave = minimum(
        minimum(maximum(low.x, high.x), maximum(low.y, high.y)),
        minimum(maximum(low.z, high.z), t_max),
    )
    return enter <= leave * STRETCH


@kernel(strict=True)
def spill(rays, o, d):
    """Write a packet's rays to memory: x, y, z of the origins, then of the directions."""
    store_lanes(rays, 0, o.x)
    store_lanes(rays, _MOST, o.y)
    store_lanes(rays, 2 * _MOST, o.z)
    store_lanes(rays, 3 * _MOST, d.x)
    store_lanes(rays, 4 * _MOST, d.y)
    store_lanes(rays, 5 * _MOST, d.z)


@kernel(strict=True)
def origin_of(rays, i):
    """Origin of lane i."""
    return Vec3(rays[i], rays[_MOST + i], rays[2 * _MOST + i])


@kernel(strict=True)
def direction_of(rays, i):
    """Direction of lane i."""
    return Vec3(rays[3 * _MOST + i], rays[4 * _MOST + i], rays[5 * _MOST + i])


@kernel(strict=True)
def wins(a, b):
    """True if the first of two hits is nearer or, at the same t, has the lower (shape, prim)."""
    earlier = (a.shape < b.shape) | ((a.shape == b.shape) & (a.prim < b.prim))
    return (a.t < b.t) | ((a.t == b.t) & earlier)


def _write_tree(kinds: tuple[str, ...]) -> tuple[Callable, Callable]:
    """Kernels that send the lanes of a packet through the tree one by one."""
    closest_one, any_one = write_mixed(kinds) if kinds else (closest_triangle, any_triangle)

    @kernel(strict=True)
    def closest(accel, data, o, d, best):
        bits = mask_bits(enters_box(accel.box, o, d, best.t))
        if bits == 0:
            return best
        rays = local_floats(_RAYS)
        found_t, found_u, found_v = local_floats(_MOST), local_floats(_MOST), local_floats(_MOST)
        indices, faces = local_uints(_MOST), local_uints(_MOST)
        spill(rays, o, d)
        store_lanes(found_t, 0, best.t)
        store_lanes(indices, 0, lanes_u32(NONE))
        while bits != 0:
            i = trailing_zeros(bits)
            bits &= bits - 1
            hit = closest_one(
                accel.tree, data, origin_of(rays, i), direction_of(rays, i), found_t[i], 0
            )
            if hit.index != NONE:
                found_t[i], found_u[i], found_v[i] = hit.t, hit.u, hit.v
                indices[i], faces[i] = as_uint(hit.index), as_uint(hit.face)
        # What was hit is looked up for all lanes at once: they wait for memory together.
        index, t = load_lanes(indices, 0), load_lanes(found_t, 0)
        # Triangles whose area underflows are "met" at infinity.
        met = (index != NONE) & (t < INFINITY)
        at = 2 * where(met, index, 0)
        found = Hit(
            t,
            load_lanes(found_u, 0),
            load_lanes(found_v, 0),
            gather(accel.tree.ids, at),
            gather(accel.tree.ids, at + 1) + load_lanes(faces, 0),
        )
        return keep(met & wins(found, best), found, best)

    @kernel(strict=True)
    def occlude(accel, data, o, d, t_max):
        bits = mask_bits(enters_box(accel.box, o, d, t_max))
        if bits == 0:
            return t_max
        rays, ends = local_floats(_RAYS), local_floats(_MOST)
        spill(rays, o, d)
        store_lanes(ends, 0, t_max)
        while bits != 0:
            i = trailing_zeros(bits)
            bits &= bits - 1
            if any_one(accel.tree, data, origin_of(rays, i), direction_of(rays, i), ends[i], 0):
                ends[i] = -1.0
        return load_lanes(ends, 0)

    return closest, occlude


@lru_cache(maxsize=256)
def _write_queries(plan: tuple[str, ...]) -> tuple[Callable, Callable]:
    """The kernels `intersect_closest` and `is_occluded` of one plan (`accelerator`)."""
    kinds = tuple(kind for kind in KINDS if kind + "s in tree" in plan)
    closest_of_lists, occlude_by_lists = write_lists(
        tuple(name for name in plan if "tree" not in name)
    )
    closest_of_tree, occlude_by_tree = closest_of_nothing, occlude_by_nothing
    if "tree" in plan:
        closest_of_tree, occlude_by_tree = _write_tree(kinds)

    @kernel(strict=True)
    def closest(scene, o, d, t_max, active):
        """The first surface that each ray meets.

        Parameters
        ----------
        scene : namedtuple
            With ``accel`` (`Accelerator`) and ``shapes.data``.
        o, d : Vec3
            Origins, metres, and directions; |d| is the unit of t.
        t_max : float
            Largest t that counts.
        active : mask
            Other lanes, and rays that are not finite or have no direction, meet nothing.

        Returns
        -------
        Hit
            t infinite for a miss; of hits at the same t the one with the lowest (shape, prim).
        """
        data = scene.shapes.data
        traceable = active & is_traceable(o, d, t_max)
        best = Hit(
            where(traceable, t_max, -1.0), lanes(0.0), lanes(0.0), lanes_u32(NOTHING), lanes_u32(0)
        )
        best = closest_of_lists(scene.accel, data, o, d, best)
        best = closest_of_tree(scene.accel, data, o, d, best)
        missed = best.shape == NOTHING
        return Hit(
            where(missed, INFINITY, best.t), best.u, best.v, where(missed, 0, best.shape), best.prim
        )

    @kernel(strict=True)
    def occluded(scene, o, d, t_max, active):
        """Lanes that meet anything at 0 < t <= t_max; parameters as of `closest`."""
        data = scene.shapes.data
        traceable = active & is_traceable(o, d, t_max)
        end = where(traceable, t_max, -1.0)
        end = occlude_by_lists(scene.accel, data, o, d, end)
        end = occlude_by_tree(scene.accel, data, o, d, end)
        return traceable & (end < 0.0)

    return closest, occluded


@specialised
def intersect_closest(program):
    """Closest hits of a packet of rays with the scene; see `_write_queries`."""
    return _write_queries(program.accel)[0]


@specialised
def is_occluded(program):
    """Occlusion of a packet of rays by the scene; see `_write_queries`."""
    return _write_queries(program.accel)[1]
