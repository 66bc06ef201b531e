"""Light tree: chooses a light for a point by the positions and orientations of the lights.

A tree over all lights that have a place; each triangle of a shining mesh is one of them. The root
has up to four children, which all lanes look at together, others two. From the root a path goes
down at random, to each child in proportion to a guess at the light that it sends to the point
(`alight.lights.tree.bounds`).

A path that hits a lamp is weighted against light sampling by a density without the normal: paths
do not keep the normals of the vertices that they come from. Both sides of multiple importance
sampling use that density (`Choice.mis_pmf`), so the weights sum to one; light sampling divides by
its true probability.

Once the sphere of a group is small from where it is seen, and its lights face much the same way,
they only differ by their intensity, and that alone decides: a leaf is found by bisection in a table
of sums, as the table of powers is. The same holds for groups of which the scene's surfaces see
little but their intensity (`alight.compiled.light_gain`), however near they are. Where either
holds for all lights together, no node is looked at.

Lights without a place (environments, directional ones) are chosen outside the tree, by their power.

Source: Conty Estevez and Kulla, Importance sampling of many lights with adaptive tree splitting,
Proc. ACM Comput. Graph. Interact. Tech. 1(2), 2018 (without the splitting); PBR4 section 12.6.3.
"""

from __future__ import annotations

from collections import namedtuple

from alight.core.constants import ONE_MINUS_EPSILON
from alight.core.distributions import UNIT, sample_discrete
from alight.core.registry import specs_of
from alight.core.rng import unit_float
from alight.core.spec import Bsdf
from alight.core.vec import dot, row_vec3
from alight.lights.tables import INFO
from alight.lights.tree.bounds import ROW, WORDS, bounds_at, bounds_of_row, group_importance
from alight.shapes.hit import BENT
from lanewise.jit import kernel, specialised
from lanewise.simd import (
    any_lane,
    as_int,
    float_bits,
    fma,
    gather,
    lanes,
    lanes_mask,
    lanes_u32,
    maximum,
    minimum,
    minimum_u32,
    to_float,
    to_uint,
    where,
)

#: `LightTables.cdf` of a program with a tree starts with: probability of the lights outside the
#: tree; how many rows of `LightTables.info` there are; start of the root's children, which the
#: binary nodes follow; start of the leaves (bits); middle of all lights, and the squared distance
#: from which only intensity counts; then the distribution of the lights outside the tree. After the
#: tree follow the leaves, group by group: sums of their intensities (bits; one more than there are
#: leaves), row and triangle of each (bits); finally, light by light and triangle by triangle, way
#: and number of the leaf (bits).
OUTER, ROWS, START, LEAVES, MIDDLE, FAR_FROM_ALL, OUTER_CDF = 0, 1, 2, 3, 4, 7, 8

#: What the intensities add up to: each leaf has at least 1. Not NaN as bits.
WHOLE = 1 << 30

#: Words of a child: those of `alight.lights.tree.bounds`, where to continue, and the triangle of a
#: light. Two children are a node, with the numbers of its first leaf and the one behind its last.
CHILD, FIRST_LEAF, NODE = WORDS + 2, 2 * WORDS + 4, 2 * WORDS + 6
NEXT, PRIM = WORDS, WORDS + 1

#: Children of the root, and numbers of each: those of `alight.lights.tree.bounds.unpack`, then as
#: bits where to continue and the triangle.
TOP, TOP_ROW = 4, ROW + 2
TOP_NEXT, TOP_PRIM = ROW, ROW + 1

#: In NEXT: the rest of the word is the row of a light, not the offset of a node.
LEAF = 0x80000000

#: A way: the root's child (the lowest bits), then for each node whether it continues to the second
#: one. The deepest way fits a float32 that is not NaN.
TOP_BITS, MOST_LEVELS = 2, 28

#: Smallest cosine at the lit point that counts where light from behind may matter.
BEHIND = 0.1

#: index: row of a light; pmf: the probability that it had; mis_pmf: that for MIS, without the
#: normal; rest: number of its triangle (exact; 0 for others than meshes).
Choice = namedtuple("Choice", "index pmf mis_pmf rest")

