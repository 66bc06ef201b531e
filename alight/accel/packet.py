"""Packet traversal: the rays of a packet descend the bounding volume hierarchy while they agree.

Rays of neighbouring samples, and from one point to one light, visit the same nodes. One box against
all of them is one test, and the overhead of a step, mostly the misprediction of the next child, is
paid once. So a packet opens a node as a whole while enough of its rays are in it (`FEW`); a subtree
that only few enter waits until they reach it alone (`interleaved`). The choice is made at every
node, so nothing depends on a guess about the scene.

The companions of a ray change the order of its visits, but not its hit: the nearest one, the lowest
among equals, is the same in any order, as no box is culled wrongly (`node_test`).
"""

from __future__ import annotations

from collections import namedtuple

from alight.accel.layout import BLOCK, CHILD, CHILDREN, LEAF, MAX_DEPTH, NODE, STACK
from alight.accel.leaf_test import new_leaf_tests, run_leaf_tests
from alight.accel.node_test import SHRINK, meet_box
from alight.accel.rays import (
    MOST,
    RECIPROCAL,
    BoxRays,
    new_hits,
    new_rays,
    write_no_hits,
    write_rays,
)
from alight.accel.stack import ROOM, Stacks, fetch_ahead
from alight.core.vec import Vec3
from lanewise.jit import kernel
from lanewise.simd import (
    LANES,
    as_int,
    as_uint,
    count_bits,
    float_bits,
    lane_floats,
    lane_index,
    lane_uints,
    lanes,
    load_lanes,
    local_floats,
    local_longs,
    local_uints,
    mask_bits,
    store_lanes,
    trailing_zeros,
    where,
)
from lanewise.wide import load_wide

#: If at most this many sixteenths of the lanes enter a subtree, each goes on alone: a test for all
#: takes as long as theirs (decision 11).
FEW = 12

#: Subtrees that may wait for a ray alone; beyond that, all continue together.
WAITING = 32

#: Room for the stack of a ray alone: what waits, then what it puts on it itself.
OWN = WAITING + ROOM

#: A packet in memory: `Rays`, `Hits`, the `Stacks` of its rays; bases: local uints, what waits for
#: ray i lies from number bases[i] of the stacks on, up to number OWN * i + WAITING; behind it there
#: is room for a stack; tests: `LeafTests`.
Packet = namedtuple("Packet", "rays hits stacks bases tests")

#: The packet's own stack. keys: local longs, entry (bits) and place of what waits; by place, codes
#: of children (local longs), masks: the rays that meet them (local longs), and entries, where each
#: ray does (rows of MOST local floats). A *place* is a child that some rays have met: CHILDREN on
#: each level, at most MAX_DEPTH levels and the root's own.
PacketStack = namedtuple("PacketStack", "keys codes masks entries")
_PLACES = CHILDREN * (MAX_DEPTH + 2)
_ENTRIES = MOST * _PLACES


@kernel(strict=True)
def new_packet():
    """Room for a packet; `write_packet` fills it (see `lanewise.simd.local_floats`)."""
    stacks = Stacks(lane_uints(OWN), lane_floats(OWN), local_floats(CHILDREN))
    return Packet(new_rays(), new_hits(), stacks, local_uints(MOST), new_leaf_tests())


@kernel(strict=True)
def write_packet(packet, o, d, t_max):
    """The rays of a packet that have found nothing yet, up to t_max in each lane."""
    write_rays(packet.rays, o, d)
    write_no_hits(packet.hits, t_max)
    store_lanes(packet.bases, 0, OWN * lane_index() + WAITING)


@kernel(strict=True)
def meet_node(search, at, rays, bits, place, stack):
    """The rays in `bits` and all children of a node: which children are met by any.

    Written for child i at ``place + i``: the rays that meet it and, if order matters, their
    entries.
    """
    nodes, met_by_any = search.tree.nodes, 0
    there = float_bits(load_wide(CHILDREN, nodes, at + CHILD)) != 0
    for child in range(count_bits(mask_bits(there))):
        enter, met = meet_box(nodes, at + child, CHILDREN, rays)
        if search.nearest:
            store_lanes(stack.entries, MOST * (place + child), enter)
        inside = mask_bits(met) & bits
        stack.masks[place + child] = inside
        met_by_any |= where(inside != 0, 1, 0) << child
    return met_by_any


