"""Leaves that hold analytic shapes and instances as well as triangles.

One ray meets an analytic shape in packet arithmetic, all lanes alike, so that its numbers are those
that the flat lists get. An instance is met by moving the ray to the space of its geometry, whose
tree lies in the same arrays; the direction keeps its length, so that t means the same in both
spaces.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from alight.accel.layout import IDS, INSTANCE, TRIANGLES, number_of
from alight.accel.leaf_test import SOMETHING_ELSE, take_hit
from alight.accel.rays import NONE, SingleHit
from alight.accel.single_ray import trace_single_ray
from alight.core.vec import Vec3
from alight.shapes.model import SHAPES
from lanewise.jit import kernel
from lanewise.records import replace
from lanewise.simd import as_float, as_int, float_bits, lanes, mask_bits
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
def to_object(blocks, at, v, w):
    """A point (w = 1) or direction (w = 0) in the space of the instance whose map is at `at`."""
    return Vec3(
        blocks[at] * v.x + blocks[at + 1] * v.y + blocks[at + 2] * v.z + blocks[at + 3] * w,
        blocks[at + 4] * v.x + blocks[at + 5] * v.y + blocks[at + 6] * v.z + blocks[at + 7] * w,
        blocks[at + 8] * v.x + blocks[at + 9] * v.y + blocks[at + 10] * v.z + blocks[at + 11] * w,
    )


@kernel(strict=True)
def word_of(tree, at):
    """A whole number in the blocks of a tree."""
    return as_int(float_bits(tree.blocks[at]))


def _write_meet_one_of_many(meet_alone: Callable) -> Callable:
    @kernel(strict=True)
    def meet_one_of_many(search, at, ray):
        """The hit of one ray on the primitive of the block at `at`; index NONE if none."""
        row = word_of(search.tree, at + 1)
        t, u, v, bits = meet_alone(search.data, row, ray.o, ray.d, ray.t)
        found = word_of(search.tree, at + IDS) if bits != 0 else NONE
        return SingleHit(t, found, 0, u, v)

    return meet_one_of_many


def _write_meet_shape(intersect: Callable) -> Callable:
    @kernel(strict=True)
    def meet_shape(search, at, ray):
        """The hit of one ray on the analytic shape of the block at `at`; index NONE if none."""
        o, d = ray.o, ray.d
        origin = Vec3(lanes(o.x), lanes(o.y), lanes(o.z))
        direction = Vec3(lanes(d.x), lanes(d.y), lanes(d.z))
        row = word_of(search.tree, at + 1)
        t, u, v, hit = intersect(search.data, row, origin, direction, lanes(ray.t))
        found = word_of(search.tree, at + IDS) if mask_bits(hit) != 0 else NONE
        return SingleHit(lane(t, 0), found, 0, lane(u, 0), lane(v, 0))

    return meet_shape


@kernel(strict=True)
def meet_mesh(search, at, ray):
    """The hit of one ray, in the space of the mesh, on the mesh of the block at `at`."""
    hit = trace_single_ray(search, word_of(search.tree, at + 1), ray)
    found = word_of(search.tree, at + IDS) if hit.index != NONE else NONE
    return SingleHit(hit.t, found, hit.index, hit.u, hit.v)


@kernel(strict=True)
def meet_instance(search, at, ray):
    """The hit of one ray on the instance of the block at `at`."""
    origin = to_object(search.tree.blocks, at + 2, ray.o, 1.0)
    direction = to_object(search.tree.blocks, at + 2, ray.d, 0.0)
    return meet_mesh(search, at, replace(ray, o=origin, d=direction))


@kernel(strict=True)
def meet_nothing(search, at, ray):
    """End of the chain of kinds."""
    return SingleHit(ray.t, NONE, 0, 0.0 * ray.t, 0.0 * ray.t)


def meet_of(kind: str) -> Callable:
    """How one ray meets a kind, in the space in which that is at rest."""
    if kind == INSTANCE:
        return meet_instance
    if kind == TRIANGLES:
        return meet_mesh
    intersect, meet_alone = SHAPES[kind].intersect, SHAPES[kind].meet_alone
    if meet_alone is not None:
        return _write_meet_one_of_many(meet_alone)
    assert intersect is not None
    return _write_meet_shape(intersect)


def write_chain(meets: Iterable[tuple[int, Callable]], otherwise: Callable = meet_nothing):
    """How one ray meets several kinds, given by their numbers."""
    for number, meet in meets:
        otherwise = _write_branch(number, meet, otherwise)
    return otherwise


def _write_branch(number: int, meet: Callable, otherwise: Callable) -> Callable:
    @kernel(strict=True)
    def branch(search, at, ray):
        """Meet what a block holds if it is of this kind, or leave it to the others."""
        if word_of(search.tree, at) == number:
            return meet(search, at, ray)
        return otherwise(search, at, ray)

    return branch


def write_others(kinds: tuple[str, ...]) -> Callable:
    """What `leaf_test.run_leaf_tests` asks of leaves that hold triangles and these kinds."""
    return take_hit_by(write_chain((number_of(kind), meet_of(kind)) for kind in kinds))


def take_hit_by(meet: Callable) -> Callable:
    """As `leaf_test.take_hit`, in a tree where blocks may hold what a chain of kinds knows."""

    @kernel(strict=True)
    def take_any_hit(search, hits, ray, best):
        if hits.bits == SOMETHING_ELSE:
            found = meet(search, hits.at, ray)
        else:
            found = SingleHit(best.t, NONE, 0, best.u, best.v)
            found = take_hit(search, hits, found)
        if found.index == NONE:
            return best
        if not search.nearest:
            return replace(best, t=as_float(-1))
        ties = found.t == best.t
        if (found.t < best.t) | (ties & comes_first(search.tree.ids, found.index, best.index)):
            return found
        return best

    return take_any_hit
