"""What integrators ask of a scene: the nearest hit of each ray of a packet, or whether it has any.

A packet first meets the flat lists, then the box of the tree. The lanes that enter it descend as a
packet while they agree, then each as a single ray, interleaved with the others. Both questions are
one text: `nearest` is a constant where a search is called, so that each gets machine code of its
own.
"""

from __future__ import annotations

from functools import lru_cache

from alight.accel.interleaved import trace_interleaved
from alight.accel.layout import LIST, MOVING_LIST, MOVING_TREE, TREE, kinds_in, kinds_in_order
from alight.accel.lists import NOTHING, start_search, wins, write_lists
from alight.accel.moving import (
    data_at_times,
    with_times_in_memory,
    write_moving_lists,
    write_moving_others,
)
from alight.accel.node_test import is_traceable, meet_box, reciprocal_of
from alight.accel.other_leaves import write_others
from alight.accel.packet import new_packet, trace_packet, write_packet
from alight.accel.rays import NONE, BoxRays, Search
from alight.core.constants import INFINITY
from alight.shapes.hit import Hit
from alight.shapes.model import SHAPES, ShapeModel
from lanewise.jit import kernel, specialised
from lanewise.records import replace
from lanewise.simd import gather_row, load_lanes, mask_bits, where


@kernel(strict=True)
def intersect_closest(scene, o, d, t_max, active):
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
    hit = search_scene(scene, o, d, t_max, active & is_traceable(o, d, t_max), True)
    missed = hit.shape == NOTHING
    return replace(hit, t=where(missed, INFINITY, hit.t), shape=where(missed, 0, hit.shape))


@kernel(strict=True)
def is_occluded(scene, o, d, t_max, active):
    """Lanes that meet anything at 0 < t <= t_max; parameters as of `intersect_closest`."""
    traceable = active & is_traceable(o, d, t_max)
    return traceable & (search_scene(scene, o, d, t_max, traceable, False).t < 0.0)


@specialised
def search_scene(program):
    """The search of the lists and the tree: (scene, o, d, t_max, traceable, nearest) -> Hit."""
    plan = program.accel
    data_of, search_lists, search_of_tree, others = _texts_of(plan, models_of(plan))
    has_tree = TREE in plan

    @kernel(strict=True)
    def search(scene, o, d, t_max, traceable, nearest):
        data = data_of(scene)
        best = start_search(where(traceable, t_max, -1.0))
        best = search_lists(scene.accel, data, o, d, best, nearest)
        if has_tree:
            best = search_of_tree(scene.accel, data, o, d, best, nearest, others)
        return best

    return search


@kernel(strict=True)
def search_tree(accel, data, o, d, best, nearest, others):
    """Search the tree: as a packet, then ray by ray.

    Parameters
    ----------
    accel : Accelerator
    data, nearest
        As of `Search`.
    o, d : Vec3 of lanes
    best : Hit
        What the lists hold (`lists.write_lists`); what is returned, too.
    others
        As of `leaf_test.run_leaf_tests`.
    """
    _, enters = meet_box(accel.box, 0, 1, BoxRays(o, reciprocal_of(d), best.t))
    bits = mask_bits(enters)
    if bits == 0:
        return best
    search, packet = Search(accel.tree, data, nearest), new_packet()
    write_packet(packet, o, d, best.t)
    trace_packet(search, o, packet, bits, others)
    trace_interleaved(search, packet, bits, others)
    hits = packet.hits
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


def models_of(plan: tuple[str, ...]) -> tuple[ShapeModel, ...]:
    """The models of the shapes in a plan (`accelerator`)."""
    kinds = kinds_in_order({entry.split()[-1] for entry in plan})
    return tuple(SHAPES[kind] for kind in kinds if kind in SHAPES)


@lru_cache(maxsize=256)
def _texts_of(plan: tuple[str, ...], models: tuple[ShapeModel, ...]) -> tuple:
    """What `search_scene` calls for a plan, written once for these models of its shapes.

    Returns
    -------
    data_of, search_lists, search_tree : kernels
    others : kernel or None
        As of `leaf_test.run_leaf_tests`.
    """
    if kinds_in(plan, MOVING_LIST) or kinds_in(plan, MOVING_TREE):
        search_of_tree = with_times_in_memory(search_tree)
        return data_at_times, write_moving_lists(plan), search_of_tree, write_moving_others(plan)
    kinds = kinds_in(plan, TREE)
    others = write_others(kinds) if kinds else None
    return data_of_shapes, write_lists(kinds_in(plan, LIST)), search_tree, others
