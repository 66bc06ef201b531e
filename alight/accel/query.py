"""What integrators ask of a scene: the nearest hit of each ray of a packet, or whether it has any.

A packet first meets the flat lists, then the box of the tree. The lanes that enter it descend as a
packet while they agree, then each as a single ray, interleaved with the others. Both questions are
one text: `nearest` is a constant where a search is called, so that each gets machine code of its
own.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

from alight.accel.interleaved import trace_interleaved
from alight.accel.layout import LIST, MOVING_LIST, MOVING_TREE, TREE, kinds_in, kinds_in_order
from alight.accel.lists import NOTHING, no_hit, wins, write_lists
from alight.accel.moving import (
    data_at_times,
    with_times_in_memory,
    write_moving_lists,
    write_moving_others,
)
from alight.accel.node_test import is_traceable, meet_box, reciprocal_of
from alight.accel.other_leaves import write_others
from alight.accel.packet import no_packet, trace_packet, write_packet
from alight.accel.rays import NONE
from alight.core.constants import INFINITY
from alight.shapes.hit import Hit
from alight.shapes.model import SHAPES, ShapeModel
from lanewise.jit import kernel, specialised
from lanewise.records import replace
from lanewise.simd import gather_row, load_lanes, mask_bits, where


@kernel(strict=True)
def trace_tree(tree, data, o, d, t_max, bits, nearest, others):
    """What each of some rays of a packet meets in a tree.

    Parameters
    ----------
    tree : Bvh
    data, nearest, others
        As of `leaf_test.run_leaf_tests`.
    o, d : Vec3 of lanes
        Origins, metres, and directions, whose length is the unit of t.
    t_max : lanes
        Largest t that counts.
    bits : int
        The lanes that are wanted; their rays are finite and have a direction.

    Returns
    -------
    Hits
        Of primitives at the same t the one with the lowest (shape, prim). Where any will do: t -1.
    """
    packet = no_packet()
    write_packet(packet, o, d, t_max)
    trace_packet(tree, data, o, packet, bits, nearest, others)
    trace_interleaved(tree, data, packet, bits, nearest, others)
    return packet.hits


@kernel(strict=True)
def search_tree(accel, data, o, d, best, nearest, others):
    """Search the tree, after the lists (`lists.write_lists`)."""
    _, enters = meet_box(accel.box, 0, 1, o, reciprocal_of(d), best.t)
    bits = mask_bits(enters)
    if bits == 0:
        return best
    hits = trace_tree(accel.tree, data, o, d, best.t, bits, nearest, others)
    t = load_lanes(hits.t, 0)
    if not nearest:
        return replace(best, t=t)
    # What was hit is looked up for all lanes at once: they wait for memory together.
    index = load_lanes(hits.index, 0)
    # Triangles whose area underflows are "met" at infinity.
    met = (index != NONE) & (t < INFINITY)
    shape, prim = gather_row(accel.tree.ids, 2 * where(met, index, 0), 2)
    face = load_lanes(hits.face, 0)
    found = Hit(t, load_lanes(hits.u, 0), load_lanes(hits.v, 0), shape, prim + face)
    return where(met & wins(found, best), found, best)


@kernel(strict=True)
def data_of_shapes(scene):
    """The rows of analytic shapes."""
    return scene.shapes.data


def _queries(plan: tuple[str, ...]) -> tuple[Callable, Callable]:
    """The kernels `intersect_closest` and `is_occluded` of one plan (`accelerator`)."""
    models = tuple(
        SHAPES[kind]
        for kind in kinds_in_order({entry.split()[-1] for entry in plan})
        if kind in SHAPES
    )
    return _write_queries(plan, models)


@lru_cache(maxsize=256)
def _write_queries(
    plan: tuple[str, ...], models: tuple[ShapeModel, ...]
) -> tuple[Callable, Callable]:
    """The same, written once for these shapes: another version of one has other kernels."""
    moving = bool(kinds_in(plan, MOVING_LIST) or kinds_in(plan, MOVING_TREE))
    data_of, kinds = data_of_shapes, kinds_in(plan, TREE)
    others = write_others(kinds) if kinds else None
    search_lists, in_tree = write_lists(kinds_in(plan, LIST)), search_tree
    if moving:
        data_of, others = data_at_times, write_moving_others(plan)
        search_lists, in_tree = write_moving_lists(plan), with_times_in_memory(search_tree)
    has_tree = TREE in plan

    @kernel(strict=True)
    def search(scene, o, d, t_max, traceable, nearest):
        data = data_of(scene)
        best = no_hit(where(traceable, t_max, -1.0))
        best = search_lists(scene.accel, data, o, d, best, nearest)
        if has_tree:
            best = in_tree(scene.accel, data, o, d, best, nearest, others)
        return best

    @kernel(strict=True)
    def closest(scene, o, d, t_max, active):
        """The first surface that each ray meets.

        Parameters
        ----------
        scene : namedtuple
            With ``accel`` (`Accelerator`) and ``shapes.data``; where things move, with ``motions``
            and ``time`` too.
        o, d : Vec3
            Origins, metres, and directions, whose length is the unit of t.
        t_max : float
            Largest t that counts.
        active : mask
            Other lanes, and rays that are not finite or have no direction, meet nothing.

        Returns
        -------
        Hit
            t infinite for a miss; of hits at the same t the one with the lowest (shape, prim).
        """
        best = search(scene, o, d, t_max, active & is_traceable(o, d, t_max), True)
        missed = best.shape == NOTHING
        return replace(best, t=where(missed, INFINITY, best.t), shape=where(missed, 0, best.shape))

    @kernel(strict=True)
    def occluded(scene, o, d, t_max, active):
        """Lanes that meet anything at 0 < t <= t_max; parameters as of `closest`."""
        traceable = active & is_traceable(o, d, t_max)
        return traceable & (search(scene, o, d, t_max, traceable, False).t < 0.0)

    return closest, occluded


@specialised
def intersect_closest(program):
    """Closest hits of a packet of rays with the scene; see `_write_queries`."""
    return _queries(program.accel)[0]


@specialised
def is_occluded(program):
    """Occlusion of a packet of rays by the scene; see `_write_queries`."""
    return _queries(program.accel)[1]
