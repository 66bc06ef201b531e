"""``alight resume``: continues a render from its checkpoint, to the same bits."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from alight.cli.words import Quiet, spelling_of, takes_words
from alight.cluster.fork_server import RENDERS, start_fork_server
from alight.options.resume import ResumeOptions


@takes_words(ResumeOptions, first=lambda said: start_fork_server(said.get("cluster"), RENDERS))
def resume(
    options: ResumeOptions,
    file: Annotated[
        Path, typer.Argument(metavar="CHECKPOINT", help="File written by --checkpoint.")
    ],
    quiet: Quiet = False,
) -> None:
    """Resume a stopped or killed render, or add samples to it."""
    from alight.cli.finishing import run_and_finish
    from alight.rendering.checkpoints.resume import prepare_resume

    prepared = prepare_resume(file, options)
    targets = prepared.targets
    if not targets.outputs:
        targets = replace(targets, outputs=(file.with_suffix(".png"),))
    targets.check()
    run_and_finish(
        prepared.render, targets, warnings=prepared.warnings(spelling_of(resume)), quiet=quiet,
        time_limit=options.time_limit,
    )  # fmt: skip
