"""What is wrong with a file, what was replaced in it, and what plays no part in the picture."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Protocol

from alight.core.errors import Issue, SceneError, nearest, quote
from alight.formats.report import Report as AnyReport


class Item(Protocol):
    """What remarks are about: a directive or a parameter."""

    place: str

    @property
    def label(self) -> str:
        """Its beginning, as messages show it."""
        ...


@dataclass
class Report(AnyReport):
    """Collects problems and remarks about directives and parameters."""

    # A file may have as many remarks as shapes.
    _said: set[str] = field(default_factory=set)

    def error(self, item: Item, message: str) -> None:
        """Report a problem, which nothing mends but an edit."""
        self.issues.append(Issue(item.label, message, item.place))

    def errors_of(self, item: Item, error: SceneError) -> None:
        """Report the problems of something that a directive asks for."""
        for issue in error.issues:
            message = f"{issue.path}: {issue.message}" if issue.path else issue.message
            self.error(item, message)

    def not_covered(self, item: Item, message: str, replacement: str) -> None:
        """Report what alight has no model for; when lenient, say what takes its place."""
        if self.lenient:
            self.approximated(item, f"{message.partition('  (')[0]}: {replacement}")
        else:
            self.error(item, message)

    def unknown(
        self, item: Item, kind: str, name: str, covered: Iterable[str], replacement: str
    ) -> None:
        """Report an object of a kind that alight has no model for."""
        known = sorted(covered)
        near = nearest(name, known)
        hint = f'; did you mean "{near}"?' if near and near != name else ""
        listed = ", ".join(word or '""' for word in known)
        text = f"{kind} {quote(name)} is not covered{hint}  (covered: {listed})"
        self.not_covered(item, text, replacement)

    def note(self, item: Item, text: str) -> None:
        """Remark on something that is left out without harm; once for a place."""
        self._say(self.notes, f"{item.place}: {item.label} {text}")

    def approximated(self, item: Item, text: str) -> None:
        """Remark on something that changes the picture; once for a place."""
        self._say(self.warnings, f"{item.place}: {item.label} {text}")

    def _say(self, lines: list[str], line: str) -> None:
        if line not in self._said:
            self._said.add(line)
            lines.append(line)
