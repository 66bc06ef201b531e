"""Diagrams with two logarithmic axes: points, bands of their intervals, fitted slopes, labels."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from alight.lab.report.numbers import fixed, superscript
from alight.lab.report.style import FAINT, GREY, Look, new_figure, paper_style, svg_of
from alight.metrics.estimate import Estimate

#: Inches; the axes take the left part, the names of the lines are to the right of their ends.
_WIDTH, _HEIGHT = 4.6, 3.2
_LEFT, _RIGHT, _BOTTOM, _TOP = 0.115, 0.64, 0.145, 0.93

#: What part of an axis a number takes, along it and across it.
_WIDE, _HIGH = 0.16, 0.06

#: Points (1 / 72 inch) from a label to the next one: a line of text, and room after it.
_LINE, _GAP = 9.5, 3.0


@dataclass(frozen=True)
class Line:
    """A line of a diagram.

    Parameters
    ----------
    label : str
    look : Look
    x, y, low, high : sequence of float
        Points that are not positive are left out; unknown intervals have no band.
    slope : Estimate, optional
        Fitted, of log(y) over log(x).
    expected : float, optional
        The slope that theory gives, drawn dashed.
    """

    label: str
    look: Look
    x: Sequence[float]
    y: Sequence[float]
    low: Sequence[float]
    high: Sequence[float]
    slope: Estimate | None = None
    expected: float | None = None

    def points(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """x, y and interval of the points that a logarithmic diagram can show."""
        table = np.array([self.x, self.y, self.low, self.high], np.float64).reshape(4, -1)
        x, y, low, high = table[:, np.isfinite(table[:2]).all(axis=0) & (table[:2] > 0).all(axis=0)]
        return x, y, np.where(low > 0.0, low, np.nan), np.where(high > 0.0, high, np.nan)


def diagram(
    lines: Sequence[Line], x_label: str, y_label: str, name: str, counts: bool = False
) -> str:
    """Draw lines over logarithmic axes.

    Parameters
    ----------
    lines : sequence of Line
    x_label, y_label : str
    name : str
        Unique on the page.
    counts : bool, default False
        Whether x are whole numbers worth a tick each, such as samples per pixel.

    Returns
    -------
    str
        An SVG element; empty if there is nothing to show.
    """
    shown = [line for line in lines if len(line.points()[0])]
    if not shown:
        return ""
    with paper_style():
        height = max(_HEIGHT, 0.9 + 0.36 * len(shown))
        figure = new_figure(_WIDTH, height)
        bottom = _BOTTOM * _HEIGHT / height
        axes = figure.add_axes((_LEFT, bottom, _RIGHT - _LEFT, _TOP - bottom))
        axes.set_xscale("log")
        axes.set_yscale("log")
        for line in shown:
            _draw(axes, line)
        _set_limits(axes, shown)
        for line in shown:
            _draw_slopes(axes, line)
        _set_ticks(axes, shown, counts)
        axes.set_xlabel(x_label)
        # Along the top, where it is read without turning the head.
        axes.text(-0.13, 1.005, y_label, transform=axes.transAxes, va="bottom", ha="left")
        _draw_labels(axes, shown, height)
        names = ", ".join(line.label for line in shown)
        return svg_of(figure, name, f"{y_label} over {x_label} for {names}")


def _draw(axes: Any, line: Line) -> None:
    x, y, low, high = line.points()
    color, style = line.look.color, (0, (4, 1.5)) if line.look.dashed else "-"
    band = np.isfinite(low) & np.isfinite(high)
    axes.fill_between(x[band], low[band], high[band], color=color, alpha=0.16, linewidth=0)
    if band.any():
        # Whiskers too: bands of one point have no width, narrow ones hide behind the line.
        axes.vlines(x[band], low[band], high[band], color=color, linewidth=0.8, alpha=0.6, zorder=2)
    fitted = line.slope is not None and math.isfinite(line.slope.value)
    if fitted:
        # A faint line from point to point shows where no power law fits.
        axes.plot(x, y, color=color, linewidth=0.7, alpha=0.45, zorder=1)
    axes.plot(x, y, linestyle="" if fitted else style, marker=line.look.mark, color=color,
              markeredgecolor="white", markeredgewidth=0.6, zorder=3)  # fmt: skip


def _draw_slopes(axes: Any, line: Line) -> None:
    """The fitted power law as a line, the expected one dashed, both through the middle."""
    x, y, _, _ = line.points()
    middle_x, middle_y = np.log(x).mean(), np.log(y).mean()
    ends = np.array([x.min() / 1.12, x.max() * 1.12])
    style = (0, (4, 1.5)) if line.look.dashed else "-"
    kinds = [(line.expected, 0.9, (0, (1, 2)))]
    if line.slope is not None:
        kinds.append((line.slope.value, 1.4, style))
    for slope, width, dash in kinds:
        if slope is None or not math.isfinite(slope):
            continue
        fit = np.exp(middle_y + slope * (np.log(ends) - middle_x))
        axes.plot(ends, fit, color=line.look.color, linewidth=width, linestyle=dash, zorder=2)


def _set_limits(axes: Any, lines: Sequence[Line]) -> None:
    """Leave a little room around the points; bands may be cut, so that one wild one rules none."""
    points = [line.points() for line in lines]
    for values, spans, setter in (
        (np.concatenate([p[0] for p in points]), (), axes.set_xlim),
        (
            np.concatenate([p[1] for p in points]),
            [np.concatenate([p[i] for p in points]) for i in (2, 3)],
            axes.set_ylim,
        ),
    ):
        low, high = values.min(), values.max()
        for span in spans:
            known = span[np.isfinite(span)]
            if len(known):
                low = min(low, max(known.min(), low / 4.0))
                high = max(high, min(known.max(), high * 4.0))
        room = max((high / low) ** 0.06, 1.12)
        setter(low / room, high * room)


def _set_ticks(axes: Any, lines: Sequence[Line], counts: bool) -> None:
    from matplotlib.ticker import FixedFormatter, FixedLocator, NullLocator

    shown = sorted({float(x) for line in lines for x in line.points()[0]})
    low, high = axes.get_xlim()
    ticks = shown if counts and 2 <= len(shown) <= 7 else _ticks(low, high)
    if counts and len(shown) > 7:
        ticks = shown[:: math.ceil(len(shown) / 6)]
    bottom, top = axes.get_ylim()
    ticks = legible(ticks, low, high, _WIDE)
    heights = legible(_ticks(bottom, top), bottom, top, _HIGH)
    for axis, values in ((axes.xaxis, ticks), (axes.yaxis, heights)):
        axis.set_major_locator(FixedLocator(values))
        axis.set_minor_locator(NullLocator())
        axis.set_major_formatter(FixedFormatter(tick_texts(values)))
    axes.grid(axis="y")
    axes.spines["left"].set_visible(False)


def legible(values: Sequence[float], low: float, high: float, share: float) -> list[float]:
    """Leave out numbers that would overprint those before them on a logarithmic axis.

    Examples
    --------
    >>> legible([1.0, 1.1, 10.0, 95.0, 100.0], 1.0, 100.0, 0.1)
    [1.0, 10.0, 95.0]
    """
    kept: list[float] = []
    for value in values:
        if not kept or math.log(value / kept[-1]) >= share * math.log(high / low):
            kept.append(value)
    return kept


def _ticks(low: float, high: float) -> list[float]:
    """Powers of ten, or 1, 2 and 5 of each where there are few of them."""
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    step = max(1, math.ceil((last - first) / 7))
    powers = [10.0**e for e in range(first, last + 1) if e % step == 0]
    inside = [p for p in powers if low <= p <= high]
    if len(inside) >= 3:
        return inside
    for steps in ((1, 3), (1, 2, 5), (1, 1.5, 2, 3, 4, 5, 6, 7, 8, 9)):
        fine = [s * 10.0**e for e in range(first, last + 1) for s in steps]
        inside = [v for v in fine if low <= v <= high]
        if len(inside) >= 3:
            return inside
    return inside or [math.sqrt(low * high)]


def tick_texts(values: Sequence[float]) -> list[str]:
    """Write the numbers of an axis, all as decimals or all as powers of ten.

    Examples
    --------
    >>> tick_texts([0.01, 0.1, 1.0]), tick_texts([1e-6, 1e-3, 1.0])
    (['0.01', '0.1', '1'], ['10⁻⁶', '10⁻³', '1'])
    """
    if all(0.9e-3 < v < 1.1e5 for v in values):
        return [f"{v:,.12g}".replace(",", "\u2009") for v in values]
    return [_power_text(v) for v in values]


def _power_text(value: float) -> str:
    exponent = math.floor(math.log10(value) + 1e-9)
    lead = value / 10.0**exponent
    power = f"10{superscript(exponent)}" if exponent else "1"
    return power if abs(lead - 1.0) < 1e-6 else f"{lead:g} × {power}"


def _draw_labels(axes: Any, lines: Sequence[Line], height: float) -> None:
    """Names and slopes right of the ends of the lines, moved apart, with thin leaders."""
    axes_height = 72.0 * height * axes.get_position().height
    axes_width = 72.0 * _WIDTH * axes.get_position().width
    entries = []
    for line in lines:
        x, y, _, _ = line.points()
        end = int(np.argmax(x))
        at = axes.transAxes.inverted().transform(axes.transData.transform((x[end], y[end])))
        words = textwrap.wrap(line.label, 20)[:3] or [""]
        rows = [*words, *_slope_words(line)]
        entries.append((float(at[1]) * axes_height, float(at[0]) * axes_width, rows, line, words))
    entries.sort(key=lambda entry: entry[0])
    sizes = [len(entry[2]) * _LINE + _GAP for entry in entries]
    places = spread([entry[0] for entry in entries], sizes, -8.0, axes_height + 8.0)
    for (y, x, rows, line, words), place, size in zip(entries, places, sizes, strict=True):
        left = axes_width + 15.0
        axes.plot(
            [(x + 5.0) / axes_width, (left - 4.0) / axes_width],
            [y / axes_height, place / axes_height],
            transform=axes.transAxes, color=FAINT, linewidth=0.8, clip_on=False, zorder=1,
        )  # fmt: skip
        top = place + (size - _GAP) / 2.0
        for i, row in enumerate(rows):
            name = i < len(words)
            axes.text(
                left / axes_width, (top - (i + 0.5) * _LINE) / axes_height, row,
                transform=axes.transAxes, va="center_baseline", ha="left", clip_on=False,
                color=line.look.color if name else GREY, fontsize=8.5 if name else 7.5,
                fontweight="bold" if name else "normal",
            )  # fmt: skip


def _slope_words(line: Line) -> list[str]:
    words = []
    if line.slope is not None and math.isfinite(line.slope.value):
        half = (line.slope.high - line.slope.low) / 2.0
        error = f" ± {fixed(half, 2)}" if math.isfinite(half) and half > 0.0 else ""
        words.append(f"slope {fixed(line.slope.value, 2)}{error}")
    if line.expected is not None:
        words.append(f"expected {fixed(line.expected, 2)}")
    return words


def spread(wanted: Sequence[float], sizes: Sequence[float], low: float, high: float) -> list[float]:
    """Move labels apart as little as needed.

    Parameters
    ----------
    wanted : sequence of float
        Centres, rising.
    sizes : sequence of float
    low, high : float
        Where the labels must stay if there is room for all.

    Returns
    -------
    list of float
        Centres, in the same order, that do not overlap.
    """
    # Labels that touch move as one block to the mean of what its members want.
    blocks: list[tuple[float, float, int]] = []
    for centre, size in zip(wanted, sizes, strict=True):
        blocks.append((centre - size / 2.0, size, 1))
        while len(blocks) > 1 and blocks[-2][0] + blocks[-2][1] > blocks[-1][0]:
            (at_a, size_a, n_a), (at_b, size_b, n_b) = blocks[-2], blocks[-1]
            blocks[-2:] = [((n_a * at_a + n_b * (at_b - size_a)) / (n_a + n_b), size_a + size_b,
                            n_a + n_b)]  # fmt: skip
    places = []
    i = 0
    for at, _, n in blocks:
        for size in sizes[i : i + n]:
            places.append(at + size / 2.0)
            at += size
        i += n
    # Back into the picture: down from the top, then up from the bottom.
    for order, side in ((range(len(places) - 1, -1, -1), -1.0), (range(len(places)), 1.0)):
        edge = high if side < 0 else low
        for k in order:
            limit = edge + side * sizes[k] / 2.0
            places[k] = min(places[k], limit) if side < 0 else max(places[k], limit)
            edge = places[k] + side * sizes[k] / 2.0
    return places
