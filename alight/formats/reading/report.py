"""What became of a file of another program: read, approximated, dropped, or wrong.

Every reader fills one; `alight info` shows it whole, and a render in short. Nothing is left out
silently: what alight has no counterpart for is a problem, an approximation or a drop.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Protocol

from alight.core.errors import Issue, SceneError, nearest, quote
from alight.formats.reading.reach import OutOfReachError, UnreadableError


class Item(Protocol):
    """A part of a file that remarks are about: an element, a directive, a parameter."""

    place: str

    @property
    def label(self) -> str:
        """Its beginning, as messages show it."""
        ...


@dataclass
class Report:
    """Collects problems and remarks.

    Attributes
    ----------
    lenient : bool
        Whether what is not covered becomes a remark instead of a problem.
    issues : list of Issue
        Problems.
    notes : list of str
        What was dropped without harm to the picture, a line each.
    warnings : list of str
        What was approximated, replaced, made up, or is suspicious, a line each.
    counts : dict of str to int
        What was read: kind -> how many.
    assumed : dict of str to str
        Key path -> the warning that holds as long as its value stays.
    told : set of (str, str)
        What has been reported, each only once: a file may have as many remarks as shapes.
    """

    lenient: bool = False
    issues: list[Issue] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    counts: dict[str, int] = field(default_factory=dict)
    assumed: dict[str, str] = field(default_factory=dict)
    told: set[tuple[str, str]] = field(default_factory=set)

    def error(self, item: Item, message: str) -> None:
        """Report a problem of a part of the file, which nothing mends but an edit."""
        self.issues.append(Issue(item.label, message, item.place))

    def errors_of(self, item: Item, error: SceneError) -> None:
        """Report the problems of something that a part of the file asks for."""
        for issue in error.issues:
            message = f"{issue.path}: {issue.message}" if issue.path else issue.message
            self.error(item, message)

    def not_covered(self, item: Item, message: str, replacement: str) -> None:
        """Report what alight has no model for; when lenient, say what takes its place."""
        if self.lenient:
            self.warn(item, f"{message.partition('  (')[0]}: {replacement}")
        else:
            self.error(item, message)

    def unknown(
        self, item: Item, kind: str, name: str, covered: Iterable[str], replacement: str
    ) -> None:
        """Report a kind of object, by its name in the file, that alight has no model for."""
        known = sorted(covered)
        listed = ", ".join(word or '""' for word in known)
        text = f"{kind} {quote(name)} is not covered{did_you_mean(name, known)}"
        self.not_covered(item, f"{text}  (covered: {listed})", replacement)

    def lacks(self, item: Item, error: OutOfReachError, replacement: str) -> None:
        """Report a file that cannot be had; when lenient, say what takes its place."""
        if self.can_do_without(error):
            self.warn(item, f"{error}: {replacement}")
        else:
            self.error(item, str(error))

    def lacks_at(self, place: str, path: str, error: OutOfReachError, replacement: str) -> None:
        """As `lacks`, of a place: file or line, and what it is about there."""
        if self.can_do_without(error):
            self.approximate(f"{place} {path}: {error}: {replacement}")
        else:
            self.problem(place, path, str(error))

    def can_do_without(self, error: OutOfReachError) -> bool:
        """Tell whether something takes the place of a file; not of one that is there but broken."""
        return self.lenient and not isinstance(error, UnreadableError)

    def note(self, item: Item, text: str) -> None:
        """Remark on a part of the file that is left out without harm."""
        self._say(self.notes, f"{item.place}: {item.label} {text}")

    def warn(self, item: Item, text: str) -> None:
        """Remark on a part of the file that changes the picture."""
        self._say(self.warnings, f"{item.place}: {item.label} {text}")

    def _say(self, lines: list[str], line: str) -> None:
        if ("", line) not in self.told:
            self.told.add(("", line))
            lines.append(line)

    def problem(self, place: str, path: str, message: str) -> None:
        """Report what nothing mends but an edit: file or line, what it is about, what is wrong."""
        self.issues.append(Issue(path, message, place))

    def leave_out(
        self,
        place: str,
        word: str,
        kind: str,
        *,
        dropped: Mapping[str, str],
        approximated: Mapping[str, str],
        known: Iterable[str],
    ) -> None:
        """Say once of a word of the file that it is left out.

        Parameters
        ----------
        place, word, kind : str
            Where it stands first, the word, and what it is.
        dropped, approximated : mapping of str to str
            Words that play no part, and words that would change the picture -> why.
        known : iterable of str
            Words that count; the nearest one to an unknown one is named.
        """
        if (kind, word) in self.told:
            return
        self.told.add((kind, word))
        if word in dropped:
            self.drop(f"{quote(word)}: {dropped[word]}")
        elif word in approximated:
            self.approximate(f"{quote(word)} is left out: {approximated[word]}")
        else:
            text = f"unknown {kind} {quote(word)} is left out{did_you_mean(word, known)}"
            self.warnings.append(f"{place}: {text}")

    def sort(self) -> None:
        """Sort problems by their lines; files stay in the order in which they were found."""
        parts = [re.fullmatch(r"(.*):(\d+):(\d+)", issue.place) for issue in self.issues]
        files = {part[1] if part else "": i for i, part in reversed(list(enumerate(parts)))}
        keys = [(files[p[1]], int(p[2]), int(p[3])) if p else (-1, 0, 0) for p in parts]
        self.issues = [self.issues[i] for i in sorted(range(len(keys)), key=keys.__getitem__)]

    def drop(self, text: str) -> None:
        """Say once what is left out."""
        self._say(self.notes, text)

    def approximate(self, text: str) -> None:
        """Say once what is not quite what the file says."""
        self._say(self.warnings, text)

    def assume(self, key: str, text: str) -> None:
        """Say what is chosen for the file, as long as the user does not choose otherwise."""
        self.assumed[key] = text
        self.approximate(text)

    def count(self, kind: str, number: int = 1) -> None:
        """Count what was read."""
        self.counts[kind] = self.counts.get(kind, 0) + number


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """The end of a message about an unknown word: the known one that is nearest, if any is."""
    near = nearest(word, known)
    return f"; did you mean {quote(near)}?" if near and near != word else ""
