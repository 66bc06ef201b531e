"""What light paths of training see: a record of the flux that arrives at each vertex.

Camera paths learn only from light that they find. Light paths come from the lamps, through glass
and water too, and know where light is that no camera path would ever meet.
"""

from __future__ import annotations

from alight.core.equal_area import sphere_to_square
from alight.core.vec import gather_vec3, length, max_component, min_component
from alight.guiding.lookup import direction_density, place_at, within_box
from alight.guiding.parallax import from_middle
from alight.guiding.records import (
    CORNERS,
    ROOM_OF_CORNERS,
    append_rows,
    cell_of,
    in_units,
    quarter_of,
    store_cells_around,
)
from alight.guiding.tables import LIGHT_RECORD
from lanewise.jit import kernel
from lanewise.simd import (
    LANES,
    as_int,
    gather,
    is_finite,
    lane_index,
    local_floats,
    local_uints,
    mask_bits,
    minimum,
    store_lanes,
    trailing_zeros,
    where,
)

#: Scratch memory for the widest packet.
ROOM = 16 * LIGHT_RECORD

#: No way counts as shorter than the guide's size over this, and no direction for more than one of
#: this density, per steradian.
SHORTEST, DENSEST = 1000.0, 1000.0


@kernel
def record_arrivals(log, p, w, flux, near, mask):
    """Append the points p that light reaches from the unit direction w, in the lanes of the mask.

    flux, near: float, its luminance, and 1 / length of its way (`LIGHT_RECORD`).
    """
    values = local_floats(ROOM)
    store_lanes(values, 0, p.x)
    store_lanes(values, LANES, p.y)
    store_lanes(values, 2 * LANES, p.z)
    store_lanes(values, 3 * LANES, w.x)
    store_lanes(values, 4 * LANES, w.y)
    store_lanes(values, 5 * LANES, w.z)
    store_lanes(values, 6 * LANES, flux)
    store_lanes(values, 7 * LANES, near)
    append_rows(log, values, LIGHT_RECORD, mask)


@kernel
def add_arrivals(guide, log, totals, unit):
    """Add the flux of a log to `lit` and `near` of sums, where it arrives within the guide's box.

    How far light comes from matters where it comes from few directions, so in `near` a record
    counts by the density that the guide has for its own.

    Parameters
    ----------
    guide : Guide
        Of the rounds before.
    log : LightLog
    totals : Totals
    unit : float32
        Typical flux of a vertex.
    """
    values, leaves = local_floats(48), local_uints(16)
    cells = local_uints(ROOM_OF_CORNERS)
    count, box = as_int(log.count[0]), guide.box
    # Of the box's longest side.
    size = 1.0 / min(box[3], min(box[4], box[5]))
    for start in range(0, count, LANES):
        index = lane_index() + start
        active = index < count
        row = where(active, index, 0) * LIGHT_RECORD
        p, w = gather_vec3(log.rows, row), gather_vec3(log.rows, row + 3)
        flux, near = gather(log.rows, row + 6), gather(log.rows, row + 7)
        # What happens where no camera path has been is nobody's business.
        place = within_box(guide, p)
        inside = (min_component(place) >= 0.0) & (max_component(place) < 1.0)
        active = active & inside & is_finite(flux)
        flux = where(active, flux, 0.0)
        leaf, focus = found = place_at(guide, p)
        sharp = flux * minimum(direction_density(guide, found, w, active), DENSEST)
        near = minimum(near, SHORTEST / size)
        # The middle's way to where light comes from: the sphere's radius.
        moved = focus.r > 0.0
        near = where(moved, near / length(focus.o * near + w), near)
        w, _ = from_middle(focus, w)
        x, y = sphere_to_square(w)
        _, side = cell_of(guide, leaf, x, y, active)
        store_cells_around(guide, leaf, cells, x, y, side, active)
        store_lanes(leaves, 0, leaf)
        store_lanes(values, 0, in_units(sharp, unit))
        store_lanes(values, 2 * LANES, quarter_of(in_units(flux, unit)))
        store_lanes(values, LANES, in_units(sharp * minimum(size * near, SHORTEST), unit))
        bits = mask_bits(active)
        while bits != 0:
            lane = trailing_zeros(bits)
            bits &= bits - 1
            for corner in range(CORNERS):
                totals.lit[as_int(cells[corner * LANES + lane])] += as_int(values[2 * LANES + lane])
            at = 2 * as_int(leaves[lane])
            totals.near[at] += as_int(values[lane])
            totals.near[at + 1] += as_int(values[LANES + lane])
