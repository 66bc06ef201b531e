"""The parameters of one object, read by name and kind; the others are unknown."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, overload

from alight.core.errors import quote, unknown_name
from alight.formats.reading.numbers import (
    NotNumbersError,
    parse_integer,
    parse_number,
    parse_numbers,
)
from alight.formats.reading.parameters import Asked
from alight.formats.reading.report import Report
from alight.formats.reading.xml import Element

Number = TypeVar("Number", int, float)

#: Elements that give a value to a parameter.
VALUES = ("float", "integer", "boolean", "string", "point", "vector", "transform", "animation")
COLORS = ("rgb", "srgb", "spectrum", "blackbody")
#: Elements that are objects of their own.
OBJECTS = (
    "bsdf",
    "emitter",
    "film",
    "integrator",
    "medium",
    "phase",
    "ref",
    "rfilter",
    "sampler",
    "sensor",
    "shape",
    "subsurface",
    "texture",
    "volume",
)
#: Objects about what is below surfaces, beside media.
BELOW = ("subsurface",)


class Properties(Asked[Element]):
    """Reads the children of an object's element.

    Parameters
    ----------
    element : Element
        The object.
    report : Report
        Receives problems.

    Attributes
    ----------
    objects : list of Element
        Nested objects without a name, and those named ``bsdf``, ``emitter`` and the like: they have
        a role, not a name that matters. `take` removes them.
    """

    def __init__(self, element: Element, report: Report) -> None:
        super().__init__(report)
        self.element = element
        self.objects: list[Element] = []
        for child in element.children:
            self._enter(child)

    def _enter(self, child: Element) -> None:
        if child.tag in OBJECTS and (not child.name or child.tag not in ("texture", "ref")):
            self.objects.append(child)
        elif child.tag not in (*VALUES, *COLORS, *OBJECTS):
            known = unknown_name("element", child.tag, (*VALUES, *COLORS, *OBJECTS))
            self.report.error(child, known)
        elif not child.name:
            self.report.error(child, "needs the attribute name")
        elif child.name in self.named:
            first = self.named[child.name].place
            self.report.error(child, f"is given twice, first at {first}")
        else:
            self.named[child.name] = child

    def value(self, name: str, *tags: str) -> tuple[Element, str] | None:
        """Ask for the text of a parameter that must be of one of the given kinds."""
        element = self.find(name)
        if element is None:
            return None
        if element.tag not in tags:
            wanted = " or ".join(f"<{tag}>" for tag in tags)
            self.report.error(element, f"must be given as {wanted}, got <{element.tag}>")
            return None
        if "value" not in element:
            self.report.error(element, "needs the attribute value")
            return None
        return element, element.attributes["value"]

    @overload
    def number(self, name: str, default: float) -> float: ...
    @overload
    def number(self, name: str, default: float | None = None) -> float | None: ...
    def number(self, name: str, default: float | None = None) -> float | None:
        """Ask for a number."""
        return self._parsed(parse_number, name, default, "float", "integer")

    def integer(self, name: str, default: int | None = None) -> int | None:
        """Ask for a whole number."""
        return self._parsed(parse_integer, name, default, "integer")

    def _parsed(
        self, parse: Callable[[str], Number], name: str, default: Number | None, *tags: str
    ) -> Number | None:
        found = self.value(name, *tags)
        if found is None:
            return default
        try:
            return parse(found[1])
        except NotNumbersError as error:
            self.report.error(found[0], str(error))
            return default

    def flag(self, name: str, default: bool = False) -> bool:
        """Ask for a truth value."""
        found = self.value(name, "boolean")
        if found is None:
            return default
        word = found[1].strip().lower()
        if word not in ("true", "false"):
            self.report.error(found[0], f"must be true or false, got {quote(found[1])}")
            return default
        return word == "true"

    def word(self, name: str) -> tuple[Element, str] | None:
        """Ask for a parameter that must be a text."""
        return self.value(name, "string")

    def triple(self, name: str) -> list[float] | None:
        """Ask for a point or vector."""
        element = self.find(name)
        if element is None:
            return None
        if element.tag not in ("point", "vector"):
            self.report.error(element, f"must be given as <point>, got <{element.tag}>")
            return None
        try:
            return coordinates(element, 0.0)
        except NotNumbersError as error:
            self.report.error(element, str(error))
            return None

    def only(self, name: str, accepted: bool, why: str) -> None:
        """Take a flag that may only have one value."""
        element = self.find(name)
        if element is None or self.flag(name, accepted) == accepted:
            return
        self.report.not_covered(element, f"is not covered: {why}", "ignored")

    def take(self, *tags: str) -> list[Element]:
        """Nested objects of the given kinds."""
        found = [element for element in self.objects if element.tag in tags]
        self.objects = [element for element in self.objects if element.tag not in tags]
        if "ref" in tags:
            # References may have a name without a meaning: <ref name="bsdf" .../>.
            for name, element in self.named.items():
                if element.tag == "ref" and name not in self.asked:
                    self.asked[name] = None
                    found.append(element)
        return found

    def finish(self) -> None:
        """Report whatever has not been read."""
        for element, text in self.unknown():
            self.report.not_covered(element, text, "ignored")
        for element in self.objects:
            text = f"has no use in {self.element.label}"
            if element.tag in BELOW:
                text = "is not covered: give the shape an interior medium"
            self.report.not_covered(element, text, "ignored")


def coordinates(element: Element, missing: float) -> list[float]:
    """Read ``x``, ``y``, ``z``, or three numbers (or one for all) in ``value``.

    Raises
    ------
    NotNumbersError
        If they are none.
    """
    if "value" in element:
        numbers = parse_numbers(element.attributes["value"], 1, 3)
        return numbers * 3 if len(numbers) == 1 else numbers
    axes = [element.attributes.get(axis) for axis in "xyz"]
    return [missing if axis is None else parse_number(axis) for axis in axes]
