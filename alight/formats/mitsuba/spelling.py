"""The two spellings of Mitsuba's scene files: camelCase in 0.6, snake_case since Mitsuba 2.

The attribute ``version`` of ``<scene>`` decides. Everything after this file knows one spelling.
"""

from __future__ import annotations

import re

from alight.core.errors import quote

#: The first version with the new spelling.
NEW = 2


def is_old(version: str) -> bool:
    """Whether a file has the spelling of Mitsuba 0.6.

    Raises
    ------
    ValueError
        If the version is missing or is none.
    """
    found = re.fullmatch(r"(\d{1,4})(\.\d{1,4}){0,3}", version.strip())
    if not version:
        text = 'needs the attribute version, as version="3.0.0" (0.x: names in camelCase)'
        raise ValueError(text)
    if found is None:
        raise ValueError(f"version must be numbers with dots as 3.0.0, got {quote(version)}")
    return int(found[1]) < NEW


def to_snake_case(name: str) -> str:
    """Put a camelCase name into snake_case.

    Examples
    --------
    >>> [to_snake_case(name) for name in ("toWorld", "intIOR", "rrDepth", "p0")]
    ['to_world', 'int_ior', 'rr_depth', 'p0']
    """
    parted = re.sub(r"([a-z0-9])([A-Z])", r"\1_\2", name)
    return re.sub(r"([A-Z]+)([A-Z][a-z])", r"\1_\2", parted).lower()