#: After choices that are less probable u has few digits left.
SPENT = 2.0**-10


@kernel
def divide(u, share):
    """Choose the first of two with probability `share`: (is it, its probability, rest of u)."""
    first = u < share
    mine = where(first, share, 1.0 - share)
    rest = where(first, u, u - share) / where(mine > 0.0, mine, 1.0)
    return first, mine, minimum(maximum(rest, 0.0), ONE_MINUS_EPSILON)


@kernel
def more_digits(u, extra, pmf):
    """What is left of u after choices of probability `pmf`, with digits below its last."""
    return minimum(u + extra * (UNIT / maximum(pmf, UNIT)), ONE_MINUS_EPSILON)


def least_cosine(program) -> float:
    """`BEHIND` where a material of the program may scatter light from there, else 0.

    It may where models say so, and where normals are bent.
    """
    models = specs_of(Bsdf)
    one_sided = all(models[name].one_sided for name in program.bsdfs if name in models)
    return 0.0 if one_sided and BENT not in program.bsdfs else BEHIND


@kernel
def bits(cdf, k):
    """Words of the table."""
    return float_bits(gather(cdf, lanes_u32(0) + k))


@kernel
def is_far(cdf, p):
    """Where all lights together are so far that only intensity counts."""
    d = p - row_vec3(cdf, MIDDLE)
    return dot(d, d) > cdf[FAR_FROM_ALL]


@kernel
def first_node(cdf):
    """Offset of the binary node of all leaves."""
    return as_int(cdf[START]) + TOP * TOP_ROW


@kernel
def leaf_by_intensity(cdf, k, u, extra, pmf):
    """A leaf of the group at the node k: (its number, its probability in the group).

    `extra` holds the digits of u below those that are left after choices of probability `pmf`.
    """
    leaves = bits(cdf, LEAVES)
    low, high = bits(cdf, k + FIRST_LEAF), bits(cdf, k + (FIRST_LEAF + 1))
    start, end = bits(cdf, leaves + low), bits(cdf, leaves + high)
    # The digits of u stop before those of the sums.
    size = to_float(end - start)
    at = start + to_uint(u * size) + to_uint(extra * (UNIT / maximum(pmf, UNIT) * size))
    at = minimum_u32(at, end - 1)
    while any_lane(low + 1 < high):
        middle = (low + high) >> 1
        below = bits(cdf, leaves + middle) <= at
        low, high = where(below, middle, low), where(below, high, middle)
    mine = bits(cdf, leaves + low + 1) - bits(cdf, leaves + low)
    return low, to_float(mine) / size


@kernel
def leaf_words(cdf, leaf):
    """(row of the light, its triangle) of a leaf."""
    leaves = bits(cdf, LEAVES)
    # The last of the sums is the number of the leaves' end: all of the root's node.
    count = bits(cdf, first_node(cdf) + (FIRST_LEAF + 1))
    rows = leaves + count + 1
    return bits(cdf, rows + leaf), bits(cdf, rows + count + leaf)


