"""Leaves that hold analytic shapes and instances as well as triangles.

One ray meets an analytic shape in packet arithmetic, all lanes alike, so that its numbers are those
that the flat lists get. An instance is met by moving the ray to the space of its geometry, whose
tree lies in the same arrays; the direction keeps its length, so that t means the same in both
spaces.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from alight.accel.layout import IDS, INSTANCE, TRIANGLES, number_of
from alight.accel.leaf_test import SOMETHING_ELSE, any_of_hits, closest_of_hits
from alight.accel.node_test import NONE, SingleHit
from alight.accel.single_ray import write_single
from alight.core.vec import Vec3
from alight.shapes.model import SHAPES
from lanewise.jit import kernel
from lanewise.simd import as_int, float_bits, lanes, mask_bits
from lanewise.wide import lane


@kernel(strict=True)
def comes_first(ids, a, b):
    """Does index a win against b at the same t? The lower (shape, prim) does."""
    if b == NONE:
        return True
    shape_a, shape_b = ids[2 * a], ids[2 * b]
    if shape_a != shape_b:
        return shape_a < shape_b
    return a < b


@kernel(strict=True)
def closer(ids, best, other):
    """The nearer one of two hits."""
    if other.index == NONE:
        return best
    if (other.t < best.t) | ((other.t == best.t) & comes_first(ids, other.index, best.index)):
        return other
    return best


@kernel(strict=True)
def to_object(blocks, at, v, w):
    """A point (w = 1) or direction (w = 0) in the space of the instance whose map is at `at`."""
    return Vec3(
        blocks[at] * v.x + blocks[at + 1] * v.y + blocks[at + 2] * v.z + blocks[at + 3] * w,
        blocks[at + 4] * v.x + blocks[at + 5] * v.y + blocks[at + 6] * v.z + blocks[at + 7] * w,
        blocks[at + 8] * v.x + blocks[at + 9] * v.y + blocks[at + 10] * v.z + blocks[at + 11] * w,
    )


def _write_meet_shape(intersect: Callable) -> Callable:
    @kernel(strict=True)
    def meet_shape(tree, data, at, index, o, d, t_max):
        """The hit of one ray on an analytic shape; index NONE if there is none."""
        row = as_int(float_bits(tree.blocks[at + 1]))
        origin = Vec3(lanes(o.x), lanes(o.y), lanes(o.z))
        direction = Vec3(lanes(d.x), lanes(d.y), lanes(d.z))
        t, u, v, hit = intersect(data, row, origin, direction, lanes(t_max))
        found = index if mask_bits(hit) != 0 else NONE
        return SingleHit(lane(t, 0), found, 0, lane(u, 0), lane(v, 0))

    return meet_shape


closest_triangle = write_single(True)
any_triangle = write_single(False)


@kernel(strict=True)
def meet_mesh(tree, data, at, index, o, d, t_max):
    """The hit of one ray, in the space of the mesh, on the mesh of the block at `at`; or NONE."""
    root = as_int(float_bits(tree.blocks[at + 1]))
    hit = closest_triangle(tree, o, d, t_max, root)
    found = index if hit.index != NONE else NONE
    return SingleHit(hit.t, found, hit.index, hit.u, hit.v)


@kernel(strict=True)
def mesh_is_met(tree, data, at, index, o, d, t_max):
    """True if one ray, in the space of the mesh, meets the mesh of the block at `at`."""
    root = as_int(float_bits(tree.blocks[at + 1]))
    return any_triangle(tree, o, d, t_max, root).t < 0.0


@kernel(strict=True)
def meet_instance(tree, data, at, index, o, d, t_max):
    """The hit of one ray on an instance; index NONE if there is none."""
    origin = to_object(tree.blocks, at + 2, o, 1.0)
    direction = to_object(tree.blocks, at + 2, d, 0.0)
    return meet_mesh(tree, data, at, index, origin, direction, t_max)


@kernel(strict=True)
def instance_is_met(tree, data, at, index, o, d, t_max):
    """True if one ray meets an instance."""
    origin = to_object(tree.blocks, at + 2, o, 1.0)
    direction = to_object(tree.blocks, at + 2, d, 0.0)
    return mesh_is_met(tree, data, at, index, origin, direction, t_max)


@kernel(strict=True)
def nothing_is_met(tree, data, kind, at, index, o, d, t_max):
    """End of the chain of kinds."""
    return SingleHit(t_max, NONE, 0, 0.0 * t_max, 0.0 * t_max)


@kernel(strict=True)
def nothing_is_in_the_way(tree, data, kind, at, index, o, d, t_max):
    """End of the chain of kinds."""
    return False


def _write_branch(number: int, meet: Callable, otherwise: Callable) -> Callable:
    @kernel(strict=True)
    def branch(tree, data, kind, at, index, o, d, t_max):
        """Visit a block of the right kind, or leave it to the others."""
        if kind == number:
            return meet(tree, data, at, index, o, d, t_max)
        return otherwise(tree, data, kind, at, index, o, d, t_max)

    return branch


def _write_meet_any_shape(intersect: Callable) -> Callable:
    meet_shape = _write_meet_shape(intersect)

    @kernel(strict=True)
    def shape_is_met(tree, data, at, index, o, d, t_max):
        """True if one ray meets an analytic shape."""
        return meet_shape(tree, data, at, index, o, d, t_max).index != NONE

    return shape_is_met


def visits_to(kind: str) -> tuple[Callable, Callable]:
    """What (closest, any) one ray meets of a kind, in the space in which that is at rest."""
    if kind == INSTANCE:
        return meet_instance, instance_is_met
    if kind == TRIANGLES:
        return meet_mesh, mesh_is_met
    intersect = SHAPES[kind].intersect
    assert intersect is not None
    return _write_meet_shape(intersect), _write_meet_any_shape(intersect)


def write_leaves(kinds: tuple[str, ...]) -> tuple[Callable, Callable]:
    """Visits (closest, any) to leaves that hold triangles and the given kinds."""
    return leaves_of(*write_chain((number_of(kind), *visits_to(kind)) for kind in kinds))


def write_chain(
    visits: Iterable[tuple[int, Callable, Callable]],
    meet_other: Callable = nothing_is_met,
    block_other: Callable = nothing_is_in_the_way,
) -> tuple[Callable, Callable]:
    """What (closest, any) one ray meets of several kinds: their numbers, closest and any."""
    for number, meet, block in visits:
        meet_other = _write_branch(number, meet, meet_other)
        block_other = _write_branch(number, block, block_other)
    return meet_other, block_other


def leaves_of(meet_other: Callable, block_other: Callable) -> tuple[Callable, Callable]:
    """Visits (closest, any) to leaves that hold triangles and what a chain of kinds knows."""

    @kernel(strict=True)
    def closest_of_found(tree, data, at, o, d, numbers, k, bits, best):
        """The nearer one of `best` and what is hit in a block; as `leaf_test.closest_of_hits`."""
        if bits == SOMETHING_ELSE:
            index = as_int(float_bits(tree.blocks[at + IDS]))
            kind = as_int(float_bits(tree.blocks[at]))
            found = meet_other(tree, data, kind, at, index, o, d, best.t)
        else:
            found = SingleHit(best.t, NONE, 0, best.u, best.v)
            found = closest_of_hits(tree, data, at, o, d, numbers, k, bits, found)
        return closer(tree.ids, best, found)

    @kernel(strict=True)
    def any_of_found(tree, data, at, o, d, numbers, k, bits, best):
        """`any_of_hits` if anything in a block is hit, else `best`."""
        if bits == SOMETHING_ELSE:
            index = as_int(float_bits(tree.blocks[at + IDS]))
            kind = as_int(float_bits(tree.blocks[at]))
            if not block_other(tree, data, kind, at, index, o, d, best.t):
                return best
        return any_of_hits(tree, data, at, o, d, numbers, k, bits, best)

    return closest_of_found, any_of_found
