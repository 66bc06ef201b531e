"""The page of a study: a template filled with text, figures and pictures, all in one file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from alight.lab.report import data_files
from alight.lab.report.charts import Line, diagram
from alight.lab.report.numbers import Column, number
from alight.lab.report.scenes import scene_context
from alight.lab.report.style import looks, require_packages
from alight.lab.report.tables import Cell, Row, Table, estimate_cell, overview
from alight.lab.results import Curve, CurveResult, StudyResult, TableResult
from alight.metrics.estimate import Estimate
from alight.outputs.atomic import replacing

_FOLDER = Path(__file__).resolve().parent

#: What pages and their figures need, of the extra `lab`.
PACKAGES = ("jinja2", "matplotlib")


def write_report(result: StudyResult, folder: str | Path) -> Path:
    """Write ``report.html``, one self-contained file, and its numbers next to it.

    Parameters
    ----------
    result : StudyResult
    folder : path
        Exists; old reports in it are replaced. Besides the page come ``report.json``,
        ``arms.csv``, ``points.csv``, ``curves.csv`` and a CSV file for each table of the study.

    Returns
    -------
    Path
        The page.

    Raises
    ------
    OptionError
        If matplotlib or Jinja2 are not installed.
    OutputError
        If a file cannot be written; a file that was there before is then untouched.
    """
    folder = Path(folder)
    page = render_page("report.html.j2", study_context(result))
    data_files.write_data(result, folder)
    target = folder / "report.html"
    with replacing(target) as beside:
        beside.write_text(page, encoding="utf-8")
    return target


def render_page(template: str, context: dict[str, Any]) -> str:
    """Fill a template of this folder; everything but figures is escaped.

    Raises
    ------
    OptionError
        If matplotlib or Jinja2 are not installed.
    """
    require_packages(*PACKAGES)
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(_FOLDER), autoescape=True, undefined=jinja2.StrictUndefined,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    style = (_FOLDER / "page.css").read_text(encoding="utf-8")
    return environment.get_template(template).render(style=style, **context)


def study_context(result: StudyResult) -> dict[str, Any]:
    """Everything that the template shows.

    Raises
    ------
    OptionError
        If matplotlib or Jinja2 are not installed.
    """
    require_packages(*PACKAGES)
    seconds = [(name, number(value)) for name, value in result.seconds.items()]
    return {
        "study": result,
        "date": result.created.replace("T", " ")[:16],
        "scenes": [scene_context(scene, i) for i, scene in enumerate(result.scenes)],
        "overview": overview(result.scenes) if len(result.scenes) > 1 else None,
        "curves": [curve_context(curve, i) for i, curve in enumerate(result.curves)],
        "tables": [table_context(table) for table in result.tables],
        "seconds": seconds,
        "share": _statistics_share(result.seconds),
        "machine": [*result.machine.items(), *result.versions.items()],
    }


def _statistics_share(seconds: dict[str, float]) -> str:
    if seconds.get("statistics") is None or not seconds.get("render"):
        return ""
    return f"{number(100.0 * seconds['statistics'] / seconds['render'], 2)} %"


def curve_context(result: CurveResult, index: int) -> dict[str, Any]:
    """A diagram of a study's own, with a table of its slopes."""
    curve_looks = looks(len(result.curves))
    lines = [
        Line(c.label, look, c.x, c.y, c.low, c.high, c.slope, c.expected_slope)
        for c, look in zip(result.curves, curve_looks, strict=True)
    ]
    svg = diagram(lines, result.x_label, result.y_label, f"c{index}")
    return {
        "title": result.title,
        "description": result.description,
        "notes": result.notes,
        "svg": svg,
        "slopes": _slopes(result.curves, curve_looks),
    }


def _slopes(curves: list[Curve], curve_looks: list[Any]) -> Table | None:
    """Fitted slopes next to the expected ones; None where no slope was fitted."""
    if all(c.slope is None for c in curves):
        return None
    column = Column(0, 2)
    heads = ["Slope", "Expected", "Last value"]
    last = Column.of([c.y[-1] for c in curves if c.y])
    heads[2] = f"Last value {last.unit}".strip()
    rows = []
    for curve, look in zip(curves, curve_looks, strict=True):
        expected = "" if curve.expected_slope is None else column.text(curve.expected_slope)
        end = Estimate(curve.y[-1], curve.low[-1], curve.high[-1]) if curve.y else None
        cells = [
            estimate_cell(curve.slope, column),
            Cell(expected),
            estimate_cell(end, last),
        ]
        titled = [c._replace(title=h) for c, h in zip(cells, heads, strict=True)]
        rows.append(Row(curve.label, look, [], titled))
    caption = "Slopes of the fitted power laws with 95 % intervals, and what theory expects."
    return Table(caption, heads, rows, [])


def table_context(result: TableResult) -> dict[str, Any]:
    """A table of a study's own: the first column names the rows, numbers are aligned."""
    columns = list(zip(*result.rows, strict=True)) if result.rows else []
    formats = [_format(cells) for cells in columns]
    heads = [
        f"{name} {form.unit}".strip()
        for name, form in zip(result.columns, formats or [Column(0, 0)] * len(result.columns),
                              strict=True)
    ]  # fmt: skip
    rows = []
    for row in result.rows:
        cells = [_cell(v, f, h) for v, f, h in zip(row, formats, heads, strict=True)]
        rows.append(Row(cells[0].text, None, [], cells[1:]))
    table = Table(result.description, heads[1:], rows, [])
    return {"title": result.title, "first": heads[0] if heads else "", "table": table}


def _format(cells: Sequence[Any]) -> Column:
    """How the numbers of a column are written; whole ones are counts, and keep all their digits."""
    plain = any(isinstance(cell, int) for cell in cells)
    return Column.of([value for cell in cells for value in _numbers(cell)[:1]], plain=plain)


def _numbers(cell: Any) -> list[float]:
    """The numbers of a cell: none in a text, three in an interval."""
    if isinstance(cell, bool) or cell is None or isinstance(cell, str):
        return []
    return [float(v) for v in cell] if isinstance(cell, list | tuple) else [float(cell)]


def _cell(value: Any, column: Column, title: str) -> Cell:
    numbers = _numbers(value)
    if not numbers:
        text = {None: "", True: "yes", False: "no"}.get(value, str(value)) if (
            value is None or isinstance(value, bool)
        ) else str(value)  # fmt: skip
        return Cell(text, "", "word", title)
    if len(numbers) == 3:
        return estimate_cell(Estimate(*numbers), column)._replace(title=title)
    text = (
        f"{value:,}".replace(",", "\u2009") if isinstance(value, int) else column.text(numbers[0])
    )
    return Cell(text, "", "number", title)
