"""How the light of a picture is shared by the techniques (s, t) of paths from both ends.

A pass of its own over the same samples as the picture's, as `alight.integrators.contributions`: the
bidirectional path tracer's own text, which also calls `tell` wherever it adds light. Programs
without this pass have not an instruction of it.

Paths of more than `DEEPEST` edges are one row together. A hole in a surface counts as a vertex
where a path goes through it, but not on the edge that joins two of them.

Source: Veach 1997, Robust Monte Carlo methods for light transport simulation, figure 10.2.
"""

from __future__ import annotations

from collections import namedtuple

from alight.integrators.contributions import RECORDED
from alight.integrators.model import INTEGRATORS
from lanewise.jit import kernel
from lanewise.simd import (
    LANES,
    as_int,
    is_finite,
    lanes_u32,
    local_floats,
    local_uints,
    mask_bits,
    store_lanes,
    to_uint,
    trailing_zeros,
    where,
)

#: Name of this pass instead of an integrator's.
PASS = "strategies"

#: Longest paths that are distinguished, in edges.
DEEPEST = 8

#: Rows of the log: the techniques s = 0 to k of all lengths k, then all longer paths.
LONGER = (DEEPEST * (DEEPEST + 3)) // 2
ROWS = LONGER + 1

#: sums: float64, (row, y, x, [weighted, unweighted], channel); window: i64, first column and row,
#: columns, rows.
StrategyLog = namedtuple("StrategyLog", "sums window")


def both_ends(program):
    """The kernels of the integrator that `RECORDED` names, which tell what each technique adds."""
    own = INTEGRATORS[program.option(RECORDED)].both_ends
    assert own is not None
    return own(program, tell)


def row_of(s: int, edges: int) -> int:
    """Row of a technique with s vertices of the light path."""
    return (edges - 1) * (edges + 2) // 2 + s if edges <= DEEPEST else LONGER


@kernel
def tell(scene, place, technique, mask, value, weight):
    """Add light that a technique has found.

    Parameters
    ----------
    scene : namedtuple
        With the field `log`.
    place : pair of floats
        x and y, pixels of the full film.
    technique : pair of uint32
        s, and the edges of the path.
    mask : mask
    value : Vec3
        What the picture gains, weighted.
    weight : float
        Its weight beside the other techniques.
    """
    log, rows, places, floats = scene.log, local_uints(16), local_uints(16), local_floats(64)
    s, edges = technique
    row = ((edges - 1) * (edges + 2) >> 1) + s
    store_lanes(rows, 0, where(edges > DEEPEST, lanes_u32(LONGER), row))
    x0, y0, columns, height = log.window[0], log.window[1], log.window[2], log.window[3]
    x, y = place[0] - x0, place[1] - y0
    lit = mask & (x >= 0.0) & (x < columns) & (y >= 0.0) & (y < height)
    lit = lit & is_finite(value.x) & is_finite(value.y) & is_finite(value.z)
    at = to_uint(where(lit, y, 0.0)) * to_uint(columns) + to_uint(where(lit, x, 0.0))
    store_lanes(places, 0, at)
    store_lanes(floats, 0, value.x)
    store_lanes(floats, LANES, value.y)
    store_lanes(floats, 2 * LANES, value.z)
    store_lanes(floats, 3 * LANES, where(weight > 0.0, 1.0 / weight, 0.0))
    size = as_int(columns) * as_int(height)
    bits = mask_bits(lit)
    while bits != 0:
        lane = trailing_zeros(bits)
        bits &= bits - 1
        first = (as_int(rows[lane]) * size + as_int(places[lane])) * 6
        for i in range(3):
            log.sums[first + i] += floats[i * LANES + lane]
            log.sums[first + 3 + i] += floats[i * LANES + lane] * floats[3 * LANES + lane]
