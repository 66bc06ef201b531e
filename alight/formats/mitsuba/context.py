"""What the converters of all kinds of objects share: names, places, files, problems."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from alight.core.errors import join_path, unknown_name
from alight.formats.mitsuba.colors import Colors
from alight.formats.reading.context import Conversion, Data
from alight.formats.reading.xml import Element

#: Objects that refer to each other in a longer chain are refused.
MOST_REFERENCES = 24


@dataclass
class Context(Conversion):
    """State of one conversion; see `alight.formats.reading.context.Conversion`.

    Attributes
    ----------
    materials : mapping
        Plug-in -> our name, and what reads its parameters.
    ids : dict of str to Element
        Objects that can be referred to.
    moves : bool
        Whether the file has animations.
    sees_media, uses_media : bool
        Whether the file's integrator knows of media; whether there are any.
    has_panes : bool
        Whether anything is of ``thindielectric``.
    """

    materials: Mapping[str, tuple[str, Callable[[Any], None]]] = field(default_factory=dict)
    ids: dict[str, Element] = field(default_factory=dict)
    moves: bool = False
    sees_media: bool = False
    uses_media: bool = False
    has_panes: bool = False
    _names: dict[tuple[str, str], str] = field(default_factory=dict)
    _open: list[Element] = field(default_factory=list)
    # How many objects in a row each named one refers through; and for those being built, so far.
    _levels: dict[tuple[str, str], int] = field(default_factory=dict)
    _inner: list[int] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Open the tables."""
        self.colors = Colors(self.report, self.reach)
        self.tables = {"bsdfs": {}, "textures": {}, "media": {}, "prototypes": {}}

    def target(self, element: Element, *tags: str) -> Element | None:
        """Find what a ``<ref>`` refers to; other elements stand for themselves."""
        if element.tag != "ref":
            return element
        name = element.attributes.get("id", "")
        found = self.ids.get(name)
        if found is None:
            known = [key for key, other in self.ids.items() if other.tag in tags]
            self.report.error(element, unknown_name("id", name, known, listed_as="ids"))
        elif found.tag not in tags:
            wanted = " or ".join(f"<{tag}>" for tag in tags)
            self.report.error(element, f"must refer to a {wanted}, got {found.label}")
            found = None
        return found

    def named(
        self, table: str, element: Element, build: Callable[[str], Data], variant: str = ""
    ) -> str:
        """Put an object with an id (and a variant of it) into a table, once; return its name."""
        entries = self.tables[table]
        name = self.name(table, element.attributes["id"] + variant)
        key = (table, name)
        if name not in entries:
            # Its place in the order comes before the parts that it is made of.
            entries[name] = {}
            self._inner.append(0)
            entries[name] = build(join_path(table, name))
            self._levels[key] = 1 + self._inner.pop()
            if self._levels[key] == MOST_REFERENCES:
                self.report.error(element, f"refers through more than {MOST_REFERENCES} objects")
        if self._inner:
            self._inner[-1] = max(self._inner[-1], self._levels.get(key, 0))
        return name

    def enter(self, element: Element) -> bool:
        """Begin to convert an object; False if it contains itself or is nested too deeply."""
        if element in self._open:
            self.report.error(element, "contains itself")
            return False
        if len(self._open) >= MOST_REFERENCES:
            self.report.error(element, f"is nested deeper than {MOST_REFERENCES} levels")
            return False
        self._open.append(element)
        return True

    def leave(self) -> None:
        """End what `enter` began."""
        self._open.pop()

    def name(self, table: str, wanted: str) -> str:
        """Make a name of the native format from an id; each id has its own."""
        key = (table, wanted)
        if key not in self._names:
            self._names[key] = self.free_name(table, wanted)
        return self._names[key]
