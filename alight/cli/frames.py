"""An animation under the terminal: which frame it is at, signals, and the last line."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING

import typer

from alight.cli.interrupts import cancelling
from alight.cli.progress import ProgressBar
from alight.cli.reporting import WarnOnce, note_unused

if TYPE_CHECKING:
    from alight.options.animation import AnimationOptions
    from alight.rendering import Progress


def render_frames(
    scene: str, options: AnimationOptions, spell: Callable[[str], str], *, quiet: bool
) -> None:
    """Render an animation until its end or a signal; frames that are there already are kept.

    Parameters
    ----------
    scene : str
    options : AnimationOptions
    spell : callable
        How the user spells an option, for warnings.
    quiet : bool

    Raises
    ------
    typer.Exit
        After a signal; where frames are kept, the same command then goes on.
    """
    from alight.outputs.moving import played_fps
    from alight.rendering.animation import Animation

    cancel, warns = threading.Event(), WarnOnce()
    with ProgressBar(quiet, warns=warns) as bar, cancelling(cancel, bar) as interruption:

        def show(progress: Progress) -> None:
            bar.title = f"frame {made.current}: "
            bar(progress)

        made = Animation(scene, options.changed(progress=show, cancel=cancel))
        if not quiet:
            note_unused(scene, made.scene)
        warns(made.prepared.warnings(spell))
        try:
            written = made.render()
            stopped = cancel.is_set()
        except KeyboardInterrupt:
            written, stopped = [], True
    warns(made.warnings)
    if stopped:
        again = "goes on there" if made.goes_on else (
            f"starts at frame {made.numbers.start} again: only EXR files of frames are kept for a "
            "film, and without one EXR and PNG files"
        )  # fmt: skip
        typer.echo(f"stopped at frame {made.current}; the same command {again}", err=True)
        raise typer.Exit(interruption.exit_code)
    if not quiet:
        kept = f", {len(made.kept)} of them kept" if made.kept else ""
        files = "1 file" if len(written) == 1 else f"{len(written)} files"
        typer.echo(f"{len(made.numbers)} frames: {files}{kept}")
        for path in made.films:
            played = played_fps(path, options.fps)
            if played != options.fps:
                told = f"{played:.4g} frames per second, not {options.fps}"
                typer.echo(f"{path}: plays {told}: GIF counts in hundredths of a second")
