"""What is wrong with a file, what was replaced in it, and what plays no part in the picture."""

from __future__ import annotations

from collections.abc import Iterable

from alight.core.errors import Issue, SceneError, nearest, quote
from alight.formats.mitsuba.elements import Element
from alight.formats.report import Report as AnyReport


class Report(AnyReport):
    """Collects problems and remarks about elements."""

    def error(self, element: Element, message: str) -> None:
        """Report a problem, which nothing mends but an edit."""
        self.issues.append(Issue(element.label, message, element.place))

    def errors_of(self, element: Element, error: SceneError) -> None:
        """Report the problems of something that an element asks for."""
        for issue in error.issues:
            message = f"{issue.path}: {issue.message}" if issue.path else issue.message
            self.error(element, message)

    def not_covered(self, element: Element, message: str, replacement: str) -> None:
        """Report what alight has no model for; when lenient, say what takes its place."""
        if self.lenient:
            self.warn(element, f"{message.partition('  (')[0]}: {replacement}")
        else:
            self.error(element, message)

    def unknown(
        self, element: Element, kind: str, covered: Iterable[str], replacement: str
    ) -> None:
        """Report an object whose plug-in alight has no model for."""
        near = nearest(element.type, covered)
        hint = f'; did you mean "{near}"?' if near else ""
        listed = ", ".join(sorted(covered))
        text = f"{kind} {quote(element.type)} is not covered{hint}  (covered: {listed})"
        self.not_covered(element, text, replacement)

    def note(self, element: Element, text: str) -> None:
        """Remark on something that is left out without harm."""
        self.notes.append(f"{element.place}: {element.label} {text}")

    def warn(self, element: Element, text: str) -> None:
        """Remark on something that changes the picture."""
        self.warnings.append(f"{element.place}: {element.label} {text}")
