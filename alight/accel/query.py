"""The interface for integrators: packets of rays against a whole scene.

A packet first meets the flat lists, then the box of the tree; the lanes that enter it go down
together as long as they go the same way, then each on 8 boxes at a time.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

from alight.accel.interleaved import write_packet
from alight.accel.layout import LIST, MOVING_LIST, MOVING_TREE, TREE, kinds_in, kinds_in_order
from alight.accel.leaf_test import any_of_hits, closest_of_hits, data_of_all
from alight.accel.lists import (
    NOTHING,
    closest_of_nothing,
    keep,
    occlude_by_nothing,
    wins,
    write_lists,
)
from alight.accel.moving import (
    data_at_times,
    data_of_ray,
    with_times_in_memory,
    write_moving_leaves,
    write_moving_lists,
)
from alight.accel.node_test import NONE, STRETCH, is_traceable, safe_reciprocal
from alight.accel.other_leaves import write_leaves
from alight.accel.rays import MOST, Hits
from alight.core.constants import INFINITY
from alight.core.vec import Vec3
from alight.shapes.hit import Hit
from alight.shapes.model import SHAPES, ShapeModel
from lanewise.jit import kernel, specialised
from lanewise.simd import (
    gather_row,
    lanes,
    lanes_u32,
    load_lanes,
    local_floats,
    local_uints,
    mask_bits,
    maximum,
    minimum,
    store_lanes,
    where,
)


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
def start(hits, t_max):
    """Nothing found yet, up to t_max in each lane."""
    store_lanes(hits.t, 0, t_max)
    store_lanes(hits.u, 0, lanes(0.0))
    store_lanes(hits.v, 0, lanes(0.0))
    store_lanes(hits.index, 0, lanes_u32(NONE))
    store_lanes(hits.face, 0, lanes_u32(0))


def _write_tree(plan: tuple[str, ...], moving: bool) -> tuple[Callable, Callable]:
    """Kernels that send the lanes of a packet through the tree."""
    kinds = kinds_in(plan, TREE)
    leaf, any_leaf = write_leaves(kinds) if kinds else (closest_of_hits, any_of_hits)
    of_ray = data_of_all
    if moving:
        leaf, any_leaf = write_moving_leaves(plan)
        of_ray = data_of_ray
    closest_of_rays = write_packet(leaf, True, bool(kinds) or moving, of_ray)
    any_of_rays = write_packet(any_leaf, False, bool(kinds) or moving, of_ray)

    @kernel(strict=True)
    def closest(accel, data, o, d, best):
        bits = mask_bits(enters_box(accel.box, o, d, best.t))
        if bits == 0:
            return best
        hits = Hits(
            local_floats(MOST), local_floats(MOST), local_floats(MOST),
            local_uints(MOST), local_uints(MOST),
        )  # fmt: skip
        start(hits, best.t)
        closest_of_rays(accel.tree, data, o, d, bits, hits)
        # What was hit is looked up for all lanes at once: they wait for memory together.
        index, t = load_lanes(hits.index, 0), load_lanes(hits.t, 0)
        # Triangles whose area underflows are "met" at infinity.
        met = (index != NONE) & (t < INFINITY)
        shape, prim = gather_row(accel.tree.ids, 2 * where(met, index, 0), 2)
        found = Hit(
            t,
            load_lanes(hits.u, 0),
            load_lanes(hits.v, 0),
            shape,
            prim + load_lanes(hits.face, 0),
        )
        return keep(met & wins(found, best), found, best)

    @kernel(strict=True)
    def occlude(accel, data, o, d, t_max):
        bits = mask_bits(enters_box(accel.box, o, d, t_max))
        if bits == 0:
            return t_max
        hits = Hits(
            local_floats(MOST), local_floats(MOST), local_floats(MOST),
            local_uints(MOST), local_uints(MOST),
        )  # fmt: skip
        start(hits, t_max)
        any_of_rays(accel.tree, data, o, d, bits, hits)
        return load_lanes(hits.t, 0)

    if moving:
        return with_times_in_memory(closest), with_times_in_memory(occlude)
    return closest, occlude


@kernel(strict=True)
def data_of_shapes(scene):
    """The rows of analytic shapes."""
    return scene.shapes.data


def _write_queries(plan: tuple[str, ...]) -> tuple[Callable, Callable]:
    """The kernels `intersect_closest` and `is_occluded` of one plan (`accelerator`)."""
    models = tuple(
        SHAPES[kind]
        for kind in kinds_in_order({entry.split()[-1] for entry in plan})
        if kind in SHAPES
    )
    return _queries_of(plan, models)


@lru_cache(maxsize=256)
def _queries_of(plan: tuple[str, ...], models: tuple[ShapeModel, ...]) -> tuple[Callable, Callable]:
    """The same, written once for these shapes: another version of one has other kernels."""
    moving = bool(kinds_in(plan, MOVING_LIST) or kinds_in(plan, MOVING_TREE))
    data_of = data_at_times if moving else data_of_shapes
    if moving:
        closest_of_lists, occlude_by_lists = write_moving_lists(plan)
    else:
        closest_of_lists, occlude_by_lists = write_lists(kinds_in(plan, LIST))
    closest_of_tree, occlude_by_tree = closest_of_nothing, occlude_by_nothing
    if "tree" in plan:
        closest_of_tree, occlude_by_tree = _write_tree(plan, moving)

    @kernel(strict=True)
    def closest(scene, o, d, t_max, active):
        """The first surface that each ray meets.

        Parameters
        ----------
        scene : namedtuple
            With ``accel`` (`Accelerator`) and ``shapes.data``; where things move, with ``motions``
            and ``time`` too.
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
        data = data_of(scene)
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
        data = data_of(scene)
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
