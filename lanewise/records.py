"""Records: named tuples of lanes, of `Vec3` and of other records, as one value of kernel text.

`where` of `lanewise.simd` selects between whole records. What is uniform in a record (a Python
number in the twin) is no part of what the functions below write and read.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from lanewise.simd import LANES, room_for
from lanewise.vec3 import Vec3


def replace(record: Any, **fields: Any) -> Any:
    """The record with new values in the named fields, which may have other types than before.

    Parameters
    ----------
    record : named tuple
    **fields
        Names of its fields, and what they become.
    """
    return record._replace(**fields)


def local_records(room: int, like: Any) -> Any:
    """Scratch memory of this call.

    Parameters
    ----------
    room : int
        How many lanes of each field there is room for, a constant.
    like : record
        Only its type counts.
    """
    return np.zeros((sum(1 for _ in _lanes_of(like)), room_for(room)), np.uint32)


def put_records(memory: Any, room: int, at: int, order: Any, record: Any) -> None:
    """Write all lanes of a record, reordered, from number `at` on.

    Parameters
    ----------
    memory
        From `local_records`, for records of this type.
    room : int
        As given there.
    at : int
    order : u32 lanes
        For `lanewise.simd.permuted`.
    record : record
    """
    for row, lanes in zip(memory, _lanes_of(record), strict=True):
        permuted = np.broadcast_to(lanes, np.shape(order))[order]
        row[at : at + int(LANES)] = (
            permuted.view(np.uint32) if permuted.dtype == np.float32 else permuted
        )


def records_at(memory: Any, room: int, at: int, like: Any) -> Any:
    """The lanes from number `at` on as one record, with what is uniform in `like`.

    Parameters
    ----------
    memory
        What `put_records` has written to.
    room : int
        As given to `local_records`.
    at : int
    like : record
        Of the type that was written.
    """
    return _loaded(iter(memory[:, at : at + int(LANES)]), like)


def _lanes_of(value: Any) -> Iterator[Any]:
    """All lanes of a record, in the order of its fields."""
    if isinstance(value, Vec3):
        value = (value.x, value.y, value.z)
    if isinstance(value, tuple):
        for part in value:
            yield from _lanes_of(part)
    elif not isinstance(value, (bool, int, float)):
        yield value


def _loaded(rows: Iterator[Any], like: Any) -> Any:
    """The record that the rows hold."""
    if isinstance(like, Vec3):
        return Vec3(*(_loaded(rows, part) for part in (like.x, like.y, like.z)))
    if isinstance(like, tuple):
        parts = [_loaded(rows, part) for part in like]
        return type(like)(*parts) if hasattr(like, "_fields") else tuple(parts)
    if isinstance(like, (bool, int, float)):
        return like
    row = next(rows)
    kind = np.asarray(like).dtype
    return row.copy().view(np.float32) if kind == np.float32 else row.astype(kind)
