"""What the converters of scene languages share: names, places, tables, meshes, problems."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any, ClassVar

from alight.formats.reading.names import plain_name
from alight.formats.reading.reach import Reach
from alight.formats.reading.report import Report
from alight.scene.description import name_problem
from alight.scene.files import Files

Data = dict[str, Any]


@dataclass
class Conversion:
    """State of one conversion.

    Attributes
    ----------
    report : Report
    reach : Reach
        Finds files.
    places : dict of str to str
        Key path of the native description -> ``file:line:column``.
    tables : dict of str to dict
        Textures, materials and prototypes by name, as in the native format.
    meshes : Files
        Reads meshes, for the time of the conversion.
    loaded : dict
        Meshes that have been made of them.
    """

    #: Between a name that is taken and its number.
    JOINT: ClassVar[str] = "-"

    report: Report
    reach: Reach
    places: dict[str, str] = field(default_factory=dict)
    tables: dict[str, dict[str, Data]] = field(default_factory=dict)
    meshes: Files = field(default_factory=Files)
    loaded: dict[Any, Any] = field(default_factory=dict)
    _taken: set[tuple[str, str]] = field(default_factory=set)
    _last: dict[tuple[str, str], int] = field(default_factory=dict)

    def free_name(self, table: str, wanted: str) -> str:
        """Make a name of the native format that nothing else in the table has."""
        plain = plain_name(wanted.strip(), "unnamed")
        name, number = plain, self._last.get((table, plain), 1)
        while (table, name) in self._taken or name_problem(name):
            number += 1
            name = f"{plain}{self.JOINT}{number}"
        self._last[table, plain] = number
        self._taken.add((table, name))
        return name

    def holds(self, values: Iterable[object], wanted: Callable[[Data], bool]) -> bool:
        """Whether descriptions, or those that they name, hold one that is wanted."""
        stack, seen = list(values), set()
        while stack:
            value = stack.pop()
            if isinstance(value, str) and value not in seen:
                seen.add(value)
                stack += [table[value] for table in self.tables.values() if value in table]
            elif isinstance(value, dict):
                if wanted(value):
                    return True
                stack.extend(value.values())
            elif isinstance(value, list):
                stack.extend(value)
        return False


def sees_coordinates(value: Data) -> bool:
    """Whether a description is a texture, or a material that is not the same all around."""
    return value.get("type") in ("bitmap", "checkerboard") or "alpha_u" in value
