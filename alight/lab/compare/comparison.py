"""`alight.compare`: two pictures of any renderer, in figures and side by side."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from alight.films import Film
from alight.lab.compare.figures import (
    NOT_ASKED,
    PictureComparison,
    compare_inputs,
    exceeded,
    parse_limits,
)
from alight.lab.compare.inputs import as_input, make_comparable
from alight.lab.compare.views import SUFFIXES, figure_rows, signed_difference, write_view
from alight.lab.report.targets import check_target
from alight.metrics import JUDGED
from alight.options.entry import takes
from alight.options.laboratory import CompareOptions
from alight.options.plugins import load_plugins
from alight.outputs import html

#: What can be compared.
Comparable = Film | np.ndarray | str | os.PathLike[str]


@dataclass(frozen=True)
class Comparison:
    """One or two pictures against a reference.

    Attributes
    ----------
    found : tuple of PictureComparison
        The second where both were compared with a third.
    exceeded : tuple of str
        Limits that are exceeded, in words.
    exposure : float
        Stops, for what a display shows.
    """

    found: tuple[PictureComparison, ...]
    exceeded: tuple[str, ...] = ()
    exposure: float = 0.0

    def __str__(self) -> str:
        """What ``alight compare`` prints."""
        found, rows = self.found, figure_rows(self.found)
        if len(found) > 1:
            rows = [("", [one.a.name for one in found]), *rows]
        name_width = max(len(name) for name, _ in rows)
        widths = [max(len(values[i]) for _, values in rows) for i in range(len(found))]
        lines = [self._head(), ""]
        for name, values in rows:
            cells = "   ".join(v.ljust(n) for v, n in zip(values, widths, strict=True))
            lines.append(f"{name.ljust(name_width)}   {cells}".rstrip())
        notes = self._notes()
        return "\n".join([*lines, *([""] if notes else []), *notes])

    def _head(self) -> str:
        w, h = self.found[0].a.size
        heads = " and ".join(one.a.name for one in self.found)
        return f"{heads} against {self.found[0].b.name}, {w} x {h} pixels"

    def _notes(self) -> list[str]:
        """What the verdicts rest on, and which picture is nearer."""
        found = self.found
        notes = [text for one in found for text in _notes_of(one, len(found) > 1)]
        notes += sorted({why for one in found for why in one.missing.values()} - {NOT_ASKED})
        errors = [one.errors[JUDGED] for one in found]
        if len(found) == 2 and min(errors) > 0.0:
            ratio = errors[1] / errors[0]
            near = found[0] if ratio > 1.0 else found[1]
            notes.append(
                f"{near.a.name} is nearer: MSE {math.exp(abs(math.log(ratio))):.3g} times less"
            )
        return notes

    def to_dict(self) -> dict[str, Any]:
        """All numbers, ready for JSON; two comparisons are a list under ``comparisons``."""
        data = [one.to_dict() for one in self.found]
        return data[0] if len(data) == 1 else {"comparisons": data}

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write pictures side by side (PNG, HTML), or the plain difference (EXR, NPY, PFM).

        Raises
        ------
        AlightError
            If it cannot be written, or the packages that draw it are not installed.
        """
        check_target(Path(path), SUFFIXES, drawn=(".png", ".html"))
        return write_view(Path(path), self.found, self.exposure)

    def _repr_html_(self) -> str:
        """Show the pictures, their differences and the figures in a notebook."""
        inputs = [one.a for one in self.found] + [self.found[0].b]
        shown = [html.figure(one.image, one.name, self.exposure) for one in inputs]
        shown += [
            html.figure(_red_and_blue(one), f"{one.a.name} - {one.b.name}, up to ± 25 %")
            for one in self.found
        ]
        heads = ("", *(one.a.name for one in self.found))
        rows = [(name, *values) for name, values in figure_rows(self.found)]
        return html.division(
            "".join(shown), html.table(rows, heads, self._head()),
            html.preformatted([*self._notes(), *self.exceeded]),
        )  # fmt: skip


def _red_and_blue(one: PictureComparison) -> np.ndarray:
    """The relative difference: red where the first is brighter, blue where darker, else white."""
    level = np.clip(signed_difference(one) / 0.25, -1.0, 1.0)
    up, down = np.maximum(level, 0.0), np.maximum(-level, 0.0)
    return np.stack([1.0 - down, 1.0 - up - down, 1.0 - up], axis=-1)


def _notes_of(comparison: PictureComparison, named: bool) -> list[str]:
    """Give what the verdict rests on, after the picture's name where there are two."""
    start = f"{comparison.a.name}: " if named else ""
    return [text if text.startswith(start) else start + text for text in comparison.notes]


@takes(CompareOptions)
def compare(a: Comparable, b: Comparable, options: CompareOptions) -> Comparison:
    """Compare two pictures: errors, visible differences, and whether they exceed the noise.

    Parameters
    ----------
    a : Film, ndarray or path
        A film knows its noise, as EXR files of alight do; an array is linear, of shape (h, w, 3).
    b : Film, ndarray or path
        The reference of relative figures.
    {options}

    Returns
    -------
    Comparison

    Raises
    ------
    AlightError
        For pictures that cannot be read or compared, and for options that are wrong.

    Examples
    --------
    >>> coarse, fine = (alight.render("cornell-box", spp=n) for n in (16, 256))  # doctest: +SKIP
    >>> print(alight.compare(coarse, fine))  # doctest: +SKIP
    """
    load_plugins(options.plugins)
    limits = parse_limits(list(options.fail_above))
    if options.output is not None:
        check_target(options.output, SUFFIXES, drawn=(".png", ".html"))
    given: Sequence[tuple[Any, str]] = [(a, "A"), (b, "B")]
    if options.reference is not None:
        given = [*given, (options.reference, "reference")]
    read = [as_input(one, name, options.layer) for one, name in given]
    inputs = make_comparable(read, options.skip_invalid)
    found = tuple(
        compare_inputs(one, inputs[-1], exposure=options.exposure, slow=options.flip)
        for one in inputs[:-1]
    )
    failures = tuple(text for one in found for text in exceeded(one, limits))
    comparison = Comparison(found, failures, options.exposure)
    if options.output is not None:
        comparison.save(options.output)
    return comparison
