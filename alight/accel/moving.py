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
from alight.accel.lists import NOTHING, Accelerator, keep, wins, write_lists
from alight.accel.other_leaves import (
    leaves_of,
    visits_to,
    write_chain,
)
from alight.accel.rays import MOST
from alight.core.motion import direction_at_rest, inverse_rows, matrix_at, point_at_rest
from alight.shapes.hit import Hit
from alight.shapes.model import SHAPES
from alight.shapes.triangle import intersect as intersect_triangle
from alight.shapes.triangle import rotated, shear_of
from lanewise.jit import kernel
from lanewise.simd import (
    as_int,
    float_bits,
    lanes,
    lanes_u32,
    local_floats,
    store_lanes,
    where,
)

#: An `Accelerator`, and moving: u32, kind (`number_of`), shape, motion, row or first triangle and
#: number of triangles of those in the list; moving_corners: float32, of their triangles.
MovingAccelerator = namedtuple(
    "MovingAccelerator", (*Accelerator._fields, "moving", "moving_corners")
)
MOVING_ROW = 5

#: In the place of the rows of analytic shapes: those, `Motions`, and the times of the rays: lanes,
#: local floats, or the one of the ray that is looked at.
AtTimes = namedtuple("AtTimes", "data motions time")


@kernel(strict=True)
def data_at_times(scene):
    """The `AtTimes` of a packet."""
    return AtTimes(scene.shapes.data, scene.motions, scene.time)


@kernel(strict=True)
def data_of_ray(at_times, i):
    """The `AtTimes` of ray i of a packet in memory."""
    return AtTimes(at_times.data, at_times.motions, at_times.time[i])


# ---------------------------------------------------------------- in the list


@kernel(strict=True)
def _no_shape(accel, data, at, o, d, best):
    """End of the chain of kinds."""
    return best


@kernel(strict=True)
def _meet_triangles(accel, data, at, o, d, best):
    """Closest hits with a mesh of the list, at rest."""
    shear = shear_of(d)
    origin, table = rotated(o, shear), accel.moving
    first = as_int(table[at + 3])
    for i in range(as_int(table[at + 4])):
        t, u, v, hit = intersect_triangle(
            accel.moving_corners, 9 * (first + i), origin, shear, best.t
        )
        found = Hit(t, u, v, lanes_u32(table[at + 1]), lanes_u32(i))
        best = keep(hit & wins(found, best), found, best)
    return best


def _write_meet_shape(intersect: Callable) -> Callable:
    @kernel(strict=True)
    def meet_shape(accel, data, at, o, d, best):
        t, u, v, hit = intersect(data, as_int(accel.moving[at + 3]), o, d, best.t)
        found = Hit(t, u, v, lanes_u32(accel.moving[at + 1]), lanes_u32(0))
        return keep(hit & wins(found, best), found, best)

    return meet_shape


def _write_meet_kind(kind: str, otherwise: Callable) -> Callable:
    """The chain of kinds, one longer."""
    number = number_of(kind)
    intersect = None if kind == TRIANGLES else SHAPES[kind].intersect
    meet = _meet_triangles if intersect is None else _write_meet_shape(intersect)

    @kernel(strict=True)
    def meet_kind(accel, data, at, o, d, best):
        if as_int(accel.moving[at]) == number:
            return meet(accel, data, at, o, d, best)
        return otherwise(accel, data, at, o, d, best)

    return meet_kind


def write_moving_lists(plan: tuple[str, ...]) -> tuple[Callable, Callable]:
    """As `lists.write_lists` for the lists of a plan and `AtTimes`: what rests, then what moves."""
    closest_at_rest, occlude_at_rest = write_lists(kinds_in(plan, LIST))
    meet = _no_shape
    for kind in kinds_in(plan, MOVING_LIST):
        meet = _write_meet_kind(kind, meet)

    @kernel(strict=True)
    def closest_of_moving(accel, data, o, d, best):
        for i in range(accel.moving.size // MOVING_ROW):
            at = MOVING_ROW * i
            number = lanes_u32(accel.moving[at + 2]) + lanes_u32(0)
            w = inverse_rows(matrix_at(data.motions, number, data.time))
            origin, direction = point_at_rest(w, o), direction_at_rest(w, d)
            best = meet(accel, data.data, at, origin, direction, best)
        return best

    @kernel(strict=True)
    def closest(accel, data, o, d, best):
        best = closest_at_rest(accel, data.data, o, d, best)
        return closest_of_moving(accel, data, o, d, best)

    @kernel(strict=True)
    def occlude(accel, data, o, d, t_max):
        t_max = occlude_at_rest(accel, data.data, o, d, t_max)
        best = Hit(t_max, lanes(0.0), lanes(0.0), lanes_u32(NOTHING), lanes_u32(0))
        best = closest_of_moving(accel, data, o, d, best)
        return where(best.shape == NOTHING, t_max, -1.0)

    return closest, occlude


# ---------------------------------------------------------------- in the tree


def with_times_in_memory(search: Callable) -> Callable:
    """A search of the tree with the times of its rays where each can be taken up alone."""

    @kernel(strict=True)
    def in_memory(accel, data, o, d, state):
        times = local_floats(MOST)
        store_lanes(times, 0, data.time)
        return search(accel, AtTimes(data.data, data.motions, times), o, d, state)

    return in_memory


@kernel(strict=True)
def _ray_at_rest(tree, data, at, o, d):
    """Origin and direction of a ray at rest, for the block at `at`."""
    number = as_int(float_bits(tree.blocks[at + 2]))
    w = inverse_rows(matrix_at(data.motions, number, data.time))
    return point_at_rest(w, o), direction_at_rest(w, d)


def _unmoved(meet: Callable) -> Callable:
    """A visit to what rests, in a scene in which other things move."""

    @kernel(strict=True)
    def meet_resting(tree, data, at, index, o, d, t_max):
        return meet(tree, data.data, at, index, o, d, t_max)

    return meet_resting


def _moved(meet: Callable) -> Callable:
    """A chain of kinds at rest, with the ray taken there first."""

    @kernel(strict=True)
    def meet_moving(tree, data, kind, at, index, o, d, t_max):
        origin, direction = _ray_at_rest(tree, data, at, o, d)
        return meet(tree, data.data, kind, at, index, origin, direction, t_max)

    return meet_moving


def write_moving_leaves(plan: tuple[str, ...]) -> tuple[Callable, Callable]:
    """As `other_leaves.write_leaves`, for the `AtTimes` of one ray."""
    moving = [(MOVING + number_of(k), *visits_to(k)) for k in kinds_in(plan, MOVING_TREE)]
    resting = [(number_of(k), *map(_unmoved, visits_to(k))) for k in kinds_in(plan, TREE)]
    return leaves_of(*write_chain(resting, *map(_moved, write_chain(moving))))
