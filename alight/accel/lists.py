"""Packets of rays against flat lists of primitives, one primitive after another.

For a few big primitives this beats every tree: all lanes work on every test. Each kind has its own
loop; `write_lists` strings together those that a scene needs.

A list holds its primitives with (shape, prim) ascending, and of hits at the same t the one with the
lower (shape, prim) wins, so the result does not depend on the order of the loops.
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
from lanewise.records import replace
from lanewise.simd import as_int, bits_float, float_bits, lanes, lanes_u32, where

#: What `alight.accel.accelerator` makes and kernels are given. shapes: u32, where the list of each
#: kind with a formula starts, in the plan's order, and where the last one ends; then the lists, of
#: shapes and their rows in the data, and of which of its primitives it is where a shape has many.
#: They are one table so that kernels are given the same types however many kinds there are.
#: triangles: float32, corners of those in the list, and triangle_ids: u32, their shape and prim;
#: pairs: float32, four corners of two triangles each (`intersect_pair`), and pair_ids: u32, their
#: shape and two prims; tree: `Bvh`; box: float32, lower and upper bounds of it.
Accelerator = namedtuple("Accelerator", "shapes triangles triangle_ids pairs pair_ids tree box")

#: Kinds of lists beside those of shapes.
PAIRS = "pairs"

#: Shape of a hit that is none; it loses every tie.
NOTHING = 0xFFFFFFFF


@kernel(strict=True)
def start_search(t_max):
    """Where the search for a packet's hits starts: nothing up to t_max."""
    return Hit(t_max, lanes(0.0), lanes(0.0), lanes_u32(NOTHING), lanes_u32(0))


@kernel(strict=True)
def wins(a, b):
    """True if the first of two hits is nearer or, at the same t, has the lower (shape, prim)."""
    earlier = (a.shape < b.shape) | ((a.shape == b.shape) & (a.prim < b.prim))
    return (a.t < b.t) | ((a.t == b.t) & earlier)


@kernel(strict=True)
def take(best, mask, hit, nearest):
    """The lanes of `mask` take the hit; where any will do, their search is over (t -1)."""
    if nearest:
        return where(mask, hit, best)
    return replace(best, t=where(mask, -1.0, best.t))


@kernel(strict=True)
def start_list(best, nearest):
    """Where the search of one list starts: anything up to ``best.t``, itself included, is closer.

    Inside a list, in its order, a later hit must be strictly closer; that is one comparison.
    """
    if nearest:
        return start_search(where(best.t < INFINITY, bits_float(float_bits(best.t) + 1), best.t))
    return best


@kernel(strict=True)
def take_next(found, met, hit, nearest):
    """What a list has found after its next primitive, which is hit in the lanes of `met`."""
    return take(found, met & (hit.t < found.t) if nearest else met, hit, nearest)


@kernel(strict=True)
def end_list(found, best, nearest):
    """The better one of what a list found and what there was before, of other shapes."""
    if nearest:
        better = (found.shape != NOTHING) & ((found.t < best.t) | (found.shape < best.shape))
        return where(better, found, best)
    return found


def _write_shape_list(kind: str, place: int) -> Callable:
    """The search of the list of that kind of shape, which has that place."""
    intersect = SHAPES[kind].intersect
    assert intersect is not None
    if SHAPES[kind].is_many:
        return _write_list_of_many(intersect, place)

    @kernel(strict=True)
    def search_shapes(accel, data, o, d, best, nearest):
        table, found = accel.shapes, start_list(best, nearest)
        for i in range(as_int(table[place]), as_int(table[place + 1]), 2):
            t, u, v, met = intersect(data, as_int(table[i + 1]), o, d, found.t)
            hit = Hit(t, u, v, lanes_u32(table[i]), lanes_u32(0))
            found = take_next(found, met, hit, nearest)
        return end_list(found, best, nearest)

    return search_shapes


def _write_list_of_many(intersect: Callable, place: int) -> Callable:
    """The same of a shape of many primitives."""

    @kernel(strict=True)
    def search_many(accel, data, o, d, best, nearest):
        table, found = accel.shapes, start_list(best, nearest)
        for i in range(as_int(table[place]), as_int(table[place + 1]), 3):
            t, u, v, met = intersect(data, as_int(table[i + 1]), o, d, found.t)
            hit = Hit(t, u, v, lanes_u32(table[i]), lanes_u32(table[i + 2]))
            found = take_next(found, met, hit, nearest)
        return end_list(found, best, nearest)

    return search_many


@kernel(strict=True)
def search_triangles(accel, data, o, d, best, nearest):
    """Search the list of triangles."""
    shear, found = shear_of(d), start_list(best, nearest)
    origin, ids = rotated(o, shear), accel.triangle_ids
    for i in range(accel.triangles.size // 9):
        t, u, v, met = intersect_triangle(accel.triangles, 9 * i, origin, shear, found.t)
        hit = Hit(t, u, v, lanes_u32(ids[2 * i]), lanes_u32(ids[2 * i + 1]))
        found = take_next(found, met, hit, nearest)
    # Others of the same mesh may have been met as pairs.
    if nearest:
        return where((found.shape != NOTHING) & wins(found, best), found, best)
    return found


@kernel(strict=True)
def search_pairs(accel, data, o, d, best, nearest):
    """Search the list of pairs of triangles."""
    shear, found = shear_of(d), start_list(best, nearest)
    origin, ids = rotated(o, shear), accel.pair_ids
    for i in range(accel.pairs.size // 12):
        t, u, v, met, second = intersect_pair(accel.pairs, 12 * i, origin, shear, found.t)
        prim = where(second, lanes_u32(ids[3 * i + 2]), ids[3 * i + 1])
        found = take_next(found, met, Hit(t, u, v, lanes_u32(ids[3 * i]), prim), nearest)
    return end_list(found, best, nearest)


@kernel(strict=True)
def search_nothing(accel, data, o, d, best, nearest):
    """Start of the string of lists."""
    return best


def _then(first: Callable, second: Callable) -> Callable:
    @kernel(strict=True)
    def both(accel, data, o, d, best, nearest):
        return second(accel, data, o, d, first(accel, data, o, d, best, nearest), nearest)

    return both


def write_lists(kinds: tuple[str, ...]) -> Callable:
    """The search of the lists of the given kinds, those of shapes first.

    Returns
    -------
    kernel (accel, data, o, d, best, nearest) -> best
        best : Hit whose t is the end of the ray where nothing has been met; shape NOTHING there.
        nearest : False where any hit will do: then t becomes -1 in lanes that are blocked.
    """
    search = search_nothing
    for place, kind in enumerate(kinds):
        known = {TRIANGLES: search_triangles, PAIRS: search_pairs}
        search = _then(search, known.get(kind) or _write_shape_list(kind, place))
    return search
