"""The tables of `alight.bsdfs.microfacets.albedo_rows` in kernels.

Numbers of the base are read between rows along one axis or three, those of a coat, whose facets are
the same in all directions, along one.
"""

from __future__ import annotations

from collections import namedtuple

from alight.bsdfs.microfacets.albedo_rows import (
    ANISOTROPY_BIT,
    AZIMUTH_BIT,
    REFLECTED,
    ROW,
    STEPS,
    WHITE,
)
from alight.bsdfs.microfacets.facets import ANISOTROPIC
from alight.bsdfs.rows import (
    MANY_ROWS,
    Rows,
    Table,
    load_table,
    read_row,
    read_two,
    rows_at,
    rows_between,
)
from alight.core.vec import lerp
from lanewise.jit import kernel, specialised
from lanewise.simd import absolute, gather, lanes_u32, maximum, minimum, sqrt, to_float, to_uint

#: Rows along three axes: where they start, and the number of the last one along each (floats).
Grid = namedtuple("Grid", "curves start last anisotropy azimuth")
#: A place between eight rows: the two along the roughness, and how to get on along both other axes.
Corners = namedtuple("Corners", "along strength azimuth")
#: Distance of the next row along an axis, and the part of it.
Step = namedtuple("Step", "step part")
#: A cosine's place in a row: number of the point before it, and the part of the next one.
Place = namedtuple("Place", "index part")


# ---------------------------------------------------------------- rows


@specialised
def load_rows(program):
    """``(scene, slot, surface) -> Table or Grid``: slots hold the start and `Grid.axes`."""
    return _load_grid if ANISOTROPIC in program.bsdfs else load_table


@kernel
def _load_grid(scene, slot, surface):
    data = scene.materials.data
    axes = to_uint(gather(data, slot + 1))
    last = axes & ((1 << ANISOTROPY_BIT) - 1)
    anisotropy = (axes >> ANISOTROPY_BIT) & ((1 << (AZIMUTH_BIT - ANISOTROPY_BIT)) - 1)
    start = to_uint(gather(data, slot))
    azimuth = to_float(axes >> AZIMUTH_BIT)
    return Grid(scene.materials.curves, start, to_float(last), to_float(anisotropy), azimuth)


@specialised
def facet_rows_at(program):
    """``(table, facets, anisotropy, w) -> Rows or Corners`` of facets that are seen from w."""
    if ANISOTROPIC not in program.bsdfs:
        return _isotropic
    return _corners if MANY_ROWS in program.bsdfs else _turned


@kernel
def _isotropic(table, facets, anisotropy, w):
    return rows_at(table, sqrt(facets.alpha_x), ROW)


@kernel
def _place_of_azimuth(w):
    """Root of the cosine between w and the rougher direction, both seen from above."""
    squared = w.x * w.x + w.y * w.y
    return sqrt(absolute(w.x) / sqrt(maximum(squared, 1e-18)))


@kernel
def _turned(table, facets, anisotropy, w):
    rows = Table(table.curves, table.start, table.azimuth)
    return rows_between(rows, _place_of_azimuth(w), ROW)


@kernel
def _corners(table, facets, anisotropy, w):
    turns = (to_uint(table.azimuth) + 1) * ROW
    strengths = (to_uint(table.anisotropy) + 1) * turns
    a = Table(table.curves, table.start, table.last)
    a = rows_between(a, sqrt(facets.alpha_y), strengths)
    b = rows_between(Table(table.curves, a.row, table.anisotropy), anisotropy, turns)
    c = rows_between(Table(table.curves, b.row, table.azimuth), _place_of_azimuth(w), ROW)
    along = Rows(table.curves, c.row, a.step, a.part)
    return Corners(along, Step(b.step, b.part), Step(c.step, c.part))


# ---------------------------------------------------------------- numbers of a row


@specialised
def read_number(program):
    """``(rows, i) -> number i`` of facets."""
    if ANISOTROPIC not in program.bsdfs:
        return read_row
    return _read_eight if MANY_ROWS in program.bsdfs else read_two


@kernel
def _read_eight(rows, i):
    return lerp(rows.azimuth.part, _read_four(rows, i), _read_four(rows, i + rows.azimuth.step))


@kernel
def _read_four(rows, i):
    a, b = read_two(rows.along, i), read_two(rows.along, i + rows.strength.step)
    return lerp(rows.strength.part, a, b)


@kernel
def place_of(cosine):
    """The `Place` of a cosine, in curves over its fourth root."""
    x = sqrt(sqrt(minimum(maximum(cosine, 0.0), 1.0))) * (STEPS - 1.0)
    i = to_uint(minimum(x, STEPS - 2.0))
    return Place(i, x - to_float(i))


@kernel
def read_curve(rows, curve, place):
    """Curve number `curve` of facets at a place."""
    i = place.index + curve * STEPS
    a, b = read_number(rows, i), read_number(rows, i + 1)
    return a + place.part * (b - a)


@kernel
def read_plain_curve(rows, curve, place):
    """Curve number `curve` of a coat at a place."""
    i = place.index + curve * STEPS
    a, b = read_row(rows, i), read_row(rows, i + 1)
    return a + place.part * (b - a)


@kernel
def read_bounced(rows, place):
    """(W, R) of facets from outside at a place."""
    white = read_curve(rows, lanes_u32(WHITE), place)
    return white, read_curve(rows, lanes_u32(REFLECTED), place)