@specialised
def choose_leaf(program):
    """Go down the tree: ``choose_leaf(scene, p, n, u, extra, active) -> Choice``.

    `extra`, in units of 2^-24, carries on the digits of u; pmf is 0 where no light can shine.
    """
    behind = least_cosine(program)

    @kernel
    def from_the_root(scene, p, n, u, extra, active):
        cdf = scene.lights.cdf
        everywhere = dot(n, n) < 0.5
        k, onward, prim = lanes_u32(first_node(cdf)), lanes_u32(LEAF), lanes_u32(0)
        pmf, mis_pmf = lanes(1.0), lanes(1.0)
        coasting = active & is_far(cdf, p)
        walking = active & ~coasting
        if any_lane(walking):
            total, mis_total, apart = lanes(0.0), lanes(0.0), lanes_mask(False)
            top, i = as_int(cdf[START]), 0
            while i < TOP:
                a = group_importance(bounds_of_row(cdf, top), p, n, everywhere, behind)
                before = total
                total, mis_total = total + a.importance, mis_total + a.unoriented
                # The next one takes the place of those before with its share of the sum, where u is
                # small: there nothing is rounded of what is left of u by improbable choices.
                beyond = fma(u, total, -a.importance)
                taken = beyond < 0.0
                share = where(taken, a.importance, before)
                rest = where(taken, u * total, beyond) / maximum(share, 1e-30)
                rest = minimum(maximum(rest, 0.0), ONE_MINUS_EPSILON)
                u = where(walking & (share > 0.0), rest, u)
                pmf = where(taken, a.importance, pmf)
                mis_pmf = where(taken, a.unoriented, mis_pmf)
                onward = where(taken, float_bits(lanes(cdf[top + TOP_NEXT])), onward)
                prim = where(taken, float_bits(lanes(cdf[top + TOP_PRIM])), prim)
                apart = where(taken, a.apart, apart)
                top += TOP_ROW
                i += 1
            alive = total > 0.0
            pmf = where(walking, where(alive, pmf / where(alive, total, 1.0), 0.0), 1.0)
            mis_pmf = where(walking, mis_pmf / where(alive, mis_total, 1.0), 1.0)
            walking = walking & alive & (onward < LEAF)
            k = where(walking, onward, k)
            coasting = coasting | (walking & apart)
            walking = walking & ~apart
        while any_lane(walking):
            spent = walking & (pmf < SPENT)
            if any_lane(spent):
                # Of no more use in lanes where it is 0 already.
                u = where(spent, more_digits(u, extra, pmf), u)
                extra = where(spent, 0.0, extra)
            a = group_importance(bounds_at(cdf, k), p, n, everywhere, behind)
            b = group_importance(bounds_at(cdf, k + CHILD), p, n, everywhere, behind)
            total, mis_total = a.importance + b.importance, a.unoriented + b.unoriented
            alive = total > 0.0
            share = where(alive, a.importance / where(alive, total, 1.0), 0.0)
            first, mine, rest = divide(u, share)
            u = where(walking, rest, u)
            pmf = where(walking, where(alive, pmf * mine, 0.0), pmf)
            weight = where(first, a.unoriented, b.unoriented) / where(alive, mis_total, 1.0)
            mis_pmf = where(walking, mis_pmf * weight, mis_pmf)
            chosen = where(first, k, k + CHILD)
            onward = where(walking, float_bits(gather(cdf, chosen + NEXT)), onward)
            prim = where(walking, float_bits(gather(cdf, chosen + PRIM)), prim)
            walking = walking & alive & (onward < LEAF)
            k = where(walking, onward, k)
            apart = walking & where(first, a.apart, b.apart)
            coasting = coasting | apart
            walking = walking & ~apart
        ended = active & ~coasting & (pmf > 0.0) & (onward >= LEAF)
        index, prim = where(ended, onward & (LEAF - 1), 0), where(ended, prim, 0)
        if any_lane(coasting):
            group = where(coasting, k, first_node(cdf))
            leaf, share = leaf_by_intensity(cdf, group, u, extra, pmf)
            pmf = where(coasting, pmf * share, pmf)
            mis_pmf = where(coasting, mis_pmf * share, mis_pmf)
            rows, prims = leaf_words(cdf, leaf)
            index, prim = where(coasting, rows, index), where(coasting, prims, prim)
        return Choice(index, where(ended | coasting, pmf, 0.0), mis_pmf, to_float(prim))

    return from_the_root


