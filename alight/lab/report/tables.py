"""The tables of a scene: what was won, how wrong each arm is, what it costs, whether it is true."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

from alight.lab.report.numbers import UNKNOWN, Column, number, p_value
from alight.lab.report.style import Look
from alight.lab.report.whiskers import Whiskers
from alight.lab.results import BIASED, DIFFERENT, DISPUTED, ArmResult, Point, SceneResult
from alight.lab.statistics.block_means import LEVEL
from alight.metrics import JUDGED, Estimate
from alight.metrics.model import METRICS


class Cell(NamedTuple):
    """One cell.

    Attributes
    ----------
    text : str
    note : str
        Smaller, after the text: an interval.
    kind : str
        Class of the cell: "number", "word", "picture", "warning" or "muted".
    title : str
        Name of the column, with the unit; shown next to the cell on narrow screens.
    """

    text: str
    note: str = ""
    kind: str = "number"
    title: str = ""


class Row(NamedTuple):
    """One arm of a table."""

    label: str
    look: Look | None
    badges: list[tuple[str, str]]
    cells: list[Cell]


class Table(NamedTuple):
    """A table, head first; `foot` has a cell a column or is empty."""

    caption: str
    heads: list[str]
    rows: list[Row]
    foot: list[str]


Ranked = list[tuple[ArmResult, Look]]


def ranked(scene: SceneResult, looks: Sequence[Look]) -> Ranked:
    """Arms from the most to the least efficient; those of unknown efficiency come last."""
    pairs = list(zip(scene.arms, looks, strict=True))
    known = [p for p in pairs if math.isfinite(p[0].efficiency.value)]
    known.sort(key=lambda pair: -pair[0].efficiency.value)
    return known + [p for p in pairs if not math.isfinite(p[0].efficiency.value)]


def equal_time_point(arm: ArmResult) -> Point | None:
    """The point at which arms are judged: the last of equal time, else the last there is."""
    points = arm.times or arm.samples
    return points[-1] if points else None


def efficiency_table(arms: Ranked) -> Table:
    """Speed-up over the baseline with its interval, error at equal time, efficiency."""
    one = Estimate(1.0, 1.0, 1.0)
    ratios = [_ratio(arm) for arm, _ in arms]
    whiskers = Whiskers([r for r in ratios if r is not None])
    speed = _ratio_column([r.value for r in ratios if r is not None])
    points = [equal_time_point(arm) for arm, _ in arms]
    error = Column.of([p.relmse.value for p in points if p])
    gain = Column.of([arm.efficiency.value for arm, _ in arms])
    heads = ["Speed-up", "", "p (Holm)", head("relMSE", error), head("Efficiency", gain)]
    rows = []
    for (arm, look), ratio, point in zip(arms, ratios, points, strict=True):
        p = arm.speedup.p_adjusted if arm.speedup else math.nan
        shown = one if arm.is_baseline else ratio
        speed_cell = (
            Cell("1", "baseline", "number")
            if arm.is_baseline
            else estimate_cell(ratio, speed, suffix="×")
        )
        cells = [
            speed_cell,
            Cell(whiskers.row(shown, look.color, not comparable(arm)), "", "picture"),
            Cell(p_value(p)),
            estimate_cell(point.relmse if point else None, error),
            estimate_cell(arm.efficiency, gain),
        ]
        rows.append(_row(arm, look, cells, heads))
    caption = (
        "Arms by efficiency, 1 / (MSE · CPU seconds) at the last point of equal time. Speed-up: "
        "efficiency over the baseline’s. Errors in a time are interpolated between two numbers of "
        "samples that the arm’s sampler is made for. Brackets and whiskers: 95 % intervals. "
        "Hollow: arms that compute something else, or wrongly."
    )
    return Table(caption, heads, rows, ["", whiskers.axis(), "", "", ""])


def _ratio_column(values: Sequence[float]) -> Column:
    """Choose decimals for speed-ups: two are enough, unless one is below a tenth."""
    column = Column.of(values, plain=True)
    if column.decimals is None or min(values) < 0.1:
        # Three digits each.
        return Column(0, None)
    return Column(0, min(column.decimals, 2))


def _ratio(arm: ArmResult) -> Estimate | None:
    return arm.speedup.ratio if arm.speedup else None


#: What `error_table` calls a part of the MSE that is near 0 by nature.
_BIAS = "bias²"


def _errors() -> Iterator[tuple[str, Callable[[Point], Estimate | None], bool]]:
    """The columns of an error table: head, how to get it from a point, whether it is at most 1."""
    for name, model in METRICS.items():
        if model.IN_STUDIES:
            yield model.LABEL, lambda point, name=name: point.errors.get(name), model.BOUNDED
        if name == JUDGED:
            yield "variance", lambda point: point.variance, False
            yield _BIAS, lambda point: point.bias2, False


def error_table(arms: Ranked) -> Table:
    """All error figures of one picture at equal time."""
    points = [equal_time_point(arm) for arm, _ in arms]
    columns, heads, getters = [], [], []
    for name, get, shares in _errors():
        estimates = [get(p) for p in points if p is not None]
        if all(e is None for e in estimates):
            continue
        sizes = [e.value for e in estimates if e]
        if name == _BIAS:
            # Its noise, not its value, says how many digits mean something.
            sizes = [e.high - e.low for e in estimates if e]
        column = Column.of(sizes, digits=2 if name == _BIAS else 3, plain=shares)
        columns.append(column)
        heads.append(head(name, column))
        getters.append(get)
    rows = [
        _row(arm, look, [estimate_cell(get(p) if p else None, c)
                         for get, c in zip(getters, columns, strict=True)], heads)
        for (arm, look), p in zip(arms, points, strict=True)
    ]  # fmt: skip
    caption = (
        "Errors of one picture at equal time, with 95 % intervals. MSE = bias² + variance, each "
        "estimated without bias: bias² may come out below 0. relMSE divides by ref² + ε with "
        "ε = (0.1 · mean)²."
    )
    return Table(caption, heads, rows, [])


def cost_table(arms: Ranked) -> Table:
    """What a picture costs: time a sample, samples and seconds at equal time, what comes before."""
    points = [equal_time_point(arm) for arm, _ in arms]
    sample = Column.of([arm.microseconds_per_sample.value for arm, _ in arms], plain=True)
    seconds = Column.of([p.seconds.value for p in points if p], plain=True)
    compiling = Column.of([arm.compile_seconds for arm, _ in arms], digits=2, plain=True)
    loading = Column.of([arm.load_seconds for arm, _ in arms], digits=2, plain=True)
    heads = ["µs a sample", "Samples a pixel", "CPU seconds", "Compile s", "Load s", "Replicates",
             "NaN or ∞"]  # fmt: skip
    rows = []
    for (arm, look), point in zip(arms, points, strict=True):
        invalid = Cell(f"{arm.invalid:,}", "", "warning") if arm.invalid else Cell("0")
        cells = [
            estimate_cell(arm.microseconds_per_sample, sample),
            Cell(f"{point.spp:,}".replace(",", "\u2009") if point else UNKNOWN),
            estimate_cell(point.seconds if point else None, seconds),
            Cell(compiling.text(arm.compile_seconds)),
            Cell(loading.text(arm.load_seconds)),
            Cell(str(arm.replicates)),
            invalid,
        ]
        rows.append(_row(arm, look, cells, heads))
    caption = (
        "Cost. Samples and CPU seconds of one picture at equal time; compiling and loading are "
        "in no other figure."
    )
    return Table(caption, heads, rows, [])


def truth_table(arms: Ranked) -> Table:
    """Whether the mean of each arm's pictures agrees with the reference."""
    heads = ["Verdict", "rms z", "Largest |z|", "p", "Red", "Green", "Blue"]
    z = Column.of([arm.bias.z_rms for arm, _ in arms], plain=True)
    shares = [[_percent(e) for e in arm.bias.difference] for arm, _ in arms]
    # A difference is known no better than its interval: that decides the digits.
    widths = [(e.high - e.low) / 2.0 for row in shares for e in row]
    share = Column.of([w for w in widths if w > 0.0][:1] or [1.0], digits=1, plain=True)
    rows = []
    for (arm, look), row in zip(arms, shares, strict=True):
        bias = arm.bias
        kind = {BIASED: "warning", DISPUTED: "warning", DIFFERENT: "muted"}
        kind = kind.get(bias.verdict, "word")
        bounds = f"[{z.text(bias.z_low)}, {z.text(bias.z_high)}]"
        cells = [
            Cell(bias.verdict, "", kind),
            Cell(z.text(bias.z_rms), bounds if math.isfinite(bias.z_low) else ""),
            Cell(number(bias.z_largest)),
            Cell(p_value(bias.p_value)),
            *(estimate_cell(e, share, suffix=" %", sign=True) for e in row),
        ]
        rows.append(_row(arm, look, cells, heads))
    sizes = sorted({(a.bias.block, a.bias.blocks) for a, _ in arms})
    blocks = " or ".join(f"{count} blocks of {side} × {side} pixels" for side, count in sizes)
    larger = ", larger where rare events make the noise" if len(sizes) > 1 else ""
    caption = (
        f"Is the mean of the pictures that of the reference? Block t-tests ({blocks}{larger}): "
        "rms of z "
        "with its bounds if there is no bias, the largest |z|, and how far the channel means are "
        "off (95 % intervals). p is corrected for all tests, and the verdicts of a scene are one "
        f"family: a right arm is called biased with a probability of at most {100.0 * LEVEL:g} %. "
        "Where the study names no reference, arms are judged by each other, taking for granted "
        "that most of them are right."
    )
    return Table(caption, heads, rows, [])


