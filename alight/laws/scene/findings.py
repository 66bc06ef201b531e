"""What the check of a scene found, and which of it counts when many laws are tested at once.

Laws with a p-value form one family: Holm's step-down correction (Holm 1979) keeps the probability
that a scene without a bug fails any of them at the level. Laws without one hold or do not hold.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from alight.laws.scene.panels import side_by_side
from alight.outputs import html


@dataclass(frozen=True)
class Finding:
    """One law for one part of the scene.

    Attributes
    ----------
    part : str
        Of the scene, as ``material white`` or ``picture``.
    law : str
        In words.
    p : float or None
        Probability of so bad a value where the law holds; None for laws without chance in them, and
        for what could not be judged.
    holds : bool or None
        For laws without a p-value; None where the law could not be judged.
    detail : str
        Figures, or why it was not judged.
    pictures : dict of str to ndarray, shape (h, w, 3)
        To be looked at if the law does not hold: linear pictures, and ``z`` of shape (h, w).
    """

    part: str
    law: str
    p: float | None = None
    holds: bool | None = None
    detail: str = ""
    pictures: dict[str, np.ndarray] = field(default_factory=dict, repr=False, compare=False)


@dataclass(frozen=True)
class Verdict:
    """All findings about a scene.

    Attributes
    ----------
    findings : tuple of Finding
    level : float
        Probability that a scene without a bug fails.
    warnings : tuple of str
        What is legal but suspicious of the scene.
    """

    findings: tuple[Finding, ...]
    level: float
    warnings: tuple[str, ...] = ()

    @property
    def corrected(self) -> tuple[float | None, ...]:
        """Holm's adjusted p-value of each finding; None where it has none."""
        tested = [i for i, finding in enumerate(self.findings) if finding.p is not None]
        adjusted = adjusted_by_holm([self.findings[i].p or 0.0 for i in tested])
        found: list[float | None] = [None] * len(self.findings)
        for i, p in zip(tested, adjusted, strict=True):
            found[i] = p
        return tuple(found)

    @property
    def failures(self) -> tuple[Finding, ...]:
        """Those that do not hold."""
        return tuple(
            finding
            for finding, p in zip(self.findings, self.corrected, strict=True)
            if finding.holds is False or (p is not None and p <= self.level)
        )

    @property
    def ok(self) -> bool:
        """Whether all hold."""
        return not self.failures

    def __bool__(self) -> bool:
        """As `ok`."""
        return self.ok

    def __str__(self) -> str:
        """What ``alight check`` prints: a line for each law, and what comes of them."""
        return "\n".join(self.lines())

    def lines(self, failures_only: bool = False) -> list[str]:
        """Write the table, laws that fail marked, and its sum."""
        rows = self._rows(failures_only)
        width = max((len(row[2]) for row in rows), default=0)
        lines = [f"     p        {'part':<{width}}  law"] if rows else []
        for mark, shown, part, law, detail in rows:
            tail = f"  ({detail})" if detail else ""
            lines.append(f"{mark:<4} {shown:<8} {part:<{width}}  {law}{tail}")
        return [*lines, self._sum()]

    def _rows(self, failures_only: bool = False) -> list[tuple[str, str, str, str, str]]:
        rows = []
        for finding, p in zip(self.findings, self.corrected, strict=True):
            bad = finding in self.failures
            if failures_only and not bad:
                continue
            judged = finding.p is not None or finding.holds is not None
            mark = "BAD" if bad else "ok" if judged else "--"
            shown = "" if p is None else "<1e-99" if p < 1e-99 else f"{p:.2g}"
            rows.append((mark, shown, finding.part, finding.law, finding.detail))
        return rows

    def _sum(self) -> str:
        tests = sum(finding.p is not None for finding in self.findings)
        laws, failed = len(self.findings), len(self.failures)
        return (
            f"{laws} laws, {failed} broken; {tests} p-values corrected together (Holm), "
            f"false alarm at {100 * self.level:g} %"
        )

    def pictures(self) -> list[tuple[Finding, np.ndarray]]:
        """Both sides of what failed, linear; tests of the same pictures share one."""
        found, shown = [], set()
        for finding in self.failures:
            image = None if id(finding.pictures) in shown else side_by_side(finding.pictures)
            shown.add(id(finding.pictures))
            if image is not None:
                found.append((finding, image))
        return found

    def _repr_html_(self) -> str:
        """Show the table in a notebook, and both sides of what failed."""
        shown = [
            html.figure(image, f"{finding.part}: {finding.law}", width=image.shape[1])
            for finding, image in self.pictures()
        ]
        heads = ("", "p", "part", "law", "detail")
        table = html.table(self._rows(), heads, self._sum())
        return html.division(html.preformatted(self.warnings), table, *shown)


def adjusted_by_holm(p_values: list[float]) -> list[float]:
    """Holm's adjusted p-values: a hypothesis falls at a level if its value is not above it.

    Examples
    --------
    >>> adjusted_by_holm([0.01, 0.5, 0.02])
    [0.03, 0.5, 0.04]
    """
    order = sorted(range(len(p_values)), key=lambda i: p_values[i])
    adjusted, largest = [0.0] * len(p_values), 0.0
    for rank, i in enumerate(order):
        # A smaller p-value never gets a larger adjusted one; a NaN is as bad as 0.
        p = p_values[i] if p_values[i] == p_values[i] else 0.0
        largest = max(largest, min(1.0, (len(p_values) - rank) * p))
        adjusted[i] = largest
    return adjusted
