"""What readers of foreign formats give back."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from alight.core.errors import Issue
from alight.formats.geometry.bounds import Bounds
from alight.formats.reading.report import Report
from alight.scene.source import Remarks


@dataclass
class Parsed:
    """What a file says.

    Attributes
    ----------
    data : dict
        Plain data as of a native file.
    places : dict of str to str
        Key path -> place in the file, as messages name it.
    issues : list of Issue
        Problems.
    notes : list of str
        What was dropped.
    warnings : list of str
        What was approximated or is suspicious.
    spp : int or None
        Samples per pixel that the file asks for.
    counts : dict of str to int
        What was read.
    framed : Bounds, optional
        What the camera must see, where the file has none of its own.
    assumed : dict of str to str
        See `alight.formats.reading.report.Report`.
    """

    data: dict[str, Any]
    places: dict[str, str] = field(default_factory=dict)
    issues: list[Issue] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    spp: int | None = None
    counts: dict[str, int] = field(default_factory=dict)
    framed: Bounds | None = None
    assumed: dict[str, str] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        data: dict[str, Any],
        places: dict[str, str],
        report: Report,
        spp: int | None = None,
        framed: Bounds | None = None,
    ) -> Parsed:
        """Put a description and what was noticed together."""
        remarks = (report.issues, report.notes, report.warnings)
        return cls(data, places, *remarks, spp, report.counts, framed, report.assumed)

    @property
    def remarks(self) -> Remarks:
        """What a scene keeps of it."""
        read = tuple((kind, number) for kind, number in self.counts.items())
        assumed = tuple(self.assumed.items())
        return Remarks(tuple(self.notes), tuple(self.warnings), self.spp, read, assumed)
