"""What training paths see: a record of each vertex where a direction was drawn from a density.

A vertex is written down when the path leaves it; how much light came from its direction is only
known at the path's end: the radiance gathered since, over the throughput. So the log keeps both,
and `add_records` puts them together. Sums are whole numbers: neither order nor threads change them.
"""

from __future__ import annotations

from collections import namedtuple

from alight.core.constants import INFINITY
from alight.core.equal_area import around_edges, sphere_to_square
from alight.core.vec import gather_vec3, luminance
from alight.guiding.lookup import child_of, leaf_at, quadrant, within_box
from alight.guiding.parallax import focus_at, from_middle
from alight.guiding.tables import NODE, RECORD
from lanewise.jit import kernel
from lanewise.simd import (
    LANES,
    any_lane,
    as_int,
    bits_float,
    float_bits,
    gather,
    gather_row,
    is_finite,
    lane_index,
    lanes,
    lanes_u32,
    local_floats,
    local_uints,
    mask_bits,
    minimum,
    rint,
    store_lanes,
    trailing_zeros,
    where,
)

#: A direction that was drawn at the point p: d, its density, that of the BSDF alone, and f cos over
#: the density (RGB).
Drawn = namedtuple("Drawn", "p d pdf of_bsdf weight")

#: Shares of the guide among which a leaf chooses, and of light paths in the guide.
SHARES, MIXES = (0.2, 0.4, 0.6, 0.8, 0.9), (0.0, 0.5, 1.0)

#: All pairs of these, no guide being the first.
CHOICES = ((0.0, 0.0), *((share, mix) for share in SHARES for mix in MIXES))

#: int64 each. cells, lit: four a node, second moments of the quadrants, and the flux that arrives
#: through them. leaves: of each leaf the number of its records, and the second moment that each of
#: `CHOICES` would have had. middles: sums of the records' places in the box, x, y and z. near: flux
#: that arrives times the guide's density there, and the same times the guide's size over the length
#: of its way.
Totals = namedtuple("Totals", "cells lit leaves middles near")
LEAF_SUMS = 1 + len(CHOICES)

#: Scratch memory for the widest packet.
ROOM_OF_RECORD, ROOM_OF_SUMS = 16 * RECORD, 16 * LEAF_SUMS

#: Quarters of the box of directions over which a record is spread; scratch memory for them.
CORNERS, ROOM_OF_CORNERS = 4, 64

#: A sum counts units of 2^-20 of the typical value; a value has at most 2^20 of these.
UNITS = 2.0**20
MOST = 2.0**40


@kernel
def sample_number(window, sampler):
    """The number of each lane's sample among those of the tile in this pass."""
    pixel = (sampler.y - window[1]) * window[2] + (sampler.x - window[0])
    sample = sampler.index * window[5] + sampler.scramble
    return pixel * window[4] + sample - window[3]


@kernel
def record_vertices(log, path, drawn, mask):
    """Append the vertices that paths leave, from the lanes of the mask.

    path: with the throughput and the radiance that it had when it arrived.
    """
    values = local_floats(ROOM_OF_RECORD)
    beta = path.beta * drawn.weight
    store_lanes(values, 0, drawn.p.x)
    store_lanes(values, LANES, drawn.p.y)
    store_lanes(values, 2 * LANES, drawn.p.z)
    store_lanes(values, 3 * LANES, drawn.d.x)
    store_lanes(values, 4 * LANES, drawn.d.y)
    store_lanes(values, 5 * LANES, drawn.d.z)
    store_lanes(values, 6 * LANES, drawn.pdf)
    store_lanes(values, 7 * LANES, drawn.of_bsdf)
    store_lanes(values, 8 * LANES, luminance(drawn.weight))
    store_lanes(values, 9 * LANES, luminance(beta))
    store_lanes(values, 10 * LANES, luminance(path.L))
    store_lanes(values, 11 * LANES, bits_float(sample_number(log.window, path.sampler)))
    append_rows(log, values, RECORD, mask)


@kernel
def append_rows(log, values, size, mask):
    """Append the lanes of the mask to a `Log` or `LightLog`, or count what has no room.

    values: `size` numbers, the packet's lanes of one after those of the other.
    """
    bits = mask_bits(mask)
    while bits != 0:
        lane = trailing_zeros(bits)
        bits &= bits - 1
        at = size * log.count[0]
        if at < log.rows.size:
            for place in range(size):
                log.rows[at + place] = values[place * LANES + lane]
            log.count[0] += 1
        else:
            log.count[1] += 1


@kernel
def record_ends(log, path, finished):
    """Keep what finished samples of training come to, with the guide and without."""
    values, numbers = local_floats(32), local_uints(16)
    store_lanes(values, 0, luminance(path.L))
    store_lanes(values, LANES, path.unguided.square)
    store_lanes(numbers, 0, sample_number(log.window, path.sampler))
    bits = mask_bits(finished)
    while bits != 0:
        lane = trailing_zeros(bits)
        bits &= bits - 1
        at = as_int(numbers[lane])
        log.ends[at] = values[lane]
        log.without[at] = values[LANES + lane]