def _percent(estimate: Estimate) -> Estimate:
    return Estimate(*(100.0 * v for v in estimate))


def head(name: str, column: Column) -> str:
    """Name of a column and its power of ten."""
    return f"{name} {column.unit}".strip()


def estimate_cell(
    estimate: Estimate | None, column: Column, suffix: str = "", sign: bool = False
) -> Cell:
    """Write a value and its interval as a cell."""
    if estimate is None or math.isnan(estimate.value):
        return Cell(UNKNOWN)
    plus = "+" if sign and estimate.value > 0.0 else ""
    return Cell(plus + column.text(estimate.value) + suffix, column.bounds(estimate))


def _row(arm: ArmResult, look: Look, cells: list[Cell], heads: list[str]) -> Row:
    titled = [cell._replace(title=name) for cell, name in zip(cells, heads, strict=True)]
    return Row(arm.label, look, badges_of(arm), titled)


def comparable(arm: ArmResult) -> bool:
    """Whether an arm estimates what the others do, as far as is known."""
    return arm.bias.verdict not in (BIASED, DISPUTED, DIFFERENT) and not arm.declares_different


def overview(scenes: Sequence[SceneResult]) -> Table:
    """Speed-ups of all arms in all scenes."""
    names = list(dict.fromkeys(arm.name for scene in scenes for arm in scene.arms))
    by_name = [{arm.name: arm for arm in scene.arms} for scene in scenes]
    heads = [scene.label for scene in scenes]
    found = [[arms.get(name) for arms in by_name] for name in names]
    ratios = [a.speedup.ratio.value for row in found for a in row if a and a.speedup]
    column = _ratio_column(ratios)
    rows = []
    for row in found:
        cells = [_overview_cell(arm, column)._replace(title=h)
                 for arm, h in zip(row, heads, strict=True)]  # fmt: skip
        label = next(arm.label for arm in row if arm)
        rows.append(Row(label, None, [], cells))
    caption = (
        "Speed-up of every arm in every scene over that scene’s baseline at equal time, with 95 % "
        "intervals. Grey: biased, disputed or different by declaration."
    )
    return Table(caption, heads, rows, [])


def _overview_cell(arm: ArmResult | None, column: Column) -> Cell:
    if arm is None:
        return Cell(UNKNOWN)
    if arm.is_baseline:
        return Cell("1", "baseline")
    cell = estimate_cell(_ratio(arm), column, suffix="×")
    return cell if comparable(arm) else cell._replace(kind="muted")


def badges_of(arm: ArmResult) -> list[tuple[str, str]]:
    """Short labels next to an arm's name, each with its class."""
    found = []
    if arm.is_baseline:
        found.append(("baseline", "plain"))
    if arm.bias.verdict == BIASED:
        found.append(("biased", "bad"))
    if arm.bias.verdict == DISPUTED:
        found.append(("disputed", "bad"))
    if arm.declares_different or arm.bias.verdict == DIFFERENT:
        found.append(("different by declaration", "plain"))
    return found
