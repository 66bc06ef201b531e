"""Rays against objects that move while the shutter is open, each at its own time.

Each ray goes to what it meets as it is at rest, by the inverse of the motion at its time
(`alight.core.motion`); the direction keeps its length, so that t means the same. In a list all
lanes go together, each at its own time; in the tree, whose boxes hold the whole motion, one ray at
a time. Both make the same numbers.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable

from alight.accel.layout import (
    LIST,
    MOVING,
    MOVING_LIST,
    MOVING_TREE,
    TREE,
    TRIANGLES,
    kinds_in,
    number_of,
)
from alight.accel.lists import Accelerator, take, wins, write_lists
from alight.accel.other_leaves import meet_of, take_hit_by, write_chain
from alight.accel.rays import MOST
from alight.core.motion import direction_at_rest, inverse_rows, matrix_at, point_at_rest
from alight.shapes.hit import Hit
from alight.shapes.model import SHAPES
from alight.shapes.triangle import intersect as intersect_triangle
from alight.shapes.triangle import rotated, shear_of
from lanewise.jit import kernel
from lanewise.records import replace
from lanewise.simd import (
    as_int,
    float_bits,
    lanes_u32,
    local_floats,
    store_lanes,
)

#: An `Accelerator`, and moving: u32, kind (`number_of`), shape, motion, row or first triangle and
#: number of triangles of those in the list; moving_corners: float32, of their triangles.
MovingAccelerator = namedtuple(
    "MovingAccelerator", (*Accelerator._fields, "moving", "moving_corners")
)
MOVING_ROW = 5

#: In the place of the rows of analytic shapes: those, `Motions`, and the times of the rays: lanes,
#: in the tree local floats.
AtTimes = namedtuple("AtTimes", "data motions time")


@kernel(strict=True)
def data_at_times(scene):
    """The `AtTimes` of a packet."""
    return AtTimes(scene.shapes.data, scene.motions, scene.time)


# ---------------------------------------------------------------- in the list


@kernel(strict=True)
def _meet_nothing(accel, data, at, o, d, best, nearest):
    """End of the chain of kinds."""
    return best


@kernel(strict=True)
def _meet_triangles(accel, data, at, o, d, best, nearest):
    """Meet a mesh of the list, at rest."""
    shear = shear_of(d)
    origin, table = rotated(o, shear), accel.moving
    first = as_int(table[at + 3])
    for i in range(as_int(table[at + 4])):
        t, u, v, met = intersect_triangle(
            accel.moving_corners, 9 * (first + i), origin, shear, best.t
        )
        hit = Hit(t, u, v, lanes_u32(table[at + 1]), lanes_u32(i))
        best = take(best, met & wins(hit, best), hit, nearest)
    return best


def _write_meet_shape(intersect: Callable) -> Callable:
    @kernel(strict=True)
    def meet_shape(accel, data, at, o, d, best, nearest):
        t, u, v, met = intersect(data, as_int(accel.moving[at + 3]), o, d, best.t)
        hit = Hit(t, u, v, lanes_u32(accel.moving[at + 1]), lanes_u32(0))
        return take(best, met & wins(hit, best), hit, nearest)

    return meet_shape


def _write_meet_kind(kind: str, otherwise: Callable) -> Callable:
    """The chain of kinds, one longer."""
    number = number_of(kind)
    intersect = None if kind == TRIANGLES else SHAPES[kind].intersect
    meet = _meet_triangles if intersect is None else _write_meet_shape(intersect)

    @kernel(strict=True)
    def meet_kind(accel, data, at, o, d, best, nearest):
        if as_int(accel.moving[at]) == number:
            return meet(accel, data, at, o, d, best, nearest)
        return otherwise(accel, data, at, o, d, best, nearest)

    return meet_kind


def write_moving_lists(plan: tuple[str, ...]) -> Callable:
    """As `lists.write_lists` for the lists of a plan and `AtTimes`: what rests, then what moves."""
    search_resting = write_lists(kinds_in(plan, LIST))
    meet = _meet_nothing
    for kind in kinds_in(plan, MOVING_LIST):
        meet = _write_meet_kind(kind, meet)

    @kernel(strict=True)
    def search(accel, data, o, d, best, nearest):
        best = search_resting(accel, data.data, o, d, best, nearest)
        for i in range(accel.moving.size // MOVING_ROW):
            at = MOVING_ROW * i
            number = lanes_u32(accel.moving[at + 2]) + lanes_u32(0)
            w = inverse_rows(matrix_at(data.motions, number, data.time))
            origin, direction = point_at_rest(w, o), direction_at_rest(w, d)
            best = meet(accel, data.data, at, origin, direction, best, nearest)
        return best

    return search


# ---------------------------------------------------------------- in the tree


def with_times_in_memory(search_tree: Callable) -> Callable:
    """A search of the tree with the times of its rays where each can be taken up alone."""

    @kernel(strict=True)
    def search_at_times(accel, data, o, d, best, nearest, others):
        times = local_floats(MOST)
        store_lanes(times, 0, data.time)
        at_times = AtTimes(data.data, data.motions, times)
        return search_tree(accel, at_times, o, d, best, nearest, others)

    return search_at_times


@kernel(strict=True)
def _ray_at_rest(search, at, ray):
    """A ray as the block at `at` sees it at rest."""
    data, number = search.data, as_int(float_bits(search.tree.blocks[at + 2]))
    w = inverse_rows(matrix_at(data.motions, number, data.time[ray.lane]))
    return replace(ray, o=point_at_rest(w, ray.o), d=direction_at_rest(w, ray.d))


@kernel(strict=True)
def _without_times(search):
    """A search as what is at rest knows it."""
    return replace(search, data=search.data.data)


def _unmoved(meet: Callable) -> Callable:
    """How a ray meets what rests, in a scene in which other things move."""

    @kernel(strict=True)
    def meet_resting(search, at, ray):
        return meet(_without_times(search), at, ray)

    return meet_resting


def _moved(meet: Callable) -> Callable:
    """A chain of kinds at rest, with the ray taken there first."""

    @kernel(strict=True)
    def meet_moving(search, at, ray):
        return meet(_without_times(search), at, _ray_at_rest(search, at, ray))

    return meet_moving


def write_moving_others(plan: tuple[str, ...]) -> Callable:
    """As `other_leaves.write_others`, for `AtTimes`."""
    moving = write_chain((MOVING + number_of(k), meet_of(k)) for k in kinds_in(plan, MOVING_TREE))
    resting = ((number_of(k), _unmoved(meet_of(k))) for k in kinds_in(plan, TREE))
    return take_hit_by(write_chain(resting, _moved(moving)))
