"""Rows of numbers for each material, in `materials.curves`: how kernels look them up.

Where a roughness is the same everywhere one row serves; where it varies rows lie at equal steps
of a coordinate in [0, 1], and are interpolated linearly. Programs in which nothing varies do not
compile that.
"""

from __future__ import annotations

from collections import namedtuple

from alight.core.parameters import Slots
from lanewise.jit import kernel, specialised
from lanewise.simd import gather, lanes, lanes_u32, maximum, minimum, to_float, to_uint

#: What programs call it that a table has more than one row.
MANY_ROWS = "rows:many"

#: Rows of a table: where the first one starts, and the number of the last one (a float).
Table = namedtuple("Table", "curves start last")
#: One place between two rows: start of the first, distance to the second, part of that.
Rows = namedtuple("Rows", "curves row step part")


@kernel
def load_table(scene, slot, surface):
    """The `Table` whose start and last row are in two slots."""
    data = scene.materials.data
    return Table(scene.materials.curves, to_uint(gather(data, slot)), gather(data, slot + 1))


def rows_in_slots(name: str) -> Slots:
    """A field that is a `Table`: where it begins is in the slot `name`, then ``last_{name}``."""
    return Slots(load_table, {name: 1, f"last_{name}": 1})


@specialised
def rows_at(program):
    """``(table, root, size) -> Rows``.

    `root` is the coordinate in [0, 1] along which rows lie, `size` their length.
    """
    return rows_between if MANY_ROWS in program.bsdfs else _one_row


@kernel
def _one_row(table, root, size):
    return Rows(table.curves, table.start, lanes_u32(0), lanes(0.0))


@kernel
def rows_between(table, root, size):
    """The `Rows` around a coordinate in [0, 1]."""
    x = minimum(maximum(root, 0.0), 1.0) * table.last
    i = to_uint(minimum(x, maximum(table.last - 1.0, 0.0)))
    # A table of one row has no next one.
    step = to_uint(minimum(table.last, 1.0)) * size
    return Rows(table.curves, table.start + i * size, step, x - to_float(i))


@specialised
def read_row(program):
    """``(rows, i) -> number i`` of the row, between two rows interpolated."""
    return read_two if MANY_ROWS in program.bsdfs else _read_one


@kernel
def _read_one(rows, i):
    return gather(rows.curves, rows.row + i)


@kernel
def read_two(rows, i):
    """Number i between two rows interpolated."""
    a = gather(rows.curves, rows.row + i)
    b = gather(rows.curves, rows.row + rows.step + i)
    return a + rows.part * (b - a)