@kernel(strict=True)
def push_children(search, at, place, children, stack, size):
    """Put the children in the bits `children` on the packet's stack, the nearest on top.

    The first ray that meets a child determines its distance. Returns the new size.
    """
    tree, base, keys = search.tree, size, stack.keys
    while children != 0:
        child = trailing_zeros(children)
        children &= children - 1
        k = place + child
        stack.codes[k] = as_int(float_bits(tree.nodes[at + CHILD + child]))
        fetch_ahead(tree, stack.codes[k])
        key, j = k, size
        if search.nearest:
            first = stack.entries[MOST * k + trailing_zeros(stack.masks[k])]
            key = (as_int(float_bits(first)) << 32) | k
            while j > base:
                if keys[j - 1] >= key:
                    break
                keys[j] = keys[j - 1]
                j -= 1
        keys[j] = key
        size += 1
    return size


@kernel(strict=True)
def leave_to_single_rays(code, bits, entries, k, packet, nearest):
    """Put a subtree in front of what waits for the rays in `bits`; they enter it at entries[k]."""
    stacks, bases = packet.stacks, packet.bases
    while bits != 0:
        i = trailing_zeros(bits)
        bits &= bits - 1
        at = as_int(bases[i]) - 1
        bases[i] = as_uint(at)
        stacks.codes[at] = as_uint(code)
        if nearest:
            stacks.entries[at] = entries[k + i]


@kernel(strict=True)
def meet_leaf(search, code, bits, packet, others):
    """The leaf tests of the rays in `bits`, one block of the leaf after the other."""
    first = (code & (LEAF - 1)) >> 4
    for block in range(first, first + (code & 15)):
        left, count = bits, 0
        while left != 0:
            packet.tests.rays[count] = trailing_zeros(left)
            packet.tests.places[count] = BLOCK * block
            left &= left - 1
            count += 1
        run_leaf_tests(search, packet, count, others)


@kernel(strict=True)
def trace_packet(search, o, packet, bits, others):
    """Descend together, and leave to single rays what few of the packet enter.

    Parameters
    ----------
    search : Search
    o : Vec3
        Origins, metres.
    packet : Packet
        Subtrees for ray i, at most `WAITING`, are put in front of what waits for it, so that the
        nearest is on top.
    bits : int
        The lanes that are wanted; their rays are finite and have a direction.
    others
        As of `leaf_test.run_leaf_tests`.
    """
    nearest, hits, rays = search.nearest, packet.hits, packet.rays.numbers
    stack = PacketStack(
        local_longs(STACK), local_longs(_PLACES), local_longs(_PLACES), local_floats(_ENTRIES)
    )
    keys, masks, entries = stack.keys, stack.masks, stack.entries
    r = Vec3(
        load_lanes(rays, RECIPROCAL),
        load_lanes(rays, RECIPROCAL + MOST),
        load_lanes(rays, RECIPROCAL + 2 * MOST),
    )
    t = load_lanes(hits.t, 0)
    size, waiting, place, code = 0, 0, 0, 0
    # A lone ray is no packet: what is for several of them goes with the text that is never reached.
    few = max(FEW * LANES // 16, 1)
    store_lanes(entries, 0, lanes(0.0))
    while bits != 0:
        base = size
        if (count_bits(bits) <= few) & (waiting < WAITING):
            waiting += 1
            leave_to_single_rays(code, bits, entries, MOST * place, packet, nearest)
        elif code >= LEAF:
            meet_leaf(search, code, bits, packet, others)
            t = load_lanes(hits.t, 0)
        else:
            at = NODE * code
            place = CHILDREN * (place // CHILDREN + 1)
            met = meet_node(search, at, BoxRays(o, r, t), bits, place, stack)
            size = push_children(search, at, place, met, stack, size)
        bits = 0
        while (size > 0) & (bits == 0):
            size -= 1
            place = keys[size] & 0xFFFFFFFF
            # Children of a node that was opened just now are near enough.
            bits = masks[place]
            if size < base:
                if nearest:
                    bits &= mask_bits(load_lanes(entries, MOST * place) * SHRINK <= t)
                else:
                    bits &= mask_bits(t > 0.0)
        code = stack.codes[place]