@kernel
def choose_by_tree(scene, p, n, u, u2, active):
    """A `Choice` among all lights; u2 is used for the digits that u lacks."""
    cdf = scene.lights.cdf
    outer = cdf[OUTER]
    hashed = (float_bits(u2[0]) * 0x9E3779B1) ^ (float_bits(u2[1]) * 0x85EBCA77)
    extra = unit_float((hashed ^ (hashed >> 15)) * 0x2C1B3C6D)
    aside = active & (u < outer)
    index, pmf, mis_pmf, rest = lanes_u32(0), lanes(0.0), lanes(0.0), lanes(0.0)
    if any_lane(aside):
        scaled = minimum(u / maximum(outer, UNIT), ONE_MINUS_EPSILON)
        found, share, left = sample_discrete(cdf, OUTER_CDF, as_int(cdf[ROWS]), scaled)
        index, rest = where(aside, found, index), where(aside, left, rest)
        pmf = where(aside, share * outer, pmf)
        mis_pmf = pmf
    local = active & ~aside
    if any_lane(local):
        inner = 1.0 - outer
        scaled = maximum(u - outer, 0.0) / maximum(inner, UNIT)
        # The digits that u lacks begin where those of the tree's part of it end.
        extra = extra / maximum(inner, UNIT)
        leaf = choose_leaf(scene, p, n, minimum(scaled, ONE_MINUS_EPSILON), extra, local)
        index = where(local, leaf.index, index)
        pmf = where(local, leaf.pmf * inner, pmf)
        mis_pmf = where(local, leaf.mis_pmf * inner, mis_pmf)
        rest = where(local, leaf.rest, rest)
    return Choice(index, pmf, mis_pmf, rest)


@kernel
def mis_probability(scene, index, prim, p, active):
    """`Choice.mis_pmf` of a light that was found otherwise: a triangle of it, seen from p."""
    cdf = scene.lights.cdf
    entry = where(active, gather(scene.lights.info, index * INFO + 3) + 2 * prim, 0)
    way, leaf = bits(cdf, entry), where(active, bits(cdf, entry + 1), 0)
    k, onward, mis_pmf = lanes_u32(first_node(cdf)), lanes_u32(LEAF), lanes(1.0)
    none, everywhere = p * 0.0, lanes_mask(True)
    coasting = active & is_far(cdf, p)
    walking = active & ~coasting
    if any_lane(walking):
        total, apart = lanes(0.0), lanes_mask(False)
        top, i = as_int(cdf[START]), lanes_u32(0)
        while top < first_node(cdf):
            a = group_importance(bounds_of_row(cdf, top), p, none, everywhere, 0.0)
            total, mine = total + a.unoriented, (way & (TOP - 1)) == i
            mis_pmf = where(walking & mine, a.unoriented, mis_pmf)
            apart = where(mine, a.apart, apart)
            onward = where(mine, float_bits(lanes(cdf[top + TOP_NEXT])), onward)
            top += TOP_ROW
            i += 1
        mis_pmf = where(walking, mis_pmf / where(total > 0.0, total, 1.0), mis_pmf)
        way = way >> TOP_BITS
        walking = walking & (onward < LEAF) & (mis_pmf > 0.0)
        k = where(walking, onward, k)
        coasting = coasting | (walking & apart)
        walking = walking & ~apart
    while any_lane(walking):
        a = group_importance(bounds_at(cdf, k), p, none, everywhere, 0.0)
        b = group_importance(bounds_at(cdf, k + CHILD), p, none, everywhere, 0.0)
        second = (way & 1) != 0
        total = a.unoriented + b.unoriented
        share = where(second, b.unoriented, a.unoriented) / where(total > 0.0, total, 1.0)
        mis_pmf = where(walking, mis_pmf * share, mis_pmf)
        way = where(walking, way >> 1, way)
        chosen = where(second, k + CHILD, k)
        onward = float_bits(gather(cdf, chosen + NEXT))
        walking = walking & (onward < LEAF) & (mis_pmf > 0.0)
        apart = walking & where(second, b.apart, a.apart)
        k = where(walking, onward, k)
        coasting = coasting | apart
        walking = walking & ~apart
    if any_lane(coasting):
        leaves, group = bits(cdf, LEAVES), k + FIRST_LEAF
        size = bits(cdf, leaves + bits(cdf, group + 1)) - bits(cdf, leaves + bits(cdf, group))
        mine = bits(cdf, leaves + leaf + 1) - bits(cdf, leaves + leaf)
        mis_pmf = where(coasting, mis_pmf * (to_float(mine) / to_float(size)), mis_pmf)
    return mis_pmf * (1.0 - cdf[OUTER])
