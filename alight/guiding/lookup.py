"""Asking a guide: the leaf of a place, directions from its density, and the density of one."""

from __future__ import annotations

from collections import namedtuple

from alight.core.constants import INV_FOUR_PI, ONE_MINUS_EPSILON
from alight.core.equal_area import sphere_to_square, square_to_sphere
from alight.guiding.parallax import focus_at, from_middle, from_point
from alight.guiding.tables import LEAF, NODE, PART_BITS, PARTS, QUADRANTS
from lanewise.jit import kernel
from lanewise.simd import (
    any_lane,
    gather,
    gather_row,
    lanes,
    lanes_mask,
    lanes_u32,
    maximum,
    minimum,
    to_float,
    where,
)
from lanewise.vec3 import Vec3

#: What a part is worth; all of them are one.
UNIT = 1.0 / (PARTS - 1)

#: Where a point is in a guide: number of its leaf, and `Focus` there.
Place = namedtuple("Place", "leaf focus")


@kernel
def place_at(guide, p):
    """Where the point p is."""
    leaf = leaf_at(guide, p)
    return Place(leaf, focus_at(guide, leaf, p))


@kernel
def within_box(guide, p):
    """Place of the point p within the guide's box, in [0, 1) along each axis if it is inside."""
    box = guide.box
    return Vec3((p.x - box[0]) * box[3], (p.y - box[1]) * box[4], (p.z - box[2]) * box[5])


@kernel
def leaf_at(guide, p):
    """Number of the leaf that holds the point p; outside the box, of one at its border."""
    space, place = guide.space, within_box(guide, p)
    x = minimum(maximum(place.x, 0.0), ONE_MINUS_EPSILON)
    y = minimum(maximum(place.y, 0.0), ONE_MINUS_EPSILON)
    z = minimum(maximum(place.z, 0.0), ONE_MINUS_EPSILON)
    word = gather(space, lanes_u32(0))
    inner = word < LEAF
    while any_lane(inner):
        upper = x >= 0.5
        child = gather(space, where(inner, word, 0) + where(upper, lanes_u32(1), lanes_u32(0)))
        word = where(inner, child, word)
        inner = word < LEAF
        # The next axis first; lanes at their leaves turn too, which no longer matters.
        x, y, z = y, z, where(upper, 2.0 * x - 1.0, 2.0 * x)
    return word & (LEAF - 1)


@kernel
def child_of(word, place):
    """The node that divides a quadrant further, or 0; word: the second one of its node."""
    divided = word & ((1 << QUADRANTS) - 1)
    before = divided & ((lanes_u32(1) << place) - 1)
    count = (before & 1) + ((before >> 1) & 1) + ((before >> 2) & 1)
    return where(((divided >> place) & 1) != 0, (word >> QUADRANTS) + count, 0)


@kernel
def quadrant(left, lower):
    """Number of a quadrant within its node."""
    return where(left, lanes_u32(0), lanes_u32(1)) + where(lower, lanes_u32(0), lanes_u32(2))


@kernel
def direction_density(guide, place, w, active):
    """Density of `draw_direction` per steradian, for unit directions w."""
    return draw_direction(guide, place, lanes_mask(False), (lanes(0.0), lanes(0.0)), w, active)[1]


@kernel
def draw_direction(guide, place, led, u2, w, active):
    """A direction where the guide leads, and its density there and for the directions elsewhere.

    Parameters
    ----------
    guide : Guide
    place : Place
    led : mask
        Lanes that draw a direction.
    u2 : tuple of 2 floats
        Uniform in [0, 1), used there.
    w : Vec3
        Unit directions of the other lanes.
    active : mask
        Lanes whose density is wanted.

    Returns
    -------
    w : Vec3
    density : float
        Per steradian.
    """
    leaf, focus = place
    seen, spread = from_middle(focus, w)
    x, y = sphere_to_square(seen)
    # Either numbers that choose, or the place within the square: both descend the same tree.
    u, v = where(led, u2[0], x), where(led, u2[1], y)
    a, b, size, density = lanes(0.0), lanes(0.0), lanes(1.0), lanes(INV_FOUR_PI)
    node, more = gather(guide.roots, leaf), active
    while any_lane(more):
        parts, word = gather_row(guide.nodes, node * NODE, NODE)
        row = to_float(parts & (PARTS - 1)) * UNIT
        half = where(led, row, 0.5)
        lower = v < half
        column = where(lower, parts >> PART_BITS, parts >> (2 * PART_BITS))
        column = to_float(column & (PARTS - 1)) * UNIT
        middle = where(led, column, 0.5)
        left = u < middle
        share = where(lower, row, 1.0 - row) * where(left, column, 1.0 - column)
        density = where(more, density * (4.0 * share), density)
        # What is left of the numbers is uniform again.
        v, u = rest_of(v, half, lower, more), rest_of(u, middle, left, more)
        size = where(more, 0.5 * size, size)
        a, b = where(more & ~left, a + size, a), where(more & ~lower, b + size, b)
        child = child_of(word, quadrant(left, lower))
        more = more & (child != 0)
        node = where(more, child, node)
    drawn, spread_drawn = from_point(focus, square_to_sphere(a + u * size, b + v * size))
    return where(led, drawn, w), density * where(led, spread_drawn, spread)


@kernel
def rest_of(u, share, first, more):
    """U after the choice of the `first` with the probability `share`; elsewhere as it was."""
    mine = where(first, share, 1.0 - share)
    rest = where(first, u, u - share) / where(mine > 0.0, mine, 1.0)
    return where(more, minimum(maximum(rest, 0.0), ONE_MINUS_EPSILON), u)
