"""Records: named tuples of lanes, of `Vec3` and of other records, as one value of kernel text.

`where` of `lanewise.simd` selects between whole records, and `permuted` reorders all their lanes.
"""

from __future__ import annotations

from typing import Any


def replace(record: Any, **fields: Any) -> Any:
    """The record with new values in the named fields, which may have other types than before.

    Parameters
    ----------
    record : named tuple
    **fields
        Names of its fields, and what they become.
    """
    return record._replace(**fields)