@kernel
def add_records(guide, densities, log, totals, unit):
    """Add the vertices of a log, whose samples are all finished, to sums.

    Parameters
    ----------
    guide : Guide
        That the directions were drawn with.
    densities : float32
        Of each quadrant, four a node: per steradian, what camera paths and what light paths say.
    log : Log
    totals : Totals
    unit : float32
        Typical gain of a vertex.
    """
    values, cells = local_floats(ROOM_OF_SUMS), local_uints(ROOM_OF_CORNERS)
    leaves, places = local_uints(16), local_floats(48)
    count = as_int(log.count[0])
    for start in range(0, count, LANES):
        index = lane_index() + start
        active = index < count
        row = where(active, index, 0) * RECORD
        p = gather_vec3(log.rows, row)
        d = gather_vec3(log.rows, row + 3)
        pdf, of_bsdf = gather(log.rows, row + 6), gather(log.rows, row + 7)
        weight, beta = gather(log.rows, row + 8), gather(log.rows, row + 9)
        before = gather(log.rows, row + 10)
        end = gather(log.ends, float_bits(gather(log.rows, row + 11)))
        # What the vertex gained from the direction: f cos L_i / p.
        gained = weight * (end - before) / where(beta == 0.0, 1.0, beta)
        gained = where(active & is_finite(gained), gained, 0.0)
        leaf = leaf_at(guide, p)
        store_lanes(leaves, 0, leaf)
        d, spread = from_middle(focus_at(guide, leaf, p), d)
        x, y = sphere_to_square(d)
        cell, side = cell_of(guide, leaf, x, y, active)
        store_cells_around(guide, leaf, cells, x, y, side, active)
        by_camera, by_light = gather_row(densities, 2 * cell, 2)
        by_camera, by_light = by_camera * spread, by_light * spread
        place = within_box(guide, p)
        store_lanes(places, 0, in_units(place.x, 1.0))
        store_lanes(places, LANES, in_units(place.y, 1.0))
        store_lanes(places, 2 * LANES, in_units(place.z, 1.0))
        moment = gained * gained * pdf
        store_lanes(values, 0, quarter_of(in_units(moment, unit * unit)))
        for choice in range(len(CHOICES)):
            share, mix = CHOICES[choice]
            of_guide = by_camera + mix * (by_light - by_camera)
            other = of_bsdf + share * (of_guide - of_bsdf)
            ratio = moment / where(other > 0.0, other, INFINITY)
            store_lanes(values, (choice + 1) * LANES, in_units(ratio, unit * unit))
        bits = mask_bits(active)
        while bits != 0:
            lane = trailing_zeros(bits)
            bits &= bits - 1
            for corner in range(CORNERS):
                totals.cells[as_int(cells[corner * LANES + lane])] += as_int(values[lane])
            at = as_int(leaves[lane]) * LEAF_SUMS
            totals.leaves[at] += 1
            for sum in range(1, LEAF_SUMS):
                totals.leaves[at + sum] += as_int(values[sum * LANES + lane])
            for axis in range(3):
                totals.middles[3 * as_int(leaves[lane]) + axis] += as_int(
                    places[axis * LANES + lane]
                )


@kernel
def in_units(moment, unit):
    """A whole number of units; what is too large for them counts as the largest."""
    return rint(minimum(moment * (UNITS / unit), MOST))


@kernel
def quarter_of(number):
    """A whole number again."""
    return rint(0.25 * number)


@kernel
def store_cells_around(guide, leaf, cells, x, y, side, active):
    """The undivided quadrants around points of the unit square, `CORNERS` packets of lanes.

    They hold the middles of the four quarters of a box of the given side around the point. What a
    record brings is spread over this box: few bright records would make a ragged density, and
    would leave the next quadrant with nothing.

    Source: Müller, "Practical path guiding" in production, in Path guiding in production, SIGGRAPH
    2019 courses: the box filter over directions.
    """
    for corner in range(CORNERS):
        right, up = 0.5 * (corner % 2) - 0.25, 0.5 * (corner // 2) - 0.25
        u, v = around_edges(x + right * side, y + up * side)
        store_lanes(cells, corner * LANES, cell_of(guide, leaf, u, v, active)[0])


@kernel
def cell_at(guide, leaf, w, active):
    """Number of the undivided quadrant that holds the unit direction w, four a node."""
    x, y = sphere_to_square(w)
    return cell_of(guide, leaf, x, y, active)[0]


@kernel
def cell_of(guide, leaf, x, y, active):
    """`cell_at` of a point of the unit square, and the side of its quadrant."""
    side = lanes(0.5)
    node, cell, more = gather(guide.roots, leaf), lanes_u32(0), active
    while any_lane(more):
        left, lower = x < 0.5, y < 0.5
        place = quadrant(left, lower)
        cell = where(more, 4 * node + place, cell)
        child = child_of(gather(guide.nodes, node * NODE + 1), place)
        more = more & (child != 0)
        node, side = where(more, child, node), where(more, 0.5 * side, side)
        x, y = where(left, 2.0 * x, 2.0 * x - 1.0), where(lower, 2.0 * y, 2.0 * y - 1.0)
    return cell, side
