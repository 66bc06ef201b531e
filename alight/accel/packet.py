"""The rays of a packet descend the bounding volume hierarchy together while they agree.

Rays of neighbouring samples, and from one point to one light, visit the same nodes. One box against
all of them is one test, and the overhead of a step, mostly the misprediction of the next child, is
paid once. So a packet opens a node together while enough of its rays are in it (`FEW`); a subtree
that only few enter waits until they reach it alone (`interleaved`). The choice is made at every
node, so nothing depends on a guess about the scene.

The companions of a ray change the order of its visits, but not its hit: the nearest one, the lowest
among equals, is the same in any order, as no box is culled wrongly (`node_test`).
"""

from __future__ import annotations

from collections.abc import Callable

from alight.accel.layout import BLOCK, CHILD, CHILDREN, LEAF, MAX_DEPTH, NODE, STACK, UPPER
from alight.accel.node_test import SHRINK, STRETCH, fetch_ahead
from alight.accel.rays import MOST, RECIPROCAL
from alight.accel.stack import ROOM
from alight.core.vec import Vec3
from lanewise.jit import kernel
from lanewise.simd import (
    LANES,
    as_int,
    as_uint,
    count_bits,
    float_bits,
    lanes,
    load_lanes,
    local_floats,
    local_longs,
    mask_bits,
    maximum,
    minimum,
    store_lanes,
    trailing_zeros,
    where,
)
from lanewise.wide import load_wide

#: So many sixteenths of the lanes, or fewer, go alone: a test for all takes as long as theirs
#: (decision 11).
FEW = 12

#: Subtrees that may wait for a ray alone; beyond that, all continue together.
WAITING = 32

#: Room for the stack of a ray alone: what waits, then what it puts on it itself.
OWN = WAITING + ROOM

#: A *place* is a child that some rays have met: CHILDREN on each level, at most MAX_DEPTH levels
#: and the root's own.
_PLACES = CHILDREN * (MAX_DEPTH + 2)
_ENTRIES = MOST * _PLACES


@kernel(strict=True)
def meet_box(nodes, k, o, r, t):
    """One box, whose first bound is nodes[k], and all rays: (entry, met before t).

    As `node_test.meet_boxes`, but the lanes differ in which bound comes first.
    """
    # This way round the bound is an operand from memory.
    x0, x1 = (o.x - nodes[k]) * -r.x, (o.x - nodes[k + UPPER]) * -r.x
    y0, y1 = (o.y - nodes[k + CHILDREN]) * -r.y, (o.y - nodes[k + CHILDREN + UPPER]) * -r.y
    z0, z1 = (o.z - nodes[k + 2 * CHILDREN]) * -r.z, (o.z - nodes[k + 2 * CHILDREN + UPPER]) * -r.z
    enter = maximum(maximum(minimum(x0, x1), minimum(y0, y1)), maximum(minimum(z0, z1), 0.0))
    leave = minimum(minimum(maximum(x0, x1), maximum(y0, y1)), minimum(maximum(z0, z1), t))
    return enter, enter <= leave * STRETCH


def write_meet_children(nearest_first: bool) -> Callable:
    """``(nodes, at, o, r, t, bits, place, entries, masks)``: the children that are met (bits)."""

    @kernel(strict=True)
    def meet_children(nodes, at, o, r, t, bits, place, entries, masks):
        """The rays in `bits` and all children of a node: which children are met by any.

        Written for child i: ``masks[place + i]``, the rays that meet it, and, if order matters,
        ``entries[MOST * (place + i)]`` and following, where each ray enters it.
        """
        met_by_any = 0
        there = float_bits(load_wide(CHILDREN, nodes, at + CHILD)) != 0
        for child in range(count_bits(mask_bits(there))):
            enter, met = meet_box(nodes, at + child, o, r, t)
            if nearest_first:
                store_lanes(entries, MOST * (place + child), enter)
            inside = mask_bits(met) & bits
            masks[place + child] = inside
            met_by_any |= where(inside != 0, 1, 0) << child
        return met_by_any

    return meet_children


