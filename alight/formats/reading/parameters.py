"""Parameters read by name; what nobody reads is unknown."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Generic, TypeVar

from alight.core.errors import unknown_name
from alight.formats.reading.report import Item, Report

Part = TypeVar("Part", bound=Item)


class Asked(ABC, Generic[Part]):
    """Parameters of an object of the file.

    Parameters
    ----------
    report : Report
        Receives problems.

    Attributes
    ----------
    named : dict
        Parameters by name.
    asked : dict of str to None
        What has been read, in order.
    """

    def __init__(self, report: Report) -> None:
        self.report = report
        self.named: dict[str, Part] = {}
        self.asked: dict[str, None] = {}

    def has(self, name: str) -> bool:
        """Tell whether a parameter is given, without asking for it."""
        return name in self.named

    def find(self, name: str) -> Part | None:
        """Ask for a parameter."""
        self.asked[name] = None
        return self.named.get(name)

    @abstractmethod
    def word(self, name: str) -> tuple[Part, str] | None:
        """Ask for a parameter that must be a text."""

    def text(self, name: str, default: str = "", choices: Sequence[str] = ()) -> str:
        """Ask for a text, one of `choices` if there are any."""
        found = self.word(name)
        if found is None:
            return default
        part, text = found
        if choices and text not in choices:
            known = unknown_name(name.replace("_", " "), text, choices, listed_as="covered")
            self.report.not_covered(part, known, f"{default} is taken")
            return default
        return text

    def ignore(self, why: str, *names: str) -> None:
        """Take parameters that do not change the picture, with a remark."""
        for part in filter(None, map(self.find, names)):
            self.report.note(part, f"is not used: {why}")

    def leave_out(self, why: str, *names: str) -> None:
        """Take parameters that do change the picture, with a warning."""
        for part in filter(None, map(self.find, names)):
            self.report.warn(part, f"is left out: {why}")

    def forget(self) -> None:
        """Ask for all: what is unknown itself has no unknown parameters."""
        self.asked.update(dict.fromkeys(self.named))

    def unknown(self) -> list[tuple[Part, str]]:
        """What has not been read, each with its remark."""
        return [
            (part, unknown_name("parameter", name, self.asked, listed_as="parameters"))
            for name, part in self.named.items()
            if name not in self.asked
        ]
