"""The parameters of one directive, read by name and kind; the others are unknown."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from alight.core.errors import quote
from alight.formats.pbrt.directives import Directive, Parameter
from alight.formats.reading.parameters import Asked
from alight.formats.reading.report import Report

#: Numbers in one value of a kind.
WIDTHS = {"point": 3, "vector": 3, "normal": 3, "point2": 2, "vector2": 2}


class Parameters(Asked[Parameter]):
    """Reads the parameters of a directive.

    Parameters
    ----------
    directive : Directive
    report : Report
        Receives problems.
    defaults : iterable of Parameter, optional
        Those of ``Attribute``, which count where the directive has none of the name.
    """

    def __init__(
        self, directive: Directive, report: Report, defaults: Iterable[Parameter] = ()
    ) -> None:
        super().__init__(report)
        self.directive = directive
        self.named = {parameter.name: parameter for parameter in directive.parameters}
        self._inherited = set()
        for parameter in defaults:
            if parameter.name not in self.named:
                self.named[parameter.name] = parameter
                self._inherited.add(parameter.name)

    def values(self, name: str, *kinds: str, count: int | None = None) -> Parameter | None:
        """Ask for a parameter that must be of one of the given kinds, with `count` values."""
        found = self.find(name)
        if found is None:
            return None
        if found.kind not in kinds:
            wanted = " or ".join(f'"{kind} {name}"' for kind in kinds)
            self.report.error(found, f"must be given as {wanted}")
            return None
        length = len(found.values)
        if count is not None and length != count:
            self.report.error(found, f"must hold {count} values, got {length}")
            return None
        return found

    def number(self, name: str, default: float) -> float:
        """Ask for a number."""
        found = self.values(name, "float", "integer", count=1)
        return default if found is None else float(found.values[0])

    def integer(self, name: str, default: int) -> int:
        """Ask for a whole number."""
        found = self.values(name, "integer", count=1)
        if found is None:
            return default
        number = float(found.values[0])
        if number != int(number) or abs(number) >= 2**31:
            self.report.error(found, f"must be a whole number of 32 bits, got {number:g}")
            return default
        return int(number)

    def flag(self, name: str, default: bool) -> bool:
        """Ask for a truth value."""
        found = self.values(name, "bool", count=1)
        return default if found is None else bool(found.values[0])

    def word(self, name: str) -> tuple[Parameter, str] | None:
        """Ask for a parameter that must be a text."""
        found = self.values(name, "string", count=1)
        return None if found is None else (found, str(found.values[0]))

    def table(self, name: str, *kinds: str) -> np.ndarray | None:
        """Ask for points or the like; shape (n, width) of the first kind."""
        found = self.values(name, *kinds)
        if found is None:
            return None
        width = WIDTHS[kinds[0]]
        if len(found.values) % width:
            text = f"must hold a multiple of {width} numbers, got {len(found.values)}"
            self.report.error(found, text)
            return None
        return np.asarray(found.values).reshape(-1, width)

    def triple(self, name: str, default: Sequence[float]) -> np.ndarray:
        """Ask for one point or vector."""
        found = self.values(name, "point", "vector", count=3)
        return np.array(default if found is None else found.values, np.float64)

    def indices(self, name: str) -> np.ndarray | None:
        """Ask for a list of whole numbers >= 0."""
        found = self.values(name, "integer")
        if found is None:
            return None
        numbers = np.asarray(found.values)
        bad = (numbers < 0) | (numbers != np.floor(numbers)) | (numbers >= 2**31)
        if bad.any():
            text = f"must be whole numbers >= 0, got {numbers[bad][0]:g}"
            self.report.error(found, f"{text} as number {int(bad.argmax()) + 1}")
            return None
        return numbers.astype(np.int64)

    def positive(self, name: str, default: float) -> float:
        """Ask for a number > 0."""
        number = self.number(name, default)
        if number > 0.0:
            return number
        if name in self.named:
            self.report.error(self.named[name], f"must be > 0, got {number:g}")
        return default

    def finish(self) -> None:
        """Report whatever has not been read."""
        what = f"of {self.directive.name} {quote(self.directive.type)}"
        for parameter, text in self.unknown():
            if parameter.name not in self._inherited:
                self.report.not_covered(parameter, f"{what}: {text}", "ignored")
