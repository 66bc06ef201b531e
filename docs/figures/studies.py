"""Figures and tables of docs/studies/, from the folders that `alight study` wrote.

alight study diffuse -o out/diffuse
python docs/figures/studies.py out/diffuse
"""

import argparse
from pathlib import Path
from typing import Any

from pictures import IMAGES
from study_figures import draw, draw_examples, draw_means, draw_samples

from alight.lab.report.numbers import Column, number, p_value
from alight.lab.report.numbers import fixed as decimals
from alight.lab.result_files import load
from alight.lab.results import ArmResult, Curve, SceneResult, StudyResult, TableResult
from alight.metrics.estimate import Estimate

PAGES = Path(__file__).resolve().parents[1] / "studies"

#: This script writes the text between these lines of a page.
BEGIN, END = "<!-- measured: docs/figures/studies.py -->", "<!-- end -->"


def tables(result: StudyResult) -> str:
    """Everything measured, as Markdown."""
    parts = [scene_table(scene) for scene in result.scenes]
    if result.name == "integration":
        parts.append(slope_table(result))
    elif result.name == "acceleration":
        parts.append(time_table(result))
    else:
        parts += [own_table(table) for table in result.tables]
    return "\n\n".join([*parts, footnote(result)])


def cell(estimate: Estimate | None, column: Column) -> str:
    """A value and its 95 % interval."""
    if estimate is None:
        return ""
    return f"{column.text(estimate.value)} {column.bounds(estimate)}".strip()


def scene_table(scene: SceneResult) -> str:
    """The arms of a scene, the most efficient first; those that compute something else last."""
    arms = sorted(scene.arms, key=lambda arm: (arm.declares_different, -arm.efficiency.value))
    spp = arms[0].samples[-1].spp
    errors = Column.of([arm.samples[-1].relmse.value for arm in arms], digits=4)
    costs = Column.of([arm.microseconds_per_sample.value for arm in arms], plain=True)
    head = (
        f"relMSE at {spp} spp {errors.unit}".strip(),
        "µs a sample", "speed-up at equal time" if arms[0].times else f"speed-up at {spp} spp",
        "p", "slope", "mean",
    )  # fmt: skip
    lines = [f"| {scene.label} | {' | '.join(head)} |", "|---|" + "---:|" * 5 + "---|"]
    lines += [_row(arm, errors, costs) for arm in arms]
    return "\n".join(lines)


def _row(arm: ArmResult, errors: Column, costs: Column) -> str:
    speedup, p = "1, the baseline", ""
    if arm.speedup:
        ratio = arm.speedup.ratio
        speedup = f"**{number(ratio.value)}** [{number(ratio.low)}, {number(ratio.high)}]"
        p = p_value(arm.speedup.p_adjusted)
    slope = arm.slope_spp
    cells = (
        arm.label, cell(arm.samples[-1].relmse, errors),
        costs.text(arm.microseconds_per_sample.value), speedup, p,
        with_half_width(slope),
        arm.bias.verdict,
    )  # fmt: skip
    return f"| {' | '.join(cells)} |"


def with_half_width(slope: Estimate) -> str:
    """A slope and half the width of its interval; exact ones have none."""
    half = (slope.high - slope.low) / 2.0
    if not half > 0.0:
        return decimals(slope.value, 2)
    digits = 2 if half >= 0.01 else 3
    return f"{decimals(slope.value, digits)} ± {decimals(half, digits)}"


def own_table(table: TableResult) -> str:
    """A table of a study's own."""
    lines = [f"| {' | '.join(table.columns)} |", "|" + "---|" * len(table.columns)]
    lines += [f"| {' | '.join(plain_cell(value) for value in row)} |" for row in table.rows]
    return "\n".join(lines)


def plain_cell(value: Any) -> str:
    """A text, a number, or a value and its interval."""
    if isinstance(value, str):
        return value
    return with_bounds(*value) if isinstance(value, list) else number(value)


def with_bounds(value: float, low: float, high: float) -> str:
    """A number and its interval."""
    return f"{number(value)} [{number(low)}, {number(high)}]"


def slope_table(result: StudyResult) -> str:
    """Slopes of all rules over the dimensions, one table an integrand."""
    found = []
    for kind, title in (("smooth", "smooth"), ("edge", "with an edge")):
        panels = [panel for panel in result.curves if panel.name.startswith(kind)]
        names = [f"d = {panel.name.split('-')[1][:-1]}" for panel in panels]
        lines = [f"| {title} | {' | '.join(names)} |", "|---|" + "---:|" * len(panels)]
        for i, curve in enumerate(panels[0].curves):
            cells = [_slope(panel.curves[i]) for panel in panels]
            lines.append(f"| {curve.label} | {' | '.join(cells)} |")
        found.append("\n".join(lines))
    return "\n\n".join(found)


def _slope(curve: Curve) -> str:
    if curve.slope is None:
        return "–"
    expected = curve.expected_slope
    return with_half_width(curve.slope) + (
        "" if expected is None else f" ({decimals(expected, 2)})"
    )


def time_table(result: StudyResult) -> str:
    """Microseconds of a sample over the number of triangles."""
    panel = next(panel for panel in result.curves if panel.name == "time")
    sizes = sorted({x for curve in panel.curves for x in curve.x})
    heads = [curve.label for curve in panel.curves]
    lines = [f"| triangles | {' | '.join(heads)} |", "|---:|" + "---:|" * len(heads)]
    for size in sizes:
        cells = []
        for curve in panel.curves:
            at = curve.x.index(size) if size in curve.x else None
            found = (curve.y[at], curve.low[at], curve.high[at]) if at is not None else ()
            cells.append(with_bounds(*found) if found else "")
        lines.append(f"| {decimals(size, 0)} | {' | '.join(cells)} |")
    return "\n".join(lines)


def footnote(result: StudyResult) -> str:
    """Where the numbers come from."""
    seeds = "" if not result.scenes else f"{result.replicates} replicates an arm; "
    quick = "with `--quick`, " if result.quick else ""
    return (
        f"*{seeds}brackets and ± are 95 % intervals, p is adjusted over the arms (Holm). "
        f"{quick.capitalize()}{result.machine['processor']}, {result.machine['threads']} threads, "
        f"alight {result.versions['alight']}, {result.created[:10]}.*"
    )


def main() -> None:
    """Draw the figure of each folder and write its tables into its page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="+", type=Path)
    for folder in parser.parse_args().folders:
        result = load(folder / "results.json")
        draw(result, IMAGES / "studies" / f"{result.name}.svg")
        page = PAGES / f"{result.name}.md"
        if result.name == "antialiasing":
            draw_samples(IMAGES / "studies" / "zone-plate.svg")
            draw_means(result.scenes[0], IMAGES / "studies" / "filters.png")
        if result.name == "hard-light":
            draw_examples(result.scenes, IMAGES / "studies" / "hard-light-pictures.png")
        before, _, rest = page.read_text(encoding="utf-8").partition(BEGIN)
        after = rest.partition(END)[2]
        text = f"{before}{BEGIN}\n\n{tables(result)}\n\n{END}{after}"
        page.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
