"""``alight study``: run an experiment and write its report."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from alight.lab.pictures import StudyProgress
    from alight.lab.results import SceneResult, StudyResult

from alight.cli import arguments
from alight.cli.progress import Bar
from alight.cli.reporting import INTERRUPTED


def study(
    name: Annotated[
        str | None, typer.Argument(help="Study file, or a name that --list shows.")
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help="Folder to write.", show_default="study-NAME"),
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Small and short, with wider intervals.")
    ] = False,
    list_ready: Annotated[bool, typer.Option("--list", help="List the ready studies.")] = False,
    root: arguments.Root = None,
    threads: Annotated[
        int | None, typer.Option(help="Threads; by default all processors.", min=1)
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Only warnings and errors.")] = False,
) -> None:
    """Compare techniques: how much noise each leaves, at what cost, with what certainty."""
    from alight.core.errors import OptionError
    from alight.lab.study_file import load_study, ready_names

    if list_ready:
        _list()
        return
    if name is None:
        raise OptionError(f"name a study file or one of: {', '.join(ready_names())}")
    description = load_study(name, root)
    folder = output or Path(f"study-{Path(name).stem}{'-quick' if quick else ''}")
    # After the messages about a wrong file: these imports take a second.
    from alight.lab.report import write_report
    from alight.lab.run import run_study

    with StudyBar(quiet) as bar:
        try:
            result = run_study(description, folder, quick=quick, threads=threads, progress=bar)
        except KeyboardInterrupt:
            typer.echo("stopped; the same command continues from here", err=True)
            raise typer.Exit(INTERRUPTED) from None
    begin = time.process_time()
    page = write_report(result, folder)
    if not quiet:
        for line in summary(result, time.process_time() - begin):
            typer.echo(line)
        typer.echo(f"report: {page}")


def _list() -> None:
    from alight.lab.study_file import load_study, ready_names

    names = ready_names()
    width = max(len(name) for name in names)
    for name in names:
        typer.echo(f"{name:<{width}}  {load_study(name).title}")


def summary(result: StudyResult, report_seconds: float) -> list[str]:
    """The findings in a few lines: a table for each scene, and where the time went."""
    lines = []
    for scene in result.scenes:
        lines += [*_scene_lines(scene), ""]
    for diagram in result.curves:
        lines.append(diagram.title)
        for curve in diagram.curves:
            slope = "" if curve.slope is None else f"  slope {curve.slope.value:+.2f}"
            wanted = curve.expected_slope
            expected = "" if wanted is None else f" (expected {wanted:+.2f})"
            lines.append(f"  {curve.label}: {curve.y[-1]:.3g}{slope}{expected}")
    for table in result.tables:
        lines.append(table.title)
        lines += ["  " + "  ".join(_cell(cell) for cell in row) for row in table.rows]
    spent = {**result.seconds, "statistics": result.seconds["statistics"] + report_seconds}
    lines.append("CPU seconds: " + ", ".join(f"{k} {v:.1f}" for k, v in spent.items()))
    return lines


def _cell(cell: object) -> str:
    if isinstance(cell, float):
        return f"{cell:.4g}"
    if isinstance(cell, list) and len(cell) == 3:
        return f"{cell[0]:.4g} [{cell[1]:.4g}, {cell[2]:.4g}]"
    return str(cell)


def _scene_lines(scene: SceneResult) -> list[str]:
    """The arms of a scene, the most efficient first."""
    reference = scene.reference
    noise = f"{reference.relative_noise:.2%}" + (" as stated" if reference.declared else "")
    origin = f"{reference.source}, {reference.arm} {reference.spp} spp" if reference.arm else ""
    size = f"{scene.size[0]}x{scene.size[1]}"
    lines = [f"{scene.label}, {size}; reference {origin or reference.source}, error {noise}"]
    width = max(len(arm.label) for arm in scene.arms)
    lines.append(f"  {'arm':<{width}}  {'speed-up [95 %]':<22} {'p':<8} relMSE    slope  mean")
    for arm in sorted(scene.arms, key=lambda arm: -arm.efficiency.value):
        speedup, p = "baseline", ""
        if arm.speedup is not None:
            value, low, high = arm.speedup.ratio
            speedup, p = f"{value:.3g} [{low:.3g}, {high:.3g}]", f"{arm.speedup.p_adjusted:.2g}"
        error = (arm.times or arm.samples)[-1].relmse.value
        lines.append(
            f"  {arm.label:<{width}}  {speedup:<22} {p:<8} {error:<9.3g} "
            f"{arm.slope_spp.value:+.2f}  {arm.bias.verdict}"
        )
    return lines


class StudyBar(Bar):
    """Shows `StudyProgress` on stderr, with the time that is left."""

    def __init__(self, quiet: bool) -> None:
        super().__init__(quiet)
        self._total: float | None = None

    def __call__(self, progress: StudyProgress) -> None:
        """Show how far the study is."""
        if progress.total != self._total:
            # Another phase: its speed says nothing about the last one's.
            self._bar.remove_task(self._task)
            self._task = self._begin(progress.text, progress.total or None)
            self._total = progress.total
        self._bar.update(self._task, description=progress.text, completed=progress.done)
