"""Names of the native format from the names that a file has, or has not."""

from __future__ import annotations

import re
from collections.abc import Container

from alight.scene.description import name_problem


def free_name(wanted: str, taken: Container[str], otherwise: str) -> str:
    """Make a name that is allowed and not taken.

    Examples
    --------
    >>> free_name("a.b/c", {"a-b-c"}, "node")
    'a-b-c-2'
    """
    plain = plain_name(wanted, otherwise)
    name, number = plain, 1
    while name in taken or name_problem(name):
        number += 1
        name = f"{plain}-{number}"
    return name


def plain_name(wanted: str, otherwise: str) -> str:
    """A name without what names must not hold."""
    plain = re.sub(r"[/.\[\]=]+", "-", wanted).strip()[:80]
    return "".join(c for c in plain if c.isprintable()).strip() or otherwise
