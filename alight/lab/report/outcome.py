"""`alight.study`: an experiment is run, its report written, and its findings shown."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

from alight.lab.report.page import PACKAGES, write_report
from alight.lab.report.style import require_packages
from alight.lab.results import CurveResult, SceneResult, StudyResult
from alight.lab.run import run_study
from alight.lab.study import Study
from alight.lab.study_file import load_study
from alight.options.entry import takes
from alight.options.laboratory import StudyOptions
from alight.options.plugins import load_plugins
from alight.outputs import html


@dataclass(frozen=True)
class StudyReport:
    """A study that has been run, and its report.

    Attributes
    ----------
    result : StudyResult
        Everything that was found, as plain data.
    page : Path
        The report; its numbers lie beside it as CSV and JSON.
    seconds : float
        CPU time of the report.
    """

    result: StudyResult
    page: Path
    seconds: float = 0.0

    def __str__(self) -> str:
        """What ``alight study`` prints: tables of the findings, and where the time went."""
        return "\n".join([*summary(self.result, self.seconds), f"report: {self.page}"])

    def _repr_html_(self) -> str:
        """Show the tables of the findings in a notebook, and the way to the report."""
        result = self.result
        parts = [
            html.table(rows, heads, head)
            for head, heads, rows in (scene_table(scene) for scene in result.scenes)
        ]
        for scene in result.scenes:
            parts.append(html.preformatted(scene.notes))
            pictures = [(arm.label, arm.images.example) for arm in scene.arms]
            pictures.append(("reference", scene.reference_image))
            parts.append("".join(html.figure(image, label) for label, image in pictures))
        parts += [
            html.table([[_cell(cell) for cell in row] for row in table.rows], table.columns,
                       table.title)
            for table in result.tables
        ]  # fmt: skip
        rest = [line for diagram in result.curves for line in _curve_lines(diagram)]
        return html.division(
            html.paragraph(result.title), *parts, html.preformatted(rest),
            html.paragraph(f"report: {self.page}"),
        )  # fmt: skip


@takes(StudyOptions)
def study(name: Study | str | Path, options: StudyOptions) -> StudyReport:
    """Compare techniques: how much noise each leaves, at what cost, with what certainty.

    Parameters
    ----------
    name : Study, path of a study file, or name of a ready study
    {options}

    Returns
    -------
    StudyReport

    Raises
    ------
    AlightError
        For a study that is wrong, an arm without noise, a reference with too much, or a full disk.
        What was measured is kept, and the same call goes on from there. Without the packages of
        the report nothing is begun.
    KeyboardInterrupt
        The same call goes on from there.

    Examples
    --------
    >>> print(alight.study("direct-light", quick=True))  # doctest: +SKIP
    """
    load_plugins(options.plugins)
    description = name if isinstance(name, Study) else load_study(name, options.root)
    folder = options.output or Path(
        f"study-{Path(description.name).stem}{'-quick' if options.quick else ''}"
    )
    # Before hours of rendering rather than after them.
    require_packages(*PACKAGES)
    result = run_study(
        description, folder, quick=options.quick, threads=options.threads,
        progress=options.progress, cluster=options,
    )  # fmt: skip
    begin = time.process_time()
    page = write_report(result, folder)
    return StudyReport(result, page, time.process_time() - begin)


def summary(result: StudyResult, report_seconds: float) -> list[str]:
    """The findings in a few lines: a table for each scene, and where the time went."""
    lines = []
    for scene in result.scenes:
        lines += [*_scene_lines(scene), ""]
    for diagram in result.curves:
        lines += _curve_lines(diagram)
    for table in result.tables:
        lines.append(table.title)
        lines += ["  " + "  ".join(_cell(cell) for cell in row) for row in table.rows]
    spent = {**result.seconds, "statistics": result.seconds["statistics"] + report_seconds}
    lines.append("CPU seconds: " + ", ".join(f"{k} {v:.1f}" for k, v in spent.items()))
    return lines


def _curve_lines(diagram: CurveResult) -> list[str]:
    """The last values of the curves, and their slopes."""
    lines = [diagram.title]
    for curve in diagram.curves:
        slope = "" if curve.slope is None else f"  slope {curve.slope.value:+.2f}"
        wanted = curve.expected_slope
        expected = "" if wanted is None else f" (expected {wanted:+.2f})"
        lines.append(f"  {curve.label}: {curve.y[-1]:.3g}{slope}{expected}")
    return lines


def _cell(cell: object) -> str:
    if isinstance(cell, float):
        return f"{cell:.4g}"
    if isinstance(cell, list) and len(cell) == 3:
        return f"{cell[0]:.4g} [{cell[1]:.4g}, {cell[2]:.4g}]"
    return str(cell)


def scene_table(scene: SceneResult) -> tuple[str, tuple[str, ...], list[tuple[str, ...]]]:
    """The arms of a scene, the most efficient first: a line about the scene, heads, rows."""
    reference = scene.reference
    noise = f"{reference.relative_noise:.2%}" + (" as stated" if reference.declared else "")
    origin = f"{reference.source}, {reference.arm} {reference.spp} spp" if reference.arm else ""
    size = f"{scene.size[0]}x{scene.size[1]}"
    head = f"{scene.label}, {size}; reference {origin or reference.source}, error {noise}"
    rows = []
    for arm in sorted(scene.arms, key=lambda arm: -arm.efficiency.value):
        speedup, p = "baseline", ""
        if arm.speedup is not None:
            value, low, high = arm.speedup.ratio
            speedup, p = f"{value:.3g} [{low:.3g}, {high:.3g}]", f"{arm.speedup.p_adjusted:.2g}"
        error = f"{(arm.times or arm.samples)[-1].relmse.value:.3g}"
        slope = f"{arm.slope_spp.value:+.2f}"
        rows.append((arm.label, speedup, p, error, slope, arm.bias.verdict))
    return head, ("arm", "speed-up [95 %]", "p", "relMSE", "slope", "mean"), rows


def _scene_lines(scene: SceneResult) -> list[str]:
    """The same as text."""
    head, heads, rows = scene_table(scene)
    width = max(len(row[0]) for row in rows)
    lines = [head, f"  {heads[0]:<{width}}  {heads[1]:<22} {heads[2]:<8} relMSE    slope  mean"]
    for label, speedup, p, error, slope, verdict in rows:
        lines.append(f"  {label:<{width}}  {speedup:<22} {p:<8} {error:<9} {slope}  {verdict}")
    return [*lines, *(f"  note: {note}" for note in scene.notes)]
