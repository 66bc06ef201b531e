"""What became of a file of another program: read, approximated, dropped, or wrong.

Every reader fills one; `alight info` shows it whole, and a render in short. Nothing is left out
silently: what alight has no counterpart for is a problem, an approximation or a drop.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from alight.core.errors import Issue, nearest, quote


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
        Kinds and words of the file of which it was said that they are left out.
    """

    lenient: bool = False
    issues: list[Issue] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    counts: dict[str, int] = field(default_factory=dict)
    assumed: dict[str, str] = field(default_factory=dict)
    told: set[tuple[str, str]] = field(default_factory=set)

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
            near = nearest(word, known)
            hint = f"; did you mean {quote(near)}?" if near else ""
            self.warnings.append(f"{place}: unknown {kind} {quote(word)} is left out{hint}")

    def drop(self, text: str) -> None:
        """Say once what is left out."""
        if text not in self.notes:
            self.notes.append(text)

    def approximate(self, text: str) -> None:
        """Say once what is not quite what the file says."""
        if text not in self.warnings:
            self.warnings.append(text)

    def assume(self, key: str, text: str) -> None:
        """Say what is chosen for the file, as long as the user does not choose otherwise."""
        self.assumed[key] = text
        self.approximate(text)

    def count(self, kind: str, number: int = 1) -> None:
        """Count what was read."""
        self.counts[kind] = self.counts.get(kind, 0) + number