def write_push_places(nearest_first: bool) -> Callable:
    """``(tree, at, place, children, entries, masks, codes, keys, size)``: the stack's new size."""

    @kernel(strict=True)
    def push_places(tree, at, place, children, entries, masks, codes, keys, size):
        """Put the children in the bits `children` on the stack, nearest on top.

        The first ray that hits a child determines its distance.
        """
        base = size
        while children != 0:
            child = trailing_zeros(children)
            children &= children - 1
            k = place + child
            codes[k] = as_int(float_bits(tree.nodes[at + CHILD + child]))
            fetch_ahead(tree, codes[k])
            key, j = k, size
            if nearest_first:
                first = entries[MOST * k + trailing_zeros(masks[k])]
                key = (as_int(float_bits(first)) << 32) | k
                while j > base:
                    if keys[j - 1] >= key:
                        break
                    keys[j] = keys[j - 1]
                    j -= 1
            keys[j] = key
            size += 1
        return size

    return push_places


def write_together(visit_all: Callable, nearest_first: bool) -> Callable:
    """The first part of a packet's traversal; `visit_all` is from `leaf_test.write_visit_all`."""
    push_places = write_push_places(nearest_first)
    meet_children = write_meet_children(nearest_first)

    @kernel(strict=True)
    def together(tree, data, o, rays, bits, hits, stacks, bases, visits):
        """Go down together, and leave to the rays alone what few of them enter.

        Parameters
        ----------
        tree, data, o, rays, bits, hits
            As of `interleaved.write_packet`.
        stacks : Stacks
        bases : local uints
            Subtrees for ray i, at most `WAITING`, are put in front of number bases[i] of the
            stacks, the nearest first, so that it is on top; bases[i] becomes the lowest used.
        visits : Visits
            Room for them.
        """
        keys, masks, codes = local_longs(STACK), local_longs(_PLACES), local_longs(_PLACES)
        entries = local_floats(_ENTRIES)
        r = Vec3(
            load_lanes(rays.numbers, RECIPROCAL),
            load_lanes(rays.numbers, RECIPROCAL + MOST),
            load_lanes(rays.numbers, RECIPROCAL + 2 * MOST),
        )
        t = load_lanes(hits.t, 0)
        size, waiting, place, code = 0, 0, 0, 0
        few = FEW * LANES // 16
        store_lanes(entries, 0, lanes(0.0))
        while bits != 0:
            base = size
            if (count_bits(bits) <= few) & (waiting < WAITING):
                waiting += 1
                while bits != 0:
                    i = trailing_zeros(bits)
                    bits &= bits - 1
                    at = as_int(bases[i]) - 1
                    bases[i] = as_uint(at)
                    stacks.codes[at] = as_uint(code)
                    if nearest_first:
                        stacks.entries[at] = entries[MOST * place + i]
            elif code >= LEAF:
                first = (code & (LEAF - 1)) >> 4
                for block in range(first, first + (code & 15)):
                    left, count = bits, 0
                    while left != 0:
                        visits.rays[count] = trailing_zeros(left)
                        visits.places[count] = BLOCK * block
                        left &= left - 1
                        count += 1
                    visit_all(tree, data, rays, hits, visits, count)
                t = load_lanes(hits.t, 0)
            else:
                at = NODE * code
                place = CHILDREN * (place // CHILDREN + 1)
                met = meet_children(tree.nodes, at, o, r, t, bits, place, entries, masks)
                size = push_places(tree, at, place, met, entries, masks, codes, keys, size)
            bits = 0
            while (size > 0) & (bits == 0):
                size -= 1
                place = keys[size] & 0xFFFFFFFF
                # Children of a node that was opened just now are near enough.
                bits = masks[place]
                if size < base:
                    if nearest_first:
                        bits &= mask_bits(load_lanes(entries, MOST * place) * SHRINK <= t)
                    else:
                        bits &= mask_bits(t > 0.0)
            code = codes[place]

    return together
