"""``alight resume``: continues a render from its checkpoint, to the same bits."""

from __future__ import annotations

import functools
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer

from alight.cli import arguments, promises


def resume(
    checkpoint: Annotated[Path, typer.Argument(help="File written by --checkpoint.")],
    output: Annotated[
        list[Path] | None,
        typer.Option(
            "-o",
            "--output",
            help="File to write; repeatable.",
            show_default="as for the first part of the render",
        ),
    ] = None,
    spp: Annotated[
        int | None,
        typer.Option(help="Samples per pixel in all.", min=1, show_default="as asked for first"),
    ] = None,
    error: promises.Error = None,
    confidence: promises.Confidence = "95%",
    metric: promises.Metric = "relrmse",
    share: promises.Share = "95%",
    max_spp: promises.MaxSpp = None,
    time_limit: Annotated[
        float | None,
        typer.Option(
            "--time",
            help="Start no pass after this many seconds.",
            show_default="what is left of the first limit",
        ),
    ] = None,
    scene: Annotated[
        str | None, typer.Option(help="Where the scene file is now, if it was moved.")
    ] = None,
    root: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER",
            help="Folder whose files the scene may read.",
            show_default="as the render began",
        ),
    ] = None,
    to: Annotated[
        Path | None,
        typer.Option("--checkpoint", help="Write checkpoints to another file."),
    ] = None,
    every: arguments.Every = "60s",
    threads: arguments.Threads = None,
    plugin: arguments.Plugins = None,
    stats: arguments.Stats = None,
    quiet: arguments.Quiet = False,
) -> None:
    """Resume a stopped or killed render, or add samples to it."""
    from alight.cli.finishing import Results, run_and_finish
    from alight.cli.options import parse_seconds
    from alight.cli.plugins import load_plugins
    from alight.cli.reporting import warn
    from alight.outputs.display import Display
    from alight.rendering import resume as resume_render
    from alight.rendering.checkpoint import read_checkpoint

    promise = promises.promise_to_resume(error, confidence, metric, share, spp, max_spp)
    saved = read_checkpoint(checkpoint)
    notes = _Notes(saved.origin.notes)
    # Only now: what they register decides how the scene is understood.
    load_plugins([*notes.plugins, *(plugin or [])])
    results = Results(
        outputs=output or notes.outputs or [checkpoint.with_suffix(".png")],
        display=Display(**notes.display),
        denoise=notes.denoise,
        stats=stats,
        checkpoint=to or checkpoint,
        quiet=quiet,
    )
    results.check()
    held = saved.state.rounds[0].spp
    if spp is not None and spp <= held:
        warn(f"there are {held:g} samples per pixel already; --spp {spp} adds none")
    render = functools.partial(
        resume_render,
        saved,
        scene=scene,
        root=root,
        spp=max_spp if promise else spp,
        promise=promise,
        time_limit=time_limit,
        threads=threads,
        checkpoint=to,
        every=parse_seconds("--every", every),
    )
    run_and_finish(render, results, time_limit)


class _Notes:
    """What ``alight render`` has noted in the checkpoint; a render in Python notes nothing."""

    def __init__(self, notes: Any) -> None:
        self.outputs = [Path(path) for path in notes.get("outputs", [])]
        self.plugins = [Path(path) for path in notes.get("plugins", [])]
        self.display = dict(notes.get("display", {}))
        self.denoise = bool(notes.get("denoise", False))


def notes_of(
    outputs: list[Path], plugins: list[Path] | None, display: Any, denoise: bool
) -> dict[str, Any]:
    """Gather what a checkpoint keeps for `resume`; it may be called from another folder."""
    return {
        "outputs": [str(path.absolute()) for path in outputs],
        "plugins": [str(path.absolute()) for path in plugins or []],
        "display": asdict(display),
        "denoise": denoise,
    }
