"""What the converters of all kinds of directives share: names, places, files, problems."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from alight.formats.pbrt.colors import Colors
from alight.formats.reach import Reach
from alight.formats.report import Report
from alight.scene.description import name_problem
from alight.scene.files import Files

Data = dict[str, Any]


@dataclass
class Context:
    """State of one conversion.

    Attributes
    ----------
    report : Report
    reach : Reach
        Finds files.
    old : bool
        Whether the scene is one of pbrt 3.
    sees_media : bool
        Whether the integrator of the file does.
    exposure : float
        Factor of all light: what the film makes of a radiance of 1.
    places : dict of str to str
        Key path of the native description -> ``file:line:column``.
    tables : dict of str to dict
        ``bsdfs``, ``textures`` and ``prototypes`` by name, as the native format has them.
    meshes : Files
        Reads meshes, for the time of the conversion.
    loaded : dict
        Meshes that have been made of them.
    textures, materials : mapping
        What converts textures and materials, by pbrt's name.
    """

    report: Report
    reach: Reach
    old: bool = False
    sees_media: bool = True
    exposure: float = 1.0
    places: dict[str, str] = field(default_factory=dict)
    tables: dict[str, dict[str, Data]] = field(
        default_factory=lambda: {"textures": {}, "bsdfs": {}, "prototypes": {}}
    )
    meshes: Files = field(default_factory=Files)
    loaded: dict[Any, Any] = field(default_factory=dict)
    textures: Mapping[str, Callable[[Any], Any]] = field(default_factory=dict)
    materials: Mapping[str, Callable[[Any], Data]] = field(default_factory=dict)
    _taken: set[tuple[str, str]] = field(default_factory=set)
    _last: dict[tuple[str, str], int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Make the reader of colours."""
        self.colors = Colors(self.report, self.reach)

    def name(self, table: str, wanted: str) -> str:
        """Make a name of the native format that nothing else in the table has."""
        plain = re.sub(r"[/.\[\]=]+", "-", wanted).strip()[:80]
        plain = "".join(c for c in plain if c.isprintable()).strip() or "unnamed"
        name, number = plain, self._last.get((table, plain), 1)
        while (table, name) in self._taken or name_problem(name):
            number += 1
            name = f"{plain} {number}"
        self._last[table, plain] = number
        self._taken.add((table, name))
        return name

    def sees_coordinates(self, value: object) -> bool:
        """Whether a description, or one that it names, depends on texture coordinates."""
        stack, seen = [value], set()
        while stack:
            value = stack.pop()
            if isinstance(value, str) and value not in seen:
                seen.add(value)
                stack += [t[value] for t in self.tables.values() if value in t]
            elif isinstance(value, dict):
                if value.get("type") in ("bitmap", "checkerboard") or "alpha_u" in value:
                    return True
                stack.extend(value.values())
            elif isinstance(value, list):
                stack.extend(value)
        return False
