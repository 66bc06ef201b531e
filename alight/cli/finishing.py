"""A render under the terminal: a progress bar, signals, and the last lines."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import typer

from alight.cli.interrupts import cancelling
from alight.cli.reporting import WarnOnce
from alight.core.errors import AlightError, OutputError

if TYPE_CHECKING:
    from alight.films import Film
    from alight.rendering.writing import Targets


def run_and_finish(
    render: Callable[..., Film],
    targets: Targets,
    *,
    quiet: bool,
    time_limit: float | None,
    warnings: Sequence[str] = (),
) -> None:
    """Render until the end or a signal, with a progress bar, and write the result.

    Parameters
    ----------
    render : callable
        Takes `progress` and `cancel`, as `alight.render` does.
    targets : Targets
    quiet : bool
    time_limit : float or None
        For the progress bar.
    warnings : sequence of str
        Printed before those of the compiled scene.

    Raises
    ------
    typer.Exit
        After a signal.
    OutputError
        If a picture cannot be written; the message says where the samples are.
    """
    from alight.cli.progress import ProgressBar
    from alight.rendering.writing import finish

    begin, cancel = time.perf_counter(), threading.Event()
    film, stopped, warns = None, False, WarnOnce()
    warns(warnings)
    with ProgressBar(quiet, time_limit, warns) as bar, cancelling(cancel, bar) as interruption:
        try:
            film = render(progress=bar, cancel=cancel)
        except KeyboardInterrupt:
            stopped = True
        except AlightError:
            raise
        except Exception:
            # Out of memory, or a bug of ours: the samples are no worse for it.
            _save_partial(bar.film, targets)
            raise
    if stopped or cancel.is_set():
        _save_partial(film or bar.film, targets)
        raise typer.Exit(interruption.exit_code)
    assert film is not None
    outcome = finish(film, targets, begin, warnings)
    warns(film.warnings)
    if not quiet:
        typer.echo(str(outcome))


def _save_partial(film: Film | None, targets: Targets) -> None:
    """Write an interrupted picture next to its target, which stays as it is."""
    if film is None or not film.sample_count.any():
        typer.echo("stopped before the first samples; nothing was written", err=True)
    else:
        target = targets.outputs[0]
        try:
            path = film.save(target.with_name(f"{target.stem}.partial.exr"))
            typer.echo(f"stopped at {film.spp:.3g} spp; the samples so far are in {path}", err=True)
        except OutputError as error:
            typer.echo(f"stopped at {film.spp:.3g} spp; {error}", err=True)
    if targets.checkpoint is not None and targets.checkpoint.exists():
        typer.echo(f"to continue: {targets.resuming()}", err=True)
