"""A dot and its interval in a cell of a table, all rows over one logarithmic axis."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

from alight.lab.report.style import BASELINE, GREY
from alight.metrics.estimate import Estimate

_WIDTH, _HEIGHT, _MARGIN = 180.0, 22.0, 8.0


class Whiskers:
    """The common axis of a column of ratios.

    Parameters
    ----------
    estimates : sequence of Estimate
        Of all rows; unknown ones are left out. 1 is always on the axis.
    """

    def __init__(self, estimates: Sequence[Estimate]) -> None:
        ends = [v for e in estimates for v in e if math.isfinite(v) and v > 0.0]
        low, high = min([*ends, 1.0]), max([*ends, 1.0])
        # One very wide interval would press all others into a point.
        values = [e.value for e in estimates if math.isfinite(e.value) and e.value > 0.0] or [1.0]
        low, high = max(low, min([*values, 1.0]) / 5.0), min(high, max([*values, 1.0]) * 5.0)
        room = max((high / low) ** 0.08, 1.06)
        self.low, self.high = low / room, high * room

    def place(self, value: float) -> float:
        """Where a ratio lies, in units of the picture."""
        share = math.log(value / self.low) / math.log(self.high / self.low)
        return _MARGIN + min(max(share, 0.0), 1.0) * (_WIDTH - 2.0 * _MARGIN)

    def row(self, estimate: Estimate | None, color: str, hollow: bool = False) -> str:
        """Draw one row: the line of "no difference", the interval, the value.

        Parameters
        ----------
        estimate : Estimate or None
        color : str
        hollow : bool, default False
            For rows that must not be compared with the others.
        """
        middle = _HEIGHT / 2.0
        one = self.place(1.0)
        parts = [_line((one, 0.0), (one, _HEIGHT), BASELINE, 'stroke-dasharray="2 2"')]
        if estimate is not None and math.isfinite(estimate.value) and estimate.value > 0.0:
            if estimate.low > 0.0 and math.isfinite(estimate.high):
                ends = [(self.place(v), middle) for v in (estimate.low, estimate.high)]
                style = 'stroke-width="2" stroke-linecap="round"'
                parts.append(_line(ends[0], ends[1], color, style))
            at = f'cx="{self.place(estimate.value):.1f}" cy="{middle:g}" r="4"'
            fill, edge = ("#fff", color) if hollow else (color, "#fff")
            width = 2 if hollow else 1
            parts.append(f'<circle {at} fill="{fill}" stroke="{edge}" stroke-width="{width}"/>')
        return _svg("".join(parts), _HEIGHT)

    def axis(self) -> str:
        """Draw the numbers of the axis, for the foot of the column."""
        parts = [_line((_MARGIN, 0.5), (_WIDTH - _MARGIN, 0.5), GREY, 'stroke-width="0.7"')]
        for value in self._ticks():
            at = self.place(value)
            parts.append(_line((at, 0.0), (at, 3.0), GREY))
            style = f'text-anchor="middle" font-size="10" fill="{GREY}"'
            parts.append(f'<text x="{at:.1f}" y="13" {style}>{value:g}×</text>')
        return _svg("".join(parts), 16.0)

    def _ticks(self) -> list[float]:
        """A few round numbers with room between them, 1 among them."""
        for steps in ((1, 1.2, 1.5, 2, 3, 5, 7), (1, 2, 5), (1, 3), (1,)):
            decades = range(math.floor(math.log10(self.low)), math.ceil(math.log10(self.high)) + 1)
            values = [float(f"{s * 10.0**e:.6g}") for e in decades for s in steps]
            inside = [v for v in values if self.low <= v <= self.high]
            places = [self.place(v) for v in inside]
            room = 8.0 + 5.5 * max(len(f"{v:g}×") for v in inside)
            if all(b - a >= room for a, b in itertools.pairwise(places)):
                return inside
        step = math.ceil(len(inside) / 4)
        return [v for v in inside if round(math.log10(v)) % step == 0]


def _line(a: tuple[float, float], b: tuple[float, float], color: str, style: str = "") -> str:
    ends = f'x1="{a[0]:.1f}" y1="{a[1]:.1f}" x2="{b[0]:.1f}" y2="{b[1]:.1f}"'
    return f'<line {ends} stroke="{color}" {style}/>'


def _svg(content: str, height: float) -> str:
    box = f'viewBox="0 0 {_WIDTH:g} {height:g}"'
    return f'<svg class="whisker" {box} aria-hidden="true">{content}</svg>'
