"""Packets of rays against flat lists of primitives, one primitive after another.

For a few big primitives this beats every tree: all lanes work on every test. Each kind has its own
loop; `write_lists` strings together those that a scene needs.

A list holds its primitives with (shape, prim) ascending, and of hits at the same t the one with the
lower shape wins, so the result does not depend on the order of the loops.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable

from alight.accel.layout import TRIANGLES
from alight.core.constants import INFINITY
from alight.shapes.hit import Hit
from alight.shapes.model import SHAPES
from alight.shapes.triangle import intersect as intersect_triangle
from alight.shapes.triangle import intersect_pair, rotated, shear_of
from lanewise.jit import kernel
from lanewise.simd import as_int, bits_float, float_bits, lanes, lanes_u32, where

#: What `alight.accel.accelerator` makes and kernels are given. shapes: of each kind with a formula
#: in the plan's lists, u32, shape and row in the data of each; triangles: float32, corners of those
#: in the list, and triangle_ids: u32, their shape and prim; pairs: float32, four corners of two
#: triangles each (`intersect_pair`), and pair_ids: u32, their shape and two prims; tree: `Bvh`;
#: box: float32, lower and upper bounds of it.
Accelerator = namedtuple("Accelerator", "shapes triangles triangle_ids pairs pair_ids tree box")

#: Kinds of lists beside those of shapes.
PAIRS = "pairs"

#: Shape of a hit that is none; it loses every tie.
NOTHING = 0xFFFFFFFF


@kernel(strict=True)
def nothing_yet(best):
    """Where the search of one list starts: anything up to ``best.t``, itself included, is closer.

    Inside a list, in its order, a later hit must be strictly closer; that is one comparison.
    """
    beyond = where(best.t < INFINITY, bits_float(float_bits(best.t) + 1), best.t)
    return Hit(beyond, lanes(0.0), lanes(0.0), lanes_u32(NOTHING), lanes_u32(0))


@kernel(strict=True)
def keep(mask, a, b):
    """Lane-wise choice between two hits."""
    return Hit(
        where(mask, a.t, b.t),
        where(mask, a.u, b.u),
        where(mask, a.v, b.v),
        where(mask, a.shape, b.shape),
        where(mask, a.prim, b.prim),
    )


@kernel(strict=True)
def keep_closer(found, hit, t, u, v, shape, prim):
    """The lanes of `hit` that are closer replace `found`."""
    return keep(hit & (t < found.t), Hit(t, u, v, shape, prim), found)


@kernel(strict=True)
def merge(best, found):
    """The closer one of two hits, at the same t the one with the lower shape."""
    closer = (found.shape != NOTHING) & ((found.t < best.t) | (found.shape < best.shape))
    return keep(closer, found, best)


@kernel(strict=True)
def wins(a, b):
    """True if the first of two hits is nearer or, at the same t, has the lower (shape, prim)."""
    earlier = (a.shape < b.shape) | ((a.shape == b.shape) & (a.prim < b.prim))
    return (a.t < b.t) | ((a.t == b.t) & earlier)


def _write_shape_list(kind: str, place: int) -> tuple[Callable, Callable]:
    """Closest hits with, and occlusion by, the shapes of that kind, whose list has that place."""
    intersect = SHAPES[kind].intersect
    assert intersect is not None

    @kernel(strict=True)
    def closest(accel, data, o, d, best):
        table, found = accel.shapes[place], nothing_yet(best)
        for i in range(table.size // 2):
            t, u, v, hit = intersect(data, as_int(table[2 * i + 1]), o, d, found.t)
            found = keep_closer(found, hit, t, u, v, table[2 * i], 0)
        return merge(best, found)

    @kernel(strict=True)
    def occlude(accel, data, o, d, t_max):
        table = accel.shapes[place]
        for i in range(table.size // 2):
            _, _, _, hit = intersect(data, as_int(table[2 * i + 1]), o, d, t_max)
            t_max = where(hit, -1.0, t_max)
        return t_max

    return closest, occlude


@kernel(strict=True)
def closest_of_triangles(accel, data, o, d, best):
    """Closest hits with the triangles in the list."""
    shear, found = shear_of(d), nothing_yet(best)
    origin = rotated(o, shear)
    for i in range(accel.triangles.size // 9):
        t, u, v, hit = intersect_triangle(accel.triangles, 9 * i, origin, shear, found.t)
        found = keep_closer(
            found, hit, t, u, v, accel.triangle_ids[2 * i], accel.triangle_ids[2 * i + 1]
        )
    # Others of the same mesh may have been met as pairs.
    return keep((found.shape != NOTHING) & wins(found, best), found, best)


@kernel(strict=True)
def occlude_by_triangles(accel, data, o, d, t_max):
    """Occlusion by the triangles in the list."""
    shear = shear_of(d)
    origin = rotated(o, shear)
    for i in range(accel.triangles.size // 9):
        _, _, _, hit = intersect_triangle(accel.triangles, 9 * i, origin, shear, t_max)
        t_max = where(hit, -1.0, t_max)
    return t_max


@kernel(strict=True)
def closest_of_pairs(accel, data, o, d, best):
    """Closest hits with the pairs of triangles in the list."""
    shear, found = shear_of(d), nothing_yet(best)
    origin = rotated(o, shear)
    for i in range(accel.pairs.size // 12):
        t, u, v, hit, second = intersect_pair(accel.pairs, 12 * i, origin, shear, found.t)
        prim = where(second, lanes_u32(accel.pair_ids[3 * i + 2]), accel.pair_ids[3 * i + 1])
        found = keep_closer(found, hit, t, u, v, accel.pair_ids[3 * i], prim)
    return merge(best, found)


@kernel(strict=True)
def occlude_by_pairs(accel, data, o, d, t_max):
    """Occlusion by the pairs of triangles in the list."""
    shear = shear_of(d)
    origin = rotated(o, shear)
    for i in range(accel.pairs.size // 12):
        _, _, _, hit, _ = intersect_pair(accel.pairs, 12 * i, origin, shear, t_max)
        t_max = where(hit, -1.0, t_max)
    return t_max


@kernel(strict=True)
def closest_of_nothing(accel, data, o, d, best):
    """Start of the string of lists."""
    return best


@kernel(strict=True)
def occlude_by_nothing(accel, data, o, d, t_max):
    """Start of the string of lists."""
    return t_max


def _then(first: Callable, second: Callable) -> Callable:
    @kernel(strict=True)
    def both(accel, data, o, d, state):
        return second(accel, data, o, d, first(accel, data, o, d, state))

    return both


def write_lists(kinds: tuple[str, ...]) -> tuple[Callable, Callable]:
    """Kernels that visit the lists of the given kinds, those of shapes first.

    Returns
    -------
    closest : kernel (accel, data, o, d, best) -> best
        best : Hit whose t is the end of the ray where nothing has been met; shape NOTHING there.
    occlude : kernel (accel, data, o, d, t_max) -> t_max
        t_max becomes -1 in lanes that are blocked.
    """
    closest, occlude = closest_of_nothing, occlude_by_nothing
    for place, kind in enumerate(kinds):
        if kind == TRIANGLES:
            texts = closest_of_triangles, occlude_by_triangles
        elif kind == PAIRS:
            texts = closest_of_pairs, occlude_by_pairs
        else:
            texts = _write_shape_list(kind, place)
        closest, occlude = _then(closest, texts[0]), _then(occlude, texts[1])
    return closest, occlude
