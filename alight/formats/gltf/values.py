"""Values of a JSON document with their JSON pointers, and the checks of what they must be."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from alight.core.errors import Issue, SceneError, show_value, unknown_name
from alight.formats.reading.report import Report


@dataclass(frozen=True)
class Item:
    """An object of the document.

    Parameters
    ----------
    value : dict
    pointer : str
        RFC 6901, for instance ``/meshes/0``.
    name : str
        Of the file, for messages.
    report : Report
        Takes the problems; the methods then give the default.
    """

    value: dict[str, Any]
    pointer: str
    name: str
    report: Report

    def at(self, key: str | int) -> str:
        """The pointer of a key of this object."""
        return f"{self.pointer}/{str(key).replace('~', '~0').replace('/', '~1')}"

    def has(self, key: str) -> bool:
        """Whether a key is there."""
        return key in self.value

    def wrong(self, key: str, message: str) -> None:
        """Report a problem with the value of a key."""
        self.report.problem(self.name, self.at(key) if key else self.pointer, message)

    def fatal(self, key: str, message: str) -> SceneError:
        """Make the error of a problem after which nothing can be read."""
        pointer = self.at(key) if key else self.pointer
        return SceneError([*self.report.issues, Issue(pointer, message, self.name)])

    def number(
        self, key: str, default: float, low: float = -math.inf, high: float = math.inf
    ) -> float:
        """A number in a range."""
        value = self.value.get(key, default)
        if isinstance(value, bool) or not isinstance(value, int | float):
            self.wrong(key, f"must be a number, got {show_value(value)}")
        elif not low <= value <= high or abs(value) > 1e15:
            self.wrong(key, f"must be {_range(low, high)}, got {show_value(value)}")
        else:
            return float(value)
        return default

    def integer(self, key: str, default: int, low: int = 0, high: int = 2**40) -> int:
        """A whole number in a range."""
        value = self.value.get(key, default)
        if isinstance(value, float) and abs(value) < 2**53 and value == math.floor(value):
            value = int(value)
        if isinstance(value, bool) or not isinstance(value, int):
            self.wrong(key, f"must be a whole number, got {show_value(value)}")
        elif not low <= value <= high:
            self.wrong(key, f"must be {_range(low, high)}, got {show_value(value)}")
        else:
            return value
        return default

    def numbers(
        self,
        key: str,
        default: tuple[float, ...],
        low: float = -math.inf,
        high: float = math.inf,
    ) -> tuple[float, ...]:
        """As many numbers in a range as the default has."""
        value = self.value.get(key)
        if value is None and key not in self.value:
            return default
        if not isinstance(value, list) or len(value) != len(default):
            self.wrong(key, f"must be a list of {len(default)} numbers, got {show_value(value)}")
            return default
        for number in value:
            if isinstance(number, bool) or not isinstance(number, int | float):
                self.wrong(key, f"must hold numbers, got {show_value(number)}")
                return default
            if not low <= number <= high or abs(number) > 1e15:
                allowed = _range(low, high).removeprefix("a number ")
                self.wrong(key, f"must hold numbers {allowed}, got {show_value(number)}")
                return default
        return tuple(float(number) for number in value)

    def text(self, key: str, default: str = "", choices: tuple[str, ...] = ()) -> str:
        """A text, one of `choices` where there are any."""
        value = self.value.get(key, default)
        if not isinstance(value, str):
            self.wrong(key, f"must be a text, got {show_value(value)}")
            return default
        if choices and value not in choices:
            self.wrong(key, unknown_name(key, value, choices))
            return default
        return value

    def flag(self, key: str, default: bool = False) -> bool:
        """True or false."""
        value = self.value.get(key, default)
        if not isinstance(value, bool):
            self.wrong(key, f"must be true or false, got {show_value(value)}")
            return default
        return value

    def object(self, key: str) -> Item | None:
        """An object, or None where there is none."""
        if key not in self.value:
            return None
        value = self.value[key]
        if not isinstance(value, dict):
            self.wrong(key, f"must be an object, got {show_value(value)}")
            return None
        return Item(value, self.at(key), self.name, self.report)

    def objects(self, key: str) -> list[Item]:
        """A list of objects; empty where there is none."""
        return list(self._objects(key))

    def _objects(self, key: str) -> Iterator[Item]:
        found = self.value.get(key, [])
        if not isinstance(found, list):
            raise self.fatal(key, f"must be a list, got {show_value(found)}")
        for index, value in enumerate(found):
            pointer = f"{self.at(key)}/{index}"
            if not isinstance(value, dict):
                text = f"must be an object, got {show_value(value)}"
                raise SceneError([*self.report.issues, Issue(pointer, text, self.name)])
            yield Item(value, pointer, self.name, self.report)

    def index(self, key: str, count: int, of: str) -> int | None:
        """An index into a list of `count` things; None where there is none, or it is wrong."""
        if key not in self.value:
            return None
        if count == 0:
            self.wrong(key, f"must be the index of one of the {of}, but the file has none")
            return None
        before = len(self.report.issues)
        found = self.integer(key, 0, 0, count - 1)
        return found if len(self.report.issues) == before else None

    def indices(self, key: str, count: int, of: str) -> list[int]:
        """A list of indices into a list of `count` things; wrong ones are left out."""
        found = self.value.get(key, [])
        if not isinstance(found, list):
            self.wrong(key, f"must be a list of indices, got {show_value(found)}")
            return []
        result = []
        for value in found:
            if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < count:
                text = f"must hold indices of {of} in [0, {count - 1}], got {show_value(value)}"
                self.wrong(key, text)
            else:
                result.append(value)
        return result

    def extension(self, name: str) -> Item | None:
        """One of the extensions of this object."""
        extensions = self.object("extensions")
        return None if extensions is None else extensions.object(name)


def _range(low: float, high: float) -> str:
    if low > -math.inf and high < math.inf:
        return f"in [{low:.10g}, {high:.10g}]"
    if low > -math.inf:
        return f">= {low:g}"
    return "a number of at most 1e+15 in size"
